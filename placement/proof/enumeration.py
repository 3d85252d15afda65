"""Every choice of places tried: the optimum itself, where there are not too many.

Choices are put together from two halves. With counts c_A and c_B of the cameras that see a point it is missed if
c_A = t and c_B <= T - 1 - t for some t < T, so T matrix products give the missed weight of all pairs of halves.
"""

import math
import time
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Float32, Int

from placement.proof.grid_program import SINGLE_PRECISION, GridProgram, GridSolution

# Halves per block: blocks this large keep the matrix products fast and fit the cache of intermediate results.
BLOCK = 512
# Views that are looked at together where each choice is tried by itself.
VIEWS_PER_BLOCK = 1_000_000

# Multiplications up to which enumeration is taken, within seconds.
QUICK_MULTIPLICATIONS = 2e11
# Pairs of cameras at a point that are looked at one by one, within seconds too.
QUICK_PAIRS = 1e9


def is_quick(program: GridProgram, multiplications: float = QUICK_MULTIPLICATIONS) -> bool:
    """Whether enumeration takes seconds, or so many multiplications.

    It multiplies for each choice, point and count below the threshold; where cameras must lie apart it looks at each
    choice, point and pair of cameras.
    """
    n, free = program.n_free, int(program.allowed.sum()) - max(program.window - 1, -1) * (program.n_free - 1)
    choices = np.prod([max(free - i, 0) / (i + 1) for i in range(n)]) if n else 1.0
    work = float(choices) * len(program.weights)
    if program.is_spread:
        return work * max(1, math.comb(n + len(program.fixed), 2)) <= QUICK_PAIRS
    return 2 * work * program.threshold <= multiplications  # twice: blocks hold choices in vain


def enumerate_all(program: GridProgram, end: float = np.inf) -> GridSolution | None:
    """Try every choice; None if the clock (`time.perf_counter`) passes `end`."""
    total = float(program.weights.sum()) or 1.0
    best, choice = -np.inf, None
    try:
        for first, later, worth in _blocks(program, end):
            at = np.unravel_index(worth.argmax(), worth.shape)
            if worth[at] > best:
                best, choice = float(worth[at]), (*first[at[0]].tolist(), *later[at[1]].tolist())
    except TimeoutError:
        return None
    if choice is None:
        return GridSolution(None, 0.0, 0.0, "enumeration", True)
    value = program.value(choice)
    return GridSolution(choice, value, value + SINGLE_PRECISION * total, "enumeration", True)


class Leading(NamedTuple):
    """The best of all choices, their worths, rounded up, and what none of the others is worth more than."""

    choices: Int[np.ndarray, "C n"]
    worths: Float[np.ndarray, " C"]
    others: float


def leading(program: GridProgram, most: int, least: float, end: float = np.inf) -> Leading | None:
    """The `most` best choices worth more than `least`; None if the clock (`time.perf_counter`) passes `end`."""
    total = float(program.weights.sum()) or 1.0
    found = [(np.zeros((0, program.n_free), dtype=np.int32), np.zeros(0))]
    others = least
    try:
        for first, later, worth in _blocks(program, end):
            row, column = np.nonzero(worth > others / total - SINGLE_PRECISION)
            worths = total * (worth[row, column].astype(np.float64) + SINGLE_PRECISION)
            found.append((np.concatenate([first[row], later[column]], axis=1).astype(np.int32), worths))
            if sum(len(some) for _, some in found) > 2 * most:
                found, others = _best_of(found, most, others)
    except TimeoutError:
        return None
    ((choices, worths),), others = _best_of(found, most, others)
    return Leading(choices, worths, others)


def _best_of(
    found: list[tuple[Int[np.ndarray, "_ n"], Float[np.ndarray, " _"]]], most: int, others: float
) -> tuple[list[tuple[Int[np.ndarray, "_ n"], Float[np.ndarray, " _"]]], float]:
    """The `most` best of several sets of choices and their worths, as one; and the greatest worth of the `others`."""
    choices, worths = (np.concatenate(parts) for parts in zip(*found, strict=True))
    order = np.argsort(-worths, kind="stable")
    if len(order) > most:
        others = max(others, float(worths[order[most]]))
    return [(choices[order[:most]], worths[order[:most]])], others


def _blocks(
    program: GridProgram, end: float
) -> Iterator[tuple[Int[np.ndarray, "A h"], Int[np.ndarray, "B k"], Float32[np.ndarray, "A B"]]]:
    """Every first half (A, h) with every second one (B, k), block by block, and what each pair is worth.

    Of a total of 1; -inf where cameras may not be together.

    Raises
    ------
    TimeoutError
        When the clock (`time.perf_counter`) has passed `end`.
    """
    n_places = len(program.seen)
    total = float(program.weights.sum()) or 1.0
    scaled = (program.weights / total).astype(np.float32)
    first = _halves(program, (program.n_free + 1) // 2)
    second = _halves(program, program.n_free // 2)
    first = first[np.argsort(first[:, -1], kind="stable")] if first.shape[1] else first
    least, most = first.min(axis=1, initial=10 * n_places), first.max(axis=1, initial=-10 * n_places)
    start, stop = second.min(axis=1, initial=10 * n_places), second.max(axis=1, initial=-10 * n_places)

    points = [np.flatnonzero(program.site == site) for site in range(program.n_sites)]
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
                raise TimeoutError
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
            yield first[rows], later, worth


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
