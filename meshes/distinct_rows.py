"""Rows of three numbers that are the same: vertices in one place, faces of the same corners."""

import numpy as np

# Odd numbers without pattern, which mix three numbers into one.
MIX = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)


def distinct_rows(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The first row of each kind, in their order, and for each row the number of its kind.

    Parameters
    ----------
    rows : (N, 3) int64 or float64
        Any values; 0.0 and -0.0 are the same, and so is a nan to itself.

    Returns
    -------
    first : (K,) int
    number : (N,) int

    Examples
    --------
    >>> first, number = distinct_rows(np.array([[1, 0, 0], [0, 0, 0], [1, -0.0, 0]]))
    >>> first.tolist(), number.tolist()
    ([0, 1], [0, 1, 0])
    """
    bits = np.ascontiguousarray(rows + 0).view(np.uint64).reshape(-1, 3)  # + 0 turns -0.0 into 0.0
    key = np.zeros(len(bits), dtype=np.uint64)
    for column, factor in zip(bits.T, MIX, strict=True):
        key ^= column * factor
        key = (key ^ (key >> np.uint64(29))) * MIX[0]
    order = np.argsort(key, kind="stable")
    ordered = bits[order]
    new = np.ones(len(key), dtype=bool)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    if (new[1:] & (np.diff(key[order]) == 0)).any():  # two kinds with the same key: only on purpose
        order = np.lexsort(bits.T)
        new[1:] = (bits[order][1:] != bits[order][:-1]).any(axis=1)
    first = order[new]  # a stable sort leaves equal ones in their order
    by_place = np.argsort(first)
    rank = np.empty_like(by_place)
    rank[by_place] = np.arange(len(by_place))
    number = np.empty(len(key), dtype=np.int64)
    number[order] = rank[np.cumsum(new) - 1]
    return first[by_place], number
