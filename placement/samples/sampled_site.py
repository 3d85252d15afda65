"""A site as the optimiser sees it: samples on the faces turned towards the ring, and their profiles."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import trimesh
from jaxtyping import Bool, Float

import exact
from exact.ring import poses
from placement.errors import PlacementError
from placement.samples.profiles import RingProfiles, Visibility, ring_profiles
from placement.samples.sampling import SurfaceSamples, sample_surface
from placement.settings import Settings

# Ring angles at which is asked where a camera may look; what lies between is covered by a margin.
VIEW_ANGLES = 24
# The sine of the angle between a face and the plane of the ring, where the face lies in it.
LEAST_SLOPE = 1e-9


@dataclass(frozen=True, eq=False)
class SampledSite:
    """Samples of one site and the profiles that a search needs.

    Attributes
    ----------
    samples : SurfaceSamples
        Points where some camera of the ring may see a face that is not excluded.
    visibility : Visibility
        For asking about further cameras.
    profiles : RingProfiles
        Of the points that some camera of the ring sees; those that all of them see are merged into one.
    ring_area : float
        Area [mm²] of the samples that enough of `settings.ring_cameras` equidistant cameras see: what the samples say
        of the ring maximum.
    """

    samples: SurfaceSamples
    visibility: Visibility
    profiles: RingProfiles
    ring_area: float


def sample_site(
    scene: exact.Scene,
    ring: exact.Ring,
    demand: exact.Demand,
    settings: Settings | None = None,
    seed: int = 0,
    n_samples: int | None = None,
) -> SampledSite:
    """Sample a surface where the ring may see it and trace the ring profiles.

    Parameters
    ----------
    scene : exact.Scene
        The site and what of it counts.
    ring : exact.Ring
        Where cameras may be.
    demand : exact.Demand
        What makes a point count.
    settings : Settings, optional
        Number of samples and angles.
    seed : int
        Of the sample points.
    n_samples : int, optional
        Instead of `settings.n_samples`.

    Raises
    ------
    PlacementError
        If no cameras see a common point that meets the demand.

    Examples
    --------
    >>> site = sample_site(exact.Scene(trimesh.creation.box((10, 10, 1))), exact.Ring(), exact.Demand())
    >>> bool(100.0 <= site.ring_area <= 140.0)  # the top and what is seen of the sides
    True
    """
    settings = Settings() if settings is None else settings
    mesh, threshold = scene.everything, demand.threshold
    n_samples = settings.n_samples if n_samples is None else n_samples
    samples, visibility = samples_in_view(scene, (ring,), demand, n_samples, seed)
    profiles = ring_profiles(visibility, samples, ring, settings.n_angles, settings.bisections)
    if not profiles.visible.any():
        raise PlacementError(_blind(_unseen(visibility, samples, ring, demand), ring, mesh))
    profiles = replace(profiles, noise=noise_of(samples, ring, demand), heights=heights_of(samples, ring, demand))
    everywhere = ring.equidistant(max(settings.ring_cameras, threshold))
    seen_from = profiles.at(everywhere).sum(axis=0)
    # Profiles miss arcs narrower than their step, which many cameras do not: there the points themselves are asked.
    few = np.flatnonzero(seen_from < threshold)
    seen_from[few] = visibility.from_angles(samples.subset(few), ring, everywhere).sum(axis=0)
    if seen_from.max(initial=0) < threshold:
        raise PlacementError(f"no point is seen by {threshold} cameras anywhere on the ring; lower the threshold")
    ring_area = float(samples.weights[seen_from >= threshold].sum())
    if not ring_area > 0:
        raise PlacementError("what the ring reconstructs has weight 0; give some of the faces it sees more")
    return SampledSite(samples, visibility, _merged(profiles, demand), ring_area)


def samples_in_view(
    scene: exact.Scene, rings: Sequence[exact.Ring], demand: exact.Demand, n_samples: int, seed: int
) -> tuple[SurfaceSamples, Visibility]:
    """Samples of what counts, is lit and may be in view of some camera of the rings, and who sees them.

    Raises
    ------
    PlacementError
        If there is nothing of the kind; the message speaks of the first ring.
    """
    mesh, excluded, face_weights = scene.everything, ~scene.counted, scene.weights
    towards = np.any([faces_towards(mesh, ring) for ring in rings], axis=0)
    if not (towards & ~excluded).any():
        raise PlacementError(
            _blind(f"none of the {int((~excluded).sum())} faces that count is turned towards it", rings[0], mesh)
        )
    ignored = excluded | ~towards if face_weights is None else excluded | ~towards | (face_weights == 0)
    if ignored.all():
        raise PlacementError("every face that is turned towards the ring has weight 0; give some of them more")
    samples = sample_surface(
        mesh, n_samples, ignored, seed, lambda corners: np.any([in_view(corners, ring) for ring in rings], axis=0)
    )
    if len(samples) == 0:
        raise PlacementError(_blind("what is turned towards it lies outside the field of view", rings[0], mesh))
    if face_weights is not None:
        samples = replace(samples, weights=samples.weights * face_weights[samples.faces])
    visibility = Visibility(mesh, demand)
    if scene.lights:
        samples = samples.subset(visibility.lit(samples, scene.lights))
        if len(samples) == 0:
            raise PlacementError(_blind("nothing turned towards it is lit; move or add lights", rings[0], mesh))
    return samples, visibility


def noise_of(samples: SurfaceSamples, ring: exact.Ring, demand: exact.Demand) -> Float[np.ndarray, " N"]:
    """(N,) variance of the error of each sample times the spread of the cameras that see it [mm⁴].

    On a ring the variance along the axis is (s z² / f)² / S, to 0.2 %: z is the distance from the plane of the ring, s
    the noise of a match, f the focal length, and S the sum of the squared distances of the cameras from their centre.
    Along a normal it is less by the squared cosine of its angle to the axis.
    """
    camera, axis = ring.cameras([0.0])[0], ring.frame[:, 2]
    depth = np.maximum(ring.working_distance - (samples.points - np.array(ring.focus)) @ axis, 0.0)
    focal = float(np.sqrt(np.prod(demand.optics.focal(camera))))
    noise = (demand.optics.match_noise * depth**2 / focal) ** 2
    return noise if demand.error == "depth" else noise * (samples.normals @ axis) ** 2


def heights_of(samples: SurfaceSamples, ring: exact.Ring, demand: exact.Demand) -> Float[np.ndarray, "3 N"]:
    """Heights of the ring's cameras over the planes of the samples' faces, as `RingProfiles` has them.

    A pair of cameras that are b apart has the disparity gradient b sin γ / h: h is the mean of their heights, and γ the
    angle between the normal and their viewing direction, here the axis, from which that differs by a degree or two.
    """
    if demand.max_disparity_gradient is None:
        return np.zeros((3, len(samples)))
    east, north, west = ring.positions([0.0, np.pi / 2, np.pi])
    centre = (east + west) / 2
    height = np.stack([
        np.einsum("ni,ni->n", centre - samples.points, samples.normals),
        samples.normals @ (east - centre), samples.normals @ (north - centre),
    ])  # fmt: skip
    across = np.sqrt(np.maximum(1.0 - (samples.normals @ ring.frame[:, 2]) ** 2, LEAST_SLOPE**2))
    return height / across


def _unseen(visibility: Visibility, samples: SurfaceSamples, ring: exact.Ring, demand: exact.Demand) -> str:
    """Why no camera sees any of the samples: with limits, whether it is these."""
    if (
        demand.limits.is_any
        and visibility.without_limits().from_angles(samples, ring, ring.equidistant(VIEW_ANGLES)).any()
    ):
        return f"no view is usable ({', '.join(demand.limits.words)}); relax the limits or change the optics"
    return f"all {len(samples)} sample points are hidden or outside the field of view"


def faces_towards(mesh: trimesh.Trimesh, ring: exact.Ring) -> Bool[np.ndarray, " F"]:
    """(F,) bool: faces in front of which some point of the ring lies; all others are seen by no camera.

    Examples
    --------
    >>> box = trimesh.creation.box((100, 100, 10))
    >>> box.face_normals[faces_towards(box, exact.Ring())].tolist()
    [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]
    """
    east, north, west = ring.positions([0.0, np.pi / 2, np.pi])
    centre = (east + west) / 2
    normals = np.asarray(mesh.face_normals)
    # The farthest the circle reaches along a normal: centre plus radius times the normal's part in its plane.
    reach = normals @ centre + np.hypot(normals @ (east - centre), normals @ (north - centre))
    return reach > np.einsum("fi,fi->f", normals, np.asarray(mesh.triangles)[:, 0])


def in_view(corners: Float[np.ndarray, "P 3 3"], ring: exact.Ring) -> Bool[np.ndarray, " P"]:
    """(P,) bool: (P, 3, 3) triangles that may be inside the field of view of some camera of the ring.

    The field of view turns with the camera, so a camera is taken to see all within its circumcircle; and a camera
    between two of those asked is at most half a step of the ring away from one.
    """
    middle = corners.mean(axis=1)
    radius = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
    spread = np.hypot(*ring.fov) / 2 / np.hypot(ring.working_distance, ring.diameter / 2)
    reach = (radius + np.pi / VIEW_ANGLES * ring.diameter / 2) * np.hypot(1.0, spread)
    seen = np.zeros(len(corners), dtype=bool)
    for position, rotation, distance in zip(*poses(ring, ring.equidistant(VIEW_ANGLES)), strict=True):
        local = (middle - position) @ rotation.T
        # Turning by half a step also turns the optical axis, by less than the step over the working distance.
        turned = 2 * np.pi / VIEW_ANGLES * ring.diameter / 2 / distance * np.abs(local[:, 2])
        seen |= np.hypot(local[:, 0], local[:, 1]) <= spread * np.maximum(local[:, 2], 0) + reach + turned
    return seen


def _blind(reason: str, ring: exact.Ring, mesh: trimesh.Trimesh) -> str:
    low, high = (tuple(round(float(one), 3) for one in corner) for corner in mesh.bounds)
    return (
        f"no camera on this ring sees anything: {reason}. The ring looks from {ring.working_distance:g} mm at the "
        f"focus {ring.focus} [mm]; check units, orientation and position of the mesh, which reaches from {low} to "
        f"{high}"
    )


def _merged(profiles: RingProfiles, demand: exact.Demand) -> RingProfiles:
    """Drop points that no angle sees; merge those that every angle sees into one (the last).

    Not if errors or disparities are bounded, which are not alike. Else the mean error of all together stays the same.
    """
    always = np.asarray(profiles.visible.all(axis=0))
    if not demand.has_derivative:
        return profiles.subset(np.asarray(profiles.visible.any(axis=0)))
    decided = profiles.subset(np.asarray(profiles.visible.any(axis=0)) & ~always)
    if not always.any():
        return decided
    weight = profiles.weights[always].sum()
    noise = float(profiles.weights[always] @ profiles.noise[always] / weight) if weight > 0 else 0.0
    return RingProfiles(
        np.concatenate([decided.behind, np.full((profiles.n_angles, 1), 2 * np.pi)], axis=1),
        np.concatenate([decided.ahead, np.full((profiles.n_angles, 1), 2 * np.pi)], axis=1),
        np.append(decided.weights, profiles.weights[always].sum()),
        np.append(decided.site, 0),
        np.concatenate([decided.parts, profiles.parts[:, always].sum(axis=1, keepdims=True)], axis=1),
        np.append(decided.noise, noise),
        np.zeros((3, len(decided.weights) + 1)),
    )
