"""Square cells over a part of an image, and which of them triangles and segments touch."""

from dataclasses import dataclass
from functools import reduce

import numpy as np

# Least and most cells along either side. Even the most are few beside the faces that ask for them.
FEWEST_CELLS, MOST_CELLS = 16, 1024
# Cells that a triangle may touch on average; the grid is made coarser where they would be more, as large triangles are.
CELLS_EACH = 12
# A window narrower than this (in image coordinates of order 1) is one cell wide.
NARROWEST_WINDOW = 1e-15
# What comes this near to a cell touches it (in parts of a cell and of the shape): far above rounding.
NEARNESS, NEARNESS_OF_SHAPE = 1e-6, 4e-7
# A side that rises less than this (in cells) runs along its row: far below `NEARNESS`.
FLAT = 1e-9


@dataclass(frozen=True, eq=False)
class Grid:
    """`n` x `n` cells over a window of the image, to find shapes and points that are near each other.

    Attributes
    ----------
    low, high : (2,) float
        Corners of the window.
    n : int
    """

    low: np.ndarray
    high: np.ndarray
    n: int

    @classmethod
    def over(cls, asked: np.ndarray, half_extent: np.ndarray, box: np.ndarray, area: np.ndarray) -> "Grid":
        """The grid over the boxes of what is `asked` about (left, low, right, high; (4, A)), in the field of view.

        Its cells are about as large as the triangles with boxes (4, N) and areas (N,).
        """
        if asked.shape[1] == 0:
            return cls(np.zeros(2), np.zeros(2), FEWEST_CELLS)
        low = np.maximum(asked[:2].min(axis=1), -half_extent)
        high = np.minimum(asked[2:].max(axis=1), half_extent)
        window = np.maximum(high - low, NARROWEST_WINDOW)
        met = in_window(box, low, high)
        sides = np.minimum(box[2:, met], high[:, None]) - np.maximum(box[:2, met], low[:, None])
        outline = float((np.maximum(sides, 0) / window[:, None]).sum())
        covered = float(np.minimum(area[met] / window.prod(), 1.0).sum())
        n = int(np.clip(np.sqrt(met.sum()), FEWEST_CELLS, MOST_CELLS))
        while n > FEWEST_CELLS and covered * n * n + outline * n > CELLS_EACH * met.sum():
            n = max(FEWEST_CELLS, n // 2)
        return cls(low, high, n)

    def part_within(self, start, end, enter: np.ndarray, leave: np.ndarray) -> list[np.ndarray]:
        """Where segments, which run from `enter` to `leave`, (N,), come into the grid and go out of it.

        In parts of the way from `start` to `end`, which have x and y. Those that pass beside it are taken as they are.
        """
        first, last = enter, leave
        for begin, finish, low, high in zip((start.x, start.y), (end.x, end.y), self.low, self.high, strict=True):
            for away, inwards in ((low - begin, finish - begin), (begin - high, begin - finish)):
                t = np.divide(away, inwards, out=np.zeros_like(away), where=inwards != 0)
                first = np.where(inwards > 0, np.maximum(first, t), first)
                last = np.where(inwards < 0, np.minimum(last, t), last)
        beside = first >= last
        return [np.where(beside, enter, first), np.where(beside, leave, last)]

    @property
    def n_cells(self) -> int:
        """How many cells it has; they are numbered column by column."""
        return self.n * self.n

    def _scale(self, axis: int) -> float:
        size = self.high[axis] - self.low[axis]
        return self.n / size if size > NARROWEST_WINDOW else 0.0

    def lines(self, coordinate: np.ndarray, axis: int) -> np.ndarray:
        """Coordinates counted in cells from the window's corner."""
        return (coordinate - self.low[axis]) * self._scale(axis)

    def line(self, coordinate: np.ndarray, axis: int) -> np.ndarray:
        """Column (axis 0) or row (axis 1) of the cell that holds each coordinate; the outer cells reach outwards."""
        return np.clip(self.lines(coordinate, axis), 0, self.n - 1).astype(np.int64)

    def cell(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """(N,) the cell that holds each point."""
        return self.line(x, 0) * self.n + self.line(y, 1)

    def boxes(self, box: np.ndarray) -> np.ndarray:
        """(4, N) columns and rows that boxes (4, N) reach: left, low, right, high."""
        return np.stack([self.line(side, k % 2) for k, side in enumerate(box)])

    def marked(self, cells: np.ndarray) -> np.ndarray:
        """(n, n) bool: the cells that some box reaches."""
        left, low, right, high = cells
        # Marks at the corners of each box, summed up along both axes, are the number of boxes over each cell.
        side = self.n + 1
        begin = np.concatenate([left * side + low, (right + 1) * side + high + 1])
        end = np.concatenate([(right + 1) * side + low, left * side + high + 1])
        corners = np.bincount(begin, minlength=side * side) - np.bincount(end, minlength=side * side)
        return corners.reshape(side, side).cumsum(axis=0).cumsum(axis=1)[: self.n, : self.n] > 0

    def meets(self, marks: np.ndarray, cells: np.ndarray) -> np.ndarray:
        """(N,) whether boxes that reach these `cells` (4, N) reach one of the marked ones."""
        left, low, right, high = cells
        total = np.zeros((self.n + 1, self.n + 1), dtype=np.int32)
        total[1:, 1:] = marks.cumsum(axis=0, dtype=np.int32).cumsum(axis=1)
        return total[right + 1, high + 1] - total[left, high + 1] - total[right + 1, low] + total[left, low] > 0

    def touched(self, x: np.ndarray, y: np.ndarray, marks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which of the marked cells each shape touches, or nearly so.

        Parameters
        ----------
        x, y : (N, K) float
            Corners of triangles, K = 3, or ends of segments, K = 2.
        marks : (n, n) bool

        Returns
        -------
        owner : (P,) int
            The shape, ascending.
        cell : (P,) int
            A cell that it touches.
        """
        across, up = self.lines(x, 0), self.lines(y, 1)
        left, right, low, high = least(across), greatest(across), least(up), greatest(up)
        slack = NEARNESS + NEARNESS_OF_SHAPE * np.maximum(right - left, high - low)
        inside = np.flatnonzero(
            (right + slack >= 0) & (left - slack <= self.n) & (high + slack >= 0) & (low - slack <= self.n)
        )
        first = np.clip(low[inside] - slack[inside], 0, self.n - 1).astype(np.int64)
        last = np.clip(high[inside] + slack[inside], 0, self.n - 1).astype(np.int64)
        owner = np.repeat(inside, last - first + 1)
        row = np.repeat(first, last - first + 1) + counting(last - first + 1)
        slack = slack[owner]
        left, right = _within_row(across, up, owner, row - slack, row + 1 + slack)
        left, right = left - slack, right + slack
        kept = np.flatnonzero((left <= self.n) & (right >= 0))  # of a row that it misses, left is infinite
        owner, row = owner[kept], row[kept]
        first = np.clip(left[kept], 0, self.n - 1).astype(np.int64)
        width = np.clip(right[kept], 0, self.n - 1).astype(np.int64) - first + 1
        cell = (np.repeat(first, width) + counting(width)) * self.n + np.repeat(row, width)
        owner = np.repeat(owner, width)
        marked = marks.reshape(-1)[cell]
        return owner[marked], cell[marked]

    def listed(self, owner: np.ndarray, cell: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What `touched` gives, by cell: (n * n + 1,) where each cell begins, and (P,) the shapes in this order."""
        key = np.sort(cell << 32 | owner)  # far faster than to sort indices
        first = np.append(0, np.cumsum(np.bincount(cell, minlength=self.n_cells)))
        return first, (key & 0xFFFFFFFF).astype(np.int32)

    def centres(self, cell: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Image coordinates x and y of the middle of each cell."""
        size = (self.high - self.low) / self.n
        return self.low[0] + (cell // self.n + 0.5) * size[0], self.low[1] + (cell % self.n + 0.5) * size[1]


def _within_row(across: np.ndarray, up: np.ndarray, owner: np.ndarray, low: np.ndarray, high: np.ndarray):
    """How far left and right the parts of shapes between two heights reach; (inf, -inf) of none."""
    left, right = np.full(len(owner), np.inf), np.full(len(owner), -np.inf)
    n = across.shape[1]
    for k in range(n if n > 2 else 1):
        u, v = across[owner, k], up[owner, k]
        du, dv = across[owner, (k + 1) % n] - u, up[owner, (k + 1) % n] - v
        flat = np.abs(dv) < FLAT
        step = np.divide(1.0, dv, out=np.zeros_like(dv), where=~flat)
        one, two = (low - v) * step, (high - v) * step
        enter = np.where(flat, 0.0, np.maximum(np.minimum(one, two), 0.0))
        leave = np.where(flat, 1.0, np.minimum(np.maximum(one, two), 1.0))
        meets = (enter <= leave) & (~flat | ((v >= low) & (v <= high)))
        at_enter, at_leave = u + enter * du, u + leave * du
        left = np.where(meets, np.minimum(left, np.minimum(at_enter, at_leave)), left)
        right = np.where(meets, np.maximum(right, np.maximum(at_enter, at_leave)), right)
    return left, right


def least(columns: np.ndarray) -> np.ndarray:
    """(N,) least of the few numbers in each row of (N, K); numpy's own is slow along so short an axis."""
    return reduce(np.minimum, columns.T)


def greatest(columns: np.ndarray) -> np.ndarray:
    """(N,) greatest of the few numbers in each row of (N, K)."""
    return reduce(np.maximum, columns.T)


def counting(count: np.ndarray) -> np.ndarray:
    """0, 1, .. count[0] - 1, 0, 1, .. count[1] - 1, and so on."""
    return np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)


def in_window(box: np.ndarray, low: np.ndarray, high: np.ndarray | None = None) -> np.ndarray:
    """(N,) whether boxes (left, low, right, high; (4, N)) meet a window, by default symmetric about the origin."""
    high = -low if high is None else high
    return (box[0] <= high[0]) & (box[1] <= high[1]) & (box[2] >= low[0]) & (box[3] >= low[1])
