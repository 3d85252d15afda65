"""The outlines of pieces, and which camera's silhouette or border each part of them is."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from exact.visibility.grid import counting
from exact.visibility.pieces.pieces import Pieces
from exact.visibility.sight_depth import blocks
from exact.visibility.silhouettes import Cuts
from exact.visibility.surface import Surface

# An outline follows a segment, or a side of its face, if it is nearer to it than this (in parts of the face): far above
# the grid that pieces are put on, and far below what two different segments of a face are apart.
SAME_LINE = 1e-10
# Pairs of an outline and a segment that are looked at in one go, as many as suit caches.
PAIRS = 250_000


@dataclass(frozen=True, eq=False)
class Borders:
    """Parts of the outlines of pieces that move with a camera.

    Attributes
    ----------
    piece : (N,) int
    face : (N,) int
    start, end : (N, 3) float
        Ends [mm], such that the piece is to the left of the way from one to the other, seen from the face's front.
    camera : (N,) int
    source : (N, 2) int
        Of what each is the shadow or the border, as of `Cuts`.
    """

    piece: np.ndarray
    face: np.ndarray
    start: np.ndarray
    end: np.ndarray
    camera: np.ndarray
    source: np.ndarray

    def take(self, chosen: np.ndarray) -> "Borders":
        """The chosen ones, by mask or index."""
        return Borders(
            self.piece[chosen], self.face[chosen], self.start[chosen], self.end[chosen], self.camera[chosen],
            self.source[chosen],
        )  # fmt: skip


def borders_of(surface: Surface, pieces: Pieces, cuts: Sequence[tuple[int, Cuts]]) -> Borders:
    """What of the outlines of pieces follows one of the `cuts`, each with its camera; sides of faces do not.

    Where two pieces meet, each has the border that is between them, once in either direction.
    """
    piece, start, end = _outlines(pieces.polygon)
    inside = ~_along_a_side(start, end)
    piece, start, end = piece[inside], start[inside], end[inside]
    camera, every = _with_cameras(cuts)
    followed = _followed(pieces.face[piece], start, end, every)
    moved = followed >= 0
    piece, followed = piece[moved], followed[moved]
    face = pieces.face[piece]
    start, end = (surface.points(face, inner[moved]) for inner in (start, end))
    return Borders(piece, face, start, end, camera[followed], every.source[followed])


def _with_cameras(cuts: Sequence[tuple[int, Cuts]]) -> tuple[np.ndarray, Cuts]:
    """(C,) camera of each of all segments, and these, by ascending face."""
    parts = [Cuts.none(), *(some for _, some in cuts)]
    camera = np.repeat([-1, *(camera for camera, _ in cuts)], [len(part.face) for part in parts])
    face, start, end, source = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("face", "start", "end", "source")
    )
    order = np.argsort(face, kind="stable")
    return camera[order], Cuts(face[order], start[order], end[order], source[order])


def _outlines(polygon: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sides of polygons and multipolygons (P,): which each is from, (N,), and its ends, (N, 2), inside to the left."""
    part, owner = shapely.get_parts(polygon, return_index=True)
    ring, of_part = shapely.get_rings(part, return_index=True)
    point, of_ring = shapely.get_coordinates(ring, return_index=True)
    side = np.flatnonzero(of_ring[1:] == of_ring[:-1])
    start, end, of_ring = point[side], point[side + 1], of_ring[side]
    twice_area = np.bincount(of_ring, start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0], minlength=len(ring))
    is_outer = np.diff(of_part, prepend=-1) > 0
    backwards = ((twice_area > 0) != is_outer)[of_ring, None]
    start, end = np.where(backwards, end, start), np.where(backwards, start, end)
    return owner[of_part[of_ring]], start, end


def _along_a_side(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """(N,) whether both ends lie on the same side of their face."""
    on_a_side = np.zeros(len(start), dtype=bool)
    for away_from in (lambda at: at[:, 0], lambda at: at[:, 1], lambda at: 1 - at[:, 0] - at[:, 1]):
        on_a_side |= (np.abs(away_from(start)) < SAME_LINE) & (np.abs(away_from(end)) < SAME_LINE)
    return on_a_side


def _followed(face: np.ndarray, start: np.ndarray, end: np.ndarray, cuts: Cuts) -> np.ndarray:
    """(N,) the segment of the same face that each side of an outline lies on, -1 for none."""
    followed = np.full(len(face), -1)
    along = cuts.end - cuts.start
    length = np.hypot(along[:, 0], along[:, 1])
    # Where faces only touch, in a point, nothing is a line; a point would lie on any.
    along = np.divide(along, length[:, None], out=np.full_like(along, np.nan), where=length[:, None] > SAME_LINE)
    offset = along[:, 0] * cuts.start[:, 1] - along[:, 1] * cuts.start[:, 0]
    first = np.searchsorted(cuts.face, face, "left")
    count = np.searchsorted(cuts.face, face, "right") - first
    for low, high in blocks(count, PAIRS):
        side = low + np.repeat(np.arange(high - low), count[low:high])
        cut = np.repeat(first[low:high], count[low:high]) + counting(count[low:high])
        away = np.abs(along[cut, 0] * start[side, 1] - along[cut, 1] * start[side, 0] - offset[cut])
        near = np.flatnonzero(away < SAME_LINE)
        side, cut = side[near], cut[near]
        other = along[cut, 0] * end[side, 1] - along[cut, 1] * end[side, 0] - offset[cut]
        at = ((start[side] + end[side]) / 2 - cuts.start[cut]) * along[cut]
        at = at[:, 0] + at[:, 1]
        near = np.flatnonzero((np.abs(other) < SAME_LINE) & (at > -SAME_LINE) & (at < length[cut] + SAME_LINE))
        # Of several, where cameras stand in line with an edge, the first: it must be the same for both pieces that meet
        # there. Written last, it stays.
        near = near[np.argsort(-cut[near], kind="stable")]
        followed[side[near]] = cut[near]
    return followed
