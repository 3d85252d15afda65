"""Pairs of faces that come near each other, found by a tree of boxes, in blocks.

A long, thin face that lies aslant is taken in several pieces along its length: the box of each is then almost as thin
as the face, while the box of the whole would hold thousands of others.
"""

from collections.abc import Iterator

import numpy as np

from exact.visibility.grid import counting

# Pieces that faces are taken in, for each face on average; more would help none but the thinnest.
PIECES = 6
# A face is taken in pieces where the middle side of its box is more than so many times as long as the face is wide.
SLENDER = 4.0
# Pairs of boxes that are looked at in one go: few enough for caches to hold, many enough for numpy.
PAIRS = 250_000
# Cells along each axis by which boxes are put in order: two to this power.
ORDER_BITS = 16


def close_pairs(corners: np.ndarray, margin: float, sheet: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Pairs of faces whose boxes, or those of pieces of them, meet, but for pairs in the same flat sheet.

    Parameters
    ----------
    corners : (F, 3, 3) float [mm]
    margin : float
        By which boxes are wider than what they hold [mm].
    sheet : (F,) int
        Number of the flat sheet each face is part of, -1 for none.

    Yields
    ------
    one, two : (P,) int
        Faces, one < two, in blocks; a pair may come more than once.

    Examples
    --------
    >>> triangle = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    >>> corners = np.stack([triangle, triangle + [0.5, 0, 0], triangle + [5, 0, 0]])
    >>> [(one.tolist(), two.tolist()) for one, two in close_pairs(corners, 1e-9, np.full(3, -1))]
    [([0], [1])]
    """
    face, low, high = _pieces(corners)
    low, high = low - margin, high + margin
    order = _order(low, high, sheet[face])
    face = face[order]
    levels = [_Level(low[order], high[order], sheet[face])]
    while levels[-1].size > 1:
        levels.append(levels[-1].above())
    top = np.zeros(1, dtype=np.int64)
    waiting = [(len(levels) - 1, top, top)]
    while waiting:
        level, one, two = waiting.pop()
        if len(one) > PAIRS:
            half = len(one) // 2
            waiting += [(level, one[:half], two[:half]), (level, one[half:], two[half:])]
        elif level > 0:
            below = levels[level - 1].meeting(*_children(one, two), keep_same=level > 1)
            if len(below[0]):
                waiting.append((level - 1, *below))
        elif len(one):
            first, second = face[one], face[two]
            differ = first != second
            first, second = first[differ], second[differ]
            yield np.minimum(first, second), np.maximum(first, second)


class _Level:
    """Boxes of one level of the tree, each around two neighbours of the level below."""

    def __init__(self, low: np.ndarray, high: np.ndarray, sheet: np.ndarray):
        self.size = len(low)
        self._low, self._high, self._sheet = np.ascontiguousarray(low.T), np.ascontiguousarray(high.T), sheet

    def above(self) -> "_Level":
        first = np.arange(0, self.size, 2)
        low, high = (
            extreme.reduceat(part, first, axis=1)
            for extreme, part in ((np.minimum, self._low), (np.maximum, self._high))
        )
        last = np.minimum(first + 1, self.size - 1)
        return _Level(low.T, high.T, np.where(self._sheet[first] == self._sheet[last], self._sheet[first], -1))

    def meeting(self, one: np.ndarray, two: np.ndarray, keep_same: bool) -> tuple[np.ndarray, np.ndarray]:
        """Of pairs of boxes (P,) those that meet and are not of one sheet; with or without pairs of one box."""
        there = two < self.size if keep_same else (two < self.size) & (one != two)
        one, two = one[there], two[there]
        for low, high in zip(self._low, self._high, strict=True):
            meets = (low[one] <= high[two]) & (low[two] <= high[one])
            one, two = one[meets], two[meets]
        sheet = self._sheet[one]
        apart = (sheet < 0) | (sheet != self._sheet[two])
        return one[apart], two[apart]


def _children(one: np.ndarray, two: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All pairs of a child of the first and one of the second; where these are the same box, each pair once."""
    differ = one != two
    apart, beside = 2 * one[differ], 2 * two[differ]
    return (
        np.concatenate([2 * one, 2 * one, 2 * one + 1, apart + 1]),
        np.concatenate([2 * two, 2 * two + 1, 2 * two + 1, beside]),
    )


def _order(low: np.ndarray, high: np.ndarray, sheet: np.ndarray) -> np.ndarray:
    """(N,) order in which boxes near each other follow each other, those of a sheet all in a row."""
    centre = (low + high) / 2
    least = centre.min(axis=0)
    size = float((centre.max(axis=0) - least).max())
    scale = ((1 << ORDER_BITS) - 1) / size if size > 0 else 0.0
    place = ((centre - least) * scale).astype(np.int64)
    key = np.zeros(len(place), dtype=np.int64)
    for bit in range(ORDER_BITS):
        for axis in range(3):
            key |= ((place[:, axis] >> bit) & 1) << (3 * bit + axis)
    return np.lexsort((key, sheet))


def _pieces(corners: np.ndarray):
    """Faces in pieces along their longest side: the face of each, (N,), and its box, (N, 3), (N, 3)."""
    size = corners.max(axis=1) - corners.min(axis=1)
    sides = corners[:, [1, 2, 0]] - corners
    longest = np.linalg.norm(sides, axis=2)
    start = longest.argmax(axis=1)
    row = np.arange(len(corners))
    height = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / longest[row, start]
    middle = np.sort(size, axis=1)[:, 1]
    count = np.clip(np.floor(middle / (SLENDER * np.maximum(height, 1e-3 * middle + 1e-300))), 1, None)
    step = SLENDER * float(np.median(height))
    while np.minimum(count, np.ceil(middle / step + 1)).sum() > PIECES * len(corners) and step < middle.max():
        step = 2 * step + 1e-300
    count = np.minimum(count, np.ceil(middle / step + 1)).astype(np.int64)
    face = np.repeat(row, count)
    low, high = corners.min(axis=1)[face], corners.max(axis=1)[face]
    several = np.flatnonzero(count[face] > 1)
    which = face[several]
    part = counting(count)[several] / count[which]
    a, b, c = (corners[which, (start[which] + k) % 3] for k in range(3))
    along = b - a
    apex = np.clip(((c - a) * along).sum(axis=1) / (along * along).sum(axis=1), 0.0, 1.0)
    ends = (part, part + 1 / count[which])
    # Cut across the longest side, the outline of a piece is made of points on it and points on the other two.
    points = [a + t[:, None] * along for t in ends]
    for t in (*ends, np.clip(apex, *ends)):
        up = np.divide(t, apex, out=np.ones_like(t), where=apex > 0)
        down = np.divide(1 - t, 1 - apex, out=np.ones_like(t), where=apex < 1)
        points.append(np.where((t <= apex)[:, None], a + up[:, None] * (c - a), b + down[:, None] * (c - b)))
    low[several], high[several] = np.minimum.reduce(points), np.maximum.reduce(points)
    return face, low, high
