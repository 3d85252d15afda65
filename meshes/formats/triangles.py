"""Cut polygons into triangles that cover them once, whichever corner a file begins with: concave and with holes too."""

import numpy as np
import shapely

from meshes.errors import MeshError
from meshes.formats.polygons import Polygons

# Of a convex polygon each corner turns by more than this, in parts of its area: far above rounding.
TURN = 1e-9
# Triangles that cover a polygon have its area but for rounding; those of one that crosses itself have not.
AREA = 1e-6
# A polygon of less area than this part of its squared length is so thin that rounding may make it cross itself.
THIN = 1e-9


def triangles_of(name: str, polygons: Polygons) -> tuple[np.ndarray, np.ndarray]:
    """Triangles of polygons whose vertices are all in different places.

    Parameters
    ----------
    name : str
        Of the file, for messages.
    polygons : Polygons
        Those with four corners or more should be flat; what is not is cut as it looks along its mean normal.

    Returns
    -------
    triangles : (T, 3) int
        Vertices, wound as the polygon; in the order of the polygons. One without area gives a triangle without area.
    polygon : (T,) int
        Which polygon each is of.

    Raises
    ------
    MeshError
        If a polygon crosses itself.
    """
    sizes, starts = polygons.sizes, polygons.starts
    if (sizes == 3).all():
        return polygons.corners.reshape(-1, 3), np.arange(len(sizes))
    small = np.flatnonzero(sizes == 3)
    parts, owners = [polygons.corners[starts[small][:, None] + np.arange(3)]], [small]
    for size in np.unique(sizes[sizes > 3]):
        many = np.flatnonzero(sizes == size)
        corners = polygons.corners[starts[many][:, None] + np.arange(size)]
        convex = _convex(polygons.vertices[corners])
        fan = np.stack([np.zeros(size - 2, dtype=np.int64), np.arange(1, size - 1), np.arange(2, size)], axis=1)
        parts.append(corners[convex][:, fan].reshape(-1, 3))
        owners.append(np.repeat(many[convex], size - 2))
        for one in np.flatnonzero(~convex):
            cut = _cut(name, int(many[one]), polygons.vertices, corners[one])
            parts.append(cut)
            owners.append(np.full(len(cut), many[one]))
    owner = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    return np.concatenate(parts)[order], owner[order]


def _flat(points: np.ndarray) -> np.ndarray:
    """(P, N, 2) polygons (P, N, 3) along their mean normals, which come out counter-clockwise; 0 for one without."""
    arm = points - points[:, :1]
    normal = np.cross(arm, np.roll(arm, -1, axis=1)).sum(axis=1)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)
    # The axis to which the normal is least parallel gives a first direction across it.
    least = np.eye(3)[np.abs(normal).argmin(axis=1)]
    first = np.cross(least, normal)
    first /= np.maximum(np.linalg.norm(first, axis=1, keepdims=True), np.finfo(float).tiny)
    second = np.cross(normal, first)
    return np.stack([np.einsum("pnk,pk->pn", arm, axis) for axis in (first, second)], axis=2)


def _convex(points: np.ndarray) -> np.ndarray:
    """(P,) whether polygons (P, N, 3) are convex, and no corner of them is straight."""
    if not np.isfinite(points).all():
        return np.ones(len(points), dtype=bool)  # as good as any: the check will name the vertex
    flat = _flat(points)
    side = np.roll(flat, -1, axis=1) - flat
    after = np.roll(side, -1, axis=1)
    turn = side[..., 0] * after[..., 1] - side[..., 1] * after[..., 0]
    angle = np.arctan2(turn, (side * after).sum(axis=2)).sum(axis=1)  # of a star more than once around
    area = _area(flat)
    return (turn > TURN * np.abs(area)[:, None]).all(axis=1) & (area > 0) & (angle < 3 * np.pi)


def _area(flat: np.ndarray) -> np.ndarray:
    after = np.roll(flat, -1, axis=1)
    return 0.5 * (flat[..., 0] * after[..., 1] - flat[..., 1] * after[..., 0]).sum(axis=1)


def _cut(name: str, number: int, vertices: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(T, 3) triangles of one polygon of any shape."""
    corners = corners[corners != np.roll(corners, 1)]
    if len(corners) < 3:
        return np.resize(corners if len(corners) else np.zeros(1, dtype=np.int64), (1, 3))
    flat = _flat(vertices[corners][None])[0]
    if _area(flat[None])[0] <= 0:
        return corners[None, :3][:, [0, 1, 0]]
    place = {int(corner): tuple(point) for corner, point in zip(corners, flat.tolist(), strict=True)}
    vertex = {point: corner for corner, point in place.items()}
    found = [_cut_flat(shape, vertex) for shape in _shapes(_loops([int(one) for one in corners]), place)]
    if found and all(one is not None for one in found):
        cut = np.concatenate([one for one in found if one is not None])
        if abs(_covered(cut, place) - _area(flat[None])[0]) <= AREA * _covered(cut, place):
            return cut
    fan = np.stack([np.full(len(corners) - 2, corners[0]), corners[1:-1], corners[2:]], axis=1)
    length = np.linalg.norm(np.roll(flat, -1, axis=0) - flat, axis=1).sum()
    if _covered(fan, place) <= THIN * length**2:
        return fan
    raise MeshError(
        f"{name}: face {number}, a polygon of {len(corners)} corners, crosses itself, so that it has no area of its "
        "own; cut it into triangles in a mesh program"
    )


def _loops(corners: list[int]) -> list[list[int]]:
    """Rings without a corner twice: a bridge to a hole, run along both ways, falls out."""
    loops, ring, seen = [], [], {}
    for corner in corners:
        if corner in seen:
            begin = seen[corner]
            loops.append(ring[begin:])
            for gone in ring[begin:]:
                del seen[gone]
            del ring[begin:]
        seen[corner] = len(ring)
        ring.append(corner)
    return [loop for loop in (*loops, ring) if len(loop) > 2]


def _shapes(loops: list[list[int]], place: dict[int, tuple[float, float]]) -> list[shapely.Polygon]:
    """Each ring that runs counter-clockwise, with those that run the other way in it as holes."""
    rings = [shapely.LinearRing([place[corner] for corner in loop]) for loop in loops]
    outside = [shapely.Polygon(ring) for ring in rings if ring.is_ccw]
    holes = [shapely.Polygon(ring) for ring in rings if not ring.is_ccw]
    return [
        shapely.Polygon(shape.exterior, [hole.exterior for hole in holes if shape.is_valid and shape.contains(hole)])
        for shape in outside
    ]


def _cut_flat(shape: shapely.Polygon, vertex: dict[tuple[float, float], int]) -> np.ndarray | None:
    """(T, 3) triangles of a polygon in the plane; None if it crosses itself."""
    if not shape.is_valid:
        return None
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(shape))
    corners = shapely.get_coordinates(triangles).reshape(-1, 4, 2)[:, :3]
    turned = _area(corners) < 0
    corners[turned] = corners[turned, ::-1]
    found = [[vertex[one, two] for one, two in corner] for corner in corners.tolist()]
    return np.array(found, dtype=np.int64).reshape(-1, 3)


def _covered(triangles: np.ndarray, place: dict[int, tuple[float, float]]) -> float:
    points = np.array([[place[int(corner)] for corner in triangle] for triangle in triangles]).reshape(-1, 3, 2)
    return float(np.abs(_area(points)).sum())
