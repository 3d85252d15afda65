"""How well a layout triangulates: separations, and the angles under which rays from two cameras meet."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import trimesh

import exact
from exact.requests import ASKED, checked, shows
from placement.errors import refusing
from placement.samples.profiles import Visibility
from placement.samples.sampled_site import faces_towards, heights_of, in_view, noise_of
from placement.samples.sampling import sample_surface
from placement.samples.viewed_samples import pair_matches, samples_met


@dataclass(frozen=True, eq=False)
class Triangulation:
    """Triangulation angles of one layout over the area it reconstructs.

    Attributes
    ----------
    smallest_separation : float
        Least chord between two cameras [mm]; infinite for one camera.
    widest_angle : float
        Greatest angle between two rays that meet in a reconstructable point [rad]; 0 where there is none.
    mean_best_angle : float
        Mean over the reconstructable area of each point's best (widest) angle [rad]; 0 where there is none.
    best_angles : (N,) ndarray
        Best angle of each reconstructable sample [rad]; 0 for one that a single camera sees.
    weights : (N,) ndarray
        Area each of these samples stands for [mm²].
    """

    smallest_separation: float
    widest_angle: float
    mean_best_angle: float
    best_angles: np.ndarray
    weights: np.ndarray

    def best_angle_quantiles(self, shares: Sequence[float] = (0.05, 0.5, 0.95)) -> tuple[float, ...]:
        """Best angles [rad] that these shares of the reconstructable area do not exceed; 0 where there is none.

        Examples
        --------
        >>> found = Triangulation(5.0, 0.4, 0.25, np.array([0.4, 0.1]), np.array([1.0, 1.0]))
        >>> found.best_angle_quantiles((0.05, 0.5, 0.95))
        (0.1, 0.1, 0.4)
        """
        if len(self.best_angles) == 0:
            return (0.0,) * len(shares)
        return tuple(np.quantile(self.best_angles, list(shares), weights=self.weights, method="inverted_cdf").tolist())

    @classmethod
    def together(cls, parts: Sequence["Triangulation"]) -> "Triangulation":
        """One layout over the area that it reconstructs of several sites, from its results at each, at least one.

        Examples
        --------
        >>> one = Triangulation(5.0, 0.1, 0.1, np.array([0.1]), np.array([2.0]))
        >>> none = Triangulation(5.0, 0.0, 0.0, np.zeros(0), np.zeros(0))
        >>> Triangulation.together([one, none]).mean_best_angle, Triangulation.together([none]).widest_angle
        (0.1, 0.0)
        """
        best = np.concatenate([part.best_angles for part in parts])
        weights = np.concatenate([part.weights for part in parts])
        mean = float(np.average(best, weights=weights)) if len(best) else 0.0
        return cls(parts[0].smallest_separation, float(best.max(initial=0.0)), mean, best, weights)


@shows(ASKED)
def triangulation(
    mesh: trimesh.Trimesh | exact.Scene,
    ring: exact.Ring,
    angles,
    *,
    rolls=None,
    n_samples: int = 20_000,
    seed: int = 0,
    **asked: Any,
) -> Triangulation:
    """Measure the triangulation angles of a layout on samples of the surface.

    Parameters
    ----------
    mesh : trimesh.Trimesh or exact.Scene
        The site [mm].
    ring : exact.Ring
        The ring.
    angles : (M,) array_like
        Ring angles [rad].
    rolls : (M,) array_like, optional
        Of the cameras [rad], as `exact.Ring.cameras` takes them.
    n_samples : int
        Sample points where the ring may see the surface.
    seed : int
        Of the samples.
    exclude, weights, threshold, min_baseline, demand
        What of the mesh counts and what makes a point count, as for `exact.evaluate`. Only pairs of cameras that are
        far enough apart, and match the point, triangulate.

    Returns
    -------
    Triangulation
        A layout that reconstructs nothing has angles 0 and no samples.

    Examples
    --------
    >>> plate = trimesh.creation.box((1, 1, 0.001))
    >>> found = triangulation(plate, exact.Ring(), [0.0, np.pi], exclude=plate.face_normals[:, 2] < 0.5)
    >>> round(float(np.degrees(found.widest_angle)), 1), found.smallest_separation  # 2 atan(15 / 400)
    (4.3, 30.0)
    """
    with refusing():
        scene, demand = checked(mesh, asked)
        separations = ring.separations(angles)
    theta = np.asarray(angles, dtype=np.float64)
    smallest = float(np.min(separations[~np.eye(len(theta), dtype=bool)], initial=np.inf))
    nothing = Triangulation(smallest, 0.0, 0.0, np.zeros(0), np.zeros(0))
    ignored = ~scene.counted | ~faces_towards(scene.everything, ring)
    if ignored.all():
        return nothing
    samples = sample_surface(scene.everything, n_samples, ignored, seed, lambda corners: in_view(corners, ring))
    if len(samples) == 0:
        return nothing
    visibility = Visibility(scene.everything, demand)
    samples = samples.subset(visibility.lit(samples, scene.lights))
    seen = visibility.from_angles(samples, ring, theta, rolls)
    heights = heights_of(samples, ring, demand)
    reconstructed = samples_met(seen, theta, demand, ring, noise_of(samples, ring, demand), heights)
    if scene.weights is not None:
        samples = replace(samples, weights=samples.weights * scene.weights[samples.faces])
        reconstructed &= samples.weights > 0
    if not reconstructed.any():
        return nothing
    far = demand.apart(separations)
    rays = ring.positions(theta)[:, None, :] - samples.points[reconstructed]
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    best = np.zeros(int(reconstructed.sum()))
    for i in range(len(theta)):
        for j in np.flatnonzero(far[i, :i]):
            both = seen[i, reconstructed] & seen[j, reconstructed]
            if demand.max_disparity_gradient is not None:
                both &= pair_matches(theta[[i, j]], demand, ring, heights[:, reconstructed])
            # 2 asin(half the difference) keeps its digits for small angles, acos of the product does not.
            angle = 2 * np.arcsin(np.minimum(np.linalg.norm(rays[i] - rays[j], axis=1) / 2, 1.0))
            best = np.maximum(best, np.where(both, angle, 0.0))
    weights = samples.weights[reconstructed]
    return Triangulation(smallest, float(best.max()), float(np.average(best, weights=weights)), best, weights)
