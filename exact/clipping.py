"""Cut pieces of faces along segments: the cells of the arrangement, in the faces' own coordinates.

Each face has coordinates (b1, b2) in which its corners are (0, 0), (1, 0) and (0, 1): every face is of order one,
whatever its size, slant and place, and the pieces that different cameras cut out of it need no mapping.
"""

import numpy as np
import shapely

from exact.errors import ExactError
from exact.silhouettes import Cuts

# The cells of a piece must fill it up to this part of the face, or the cutting is done again on a precision grid.
FILL_TOLERANCE = 1e-10
# The precision grid (in parts of the face): far below any tolerance on areas, far above float64 rounding.
GRID_SIZE = 1e-12


def whole_faces(n: int) -> np.ndarray:
    """(n,) polygons of `n` uncut faces."""
    outline = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    return np.full(n, shapely.Polygon(outline), dtype=object)


def cut_pieces(face: np.ndarray, piece: np.ndarray, cuts: Cuts, on_grid: np.ndarray):
    """Cut each piece of a face along all segments of that face.

    Parameters
    ----------
    face : (N,) int
        Face of each piece.
    piece : (N,) polygons or multipolygons, in the coordinates of their faces
    cuts : Cuts
        By ascending face.
    on_grid : (N,) bool
        Pieces to cut on a precision grid from the start: those where segments continue each other whose ends are equal
        only up to rounding. In line with each other, they would miss each other by a hair and cut nothing off.

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
    first, last = np.searchsorted(cuts.face, face, "left"), np.searchsorted(cuts.face, face, "right")
    count = last - first
    owner = np.repeat(np.arange(len(face)), count)
    chosen = np.repeat(first - (np.cumsum(count) - count), count) + np.arange(count.sum())
    ends = np.stack([cuts.start[chosen], cuts.end[chosen]], axis=1)
    lines = np.asarray(shapely.linestrings(ends))
    outline, outline_owner = shapely.get_parts(shapely.boundary(piece), return_index=True)
    everything = np.concatenate([outline, lines])
    everything_owner = np.concatenate([outline_owner, owner])
    by_owner = np.argsort(everything_owner, kind="stable")
    drawing = np.asarray(shapely.multilinestrings(everything[by_owner], indices=everything_owner[by_owner]))
    first_try = _cells(piece, drawing, np.flatnonzero(~on_grid), grid_size=None)
    failed = _unfilled(piece, *first_try, np.flatnonzero(~on_grid))
    on_grid = on_grid.copy()
    on_grid[failed] = True
    second_try = _cells(piece, drawing, np.flatnonzero(on_grid), grid_size=GRID_SIZE)
    still = _unfilled(piece, *second_try, np.flatnonzero(on_grid))
    if len(still):
        raise ExactError(
            f"face {face[still[0]]} could not be cut into its visible pieces within {FILL_TOLERANCE:g} of its area; "
            "please report the mesh"
        )
    keep = ~on_grid[first_try[0]]
    origin = np.concatenate([first_try[0][keep], second_try[0]])
    cell = np.concatenate([first_try[1][keep], second_try[1]])
    order = np.argsort(origin, kind="stable")
    return origin[order], cell[order], len(failed)


def _cells(piece: np.ndarray, drawing: np.ndarray, chosen: np.ndarray, grid_size: float | None):
    """Cells of the arrangement of the lines of each chosen `drawing` inside its piece, and which piece that is."""
    noded = np.asarray(shapely.union_all(drawing[chosen, None], axis=1, grid_size=grid_size))
    collection = shapely.polygonize(noded[:, None], axis=1)  # pyright: ignore[reportCallIssue]
    cell, origin = shapely.get_parts(collection, return_index=True)
    origin = chosen[origin]
    inside = shapely.contains_properly(piece[origin], shapely.point_on_surface(cell))
    return origin[inside], cell[inside]


def _unfilled(piece: np.ndarray, origin: np.ndarray, cell: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Those of the chosen pieces whose cells have not the same area in sum."""
    total = np.bincount(origin, weights=shapely.area(cell), minlength=len(piece))
    return chosen[np.abs(total - shapely.area(piece))[chosen] > FILL_TOLERANCE]
