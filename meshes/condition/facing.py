"""Which side of a surface is looked at, from places such as those of cameras, by rays to points all over it."""

from dataclasses import dataclass

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from meshes.distinct_rows import distinct_rows

# Points on the whole surface, and the fewest on each of its parts.
POINTS, LEAST_POINTS = 20_000, 12
# A point is hit if the ray ends this close to it, in parts of its length: Embree computes in single precision.
NEAR = 2e-5


@dataclass(frozen=True, eq=False)
class Facing:
    """What is seen of each part of a surface, by its area and not by its size in an image.

    Attributes
    ----------
    front, back : (P,) float
        Area of each part that is seen from its front and from its back [mm²], the mean over the places.
    total : (P,) float
        Area of each part [mm²].
    """

    front: np.ndarray
    back: np.ndarray
    total: np.ndarray

    @property
    def away(self) -> np.ndarray:
        """(P,) bool: parts of which more back than front is seen."""
        return self.back > self.front

    @property
    def back_share(self) -> float:
        """How much of what is seen is the back, from 0 to 1; 0 if nothing is seen."""
        seen = float(self.front.sum() + self.back.sum())
        return float(self.back.sum()) / seen if seen else 0.0


@dataclass(frozen=True, eq=False)
class Cone:
    """What is in view: from an apex (3,) [mm] around the line to a point (3,) [mm], so far from it there [mm]."""

    apex: np.ndarray
    towards: np.ndarray
    radius: float

    def holds(self, points: np.ndarray) -> np.ndarray:
        """(N,) bool: which of the points (N, 3) lie in it.

        Examples
        --------
        >>> cone = Cone(np.array([0, 0, 2.0]), np.zeros(3), 1.0)
        >>> cone.holds(np.array([[0.9, 0, 0], [1.1, 0, 0], [1.1, 0, -2], [0, 0, 3]])).tolist()
        [True, False, True, False]
        """
        axis = self.towards - self.apex
        arm = points - self.apex
        depth = arm @ axis / (axis @ axis)
        return np.linalg.norm(arm - depth[:, None] * axis, axis=1) <= self.radius * depth


def facing(
    vertices: np.ndarray, faces: np.ndarray, part: np.ndarray, places: np.ndarray, view: Cone | None = None
) -> Facing:
    """Which side of each part of a surface is seen.

    Estimated at points, by the same ones each time. A face that is there both ways round has no back.

    Parameters
    ----------
    vertices, faces : (V, 3) float [mm], (F, 3) int
    part : (F,) int
        The part that each face belongs to, from 0.
    places : (N, 3) float
        Where it is looked at from [mm].
    view : Cone, optional
        Only what lies in it is in view.

    Examples
    --------
    >>> import trimesh
    >>> bowl = trimesh.creation.icosphere(3, 10).slice_plane((0, 0, 0), (0, 0, -1))
    >>> seen = facing(bowl.vertices, bowl.faces, np.zeros(len(bowl.faces), dtype=int), np.array([[0, 0, 400.0]]))
    >>> bool(seen.away[0]), round(float(seen.back[0] / bowl.area), 3)
    (True, 1.0)
    """
    front, back, total = sides(vertices, faces, part, places, view)
    return Facing(front.mean(axis=0), back.mean(axis=0), total)


def sides(
    vertices: np.ndarray, faces: np.ndarray, part: np.ndarray, places: np.ndarray, view: Cone | None = None,
    n_points: int = POINTS,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """The same from each of the (N, 3) places: (N, P) seen from the front and from the back, (P,) in all [mm²]."""
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = 0.5 * np.linalg.norm(normals, axis=1)
    total = np.bincount(part, weights=areas)
    face, worth, points = spread(corners, areas, part, n_points)
    inside = np.ones(len(face), dtype=bool) if view is None else view.holds(points)
    _, kind = distinct_rows(np.sort(faces, axis=1))
    both_ways = (np.bincount(kind) > 1)[kind]
    # About the middle of the surface: single precision knows little far from the origin.
    middle = 0.5 * (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1)))
    scene = EmbreeScene()
    TriangleMesh(scene, (corners - middle).astype(np.float32))
    front, back = [], []
    for place in np.atleast_2d(places):
        ray = points - place
        side = -np.einsum("nk,nk->n", normals[face], ray)
        start = np.broadcast_to(place - middle, ray.shape).astype(np.float32)
        hit = scene.run(start, ray.astype(np.float32), query="INTERSECT", output=True)
        clear = inside & ((hit["primID"] < 0) | (hit["tfar"] >= 1 - NEAR))
        front.append(np.bincount(part[face], weights=worth * (clear & (side > 0)), minlength=len(total)))
        behind = clear & (side < 0) & ~both_ways[face]
        back.append(np.bincount(part[face], weights=worth * behind, minlength=len(total)))
    return np.array(front), np.array(back), total


def spread(
    corners: np.ndarray, areas: np.ndarray, part: np.ndarray, n_points: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points evenly over each part of a surface, more on the larger; the same ones each time.

    Parameters
    ----------
    corners, areas, part : (F, 3, 3) [mm], (F,) [mm²], (F,) int
        Of each face its corners, its area, and the part that it belongs to, from 0.
    n_points : int
        About so many in all.

    Returns
    -------
    (N,) int, (N,) [mm²], (N, 3) [mm]
        Of each point its face, the area that it stands for, and where it is.
    """
    total = np.bincount(part, weights=areas)
    wanted = np.maximum(np.ceil(n_points * total / max(total.sum(), np.finfo(float).tiny)), LEAST_POINTS).astype(int)
    wanted[total <= 0] = 0
    order = np.argsort(part, kind="stable")
    along = np.cumsum(areas[order])
    first = np.cumsum(total) - total
    at = np.concatenate([np.zeros(0), *(
        first[one] + total[one] * (np.arange(number) + 0.5) / number for one, number in enumerate(wanted) if number
    )])  # fmt: skip
    face = order[np.minimum(np.searchsorted(along, at), len(order) - 1)]
    random = np.random.default_rng(0).random((2, len(face)))
    u, v = np.where(random.sum(axis=0) > 1, 1 - random, random)
    a, b, c = corners[face].transpose(1, 0, 2)
    points = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    return face, (total / np.maximum(wanted, 1))[part[face]], points
