"""The part of pieces that is reconstructed to a given error: pieces cut along the contour where the error is just that.

Along a contour the error is a rational function of the place that changes slowly. Pieces are divided into triangles;
in each the contour is a straight line between two of its sides, and where that is not close enough the triangle is
divided further. Between a line and an arc of the contour lies about two thirds of the product of length and rise, which
bounds the error of the area; a point in the middle, put a third farther out than the contour, evens it out besides.
"""

import numpy as np
import shapely

from exact.predicted.bound import SMALL, ErrorBound, sizes
from exact.predicted.triangles import Triangles
from exact.visibility.pieces.pieces import Pieces
from exact.visibility.pieces.triangulated import triangles_in
from exact.visibility.projection import lone_corner_first
from exact.visibility.screen import barycentric

# Greatest error of an area by all contours together, in parts of the area.
CONTOUR_TOLERANCE = 1e-6
# A contour may pass through a triangle whose corners are all on one side if one of them is nearer to it than this
# times what the error at the centre differs from its mean at the corners.
BEND = 4.0
# Nearer to the greatest error than this, relatively, is on the contour.
ON_CONTOUR = 1e-12
# Triangles are not halved more often than this: a billionth of a side is below anything that counts.
MOST_DIVISIONS = 30


def accurate_part(bound: ErrorBound, pieces: Pieces, area: float) -> Pieces:
    """The part of each of `pieces` where the error is at most that of `bound`.

    Parameters
    ----------
    bound : ErrorBound
    pieces : Pieces
        With all cameras that see them, and not sure to keep the bound all over.
    area : float
        Area [mm²] that the error of all contours is measured by.

    Returns
    -------
    Pieces
        Those that keep the bound all over after all as they are, of the others any number of parts; by ascending face.
    """
    if not len(pieces.face):
        return pieces
    surface, cameras = bound.predictor.surface, bound.predictor.cameras
    triangles = Triangles(*triangles_in(pieces.polygon))
    # Of a piece that is whole nothing is cut up.
    kept: list[tuple[np.ndarray, np.ndarray]] = []
    undivided = np.ones(len(pieces.face), dtype=bool)
    budget = CONTOUR_TOLERANCE * area
    for _ in range(MOST_DIVISIONS):
        at = _excess(bound, pieces, triangles)
        corner, bend = at[:, :3], np.abs(at[:, 3] - at[:, :3].mean(axis=1))
        is_small = sizes(cameras, triangles.points(surface, pieces.face))[1] < SMALL
        inside = is_small & (corner.max(axis=1) <= -BEND * bend)
        outside = is_small & (corner.min(axis=1) > BEND * bend) | (at == 1e6).all(axis=1)
        crossed = is_small & (corner <= 0).any(axis=1) & (corner > 0).any(axis=1)
        kept.append((triangles.piece[inside], triangles.take(inside).polygons))
        undivided[triangles.piece[~inside]] = False
        index = np.flatnonzero(crossed)
        polygon, miss = _cut(bound, pieces, triangles.take(index), corner[index], surface.areas)
        order = np.argsort(miss, kind="stable")
        enough = order[np.cumsum(miss[order]) <= budget / 2]
        budget -= float(miss[enough].sum())
        kept.append((triangles.piece[index[enough]], polygon[enough]))
        more = ~inside & ~outside
        more[index[enough]] = False
        triangles = triangles.take(more).quartered()
        if not len(triangles.piece):
            break
    piece = np.concatenate([piece for piece, _ in kept])
    polygon = np.concatenate([polygon for _, polygon in kept])
    cut = ~undivided[piece]
    parts = Pieces(pieces.face[piece[cut]], polygon[cut], pieces.seen[piece[cut]])
    return Pieces.joined([pieces.take(undivided), parts])


def _excess(bound: ErrorBound, pieces: Pieces, triangles: Triangles) -> np.ndarray:
    """(N, 4) how much too great the error is at the corners and at the centre."""
    at = np.concatenate([triangles.corner, triangles.corner.mean(axis=1, keepdims=True)], axis=1)
    return _at(bound, pieces, np.repeat(triangles.piece, 4), at.reshape(-1, 2)).reshape(-1, 4)


def _at(bound: ErrorBound, pieces: Pieces, piece: np.ndarray, inner: np.ndarray) -> np.ndarray:
    return bound.excess(pieces.face[piece], inner, pieces.seen[piece])


def _cut(bound: ErrorBound, pieces: Pieces, triangles: Triangles, value: np.ndarray, areas: np.ndarray):
    """The inner part of triangles that the contour crosses, (N,) polygons, and bounds on the errors of areas [mm²]."""
    piece = triangles.piece
    turn, lone_inside = lone_corner_first(value <= 0)
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
    bulge = middle + 4 / 3 * rise
    beyond = barycentric(corner[:, :, 0], corner[:, :, 1], bulge[:, 0], bulge[:, 1]).min(axis=1) < 0
    bulge = np.where(beyond[:, None], middle, bulge)
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
        if np.abs(value).max(initial=0.0) < ON_CONTOUR:
            break
        same = (value > 0) == (f_low > 0)
        f_high = np.where(same, f_high / 2, value)
        f_low_new = np.where(same, value, f_low / 2)
        low, high = np.where(same, t, low), np.where(same, high, t)
        f_low = f_low_new
    return start + t[:, None] * (end - start)
