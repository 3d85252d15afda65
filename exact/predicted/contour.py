"""The part of pieces that is reconstructed to a given error: pieces cut along the contour where the error is just that.

Along a contour the error is a rational function of the place that changes slowly. Pieces are divided into triangles;
in each the contour is a straight line between two of its sides, and where that is not close enough the triangle is
divided further. Between a line and an arc of the contour lies about two thirds of the product of length and rise, which
bounds the error of the area; a point in the middle, put a third farther out than the contour, evens it out besides.
"""

from dataclasses import dataclass

import numpy as np
import shapely

from exact.predicted.bound import SMALL, ErrorBound, nearest
from exact.visibility.coverage import Pieces

# Greatest error of an area by all contours together, in parts of the area.
CONTOUR_TOLERANCE = 1e-6
# A contour may pass through a triangle whose corners are all on one side if one of them is nearer to it than this
# times what the error at the centre differs from its mean at the corners.
BEND = 4.0
# Triangles are not halved more often than this: a billionth of a side is below anything that counts.
MOST_DIVISIONS = 30


@dataclass(frozen=True, eq=False)
class _Triangles:
    """Triangles in the coordinates of their faces: which piece each is from, (N,), and its corners, (N, 3, 2)."""

    piece: np.ndarray
    corner: np.ndarray

    def take(self, chosen: np.ndarray) -> "_Triangles":
        return _Triangles(self.piece[chosen], self.corner[chosen])

    def quartered(self) -> "_Triangles":
        a, b, c = self.corner.transpose(1, 0, 2)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        return _Triangles(np.tile(self.piece, 4), np.concatenate([np.stack(part, axis=1) for part in parts]))


def accurate_part(bound: ErrorBound, pieces: Pieces, area: float) -> Pieces:
    """The part of each of `pieces` where the error is at most that of `bound`.

    Parameters
    ----------
    bound : ErrorBound
    pieces : Pieces
        With all cameras that see them.
    area : float
        Area [mm²] that the error of all contours is measured by.

    Returns
    -------
    Pieces
        Those that keep the bound all over as they are, of the others any number of parts; by ascending face.
    """
    surface = bound.predictor.surface
    sure = bound.holds_all_over(pieces.face, pieces.seen)
    doubtful = pieces.take(~sure)
    if not len(doubtful.face):
        return pieces
    triangles = triangulate(doubtful.polygon)
    # Of a piece that is whole nothing is cut up.
    kept: list[tuple[np.ndarray, np.ndarray]] = []
    undivided = np.ones(len(doubtful.face), dtype=bool)
    budget = CONTOUR_TOLERANCE * area
    for division in range(MOST_DIVISIONS):
        face = doubtful.face[triangles.piece]
        at = _excess(bound, doubtful, triangles)
        corner, bend = at[:, :3], np.abs(at[:, 3] - at[:, :3].mean(axis=1))
        is_small = _is_small(bound, face, triangles.corner)
        inside = is_small & (corner.max(axis=1) <= -BEND * bend)
        outside = is_small & (corner.min(axis=1) > BEND * bend) | (at == 1e6).all(axis=1)
        crossed = is_small & (corner <= 0).any(axis=1) & (corner > 0).any(axis=1)
        kept.append((triangles.piece[inside], _polygons(triangles.corner[inside])))
        undivided[triangles.piece[~inside]] = False
        index = np.flatnonzero(crossed)
        polygon, miss = _cut(bound, doubtful, triangles.take(index), corner[index], surface.areas)
        order = np.argsort(miss, kind="stable")
        enough = order[np.cumsum(miss[order]) <= budget / 2]
        budget -= float(miss[enough].sum())
        kept.append((triangles.piece[index[enough]], polygon[enough]))
        more = ~inside & ~outside
        more[index[enough]] = False
        triangles = triangles.take(more)
        if not len(triangles.piece):
            break
        if division == MOST_DIVISIONS - 1:
            break
        triangles = triangles.quartered()
    piece = np.concatenate([piece for piece, _ in kept])
    polygon = np.concatenate([polygon for _, polygon in kept])
    cut = ~undivided[piece]
    parts = Pieces(doubtful.face[piece[cut]], polygon[cut], doubtful.seen[piece[cut]])
    return Pieces.joined([pieces.take(sure), doubtful.take(undivided), parts])


def triangulate(polygon: np.ndarray) -> _Triangles:
    """Triangles of polygons and multipolygons (P,), counter-clockwise or not."""
    parts, owner = shapely.get_parts(polygon, return_index=True)
    collections = shapely.constrained_delaunay_triangles(parts) if len(parts) else parts
    triangle, part = shapely.get_parts(collections, return_index=True)
    return _Triangles(owner[part], shapely.get_coordinates(triangle).reshape(-1, 4, 2)[:, :3])


