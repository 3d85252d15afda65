"""Where faces of one mesh cut through each other: segments that every camera has to respect."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from exact.visibility.close_pairs import close_pairs

# Two faces whose corners all lie nearer to the other's plane than this part of the coordinates' scale are in one plane.
SAME_PLANE = 1e-9
# A corner nearer to a plane than this part of the scale is on it. Far above rounding, since faces that miss each other
# by rounding only would leave a gap in a curve of intersections, and far below `SAME_PLANE`.
TOUCHING = 1e-13
# Segments are lengthened by this part of the face so that they surely reach what they end on: the ends of segments
# between nearly parallel faces are known to less than rounding. What reaches too far cuts nothing off.
OVERSHOOT = 1e-6
# Segments from a common vertex that are shorter than this part of the scale are that vertex itself, and rounding.
SHORTEST = 1e-9
# Faces that hang together are a flat sheet, of which none cuts another, if all of it is nearer to one plane than this
# part of the scale: enough below `SAME_PLANE` that the planes of any two of them are the same.
FLAT_SHEET = 0.1 * SAME_PLANE
# Sheets of fewer faces are not worth it.
SMALLEST_SHEET = 16


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
    is_point : (N,) bool
        Whether the faces only touch: the segment's own length is none, up to `TOUCHING`.
    """

    face: np.ndarray
    other: np.ndarray
    start: np.ndarray
    end: np.ndarray
    is_point: np.ndarray

    def of(self, number: np.ndarray) -> "Intersections":
        """Those that cut some of the faces: those that have a number, (F,) int, and not -1, by which they go then."""
        kept = number[self.face] >= 0
        return Intersections(
            number[self.face[kept]], number[self.other[kept]], self.start[kept], self.end[kept], self.is_point[kept]
        )


@dataclass(frozen=True, eq=False)
class Planes:
    """The plane of each face: normal . x = offset, with the origin in the middle of the mesh.

    Attributes
    ----------
    centre : (3,) float
        Mean of the vertices that faces with area use [mm].
    vertices : (V, 3) float
        Relative to the centre [mm].
    faces : (F, 3) int
    normal : (F, 3) float
        Unit normals, 0 for faces without area.
    offset : (F,) float [mm]
    scale : float
        Greatest coordinate [mm].
    """

    centre: np.ndarray
    vertices: np.ndarray
    faces: np.ndarray
    normal: np.ndarray
    offset: np.ndarray
    scale: float

    @classmethod
    def of(cls, vertices: np.ndarray, faces: np.ndarray, normals: np.ndarray) -> "Planes":
        """Planes of faces with these vertices (V, 3) [mm] and unit normals (F, 3)."""
        centre = vertices.mean(axis=0)
        centred = vertices - centre
        offset = (normals * centred[faces[:, 0]]).sum(axis=1)
        return cls(centre, centred, faces, normals, offset, float(np.abs(centred).max()))

    def of_faces(self, face: np.ndarray, faces: np.ndarray, vertex: np.ndarray) -> "Planes":
        """Those of some faces (K,) and vertices (W,) alone, where these go by the numbers in `faces` (K, 3)."""
        return Planes(self.centre, self.vertices[vertex], faces, self.normal[face], self.offset[face], self.scale)

    def distances(self, plane: np.ndarray, face: np.ndarray) -> np.ndarray:
        """(N, 3) distance of the corners of `face` from the plane of another, 0 where they touch it [mm]."""
        normal, columns = self.normal[plane], []
        for k in range(3):
            point = self.vertices[self.faces[face, k]]
            distance = point[:, 0] * normal[:, 0] + point[:, 1] * normal[:, 1] + point[:, 2] * normal[:, 2]
            columns.append(distance - self.offset[plane])
        distance = np.stack(columns, axis=1)
        return np.where(np.abs(distance) <= TOUCHING * self.scale, 0.0, distance)

    def coincide(self, one: np.ndarray, two: np.ndarray) -> np.ndarray:
        """(N,) whether two faces lie in the same plane, so that neither is in front of the other."""
        farthest = np.maximum(np.abs(self.distances(one, two)), np.abs(self.distances(two, one))).max(axis=1)
        return np.asarray(farthest <= SAME_PLANE * self.scale)

    def straddled(self, plane: np.ndarray, face: np.ndarray, shared: np.ndarray) -> np.ndarray:
        """(N,) whether `face` reaches to both sides of a plane, or touches it with a vertex they do not share."""
        distance = self.distances(plane, face)
        others = 3 - shared
        return np.asarray(((distance > 0).sum(axis=1) < others) & ((distance < 0).sum(axis=1) < others))


