"""Cut pieces of faces along segments: the cells of the arrangement, in the faces' own coordinates.

Each face has coordinates (b1, b2) in which its corners are (0, 0), (1, 0) and (0, 1): every face is of order one,
whatever its size, slant and place, and the pieces that different cameras cut out of it need no mapping.
"""

import numpy as np
import shapely

from exact.errors import ExactError
from exact.occlusion import Cuts

# The cells of a piece must fill it up to this part of the face, or the cutting is done again on a precision grid.
FILL_TOLERANCE = 1e-10
# The precision grid of the second attempt: far below any tolerance on areas, far above float64 rounding.
GRID_SIZE = 1e-12


def whole_faces(n: int) -> np.ndarray:
    """(n,) polygons of `n` uncut faces."""
    outline = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    return np.full(n, shapely.Polygon(outline), dtype=object)


def cut_pieces(face: np.ndarray, piece: np.ndarray, cuts: Cuts):
    """Cut each piece of a face along all segments of that face.

    Parameters
    ----------
    face : (N,) int
        Face of each piece.
    piece : (N,) polygons or multipolygons, in the coordinates of their faces
    cuts : Cuts

    Returns
    -------
    origin : (C,) int
        Which piece each cell comes from, ascending.
    cell : (C,) polygons
    n_repairs : int
        Pieces whose cells did not fill them and that were cut again on a precision grid.

    Raises
    ------
    ExactError
        If the cells of a piece do not fill it even then.
    """
    order = np.argsort(cuts.face, kind="stable")
    segment_face = cuts.face[order]
    first, last = np.searchsorted(segment_face, face, "left"), np.searchsorted(segment_face, face, "right")
    count = last - first
    owner = np.repeat(np.arange(len(face)), count)
    chosen = order[np.repeat(first - (np.cumsum(count) - count), count) + np.arange(count.sum())]
    ends = np.stack([cuts.start[chosen], cuts.end[chosen]], axis=1)
    lines = np.asarray(shapely.linestrings(ends))
    outline, outline_owner = shapely.get_parts(shapely.boundary(piece), return_index=True)
    everything = np.concatenate([outline, lines])
    everything_owner = np.concatenate([outline_owner, owner])
    by_owner = np.argsort(everything_owner, kind="stable")
    drawing = np.asarray(shapely.multilinestrings(everything[by_owner], indices=everything_owner[by_owner]))
    origin, cell = _cells(piece, drawing, grid_size=None)
    missing = _unfilled(piece, origin, cell)
    if len(missing):
        keep = ~np.isin(origin, missing)
        again, again_cell = _cells(piece[missing], drawing[missing], grid_size=GRID_SIZE)
        still = _unfilled(piece[missing], again, again_cell)
        if len(still):
            raise ExactError(
                f"face {face[missing[still[0]]]} could not be cut into its visible pieces within "
                f"{FILL_TOLERANCE:g} of its area; please report the mesh"
            )
        origin = np.concatenate([origin[keep], missing[again]])
        cell = np.concatenate([cell[keep], again_cell])
        by_origin = np.argsort(origin, kind="stable")
        origin, cell = origin[by_origin], cell[by_origin]
    return origin, cell, len(missing)


def _cells(piece: np.ndarray, drawing: np.ndarray, grid_size: float | None):
    """Cells inside each piece of the arrangement of its `drawing` of lines."""
    noded = np.asarray(shapely.union_all(drawing[:, None], axis=1, grid_size=grid_size))
    collection = shapely.polygonize(noded[:, None], axis=1)  # pyright: ignore[reportCallIssue]
    cell, origin = shapely.get_parts(collection, return_index=True)
    inside = shapely.contains_properly(piece[origin], shapely.point_on_surface(cell))
    return origin[inside], cell[inside]


def _unfilled(piece: np.ndarray, origin: np.ndarray, cell: np.ndarray) -> np.ndarray:
    """Pieces whose cells have not the same area in sum."""
    total = np.bincount(origin, weights=shapely.area(cell), minlength=len(piece))
    return np.flatnonzero(np.abs(total - shapely.area(piece)) > FILL_TOLERANCE)
