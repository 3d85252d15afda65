"""What is seen of a surface from anywhere: points all over it, and rays from them."""

from functools import cached_property

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from scipy.spatial import ConvexHull

from meshes.condition.facing import spread
from meshes.condition.winding import sphere_around

# A ray starts this far above the surface, in parts of its size: more than Embree's single precision loses.
OFFSET = 1e-5
# Points of a surface thinner than this part of its size lie in a plane, as a hull goes.
FLAT = 1e-9
# What lies this far below the convex hull, in parts of the size, lies in a hollow.
HOLLOW = 0.02
# What is seen along the surface is worth so much less than what is seen straight on, where it is no wall of a hollow.
SLANT = 0.7
# Of more corners than this those count that are the outermost in one of so many directions: what that takes off the
# hull is far less than a hollow is deep.
EXTREMES = 2_000
# Rows of points and planes at once: 64 MB.
BLOCK = 8_000_000


class Surface:
    """A surface that rays are sent to.

    Parameters
    ----------
    vertices, faces : (V, 3) float [mm], (F, 3) int
        All faces have area.

    Attributes
    ----------
    corners, normals : (F, 3, 3) float [mm], (F, 3) float
        Of each face its corners, and its unit normal.
    areas : (F,) float
        [mm²]
    middle : (3,) float
        Of its box [mm].
    size : float
        Diagonal of that box [mm].
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray):
        self.corners = corners = vertices[faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        twice = np.linalg.norm(normals, axis=1)
        self.normals, self.areas = normals / twice[:, None], 0.5 * twice
        low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        self.middle, self.size = 0.5 * (low + high), float(np.linalg.norm(high - low))
        self.rays = EmbreeScene()
        # About its middle: single precision knows little far from the origin.
        TriangleMesh(self.rays, (corners - self.middle).astype(np.float32))

    @cached_property
    def hull(self) -> np.ndarray:
        """(H, 4) planes around it, n·x + d <= 0 within, x from the middle; none for a flat surface."""
        corners = np.unique(self.corners.reshape(-1, 3), axis=0) - self.middle
        if np.linalg.matrix_rank(corners, tol=FLAT * self.size * np.sqrt(len(corners))) < 3:
            return np.zeros((0, 4))
        if len(corners) > EXTREMES:
            around = sphere_around(np.zeros((1, 3)) + [[-1.0], [1.0]], EXTREMES)
            step = max(BLOCK // len(corners), 1)
            extreme = [np.argmax(corners @ around[at : at + step].T, axis=0) for at in range(0, EXTREMES, step)]
            corners = corners[np.unique(np.concatenate(extreme))]
        return ConvexHull(corners).equations


class Sight:
    """Points all over a surface, and which of them are seen.

    Parameters
    ----------
    surface : Surface
        Only its fronts are seen; backs hide all the same.
    n_points : int
        How many points.
    focus, axis, radius : (3,) float, (3,) float, float, optional
        Only on faces that come so near to a line through a point [mm].

    Attributes
    ----------
    points, normals : (N, 3) float
        [mm], and unit vectors.
    worth : (N,) float
        The area that each point stands for [mm²].

    Examples
    --------
    >>> import trimesh
    >>> box = trimesh.creation.box((10, 10, 10))
    >>> sight = Sight(Surface(box.vertices, box.faces), 1200)
    >>> float(sight.worth[sight.seen(np.array([0, 0, 400.0]))].sum())
    100.0
    """

    def __init__(
        self, surface: Surface, n_points: int, focus: np.ndarray | None = None, axis: np.ndarray | None = None,
        radius: float = np.inf,
    ):  # fmt: skip
        self.surface, self.middle, self.size = surface, surface.middle, surface.size
        areas = surface.areas
        if focus is not None and axis is not None:
            centre = surface.corners.mean(axis=1)
            reach = np.linalg.norm(surface.corners - centre[:, None], axis=2).max(axis=1)
            arm = centre - focus
            near = np.linalg.norm(arm - np.outer(arm @ axis, axis), axis=1) <= radius + reach
            areas = np.where(near, areas, 0.0) if near.any() else areas
        face, self.worth, self.points = spread(surface.corners, areas, np.zeros(len(areas), dtype=int), n_points)
        self.normals = surface.normals[face]
        self._starts = self.points - self.middle + OFFSET * self.size * self.normals

    def seen(self, place: np.ndarray, among: np.ndarray | None = None) -> np.ndarray:
        """(N,) bool: points that are seen from a place (3,) [mm], of those `among` which, (N,) bool."""
        towards = place - self.points
        found = np.einsum("nk,nk->n", towards, self.normals) > 0
        if among is not None:
            found &= among
        asked = np.flatnonzero(found)
        if not len(asked):
            return found
        length = np.linalg.norm(towards[asked], axis=1)
        # No further than what could lie in between: single precision knows little far away.
        hit = self.surface.rays.run(
            self._starts[asked].astype(np.float32),
            (towards[asked] / length[:, None]).astype(np.float32),
            dists=np.minimum(length, 2 * self.size).astype(np.float32),
            query="OCCLUDED",
        )
        found[asked] = np.asarray(hit) < 0
        return found

    @cached_property
    def sunk(self) -> np.ndarray:
        """(N,) how far each point lies below the convex hull of the surface [mm]; 0 for a flat one."""
        planes = self.surface.hull
        depth = np.full(len(self.points), np.inf if len(planes) else 0.0)
        step = max(BLOCK // len(self.points), 1)
        for first in range(0, len(planes), step):
            some = planes[first : first + step]
            below = -((self.points - self.middle) @ some[:, :3].T + some[:, 3])
            np.minimum(depth, below.min(axis=1), out=depth)
        return np.maximum(depth, 0.0)

    def worth_seeing(self, of_hollows: bool, axis: np.ndarray) -> np.ndarray:
        """(N,) how good it is to see each point along an axis [mm²]: in a hollow its area, else less at a slant."""
        if of_hollows:
            return self.worth * self.in_hollow
        return self.worth * (1 - SLANT * (1 - np.maximum(self.normals @ axis, 0.0) ** 2))

    @property
    def in_hollow(self) -> np.ndarray:
        """(N,) bool: points that lie in a hollow."""
        return self.sunk > HOLLOW * self.size


def across(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors across an axis and each other."""
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    return first, np.cross(axis, first)


def quantile(values: np.ndarray, worth: np.ndarray, part: float) -> float:
    """The value below which this part of a worth (N,) lies."""
    order = np.argsort(values, kind="stable")
    along = np.cumsum(worth[order])
    return float(values[order[min(np.searchsorted(along, part * along[-1]), len(order) - 1)]])