def _excess(bound: ErrorBound, pieces: Pieces, triangles: _Triangles) -> np.ndarray:
    """(N, 4) how much too great the error is at the corners and at the centre."""
    at = np.concatenate([triangles.corner, triangles.corner.mean(axis=1, keepdims=True)], axis=1)
    return _at(bound, pieces, np.repeat(triangles.piece, 4), at.reshape(-1, 2)).reshape(-1, 4)


def _at(bound: ErrorBound, pieces: Pieces, piece: np.ndarray, inner: np.ndarray) -> np.ndarray:
    return bound.excess(pieces.face[piece], inner, pieces.seen[piece])


def _is_small(bound: ErrorBound, face: np.ndarray, corner: np.ndarray) -> np.ndarray:
    """(N,) whether triangles are small beside their distance from the cameras."""
    surface, cameras = bound.predictor.surface, bound.predictor.cameras
    at = surface.points(np.repeat(face, 3), corner.reshape(-1, 2)).reshape(-1, 3, 3)
    centre = at.mean(axis=1)
    return np.linalg.norm(at - centre[:, None], axis=2).max(axis=1) < SMALL * nearest(cameras, centre)


def _cut(bound: ErrorBound, pieces: Pieces, triangles: _Triangles, value: np.ndarray, areas: np.ndarray):
    """The inner part of triangles that the contour crosses, (N,) polygons, and bounds on the errors of areas [mm²]."""
    piece = triangles.piece
    # The corner that is alone on its side comes first.
    n_inside = (value <= 0).sum(axis=1)
    alone = np.argmax((value <= 0) == (n_inside == 1)[:, None], axis=1)
    turn = (alone[:, None] + np.arange(3)) % 3
    corner, value = np.take_along_axis(triangles.corner, turn[:, :, None], axis=1), np.take_along_axis(value, turn, 1)
    first, second = (_root(bound, pieces, piece, corner[:, 0], corner[:, k], value[:, 0], value[:, k]) for k in (1, 2))
    middle, chord = (first + second) / 2, second - first
    # From the lone corner over the line: the contour's rise along it, from the error in the middle and on both sides.
    across = middle - corner[:, 0]
    here = _at(bound, pieces, piece, middle)
    slope = (here - value[:, 0]) + 1e-300
    rise = np.clip(-here / slope, -1.0, 1.0)[:, None] * across
    miss = 2 / 3 * np.abs(chord[:, 0] * rise[:, 1] - chord[:, 1] * rise[:, 0]) * 2 * areas[pieces.face[piece]]
    # What lies beyond the triangle belongs to its neighbour.
    beyond = _leaves(corner, middle + 4 / 3 * rise)
    bulge = np.where(beyond[:, None], middle, middle + 4 / 3 * rise)
    lone_inside = n_inside == 1
    small = np.stack([corner[:, 0], first, bulge, second, corner[:, 0], corner[:, 0]], axis=1)
    large = np.stack([first, corner[:, 1], corner[:, 2], second, bulge, first], axis=1)
    ring = np.where(lone_inside[:, None, None], small, large)
    return np.asarray(shapely.polygons(ring)), miss


def _root(bound, pieces, piece, start, end, at_start, at_end) -> np.ndarray:
    """Where the contour crosses the lines from `start` to `end`, (N, 2), on whose two ends it has two sides."""
    low, high = np.zeros(len(start)), np.ones(len(start))
    f_low, f_high = at_start.copy(), at_end.copy()
    t = np.full(len(start), 0.5)
    for _ in range(8):  # regula falsi after Illinois: gains digits by more than half each step
        difference = f_high - f_low
        t = np.where(difference != 0, low - f_low * (high - low) / np.where(difference == 0, 1, difference), t)
        value = _at(bound, pieces, piece, start + t[:, None] * (end - start))
        same = (value > 0) == (f_low > 0)
        f_high = np.where(same, f_high / 2, value)
        f_low_new = np.where(same, value, f_low / 2)
        low, high = np.where(same, t, low), np.where(same, high, t)
        f_low = f_low_new
    return start + t[:, None] * (end - start)


def _leaves(corner: np.ndarray, point: np.ndarray) -> np.ndarray:
    """(N,) whether points are outside of triangles (N, 3, 2)."""
    side = np.roll(corner, -1, axis=1) - corner
    away = point[:, None] - corner
    turn = side[:, :, 0] * away[:, :, 1] - side[:, :, 1] * away[:, :, 0]
    return np.asarray(~((turn >= 0).all(axis=1) | (turn <= 0).all(axis=1)))


def _polygons(corner: np.ndarray) -> np.ndarray:
    return np.asarray(shapely.polygons(np.concatenate([corner, corner[:, :1]], axis=1)))
