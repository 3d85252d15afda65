"""Where faces of one mesh cut through each other: segments that every camera has to respect."""

from dataclasses import dataclass

import numpy as np
import shapely

# Below this sine two planes count as parallel: coplanar faces overlap, they do not cut each other.
PARALLEL = 1e-9
# Distances below this part of the coordinates' scale count as touching. Touching faces are cut, which is harmless:
# each piece is asked for itself. Faces that miss each other by less than rounding would leak otherwise.
TOUCHING = 1e-12
# Segments are lengthened by this part of the face so that they surely reach what they end on.
OVERSHOOT = 1e-9
# Faces are paired by their boxes seen along one direction. Walls stack up when seen along themselves, so a sample of
# this many faces tells along which of four directions the fewest boxes overlap; the first that leaves few will do.
_PROBES = 500
_FEW = 60.0
_OBLIQUE = np.linalg.qr(np.array([[1.0, 0.3, 0.2], [0.7, -1.0, 0.4], [0.9, 0.6, -1.1]]))[0]
_FRAMES = (_OBLIQUE, np.eye(3), np.eye(3)[[2, 0, 1]], np.eye(3)[[1, 2, 0]])


@dataclass(frozen=True, eq=False)
class Intersections:
    """Segments in which faces cut each other; each stands once for either of its two faces.

    Attributes
    ----------
    face : (N,) int
        The face that is cut, in ascending order.
    other : (N,) int
        The face that cuts it.
    start, end : (N, 2) float
        Ends of the segment in the face's own coordinates (b1, b2), lengthened by `OVERSHOOT`.
    """

    face: np.ndarray
    other: np.ndarray
    start: np.ndarray
    end: np.ndarray


def intersecting_faces(vertices: np.ndarray, faces: np.ndarray, normals: np.ndarray) -> Intersections:
    """All segments in which two faces of a mesh meet other than along a common edge.

    Parameters
    ----------
    vertices : (V, 3) float [mm]
    faces : (F, 3) int
    normals : (F, 3) float
        Unit normals, 0 for faces without area, which cut nothing.
    """
    centred = vertices - vertices.mean(axis=0)
    scale = np.abs(centred).max()
    planes = _Planes(centred, faces, normals, (normals * centred[faces[:, 0]]).sum(axis=1), TOUCHING * scale)
    a, b, shared = _close_pairs(centred, faces, np.flatnonzero(normals.any(axis=1)), TOUCHING * scale)
    for _ in range(2):  # each face must reach to both sides of the other's plane; few pairs are left for the second
        straddles = planes.straddled(b, a, shared)
        a, b, shared = b[straddles], a[straddles], shared[straddles]
    distance_a, distance_b = planes.distances(b, a), planes.distances(a, b)
    normal_a, normal_b = planes.normal[a], planes.normal[b]
    direction = np.cross(normal_a, normal_b)
    sine = np.linalg.norm(direction, axis=1)
    crossing = sine > PARALLEL
    a, b, shared = a[crossing], b[crossing], shared[crossing]
    distance_a, distance_b = distance_a[crossing], distance_b[crossing]
    direction = direction[crossing] / sine[crossing, None]
    origin = vertices[faces[a, 0]]
    low_a, high_a = _interval(vertices[faces[a]] - origin[:, None], distance_a, direction)
    low_b, high_b = _interval(vertices[faces[b]] - origin[:, None], distance_b, direction)
    low, high = np.maximum(low_a, low_b), np.minimum(high_a, high_b)
    base = _point_on_line(vertices[faces[a]] - origin[:, None], distance_a, direction)
    # Faces that share a vertex always touch there; only a segment that leads away from it cuts anything.
    least = np.where(shared == 1, OVERSHOOT, -TOUCHING) * scale
    meets = high - low >= least
    a, b, origin, base, direction = a[meets], b[meets], origin[meets], base[meets], direction[meets]
    start, end = (origin + base + t[meets, None] * direction for t in (low, high))
    face = np.concatenate([a, b])
    corners = vertices[faces[face]]
    start, end = (_inner(corners, np.concatenate([point, point])) for point in (start, end))
    along = end - start
    length = np.linalg.norm(along, axis=1, keepdims=True)
    # A mere touching point becomes a tiny segment, which cuts nothing off.
    extra = OVERSHOOT * np.divide(along, length, out=np.zeros_like(along), where=length > 0)
    order = np.argsort(face, kind="stable")
    other = np.concatenate([b, a])
    return Intersections(face[order], other[order], (start - extra)[order], (end + extra)[order])


