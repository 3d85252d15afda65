"""Cut pieces of faces along segments: the cells of the arrangement, in the faces' own coordinates.

Each face has coordinates (b1, b2) in which its corners are (0, 0), (1, 0) and (0, 1): every face is of order one,
whatever its size, slant and place, and the pieces that different cameras cut out of it need no mapping.
"""

import numpy as np
import shapely

from exact.errors import ExactError
from exact.visibility.grid import counting, greatest, least
from exact.visibility.projection import UNIT_FRAME
from exact.visibility.silhouettes import Cuts

# The cells of a piece must fill it as if its outline were off by at most this (in parts of the face), or the cutting is
# done again on a precision grid: 1e-10 of a whole face, and less of a small piece of it. Far above the grid, and above
# the hairs between segments that coincide up to rounding; of a face of ten metres it is a third of a nanometre.
OUTLINE_TOLERANCE = 3e-11
# The precision grid (in parts of the face): far below any tolerance on areas, far above float64 rounding.
GRID_SIZE = 1e-12
# Pieces that make up more than their face by this part of it overlap: what rounding adds is far less.
OVERLAP = 1e-10
# Pieces with more corners, or crossed by more segments of their face, are not cut line by line.
MOST_CORNERS, MOST_HALVINGS = 12, 6
POLYGON = 3
# Gaps narrower than this part of the face are rounding, not shape.
NECK = 1e-9
# A point is well off an outline if it is farther from it than this part of the mean width, area over outline.
CLEARLY_INSIDE = 1e-3


def whole_faces(n: int) -> np.ndarray:
    """(n,) polygons of `n` uncut faces."""
    return np.full(n, shapely.Polygon(UNIT_FRAME), dtype=object)


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
    inner : (C, 2) float
        A point clearly inside each cell.

    Raises
    ------
    ExactError
        If the cells of a piece do not fill it even then.
    """
    part, of_piece = shapely.get_parts(piece, return_index=True)
    owner, line = _segments_over(face[of_piece], part, cuts)
    crossed = np.zeros(len(part), dtype=bool)
    crossed[owner] = True
    outline, outline_owner = shapely.get_parts(shapely.boundary(part[crossed]), return_index=True)
    everything = np.concatenate([outline, line])
    everything_owner = np.concatenate([np.flatnonzero(crossed)[outline_owner], owner])
    order = np.argsort(everything_owner, kind="stable")
    drawing = np.full(len(part), None, dtype=object)
    number = np.cumsum(crossed) - 1
    drawing[crossed] = shapely.multilinestrings(everything[order], indices=number[everything_owner[order]])
    on_grid = on_grid[of_piece] & crossed
    uncut, chosen, later = np.flatnonzero(~crossed), np.flatnonzero(crossed & ~on_grid), np.flatnonzero(on_grid)
    found, n_repairs = [(uncut, part[uncut], _clearly_inside(part[uncut]))], 0
    for grid_size in (None, GRID_SIZE):
        cells = _cells(part, drawing, chosen, grid_size)
        failed = _unfilled(part, *cells[:2], chosen)
        keep = ~np.isin(cells[0], failed)
        found.append((cells[0][keep], cells[1][keep], cells[2][keep]))
        n_repairs += len(failed)
        chosen, later = np.append(failed, later), later[:0]
    if len(chosen):
        # Where lines nearly coincide, they may cross far from where they do; to halve triangles no two lines need meet.
        triangle, of = _triangles(part[chosen])
        owner, cell, inner = _by_lines(*_range_of(face[of_piece[chosen[of]]], cuts.face), *_convex(triangle), cuts)
        found.append((chosen[of[owner]], cell, inner))
        failed = _unfilled(part, *found[-1][:2], chosen)
        if len(failed):
            raise ExactError(
                f"face {face[of_piece[failed[0]]]} could not be cut into visible pieces that fill it up to rounding; "
                "please report the mesh"
            )
    origin, cell, inner = (np.concatenate(some) for some in zip(*found, strict=True))
    order = np.argsort(origin, kind="stable")
    return of_piece[origin[order]], cell[order], n_repairs, inner[order]


def halved_pieces(face: np.ndarray, piece: np.ndarray, cuts: Cuts, on_grid: np.ndarray):
    """Cut pieces as `cut_pieces` does, convex ones that few segments cross by whole lines: faster, in more cells.

    A segment that meets a convex cell halves it along its line. What it cuts off beyond its end does no harm, since
    each cell is asked for itself.

    Parameters
    ----------
    face, piece, cuts, on_grid
        As of `cut_pieces`.

    Returns
    -------
    origin, cell, n_repairs, inner
        As of `cut_pieces`.
    """
    corners, count = _convex(piece)
    first, last = _range_of(face, cuts.face)
    simple = (count > 0) & (last - first <= MOST_HALVINGS) & ~on_grid
    rest = np.flatnonzero(~simple)
    origin, cell, n_repairs, inner = cut_pieces(face[rest], piece[rest], cuts, on_grid[rest])
    chosen = np.flatnonzero(simple)
    owner, halves, middle = _by_lines(first[chosen], last[chosen], corners[chosen], count[chosen], cuts)
    origin = np.concatenate([rest[origin], chosen[owner]])
    order = np.argsort(origin, kind="stable")
    return origin[order], np.append(cell, halves)[order], n_repairs, np.concatenate([inner, middle])[order]


def _range_of(face: np.ndarray, of_face: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where what is of faces (N,) begins and ends among all, of ascending faces (M,): (N,), (N,)."""
    return np.searchsorted(of_face, face, "left"), np.searchsorted(of_face, face, "right")


