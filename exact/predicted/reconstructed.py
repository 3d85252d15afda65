"""Which parts of a surface count, once the views of all cameras are known."""

import numpy as np
import shapely

from exact.demand import Criterion
from exact.predicted.contour import accurate_part
from exact.visibility.coverage import Tally
from exact.visibility.pieces.clipping import GRID_SIZE, whole_faces
from exact.visibility.pieces.pieces import Pieces
from exact.visibility.surface import Surface


def reconstructed(
    surface: Surface, counted: np.ndarray, seen: Tally, criterion: Criterion
) -> tuple[np.ndarray, Pieces]:
    """Faces that meet the criterion whole, (F,) bool, and pieces that do, of those `counted`, (F,) bool."""
    uncut = np.flatnonzero(counted & ~seen.is_cut & (surface.areas > 0))
    met = criterion.met(seen.whole_seen[uncut], uncut)
    whole = np.zeros(len(surface.areas), dtype=bool)
    whole[uncut[met]] = True
    pieces = seen.pieces
    piece_met = criterion.met(pieces.seen, pieces.face)
    sure = pieces.take(piece_met)
    if criterion.bound is None:
        return whole, sure
    doubtful = uncut[~met]
    doubtful = doubtful[criterion.enough(seen.whole_seen[doubtful], doubtful)]
    in_part = pieces.take(~piece_met & criterion.enough(pieces.seen, pieces.face))
    in_part = Pieces.joined([in_part, Pieces(doubtful, whole_faces(len(doubtful)), seen.whole_seen[doubtful])])
    in_part = in_part.take(~criterion.bound.fails_all_over(in_part.face, in_part.seen))
    area = float(surface.areas[whole].sum() + piece_areas(surface, sure).sum() + piece_areas(surface, in_part).sum())
    return whole, Pieces.joined([sure, accurate_part(criterion.bound, in_part, area)])


def divided(
    surface: Surface, counted: np.ndarray, seen: Tally, criterion: Criterion
) -> tuple[Tally, np.ndarray, np.ndarray]:
    """The same views, cut so that every face and piece meets the criterion all over or nowhere.

    Also which whole faces do, (F,) bool, and which pieces, (P,) bool.
    """
    if criterion.bound is None:
        everything = np.arange(len(surface.areas))
        return seen, criterion.met(seen.whole_seen, everything), criterion.met(seen.pieces.seen, seen.pieces.face)
    whole, parts = reconstructed(surface, counted, seen, criterion)
    pieces, is_cut = seen.pieces, seen.is_cut.copy()
    new = np.setdiff1d(parts.face, np.flatnonzero(is_cut))
    is_cut[new] = True
    pieces = Pieces.joined([pieces, Pieces(new, whole_faces(len(new)), seen.whole_seen[new])])
    # What is left of each piece; where the very same piece is met, nothing.
    face, group = np.unique(parts.face, return_inverse=True)
    left = pieces.polygon.copy()
    if len(face):
        polygons, owner = shapely.get_parts(parts.polygon, return_index=True)
        together = np.asarray(shapely.multipolygons(polygons, indices=group[owner]))
        met_of_face = np.asarray(shapely.union_all(together[:, None], axis=1, grid_size=GRID_SIZE))
        touched = np.flatnonzero(np.isin(pieces.face, face))
        at = np.searchsorted(face, pieces.face[touched])
        left[touched] = shapely.difference(left[touched], met_of_face[at], grid_size=GRID_SIZE)
    kept = shapely.area(left) > 0
    rest = Pieces(pieces.face[kept], left[kept], pieces.seen[kept])
    every = [rest, parts]
    face = np.concatenate([part.face for part in every])
    order = np.argsort(face, kind="stable")
    met = np.concatenate([np.zeros(len(rest.face), dtype=bool), np.ones(len(parts.face), dtype=bool)])[order]
    return Tally(seen.whole_seen, is_cut, Pieces.joined(every), seen.n_repairs), whole, met


def piece_areas(surface: Surface, pieces: Pieces) -> np.ndarray:
    """(P,) areas of pieces [mm²]."""
    return 2 * surface.areas[pieces.face] * shapely.area(pieces.polygon)


def area_by_face(surface: Surface, whole: np.ndarray, pieces: Pieces) -> np.ndarray:
    """(F,) area of whole faces and of pieces, by face [mm²]; where pieces overlap, at most that of the face."""
    areas = surface.areas
    by_pieces = np.bincount(pieces.face, piece_areas(surface, pieces), minlength=len(areas))
    return np.where(whole, areas, 0.0) + np.minimum(by_pieces, areas)
