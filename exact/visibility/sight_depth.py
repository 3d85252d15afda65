"""How deep one camera can see at most in each cell of a grid over its image.

What lies behind a sheet of faces that covers a whole cell is hidden there, and so are the silhouettes among it, which
cannot cast a shadow that matters. Triangles that touch a cell, sorted by depth, fall into layers: wherever the next one
is farther than all before it, another layer begins. Neighbours share an edge and with it a depth, so they are in the
same layer. A layer in which no sheet ends or folds back, and that covers the middle of its cell, covers all of it: on
the way from the middle to any other point, each triangle that is left is followed by a neighbour.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from exact.visibility.grid import Grid

# Depths are counted in steps from the farthest to the nearest, in numbers of so many bits.
BITS = 20
LAST = (1 << BITS) - 1
STEPS = LAST - 2
# Faces that differ less in depth (relatively) may be in one plane, where neither hides the other.
SAME_DEPTH = 1e-7
# Only triangles at least this thick (in parts of their longest side) are sure to cover what they seem to cover.
THICK = 1e-6
# Pairs of a triangle and a cell whose middle it may cover that are looked at in one go, as many as suit caches.
PAIRS = 250_000


@dataclass(frozen=True)
class Depths:
    """Whole numbers in place of 1/depth, greater ones nearer: those of a near end rounded up, of a far end down."""

    low: float
    scale: float

    @classmethod
    def between(cls, farthest: np.ndarray, nearest: np.ndarray) -> "Depths":
        """Numbers for 1/depth from the least of `farthest` to the greatest of `nearest`, (N,) [1/mm]."""
        if not len(farthest):
            return cls(0.0, 0.0)
        low, high = float(farthest.min()), float(nearest.max())
        return cls(low, STEPS / max(high * (1 + SAME_DEPTH) - low, SAME_DEPTH * high))

    def near(self, inverse_depth: np.ndarray) -> np.ndarray:
        """(N,) int64, not less than what they stand for, and by `SAME_DEPTH` nearer."""
        steps = np.ceil((inverse_depth * (1 + SAME_DEPTH) - self.low) * self.scale) + 1
        return np.clip(steps, 1, LAST).astype(np.int64)

    def far(self, inverse_depth: np.ndarray) -> np.ndarray:
        """(N,) int64, not greater than what they stand for."""
        steps = np.floor((inverse_depth - self.low) * self.scale)
        return np.clip(steps, 0, LAST).astype(np.int64)


def sight_depth(
    n_cells: int,
    sheets: tuple[np.ndarray, np.ndarray, np.ndarray],
    covers: np.ndarray,
    ends: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> np.ndarray:
    """Depth in each cell beyond which nothing is seen.

    Parameters
    ----------
    sheets : three (P,) int
        Cells that triangles touch, and least and greatest depth of the triangle there, as `Depths`.
    covers : (P,) bool
        Whether the triangle covers the middle of the cell.
    ends : three (Q,) int
        The same of edges where a sheet ends or folds back.

    Returns
    -------
    (n_cells,) int
        As `Depths`; 0 where there is no limit.

    Examples
    --------
    >>> covers, nowhere = np.array([True, True]), np.zeros((3, 0), dtype=int)
    >>> sheets = np.array([0, 0]), np.array([9, 5]), np.array([8, 4])
    >>> sight_depth(1, sheets, covers, tuple(nowhere))  # the nearest one covers it
    array([8])
    >>> end = np.array([0]), np.array([9]), np.array([8])
    >>> sight_depth(1, sheets, covers, end)  # but ends in it
    array([4])
    """
    limit = np.zeros(n_cells, dtype=np.int64)
    if not len(covers) + len(ends[0]):
        return limit
    # All about one of them in one number, the cell first and then the nearest: numbers are sorted far faster than
    # indices.
    marks = np.concatenate([covers.astype(np.int64), np.full(len(ends[0]), 2)])
    cell, near, far = (np.concatenate(values) for values in zip(sheets, ends, strict=True))
    key = np.sort((((cell << BITS | LAST - near) << BITS | far) << 2) | marks)
    covers, is_end, far = (key & 1).astype(bool), (key & 2).astype(bool), key >> 2 & LAST
    near, cell = LAST - (key >> BITS + 2 & LAST), key >> 2 * BITS + 2
    # The farthest so far in each cell: the numbers of a later cell are all less than those of one before.
    farthest = np.minimum.accumulate(far - (cell << BITS)) + (cell << BITS)
    begins = np.ones(len(cell), dtype=bool)
    begins[1:] = (cell[1:] != cell[:-1]) | (near[1:] < farthest[:-1])
    start = np.flatnonzero(begins)
    whole = np.logical_or.reduceat(covers, start) & ~np.logical_or.reduceat(is_end, start)
    last = np.append(start[1:], len(cell)) - 1
    # The nearest such layer of each cell, which comes first.
    layer = np.flatnonzero(whole)[::-1]
    limit[cell[start[layer]]] = farthest[last[layer]]
    return limit


def cell_centres_in(
    grid: Grid, owner: np.ndarray, cell: np.ndarray, x: np.ndarray, y: np.ndarray, shape: np.ndarray
) -> np.ndarray:
    """(P,) whether the triangle `owner` covers the middle of a `cell`; of corners (N, 3) and thickness `shape` (N,)."""
    inside = np.zeros(len(owner), dtype=bool)
    for low in range(0, len(owner), PAIRS):
        which, part = owner[low : low + PAIRS], slice(low, low + PAIRS)
        at_x, at_y = grid.centres(cell[part])
        turns = []
        for k in range(3):
            a, b = (which, k), (which, (k + 1) % 3)
            turns.append((x[b] - x[a]) * (at_y - y[a]) - (y[b] - y[a]) * (at_x - x[a]))
        least, greatest = np.minimum(np.minimum(*turns[:2]), turns[2]), np.maximum(np.maximum(*turns[:2]), turns[2])
        inside[part] = ((least >= 0) | (greatest <= 0)) & (shape[which] > THICK)
    return inside


def blocks(count: np.ndarray, most: int) -> Iterator[tuple[int, int]]:
    """Ranges of what has these counts, (N,), each of about `most` in sum, or of a single one that has more.

    Examples
    --------
    >>> list(blocks(np.array([2, 2, 5, 1, 1]), 4))
    [(0, 2), (2, 3), (3, 5)]
    """
    total = np.cumsum(count)
    low, done = 0, 0
    while low < len(count):
        high = max(low + 1, int(np.searchsorted(total, done + most, "right")))
        yield low, high
        low, done = high, int(total[high - 1])
