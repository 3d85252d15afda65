"""Every choice of places tried: the optimum itself, where there are not too many.

Choices are put together from two halves. With counts c_A and c_B of the cameras that see a point it is missed if
c_A = t and c_B <= T - 1 - t for some t < T, so T matrix products give the missed weight of all pairs of halves.
"""

import time

import numpy as np
from jaxtyping import Int

from placement.proof.grid_program import SINGLE_PRECISION, GridProgram, GridSolution

# Halves per block: blocks this large keep the matrix products fast and fit the cache of intermediate results.
BLOCK = 512
# Views that are looked at together where each choice is tried by itself.
VIEWS_PER_BLOCK = 1_000_000


def enumerate_all(program: GridProgram, end: float = np.inf) -> GridSolution | None:
    """Try every choice; None if the clock (`time.perf_counter`) passes `end`."""
    n_places = len(program.seen)
    total = float(program.weights.sum()) or 1.0
    scaled = (program.weights / total).astype(np.float32)
    first = _halves(program, (program.n_free + 1) // 2)
    second = _halves(program, program.n_free // 2)
    first = first[np.argsort(first[:, -1], kind="stable")] if first.shape[1] else first
    least, most = first.min(axis=1, initial=10 * n_places), first.max(axis=1, initial=-10 * n_places)
    start, stop = second.min(axis=1, initial=10 * n_places), second.max(axis=1, initial=-10 * n_places)

    points = [np.flatnonzero(program.site == site) for site in range(program.n_sites)]
    best, choice = -np.inf, None
    for j in range(0, len(second), BLOCK):
        later = second[j : j + BLOCK]
        later_count = program.seen[later].sum(axis=1)
        misses = [
            np.concatenate(
                [later_count[:, chosen] <= program.threshold - 1 - t for t in range(program.threshold)], axis=1
            ).astype(np.float32).T.copy()
            for chosen in points
        ]  # fmt: skip
        n_before = np.searchsorted(most, start[j : j + BLOCK].max() - program.window, side="right")
        for i in range(0, n_before, BLOCK):
            if time.perf_counter() > end:
                return None
            rows = slice(i, min(i + BLOCK, n_before))
            count = program.base + program.seen[first[rows]].sum(axis=1)
            worth = np.full((len(first[rows]), len(later)), np.inf, dtype=np.float32)
            for chosen, missed in zip(points, misses, strict=True):
                waiting = np.concatenate(
                    [np.where(count[:, chosen] == t, scaled[chosen], 0) for t in range(program.threshold)], axis=1
                )
                np.minimum(worth, scaled[chosen].sum() - waiting.astype(np.float32) @ missed, out=worth)
            ordered = most[rows, None] + program.window <= start[None, j : j + BLOCK]
            highest = np.maximum(most[rows, None], stop[None, j : j + BLOCK])
            ordered &= (highest + program.window <= least[rows, None] + n_places) | (program.n_free < 2)
            worth[~ordered] = -np.inf
            at = np.unravel_index(worth.argmax(), worth.shape)
            if worth[at] > best:
                best, choice = float(worth[at]), (*first[i + at[0]].tolist(), *later[at[1]].tolist())
    if choice is None:
        return GridSolution(None, 0.0, 0.0, "enumeration", True)
    value = program.value(choice)
    return GridSolution(choice, value, value + SINGLE_PRECISION * total, "enumeration", True)


def enumerate_spread(program: GridProgram, end: float = np.inf) -> GridSolution | None:
    """The same where cameras must lie apart, each choice and each pair of its cameras one by one."""
    n_places, total = len(program.seen), float(program.weights.sum()) or 1.0
    choices = _halves(program, program.n_free)
    if program.n_free > 1:
        choices = choices[choices[:, 0] + n_places - choices[:, -1] >= program.window]
    if len(choices) == 0:
        return GridSolution(None, 0.0, 0.0, "enumeration", True)
    block, worth = max(1, VIEWS_PER_BLOCK // max(program.seen.shape[1], 1)), np.zeros(len(choices))
    for first in range(0, len(choices), block):
        if time.perf_counter() > end:
            return None
        worth[first : first + block] = program.worths(choices[first : first + block])
    best = tuple(choices[int(worth.argmax())].tolist())
    value = program.value(best)
    return GridSolution(best, value, value + SINGLE_PRECISION * total, "enumeration", True)


def _halves(program: GridProgram, size: int) -> Int[np.ndarray, "H {size}"]:
    """(H, size) every increasing choice of `size` allowed places that keeps the window, the circle left open."""
    allowed = np.flatnonzero(program.allowed)
    chosen = np.zeros((1, 0), dtype=np.int64)
    for _ in range(size):
        last = chosen[:, -1] if chosen.shape[1] else np.full(1, -program.window)
        row, column = np.nonzero(allowed[None, :] >= last[:, None] + program.window)
        chosen = np.concatenate([chosen[row], allowed[column][:, None]], axis=1)
    return chosen