def _by_lines(first: np.ndarray, last: np.ndarray, corners: np.ndarray, count: np.ndarray, cuts: Cuts):
    """Convex polygons (N, K, 2) with so many corners (N,), halved by the lines of the segments `first` to `last`.

    Which polygon each cell is from, (C,); itself; a point in it, (C, 2).
    """
    owner = np.arange(len(first))
    for k in range(int((last - first).max(initial=0))):
        which = np.flatnonzero(first[owner] + k < last[owner])
        at = first[owner[which]] + k
        parted, halves, n_corners = _halved(corners[which], count[which], cuts.start[at], cuts.end[at])
        parted = which[parted]
        width = max(corners.shape[1], halves.shape[2])
        corners, halves = _widened(corners, width), _widened(halves, width)
        corners[parted], count[parted] = halves[0], n_corners[0]
        owner = np.concatenate([owner, owner[parted]])
        corners, count = np.concatenate([corners, halves[1]]), np.concatenate([count, n_corners[1]])
    there = np.arange(corners.shape[1]) < count[:, None]
    middle = (corners * there[:, :, None]).sum(axis=1) / count[:, None]
    outline = np.concatenate([corners, corners[:, :1]], axis=1)
    ends = np.arange(len(count)), count
    outline[ends] = corners[:, 0]
    drawn = np.arange(outline.shape[1]) <= count[:, None]
    ring = shapely.linearrings(outline[drawn], indices=np.repeat(np.arange(len(count)), count + 1))
    return owner, np.asarray(shapely.polygons(ring)), middle