def _close_pairs(vertices, faces, kept, margin):
    """Pairs of faces whose boxes meet and that share no edge, with the number of vertices they share (0 or 1)."""
    tried = []
    for axes in _FRAMES:
        frame = _boxes(vertices, faces[kept], axes, margin)
        probes = frame[3][:: 1 + len(kept) // _PROBES]
        tried.append((len(frame[2].query(probes)[0]) / len(probes), frame))
        if tried[-1][0] <= _FEW:
            break
    low, high, tree, boxes = min(tried, key=lambda attempt: attempt[0])[1]
    one, two = tree.query(boxes)
    keep = one < two
    one, two = one[keep], two[keep]
    keep = (low[one, 2] <= high[two, 2]) & (low[two, 2] <= high[one, 2])
    one, two = kept[one[keep]], kept[two[keep]]
    n_shared = (faces[one][:, :, None] == faces[two][:, None, :]).sum(axis=(1, 2))
    keep = n_shared < 2
    return one[keep], two[keep], n_shared[keep]


def _boxes(vertices, faces, axes, margin):
    """Bounding boxes along `axes`, and a tree of their first two sides."""
    corner = (vertices @ axes)[faces]
    low, high = corner.min(axis=1) - margin, corner.max(axis=1) + margin
    boxes = shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1])
    return low, high, shapely.STRtree(boxes), boxes


@dataclass(frozen=True, eq=False)
class _Planes:
    """The plane of each face: normal . x = offset."""

    vertices: np.ndarray
    faces: np.ndarray
    normal: np.ndarray
    offset: np.ndarray
    touching: float

    def distances(self, plane, face):
        """(N, 3) distance of the corners of `face` from the plane of another, 0 where they touch it [mm]."""
        normal, columns = self.normal[plane], []
        for k in range(3):
            point = self.vertices[self.faces[face, k]]
            distance = point[:, 0] * normal[:, 0] + point[:, 1] * normal[:, 1] + point[:, 2] * normal[:, 2]
            columns.append(distance - self.offset[plane])
        distance = np.stack(columns, axis=1)
        return np.where(np.abs(distance) <= self.touching, 0.0, distance)

    def straddled(self, plane, face, shared):
        """(N,) whether `face` reaches to both sides of a plane, or touches it with a vertex they do not share."""
        distance = self.distances(plane, face)
        others = 3 - shared
        return ((distance > 0).sum(axis=1) < others) & ((distance < 0).sum(axis=1) < others)


def _side_crossings(corner, distance):
    """(N, 3, 3) points where the sides of a triangle meet the other's plane, nan where a side does not."""
    after, next_distance = corner[:, [1, 2, 0]], distance[:, [1, 2, 0]]
    crosses = (distance * next_distance < 0) | (distance == 0)
    t = np.divide(distance, distance - next_distance, out=np.zeros_like(distance), where=crosses & (distance != 0))
    return np.where(crosses[:, :, None], corner + t[:, :, None] * (after - corner), np.nan)


def _interval(corner, distance, direction):
    """Part of the common line inside a triangle, as least and greatest coordinate along `direction` [mm]."""
    along = (_side_crossings(corner, distance) * direction[:, None]).sum(axis=2)
    low = np.where(np.isnan(along), np.inf, along).min(axis=1)
    high = np.where(np.isnan(along), -np.inf, along).max(axis=1)
    return low, high


def _point_on_line(corner, distance, direction):
    """A point of the common line, with coordinate 0 along `direction`."""
    points = _side_crossings(corner, distance)
    which = np.argmax(~np.isnan(points[:, :, 0]), axis=1)
    point = points[np.arange(len(points)), which]
    return point - (point * direction).sum(axis=1, keepdims=True) * direction


def _inner(corners, points):
    """(N, 2) coordinates (b1, b2) of world points in the faces with these corners."""
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    away = points - corners[:, 0]
    normal = np.cross(one, two)
    squared = (normal**2).sum(axis=1)
    first = (np.cross(away, two) * normal).sum(axis=1) / squared
    return np.stack([first, (np.cross(one, away) * normal).sum(axis=1) / squared], axis=1)