def intersecting_faces(planes: Planes, edge_faces: np.ndarray) -> Intersections:
    """All segments in which two faces of a mesh meet other than along a common edge or in a common plane.

    `edge_faces`, (E, 2) int, are the two faces of each edge between two.
    """
    touching = TOUCHING * planes.scale
    vertices, faces = planes.vertices, planes.faces
    a, b, shared = _straddling(planes, edge_faces, touching)
    distance_a, distance_b = planes.distances(b, a), planes.distances(a, b)
    points_a, points_b = (
        _side_crossings(vertices[faces[a]], distance_a),
        _side_crossings(vertices[faces[b]], distance_b),
    )
    base, direction = _common_line(points_a, points_b)
    (low_a, high_a), (low_b, high_b) = (_interval(points, base, direction) for points in (points_a, points_b))
    low, high = np.maximum(low_a, low_b), np.minimum(high_a, high_b)
    # Faces that share a vertex always touch there; only a segment that leads away from it cuts anything.
    meets = high - low >= np.where(shared == 1, SHORTEST * planes.scale, -touching)
    meets &= np.isfinite(low) & np.isfinite(high)
    # Two faces that meet their line in a corner each leave it without a direction: these must be the same point.
    corners = [np.where(np.isnan(points), -2 * planes.scale, points).max(axis=1) for points in (points_a, points_b)]
    meets &= direction.any(axis=1) | (np.abs(corners[0] - corners[1]).max(axis=1) <= touching)
    a, b, base, direction, low, high = (part[meets] for part in (a, b, base, direction, low, high))
    face, other = np.concatenate([a, b]), np.concatenate([b, a])
    start, end = (_inner(vertices[faces[face]], np.tile(base + t[:, None] * direction, (2, 1))) for t in (low, high))
    along = end - start
    length = np.linalg.norm(along, axis=1, keepdims=True)
    # A mere touching point becomes a tiny segment, which cuts nothing off.
    extra = OVERSHOOT * np.divide(along, length, out=np.zeros_like(along), where=length > 0)
    is_point = np.tile(high - low <= touching, 2)
    order = np.argsort(face, kind="stable")
    return Intersections(face[order], other[order], (start - extra)[order], (end + extra)[order], is_point[order])


def _straddling(planes: Planes, edge_faces: np.ndarray, margin: float):
    """Pairs of faces that reach to both sides of each other's planes, and how many vertices they share: 0 or 1."""
    vertices, faces = planes.vertices, planes.faces
    kept = np.flatnonzero(planes.normal.any(axis=1))
    sheet = _flat_sheets(planes, edge_faces)
    pairs = [np.zeros(0, dtype=np.int64)]
    for one, two in close_pairs(vertices[faces[kept]], margin, sheet[kept]):
        one, two = kept[one], kept[two]
        shared = _n_shared(faces, one, two)
        apart = shared < 2
        one, two, shared = one[apart], two[apart], shared[apart]
        for _ in range(2):  # few pairs are left for the second
            straddles = planes.straddled(two, one, shared)
            one, two, shared = two[straddles], one[straddles], shared[straddles]
        pairs.append((one * len(faces) + two)[~planes.coincide(one, two)])
    pair = np.unique(np.concatenate(pairs))
    one, two = pair // len(faces), pair % len(faces)
    return one, two, _n_shared(faces, one, two)


