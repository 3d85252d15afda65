"""Pieces of faces and the cameras that see them: what a camera sees of each, and which are one and the same."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from exact.visibility.occlusion import CUT, HIDDEN, WHOLE, Sight
from exact.visibility.pieces.clipping import cut_pieces, halved_pieces
from exact.visibility.pieces.uniting import gathered, hulls, meets, unite


@dataclass(frozen=True, eq=False)
class Pieces:
    """Parts of faces and the cameras that see them.

    Attributes
    ----------
    face : (P,) int
    polygon : (P,) polygons or multipolygons in the coordinates of their faces
    seen : (P, M) bool
        Cameras that see each piece, up to when it was finished. For merged pieces, one of several equivalent sets.
    """

    face: np.ndarray
    polygon: np.ndarray
    seen: np.ndarray

    def take(self, chosen: np.ndarray) -> "Pieces":
        """The chosen ones, by mask or index."""
        return Pieces(self.face[chosen], self.polygon[chosen], self.seen[chosen])

    @staticmethod
    def joined(parts: Sequence["Pieces"]) -> "Pieces":
        """All of several sets, by ascending face."""
        face = np.concatenate([part.face for part in parts])
        polygon = np.concatenate([part.polygon for part in parts])
        seen = np.concatenate([part.seen for part in parts])
        return Pieces(face, polygon, seen).take(np.argsort(face, kind="stable"))


@dataclass(frozen=True, eq=False)
class HullsSeen:
    """What a camera sees of the convex hulls around all that waits of a face.

    Attributes
    ----------
    there : (F,) bool
        Faces of which some waits.
    face, cell : (C,) int, (C,) polygons
        The cells of the hulls that are seen, by ascending face.
    """

    there: np.ndarray
    face: np.ndarray
    cell: np.ndarray

    def may_show(self, face: np.ndarray, part: np.ndarray) -> np.ndarray:
        """(N,) whether the camera may see some of parts of faces that waited or, if none did, are new."""
        return ~self.there[face] | meets(face, part, self.face, self.cell)


def look_at_hulls(waiting: Pieces, sights: list[Sight], status: np.ndarray) -> tuple[np.ndarray, list[HullsSeen]]:
    """What the cameras of a block see of hulls, and the status, (F, B), of faces with regard to what waits of them."""
    face, hull = hulls(waiting.face, waiting.polygon)
    there = np.zeros(len(status), dtype=bool)
    there[face] = True
    status, seen = status.copy(), []
    for k, sight in enumerate(sights):
        which = np.flatnonzero(status[face, k] == CUT)
        asked = face[which]
        origin, cell, _, inner = halved_pieces(asked, hull[which], sight.cuts, sight.on_grid[asked])
        answer = sight.sees(asked[origin], inner)
        n_cells, n_seen = np.bincount(origin, minlength=len(asked)), np.bincount(origin, answer, len(asked))
        status[asked[n_seen == n_cells], k] = WHOLE
        status[asked[n_seen == 0], k] = HIDDEN
        seen.append(HullsSeen(there, asked[origin[answer]], cell[answer]))
    return status, seen


def cells_of(cut: Pieces, sight: Sight, hull_seen: HullsSeen | None, by_set: bool):
    """The cells of pieces: which piece each is of, (C,), itself, and whether it is seen; and the number of repairs."""
    if by_set:
        origin, cell, n_repairs, inner = halved_pieces(cut.face, cut.polygon, sight.cuts, sight.on_grid[cut.face])
        return origin, cell, sight.sees(cut.face[origin], inner), n_repairs
    part, of_piece = shapely.get_parts(cut.polygon, return_index=True)
    face = cut.face[of_piece]
    shown = np.ones(len(part), dtype=bool) if hull_seen is None else hull_seen.may_show(face, part)
    dark, rest = np.flatnonzero(~shown), np.flatnonzero(shown)
    origin, cell, n_repairs, inner = cut_pieces(face[rest], part[rest], sight.cuts, sight.on_grid[face[rest]])
    origin = rest[origin]
    answer = sight.sees(face[origin], inner)
    of_dark, group = np.unique(of_piece[dark], return_inverse=True)
    left = gathered(part[dark], group)
    answer = np.append(np.zeros(len(left), dtype=bool), answer)
    return np.append(of_dark, of_piece[origin]), np.append(left, cell), answer, n_repairs


def merged(pieces: Pieces, state: np.ndarray) -> tuple[Pieces, int]:
    """Unite the pieces of each face that are in the same state; also the number of repairs."""
    if not len(pieces.face):
        return pieces, 0
    key = np.concatenate([pieces.face[:, None], state], axis=1)
    _, first, group = np.unique(key, axis=0, return_index=True, return_inverse=True)
    group = group.reshape(-1)
    order = np.argsort(group, kind="stable")
    united, failed, n_repairs = unite(group[order], pieces.polygon[order])
    together = Pieces(pieces.face[first], united, pieces.seen[first]).take(~failed)
    return Pieces.joined([together, pieces.take(failed[group])]), n_repairs