def _convex(piece: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(N, K, 2) corners of polygons in order, and how many, (N,); 0 of those that are not convex or have too many."""
    n_points = shapely.get_num_coordinates(piece)
    fit = (shapely.get_type_id(piece) == POLYGON) & (shapely.get_num_interior_rings(piece) == 0)
    fit &= (n_points > 3) & (n_points <= MOST_CORNERS + 1)
    chosen = np.flatnonzero(fit)
    point, owner = shapely.get_coordinates(piece[chosen], return_index=True)
    count = n_points[chosen] - 1
    place = counting(n_points[chosen])
    is_corner = place < count[owner]
    corners = np.zeros((len(piece), MOST_CORNERS, 2))
    corners[chosen[owner[is_corner]], place[is_corner]] = point[is_corner]
    here = corners[chosen]
    ahead = here[np.arange(len(chosen))[:, None], (np.arange(MOST_CORNERS) + 1) % count[:, None]]
    side = ahead - here
    after = side[np.arange(len(chosen))[:, None], (np.arange(MOST_CORNERS) + 1) % count[:, None]]
    turn = side[:, :, 0] * after[:, :, 1] - side[:, :, 1] * after[:, :, 0]
    turn[np.arange(MOST_CORNERS) >= count[:, None]] = 0.0
    number = np.zeros(len(piece), dtype=int)
    is_convex = (turn >= 0).all(axis=1) | (turn <= 0).all(axis=1)
    number[chosen] = np.where(is_convex, count, 0)
    return corners, number


def _halved(corners: np.ndarray, count: np.ndarray, start: np.ndarray, end: np.ndarray):
    """Convex polygons (N, K, 2) with so many corners (N,), parted by the lines of segments that meet them.

    Returns
    -------
    parted : (P,) int
        Those that their segment meets inside.
    halves : (2, P, K', 2) float
    n_corners : (2, P) int
    """
    along = end - start
    length = np.hypot(along[:, 0], along[:, 1])
    along = along / np.maximum(length, 1e-300)[:, None]
    there = np.arange(corners.shape[1]) < count[:, None]
    away = corners - start[:, None]
    side = along[:, None, 0] * away[:, :, 1] - along[:, None, 1] * away[:, :, 0]
    side[np.abs(side) <= GRID_SIZE] = 0.0
    side[~there] = 0.0
    parted = np.flatnonzero((side > 0).any(axis=1) & (side < 0).any(axis=1) & (length > 0))
    corners, count, there, side, away = corners[parted], count[parted], there[parted], side[parted], away[parted]
    row = np.arange(len(parted))[:, None]
    onwards = (np.arange(corners.shape[1]) + 1) % count[:, None]
    other = side[row, onwards]
    crosses = there & (side * other < 0)
    share = np.divide(side, side - other, out=np.zeros_like(side), where=crosses)[:, :, None]
    crossing = corners + share * (corners[row, onwards] - corners)
    # Where the line enters and leaves the polygon: at corners on it or crossings of sides.
    place = (away * along[parted][:, None]).sum(axis=2)
    place_of_crossing = ((crossing - start[parted][:, None]) * along[parted][:, None]).sum(axis=2)
    on_line = there & (side == 0)
    low = np.minimum(
        np.where(on_line, place, np.inf).min(axis=1), np.where(crosses, place_of_crossing, np.inf).min(axis=1)
    )
    high = np.maximum(
        np.where(on_line, place, -np.inf).max(axis=1), np.where(crosses, place_of_crossing, -np.inf).max(axis=1)
    )
    met = np.minimum(high, length[parted]) - np.maximum(low, 0.0) > GRID_SIZE
    halves, numbers = [], []
    room = 2 * corners.shape[1]
    for sign in (1.0, -1.0):
        # Each corner on this side, followed by the crossing of the side that begins there, if there is one.
        given = np.stack([there & (sign * side >= 0), crosses], axis=2)[met].reshape(-1, room)
        points = np.stack([corners, crossing], axis=2)[met].reshape(-1, room, 2)
        number = given.sum(axis=1)
        half = np.zeros((len(number), int(number.max(initial=0)), 2))
        which, _ = np.nonzero(given)
        half[which, counting(number)] = points[given]
        halves.append(half)
        numbers.append(number)
    width = max(half.shape[1] for half in halves)
    return parted[met], np.stack([_widened(half, width) for half in halves]), np.stack(numbers)


def _widened(corners: np.ndarray, width: int) -> np.ndarray:
    """(..., width, 2) corners with room for more."""
    room = [(0, 0)] * (corners.ndim - 2) + [(0, width - corners.shape[-2]), (0, 0)]
    return np.pad(corners, room) if width > corners.shape[-2] else corners


def of_same_face(face: np.ndarray, of_face: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (P,), (P,) of one of the faces (N,) and one of others that is the same, (M,) ascending."""
    first, last = _range_of(face, of_face)
    return np.repeat(np.arange(len(face)), last - first), np.repeat(first, last - first) + counting(last - first)


def _segments_over(face: np.ndarray, piece: np.ndarray, cuts: Cuts):
    """Lines of `cuts` that part a piece of their face, a polygon: the piece of each, (L,) int, and the line."""
    owner, chosen = of_same_face(face, cuts.face)
    start, end = cuts.start[chosen], cuts.end[chosen]
    low, high = np.minimum(start, end), np.maximum(start, end)
    box = shapely.bounds(piece)[owner]
    near = (low <= box[:, 2:] + GRID_SIZE).all(axis=1) & (high >= box[:, :2] - GRID_SIZE).all(axis=1)
    owner, start, end, box = owner[near], start[near], end[near], box[near]
    near = ~_beside(box, start, end)
    owner, start, end = owner[near], start[near], end[near]
    near = _more_than_touches(piece, owner, start, end)
    owner = owner[near]
    line = np.asarray(shapely.linestrings(np.stack([start[near], end[near]], axis=1)))
    # Within the grid size is as good as touching, since the cutting may move lines by that much.
    meets = shapely.dwithin(line, piece[owner], GRID_SIZE)
    return owner[meets], line[meets]


def _beside(box: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """(L,) whether a box (left, low, right, high) lies clearly on one side of the line through a segment."""
    along_x, along_y = (end - start).T
    across = along_x[:, None] * (box[:, 1::2] - start[:, 1:])
    up = -along_y[:, None] * (box[:, ::2] - start[:, :1])
    slack = 2 * GRID_SIZE * np.hypot(along_x, along_y)
    return (least(across) + least(up) > slack) | (greatest(across) + greatest(up) < -slack)


def _more_than_touches(piece: np.ndarray, owner: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """(L,) whether a segment does more to its piece than touch a corner of the face in which it ends: many do not.

    One that runs along the outline, or touches it elsewhere, may be what a segment that ends there hangs together with.
    """
    point, of_piece = shapely.get_coordinates(piece, return_index=True)
    at_corner = (np.abs(point[:, None] - UNIT_FRAME).max(axis=2) <= GRID_SIZE).any(axis=1)
    from_corner = (np.stack([start, end], axis=1)[:, :, None] == UNIT_FRAME).all(axis=3).any(axis=(1, 2))
    count = np.bincount(of_piece, minlength=len(piece))
    number = count[owner]
    at = np.repeat((np.cumsum(count) - count)[owner], number) + counting(number)
    along = end - start
    along = np.repeat(along / np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-300)[:, None], number, axis=0)
    away = point[at] - np.repeat(start, number, axis=0)
    side = along[:, 0] * away[:, 1] - along[:, 1] * away[:, 0]
    begins = np.cumsum(number) - number
    on_it = (np.abs(side) <= GRID_SIZE) & ~(at_corner[at] & np.repeat(from_corner, number))
    if not len(begins):
        return np.zeros(0, dtype=bool)
    parts = (np.minimum.reduceat(side, begins) < -GRID_SIZE) & (np.maximum.reduceat(side, begins) > GRID_SIZE)
    return parts | np.maximum.reduceat(on_it, begins)


def _cells(piece: np.ndarray, drawing: np.ndarray, chosen: np.ndarray, grid_size: float | None):
    """Cells of the arrangement of each chosen `drawing` in its piece: of which piece each is, itself, a point in it."""
    noded = np.asarray(shapely.union_all(drawing[chosen, None], axis=1, grid_size=grid_size))
    collection = shapely.polygonize(noded[:, None], axis=1)  # pyright: ignore[reportCallIssue]
    cell, origin = shapely.get_parts(collection, return_index=True)
    cell, origin = _without_necks(cell, chosen[origin])
    inner = _clearly_inside(cell)
    inside = shapely.contains_properly(piece[origin], shapely.points(inner))
    return origin[inside], cell[inside], inner[inside]


def _clearly_inside(polygon: np.ndarray) -> np.ndarray:
    """(N, 2) a point of each polygon that is well off its outline.

    The point that shapely finds is halfway up, and on the outline itself where that follows the same line up to
    rounding, as that of a face in line with a camera does.
    """
    point = shapely.point_on_surface(polygon)
    inner = shapely.get_coordinates(point)
    least_away = CLEARLY_INSIDE * shapely.area(polygon) / shapely.length(polygon)
    doubtful = np.flatnonzero(shapely.distance(point, shapely.boundary(polygon)) < least_away)
    triangle, of = _triangles(polygon[doubtful])
    size = shapely.area(triangle)
    order = np.argsort(size, kind="stable")  # the largest of each is written last
    inner[doubtful[of[order]]] = shapely.get_coordinates(shapely.centroid(triangle[order]))
    return inner


def _triangles(polygon: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles that fill polygons (N,), and which polygon each is from."""
    return shapely.get_parts(shapely.constrained_delaunay_triangles(polygon), return_index=True)


def _without_necks(cell: np.ndarray, origin: np.ndarray):
    """The same cells, but those that hang together by less than `NECK` only, cut into triangles.

    Where two cameras' segments coincide up to rounding, a gap of no width is left between them. A cell may reach
    through it to what is really another cell, so that no one point speaks for all of it.
    """
    suspects = np.flatnonzero(shapely.get_num_coordinates(cell) > 4)
    suspects = suspects[_convex(cell[suspects])[1] == 0]
    suspects = suspects[shapely.minimum_clearance(cell[suspects]) < NECK]
    if not len(suspects):
        return cell, origin
    # On the grid, hairs of no width, which no triangulation gets through, are gone.
    tidy, owner = shapely.get_parts(shapely.set_precision(cell[suspects], GRID_SIZE), return_index=True)
    triangle, which = _triangles(tidy)
    kept = np.ones(len(cell), dtype=bool)
    kept[suspects] = False
    return np.concatenate([cell[kept], triangle]), np.concatenate([origin[kept], origin[suspects[owner[which]]]])


def _unfilled(piece: np.ndarray, origin: np.ndarray, cell: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Those of the chosen pieces whose cells have not the same area in sum."""
    total = np.bincount(origin, weights=shapely.area(cell), minlength=len(piece))[chosen]
    return chosen[differ(total, shapely.area(piece[chosen]), shapely.length(piece[chosen]))]


def differ(area: np.ndarray, expected: np.ndarray, outline: np.ndarray) -> np.ndarray:
    """(N,) whether areas are not those expected of polygons with outlines of these lengths."""
    return np.abs(area - expected) > OUTLINE_TOLERANCE * outline