def _n_shared(faces: np.ndarray, one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """(N,) how many vertices two faces share."""
    n_shared = np.zeros(len(one), dtype=np.int8)
    columns = [[faces[which, k] for k in range(3)] for which in (one, two)]
    for of_one in columns[0]:
        for of_two in columns[1]:
            n_shared += of_one == of_two
    return n_shared


def _flat_sheets(planes: Planes, edge_faces: np.ndarray) -> np.ndarray:
    """(F,) number of the flat sheet that each face is part of, -1 for none."""
    n = len(planes.faces)
    one, two = edge_faces.T
    near = FLAT_SHEET * planes.scale
    bend = np.maximum(np.abs(planes.distances(one, two)), np.abs(planes.distances(two, one))).max(axis=1)
    flat = (bend <= near) & ((planes.normal[one] * planes.normal[two]).sum(axis=1) > 0)
    graph = coo_array((np.ones(flat.sum(), dtype=np.int8), (one[flat], two[flat])), shape=(n, n))
    n_sheets, sheet = connected_components(graph, directed=False)
    # Sheets that bend little by little are none: each is held against the plane of its largest face.
    sides = planes.vertices[planes.faces[:, 1:]] - planes.vertices[planes.faces[:, :1]]
    size = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    largest = np.zeros(n_sheets, dtype=np.int64)
    order = np.argsort(size, kind="stable")
    largest[sheet[order]] = order  # the last one written stays
    away = np.abs(planes.distances(largest[sheet], np.arange(n))).max(axis=1)
    bent = np.zeros(n_sheets, dtype=bool)
    bent[sheet[away > near]] = True
    few = np.bincount(sheet, minlength=n_sheets) < SMALLEST_SHEET
    return np.where((bent | few)[sheet], -1, sheet)


def _side_crossings(corner, distance):
    """(N, 3, 3) points where the sides of a triangle meet the other's plane, nan where a side does not."""
    after, next_distance = corner[:, [1, 2, 0]], distance[:, [1, 2, 0]]
    crosses = (distance * next_distance < 0) | (distance == 0)
    t = np.divide(distance, distance - next_distance, out=np.zeros_like(distance), where=crosses & (distance != 0))
    return np.where(crosses[:, :, None], corner + t[:, :, None] * (after - corner), np.nan)


def _common_line(points_a: np.ndarray, points_b: np.ndarray):
    """A point of the line in which two faces meet, and its direction: the longer of the two faces' own chords.

    Two nearly parallel planes leave the direction of their line to rounding; a chord does not.
    """
    points = np.concatenate([points_a, points_b], axis=1)
    chords = np.stack([points[:, j] - points[:, i] for i, j in _SIDES], axis=1)
    length = np.nan_to_num(np.linalg.norm(chords, axis=2), nan=-1.0)
    longest, row = length.argmax(axis=1), np.arange(len(points))
    base = points[row, np.array([i for i, _ in _SIDES])[longest]]
    chord, size = chords[row, longest], length[row, longest][:, None]
    return base, np.divide(chord, size, out=np.zeros_like(chord), where=size > 0)


_SIDES = ((0, 1), (1, 2), (0, 2), (3, 4), (4, 5), (3, 5))


def _interval(points: np.ndarray, base: np.ndarray, direction: np.ndarray):
    """Part of the common line inside a triangle, as least and greatest coordinate along `direction` [mm]."""
    along = ((points - base[:, None]) * direction[:, None]).sum(axis=2)
    low = np.where(np.isnan(along), np.inf, along).min(axis=1)
    high = np.where(np.isnan(along), -np.inf, along).max(axis=1)
    return low, high


def _inner(corners, points):
    """(N, 2) coordinates (b1, b2) of world points in the faces with these corners."""
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    away = points - corners[:, 0]
    normal = np.cross(one, two)
    squared = (normal**2).sum(axis=1)
    first = (np.cross(away, two) * normal).sum(axis=1) / squared
    return np.stack([first, (np.cross(one, away) * normal).sum(axis=1) / squared], axis=1)
