"""Faces that lie on top of others, look the same way and have other corners: what they share counts twice."""

from typing import NamedTuple

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

# Where in a face it is asked whether another lies there: in its middle, near each corner, and at random. In so many
# places of all faces together, as far as that goes: a part of a face of many is a small part of the whole.
CORNERS = np.array([[1, 1, 1], [10, 1, 1], [1, 10, 1], [1, 1, 10]]) / np.array([[3], [12], [12], [12]])
INSIDE = np.concatenate([CORNERS, np.random.default_rng(0).dirichlet((1, 1, 1), 60)])
PLACES = 200_000
# A ray starts this far above the face and ends as far below, in parts of the size: more than Embree's single precision
# loses.
REACH = 1e-5
# Two faces lie in one plane if a point of one is this near to the other, in parts of the greatest coordinate: those of
# a file in single precision are rounded to 6e-8 of them; and if the sine of the angle between them is at most that.
ROUNDING, PARALLEL = 1e-6, 1e-4
# A point lies in a face, and not just on its border, with so much of each barycentric coordinate.
WITHIN = 1e-3


class Overlapping(NamedTuple):
    """Faces on top of others."""

    pairs: np.ndarray
    """(N, 2) each such face, once, and one that it lies on."""
    points: np.ndarray
    """(N, 3) a point that both hold [mm]."""


def overlapping(vertices: np.ndarray, faces: np.ndarray) -> Overlapping:
    """Faces that lie on top of others and look the same way, found at points in each of them.

    Parameters
    ----------
    vertices, faces : (V, 3) float [mm], (F, 3) int
        All faces have area.

    Examples
    --------
    >>> import trimesh
    >>> low, high = trimesh.creation.box((10, 10, 2)), trimesh.creation.box((4, 4, 2))
    >>> both = trimesh.util.concatenate([low, high])
    >>> found = overlapping(both.vertices, both.faces)
    >>> len(found.pairs), float(abs(found.points[0, 2]))
    (4, 1.0)
    >>> len(overlapping(low.vertices, low.faces).pairs)
    0
    """
    corners = vertices[faces]
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    size, middle = float(np.linalg.norm(high - low)), 0.5 * (low + high)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    scene = EmbreeScene()
    TriangleMesh(scene, (corners - middle).astype(np.float32))
    pairs, points = [], []
    for weights in INSIDE[: max(PLACES // len(faces), 1)]:
        point = np.einsum("c,fck->fk", weights, corners)
        hit = scene.run(
            (point - middle + REACH * size * normals).astype(np.float32),
            -normals.astype(np.float32),
            dists=np.full(len(faces), 2 * REACH * size, dtype=np.float32),
            query="INTERSECT",
            output=True,
        )
        other = np.asarray(hit["primID"])
        asked = np.flatnonzero((other >= 0) & (other != np.arange(len(faces))))
        other = other[asked].astype(np.int64)
        same = _hold(corners[other], normals[other], point[asked], ROUNDING * float(np.abs(corners).max()))
        same &= (normals[asked] * normals[other]).sum(axis=1) > 1 - PARALLEL**2
        pairs.append(np.column_stack([asked, other])[same])
        points.append(point[asked][same])
    found, where = np.concatenate(pairs), np.concatenate(points)
    _, first = np.unique(found[:, 0], return_index=True)
    return Overlapping(found[first], where[first])


def _hold(corners: np.ndarray, normals: np.ndarray, points: np.ndarray, tolerance: float) -> np.ndarray:
    """(N,) bool: does each triangle (N, 3, 3) hold its point (N, 3), well within and to this distance [mm]."""
    arm = points - corners[:, 0]
    near = np.abs((arm * normals).sum(axis=1)) <= tolerance
    sides = np.roll(corners, -1, axis=1) - corners
    areas = np.einsum("nck,nk->nc", np.cross(sides, points[:, None] - corners), normals)
    return near & (areas > WITHIN * areas.sum(axis=1, keepdims=True)).all(axis=1)


def words(found: Overlapping, number: np.ndarray) -> str | None:
    """What that means for an area, with the numbers (F,) of the faces in the file; None where there are none."""
    if not len(found.pairs):
        return None
    (one, other), point = number[found.pairs[0]], found.points[0]
    where = ", ".join(f"{axis} {value:.4g}" for axis, value in zip("xyz", point, strict=True))
    return (
        f"{len(found.pairs)} faces lie on top of others that look the same way, such as face {one} on face {other} at "
        f"{where} mm; what they share counts twice: join the bodies, or remove one of them, in a mesh program"
    )
