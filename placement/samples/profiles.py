r"""Ring profiles: from which ring angles a point is seen, and how far away the next change is.

A point is visible from a ring angle if its face is turned towards the camera, it lies inside the field of view
(which turns with the ring angle), and no face lies between (Embree). Where the boolean profile on a regular grid of
angles changes, further rays find the angle; every grid angle then knows how far behind and how far ahead of it the
nearest changes are. The nearer of the two is the signed angular distance, positive where visible::

    visible          ------#########-------------#####-----
    signed distance        /\                    /\
                     \    /  \      /\     /\   /  \   /
                  0 --\--/----\----/--\---/--\-/----\-/----   ring angle ->
                       \/      \  /    \ /    \      \
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import trimesh
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from jaxtyping import Bool, Float, Int

import exact
from exact.ring import MOST_CAMERAS, Poses, poses
from exact.whole_numbers import is_whole
from placement.errors import PlacementError
from placement.samples.sampling import SurfaceSamples

# Embree computes in single precision. A ray starts this fraction of the mesh's extent above its face: some 30 times
# the rounding of a coordinate, so it does not hit the face it leaves. Not more: walls of a channel are seen under one
# or two degrees, where a start 1e-5 above moved the border of a shadow enough to change areas by 0.3 %.
RAY_OFFSET = 1e-6
RAYS_PER_BATCH = 1_000_000  # some 100 MB of intermediate arrays
# Interleaved parts of the samples.
N_PARTS = 8


@dataclass(frozen=True, eq=False)
class RingProfiles:
    """Visibility of sample points around a ring.

    Between two grid angles visibility changes once or not at all.

    Attributes
    ----------
    behind, ahead : (K, N) ndarray
        Angle [rad] from ring angle 2 pi k / K back to the last and on to the next change of visibility of point n,
        both positive where visible and negative where not. A full turn where visibility never changes.
    weights : (N,) ndarray
        What each point counts: the area it stands for [mm²], or its share of the ring maximum.
    site : (N,) ndarray of int
        Sum to which each point belongs, from 0; what a layout is worth is the least of its sums.
    parts : (P, N) ndarray
        Weight of each point in each of P interleaved parts of the samples, whose scatter measures the sampling error;
        they add up to `weights`. A point that stands for several samples has weight in several parts.
    noise : (N,) ndarray
        Variance of each point's predicted error times the spread of the cameras that see it, the sum of their squared
        distances from their centre [mm⁴]; 0 where errors are of no concern.
    heights : (3, N) ndarray
        Height of a camera at ring angle θ over the plane of each point's face, over the sine of the angle between its
        normal and the ring's axis, as the factors of 1, cos θ and sin θ [mm]; 0 where disparities are of no concern.
    """

    behind: Float[np.ndarray, "K N"]
    ahead: Float[np.ndarray, "K N"]
    weights: Float[np.ndarray, " N"]
    site: Int[np.ndarray, " N"]
    parts: Float[np.ndarray, "P N"]
    noise: Float[np.ndarray, " N"]
    heights: Float[np.ndarray, "3 N"]

    @staticmethod
    def of(signed_distance: Float[np.ndarray, "K N"], weights: Float[np.ndarray, " N"]) -> "RingProfiles":
        """Profiles of single samples, of which all belong to one sum.

        Visibility changes where linear interpolation of the signed distances [rad] on the grid crosses zero.

        Examples
        --------
        >>> profiles = RingProfiles.of(np.array([[1.0], [-0.5], [-1.0], [-0.5]]), np.ones(1))
        >>> profiles.at(np.radians([50, 70, 290, 310]))[:, 0].tolist()  # the arc ends at 60 degrees
        [True, False, False, True]
        """
        visible = signed_distance > 0
        at, point = _changes(visible)
        here, there = signed_distance[at, point], signed_distance[(at + 1) % len(visible), point]
        return RingProfiles._between(
            visible, at, point, (at + here / (here - there)) * 2 * np.pi / len(visible), weights
        )

    @staticmethod
    def _between(
        visible: Bool[np.ndarray, "K N"],
        at: Int[np.ndarray, " C"],
        point: Int[np.ndarray, " C"],
        change: Float[np.ndarray, " C"],
        weights: Float[np.ndarray, " N"],
    ) -> "RingProfiles":
        """Profiles of single samples with changes at angles `change` in [grid[at], grid[at + 1]] of points `point`."""
        n_angles = len(visible)
        step = 2 * np.pi / n_angles
        behind, ahead = np.full(visible.shape, np.inf), np.full(visible.shape, np.inf)
        behind[(at + 1) % n_angles, point] = (at + 1) * step - change
        ahead[at, point] = change - at * step
        for k in range(1, 2 * n_angles):  # twice around: the circle has no first angle
            here, there = k % n_angles, (k - 1) % n_angles
            behind[here] = np.minimum(behind[here], behind[there] + step)
            here, there = -k % n_angles, (-k + 1) % n_angles
            ahead[here] = np.minimum(ahead[here], ahead[there] + step)
        sign = np.where(visible, 1.0, -1.0)
        number = np.arange(len(weights))
        return RingProfiles(
            sign * np.minimum(behind, 2 * np.pi),
            sign * np.minimum(ahead, 2 * np.pi),
            weights,
            np.zeros(len(weights), dtype=np.int64),
            np.where(number % N_PARTS == np.arange(N_PARTS)[:, None], weights, 0.0),
            np.zeros(len(weights)),
            np.zeros((3, len(weights))),
        )

    @property
    def n_sites(self) -> int:
        """Number of sums."""
        return int(self.site.max(initial=0)) + 1

    def sums(self, covered: Bool[np.ndarray, " N"]) -> Float[np.ndarray, " S"]:
        """(n_sites,) weight of the points that the (N,) mask `covered` chooses, site by site."""
        # Of no points at all it gives whole numbers.
        return np.bincount(self.site, weights=self.weights * covered, minlength=self.n_sites).astype(np.float64)

    @property
    def n_angles(self) -> int:
        """Number of grid angles K."""
        return self.ahead.shape[0]

    @cached_property
    def visible(self) -> Bool[np.ndarray, "K N"]:
        """(K, N) bool, the boolean profiles on the grid."""
        return self.behind + self.ahead > 0

    @property
    def signed_distance(self) -> Float[np.ndarray, "K N"]:
        """(K, N) angle [rad] from each grid angle to the nearest change, positive where visible.

        pi for a point visible from everywhere, -pi for one visible from nowhere.
        """
        nearest = np.minimum(np.minimum(np.abs(self.behind), np.abs(self.ahead)), np.pi)
        return np.where(self.visible, nearest, -nearest)

    def subset(self, keep: Bool[np.ndarray, " N"]) -> "RingProfiles":
        """Profiles of the points where the (N,) mask `keep` is true."""
        return RingProfiles(
            self.behind[:, keep], self.ahead[:, keep], self.weights[keep], self.site[keep], self.parts[:, keep],
            self.noise[keep], self.heights[:, keep],
        )  # fmt: skip

    def scaled(self, factor: float) -> "RingProfiles":
        """The same points, each counting `factor` times as much."""
        return replace(self, weights=factor * self.weights, parts=factor * self.parts)

    def thinned(self, step: int) -> "RingProfiles":
        """Every `step`-th of the interleaved parts alone, each counting `step` times as much."""
        parts = self.parts[::step]
        weights = parts.sum(axis=0) * (len(self.parts) / len(parts))
        return replace(self, weights=weights).subset(weights > 0)

    def at(self, angles) -> Bool[np.ndarray, "M N"]:
        """Visibility of each point from any ring angles: that of the grid angle before it, until the next change.

        Parameters
        ----------
        angles : (M,) array_like
            Ring angles [rad].

        Returns
        -------
        (M, N) ndarray of bool
        """
        position = np.mod(np.asarray(angles, dtype=np.float64) / (2 * np.pi), 1.0) * self.n_angles
        left = np.floor(position).astype(np.int64)
        beyond = ((position - left) * 2 * np.pi / self.n_angles)[:, None]  # the grid angle before, by this much
        left = left % self.n_angles
        return self.ahead[left] > np.where(self.visible[left], beyond, -beyond)


class Visibility:
    """Which sample points a camera sees; holds the Embree scene of one mesh.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        Everything that can hide something, excluded faces and obstacles too [mm].
    demand : exact.Demand, optional
        Only its limits and optics matter here: a camera sees a point only if its view is usable.

    Examples
    --------
    >>> from placement.samples.sampling import sample_surface
    >>> plate = trimesh.creation.box((10, 10, 1))
    >>> samples = sample_surface(plate, 100)
    >>> seen = Visibility(plate).from_angles(samples, exact.Ring(), [0.0, 1.0])
    >>> seen.shape, bool(seen[:, samples.normals[:, 2] > 0.5].all()), bool(seen[:, samples.normals[:, 2] < -0.5].any())
    ((2, 100), True, False)
    """

    def __init__(self, mesh: trimesh.Trimesh, demand: exact.Demand | None = None):
        self._demand, self._any_roll = exact.Demand() if demand is None else demand, False
        # Only what hides: vertices that no face with area uses may be anywhere.
        used, faces = np.unique(mesh.faces[mesh.area_faces > 0], return_inverse=True)
        vertices = np.asarray(mesh.vertices)[used]
        bounds = np.stack([vertices.min(axis=0), vertices.max(axis=0)])
        # Centred: single precision is finest around the origin.
        self._centre = bounds.mean(axis=0)
        self._offset = RAY_OFFSET * float(np.ptp(bounds, axis=0).max())
        self._scene = EmbreeScene()
        vertices = np.ascontiguousarray(vertices - self._centre, dtype=np.float32)
        TriangleMesh(self._scene, vertices, np.ascontiguousarray(faces.reshape(-1, 3), dtype=np.int32))

    def from_angles(self, samples: SurfaceSamples, ring: exact.Ring, angles, rolls=None) -> Bool[np.ndarray, "M N"]:
        """(M, N) bool: does the camera at each of the (M,) ring angles [rad] see each of the N samples.

        `rolls` are those of the cameras (M,) [rad], as `exact.Ring.cameras` takes them.
        """
        cameras = poses(ring, angles, rolls)
        n_cameras, n_points = len(cameras.positions), len(samples)
        seen = np.zeros((n_cameras, n_points), dtype=bool)
        if n_points == 0:
            return seen
        step = max(1, RAYS_PER_BATCH // n_points)
        for first in range(0, n_cameras, step):
            batch = np.arange(first, min(first + step, n_cameras))
            which, point = np.repeat(batch, n_points), np.tile(np.arange(n_points), len(batch))
            seen[batch] = self._pairs(samples, ring, cameras, which, point).reshape(-1, n_points)
        return seen

    def pairs(self, samples: SurfaceSamples, ring: exact.Ring, angles, points) -> Bool[np.ndarray, " P"]:
        """(P,) bool: does the camera at ring angle `angles[p]` [rad] see sample number `points[p]`."""
        points = np.asarray(points, dtype=np.int64)
        if len(points) == 0:
            return np.zeros(0, dtype=bool)
        distinct, which = np.unique(np.asarray(angles, dtype=np.float64), return_inverse=True)
        # Fine bisections ask about more angles than a ring may hold cameras.
        parts = np.split(distinct, range(MOST_CAMERAS, len(distinct), MOST_CAMERAS))
        cameras = Poses(*map(np.concatenate, zip(*(poses(ring, part) for part in parts), strict=True)))
        return self._pairs(samples, ring, cameras, which, points)

    def _pairs(
        self,
        samples: SurfaceSamples,
        ring: exact.Ring,
        cameras: Poses,
        which: Int[np.ndarray, " P"],
        point: Int[np.ndarray, " P"],
    ) -> Bool[np.ndarray, " P"]:
        positions, rotations, distances = cameras
        half_extents = 0.5 * np.array(ring.fov) / distances[:, None]

        to_camera = positions[which] - samples.points[point]
        height = np.einsum("pi,pi->p", to_camera, samples.normals[point])
        facing = height > 0
        local = np.einsum("pij,pj->pi", rotations[which], -to_camera)  # right, down, look
        depth = local[:, 2:]
        if self._any_roll:  # in the circle around the field of view, which it fills as it turns
            reach = np.hypot(*half_extents[which].T) * depth[:, 0]
            inside = (depth[:, 0] > 0) & (np.hypot(local[:, 0], local[:, 1]) <= reach)
        else:
            inside = (depth[:, 0] > 0) & (np.abs(local[:, :2]) <= half_extents[which] * depth).all(axis=1)

        seen = facing & inside
        if self._demand.limits.is_any:  # cameras of one ring differ in nothing that limits depend on
            camera, distance = ring.cameras([0.0])[0], np.linalg.norm(to_camera, axis=1)
            seen &= self._demand.limits.met_at(depth[:, 0], height, distance, camera, self._demand.optics)
        candidate = np.flatnonzero(seen)
        if len(candidate):
            seen[candidate] = self._reaches(samples.subset(point[candidate]), positions[which[candidate]])
        return seen

    def without_limits(self) -> "Visibility":
        """The same, where to be seen is enough."""
        return self._but(_demand=exact.Demand())

    def at_any_roll(self) -> "Visibility":
        """The same, where it is enough to be seen with some roll of the camera."""
        return self._but(_any_roll=True)

    def _but(self, **changed) -> "Visibility":
        other = object.__new__(Visibility)
        vars(other).update(vars(self) | changed)
        return other

    def lit(self, samples: SurfaceSamples, lights: Sequence[Sequence[float]]) -> Bool[np.ndarray, " N"]:
        """(N,) bool: do the samples face one of the lights [mm], with nothing between; all are lit by no lights."""
        found = np.full(len(samples), not lights)
        for light in np.array(lights).reshape(-1, 3):
            facing = np.flatnonzero(~found & (np.einsum("ni,ni->n", light - samples.points, samples.normals) > 0))
            found[facing] = self._reaches(samples.subset(facing), np.broadcast_to(light, (len(facing), 3)))
        return found

    def _reaches(self, samples: SurfaceSamples, targets: Float[np.ndarray, "N 3"]) -> Bool[np.ndarray, " N"]:
        """(N,) bool: does nothing lie between the samples and their targets (N, 3) [mm]."""
        if len(samples) == 0:
            return np.zeros(0, dtype=bool)
        start = samples.points + self._offset * samples.normals
        ray = targets - start
        distance = np.linalg.norm(ray, axis=1)
        hit = self._scene.run(
            np.ascontiguousarray(start - self._centre, dtype=np.float32),
            np.ascontiguousarray(ray / distance[:, None], dtype=np.float32),
            dists=distance.astype(np.float32),
            query="OCCLUDED",
        )
        return np.asarray(hit < 0)  # -1 where nothing was hit before the target


def ring_profiles(
    mesh: trimesh.Trimesh | Visibility,
    samples: SurfaceSamples,
    ring: exact.Ring,
    n_angles: int = 120,
    bisections: int = 5,
) -> RingProfiles:
    """Arcs of the ring from which every sample is visible.

    Each change found between two grid angles is located by `bisections` further rays, so its angle is known to
    2 pi / K / 2**(bisections + 1). An arc of visibility (or of its absence) that holds no grid angle is missed; it is
    narrower than the grid's step.

    Parameters
    ----------
    mesh : trimesh.Trimesh or Visibility
        What hides; a `Visibility` saves building the scene again.
    samples : SurfaceSamples
        N points.
    ring : exact.Ring
        The ring.
    n_angles : int
        Number of grid angles K.
    bisections : int
        Further rays for each change of visibility.

    Examples
    --------
    >>> from placement.samples.sampling import sample_surface
    >>> plate = trimesh.creation.box((10, 10, 1))
    >>> top = sample_surface(plate, 50, exclude=plate.face_normals[:, 2] < 0.5)
    >>> profiles = ring_profiles(plate, top, exact.Ring(), n_angles=12)
    >>> profiles.signed_distance.shape
    (12, 50)
    >>> np.unique(profiles.signed_distance).tolist()  # seen from everywhere
    [3.141592653589793]
    """
    if not (is_whole(n_angles) and n_angles >= 4):
        raise PlacementError(f"number of profile angles is {n_angles}; it must be a whole number, at least 4")
    visibility = mesh if isinstance(mesh, Visibility) else Visibility(mesh)
    step = 2 * np.pi / n_angles
    grid = step * np.arange(n_angles)
    visible = visibility.from_angles(samples, ring, grid)

    at, point = _changes(visible)
    before = visible[at, point]  # halve the interval by asking its middle
    low, width = grid[at], step
    for _ in range(bisections):
        width = width / 2
        low = low + width * (visibility.pairs(samples, ring, low + width, point) == before)
    return RingProfiles._between(visible, at, point, low + width / 2, samples.weights)


def _changes(visible: Bool[np.ndarray, "K N"]) -> tuple[Int[np.ndarray, " C"], Int[np.ndarray, " C"]]:
    """Grid angle k and point n of each change of visibility, which lies between grid angles k and k + 1."""
    at, point = np.nonzero(visible != np.roll(visible, -1, axis=0))
    return at, point
