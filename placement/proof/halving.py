"""Choices of groups of places, of which the best is divided, again and again, until it is one of single places.

A group sees what any of its places sees, so a choice of groups is worth at least as much as any choice of places in
them. All choices of large groups are tried. Then always those worth the most are divided: the camera in the largest
group gets either half of it. No choice of places is worth more than the best that is left.
"""

import time
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int, UInt64

from placement.proof.enumeration import is_quick, leading
from placement.proof.grid_program import GridProgram, GridSolution

METHOD = "enumeration in groups"
# Multiplications that the first groups may take.
FIRST_MULTIPLICATIONS = 5e10
# Choices that wait, at most: of more, the others are set aside. They are kept in so many classes, by what they are
# worth, and so many are divided at a time.
MOST_WAITING, N_CLASSES, MOST_DIVIDED = 2_000_000, 256, 65_536
# Choices whose worths are found together.
BLOCK = 1024
# Points whose weights are whole multiples of the least one, to this part of it, are counted; others are rounded up to
# multiples of this part of the mean weight.
WHOLE, ROUNDING = 1e-6, 1e-4
WORD = 64


def halved(program: GridProgram, known: tuple[int, ...] | None, least: float, end: float) -> GridSolution | None:
    """Best choice, and a bound that no choice worth more than `least` exceeds.

    Parameters
    ----------
    program : GridProgram
        Any two of its cameras make a point count: `is_spread` is false.
    known : tuple of int or None
        A choice that is allowed.
    least : float
        What is worth no more is of no concern.
    end : float
        When time runs out, by `time.perf_counter` [s]; the bound holds all the same.

    Returns
    -------
    GridSolution or None
        `finished` if no choice is worth more than that found, or `least`. None if even choices of the largest groups
        are too many to be tried.

    Examples
    --------
    >>> seen = np.arange(16)[:, None] // 4 == np.arange(4)  # four arcs of four places, each of another worth
    >>> nothing = np.zeros(4)
    >>> program = GridProgram(seen, np.arange(1.0, 5.0), 2, 1, 1, np.ones(16, bool), nothing.astype(int), nothing,
    ...                       np.zeros((0, 4), bool), np.zeros(0))
    >>> found = halved(program, None, 0.0, np.inf)
    >>> round(found.value, 3), round(found.bound, 3), found.finished
    (7.0, 7.0, True)
    """
    first = program.merged()
    levels = [first]
    while len(first.seen) % 2 == 0 and not is_quick(first, FIRST_MULTIPLICATIONS):
        levels.append(_in_pairs(levels[-1]))
        first = levels[-1].merged()
    best, places = (least, None) if known is None else (max(least, program.value(known)), known)
    found = leading(first, MOST_WAITING, best, end) if is_quick(first) else None
    if found is None:
        return None
    tree, (choices, worths, others) = _Tree.of(levels), found
    waiting = _Waiting(worths)
    while True:
        # Choices of single places are done with; what is not worth more than the best of them is of no concern.
        single = tree.single(choices)
        if len(done := np.flatnonzero(single & (worths > best))):
            leader = done[worths[done].argmax()]
            best, places = float(worths[leader]), tuple(tree.first[choices[leader]].tolist())
        more = ~single & (worths > best)
        others = max(others, waiting.add(choices[more], worths[more]))
        highest = waiting.highest
        if highest <= max(best, others) or time.perf_counter() > end:
            break
        choices, worths = waiting.leading()
        choices, worths = tree.divided(choices[worths > best])
    value = 0.0 if places is None else program.value(places)
    finished = max(highest, others) <= best or max(highest, others, best) == -np.inf
    return GridSolution(places, value, max(highest, others, best, value), METHOD, finished)


class _Waiting:
    """Choices that wait to be divided, those worth about as much together."""

    def __init__(self, worths: Float[np.ndarray, " C"]):
        self._low = float(worths.min(initial=np.inf))
        self._step = max(float(worths.max(initial=-np.inf)) - self._low, 0.0) / N_CLASSES or 1.0
        self._classes: list[list[tuple[np.ndarray, np.ndarray]]] = [[] for _ in range(N_CLASSES)]
        self._size = 0

    def add(self, choices: Int[np.ndarray, "C n"], worths: Float[np.ndarray, " C"]) -> float:
        """Let more wait; the greatest worth of those that are set aside for it, -inf if there are none."""
        if not len(worths):
            return -np.inf
        number = np.clip((worths - self._low) / self._step, 0, N_CLASSES - 1).astype(int)
        order = np.argsort(number, kind="stable")
        begins = np.searchsorted(number[order], np.arange(N_CLASSES + 1))
        for one, begin, end in zip(self._classes, begins[:-1], begins[1:], strict=True):
            if begin < end:
                one.append((choices[order[begin:end]], worths[order[begin:end]]))
        self._size += len(worths)
        aside = -np.inf
        for one in self._classes:
            if self._size <= MOST_WAITING:
                break
            aside = max([aside, *(float(worths.max()) for _, worths in one)])
            self._size -= sum(len(worths) for _, worths in one)
            one.clear()
        return aside

    @property
    def highest(self) -> float:
        """The greatest worth of all that wait, -inf if nothing does."""
        first = next((one for one in reversed(self._classes) if one), [])
        return max((float(worths.max()) for _, worths in first), default=-np.inf)

    def leading(self) -> tuple[Int[np.ndarray, "C n"], Float[np.ndarray, " C"]]:
        """Some of those worth the most, which no longer wait."""
        first = next(one for one in reversed(self._classes) if one)
        choices, worths = (np.concatenate(parts) for parts in zip(*first, strict=True))
        first[:] = [(choices[MOST_DIVIDED:], worths[MOST_DIVIDED:])] if len(worths) > MOST_DIVIDED else []
        self._size -= min(len(worths), MOST_DIVIDED)
        return choices[:MOST_DIVIDED], worths[:MOST_DIVIDED]


def _in_pairs(program: GridProgram) -> GridProgram:
    """The choice of pairs of neighbouring places: 2 k and 2 k + 1 are in pair k."""
    window = -(-(program.window - 1) // 2)
    return replace(
        program, seen=program.seen[::2] | program.seen[1::2], allowed=program.allowed[::2] | program.allowed[1::2],
        window=max(window, 0), fixed_at=program.fixed_at / 2,
    )  # fmt: skip


class _Tree(NamedTuple):
    """Groups of places, the largest first: the halves of group r are 2 r + `n_first` and the one after that."""

    n_first: int
    first: Int[np.ndarray, " R"]
    """First place of each group."""
    size: Int[np.ndarray, " R"]
    allowed: Bool[np.ndarray, " R"]
    seen: UInt64[np.ndarray, "R W"]
    """Points, 64 at a time."""
    enough: UInt64[np.ndarray, "T W"]
    """Points that 1, 2, .. cameras see whatever is chosen."""
    weights: Float[np.ndarray, "W S"]
    window: int

    @classmethod
    def of(cls, levels: list[GridProgram]) -> "_Tree":
        """Places, pairs of them, pairs of pairs, .."""
        program, levels = levels[0], levels[::-1]
        sizes = [len(program.seen) // len(level.seen) for level in levels]
        points, weights = _words(program)

        def packed(views: Bool[np.ndarray, "R P"]) -> UInt64[np.ndarray, "R W"]:
            padded = np.pad(views, ((0, 0), (0, 1)))[:, points]
            return np.ascontiguousarray(np.packbits(padded, axis=1)).view(np.uint64)

        return cls(
            len(levels[0].seen),
            np.concatenate([size * np.arange(len(level.seen)) for size, level in zip(sizes, levels, strict=True)]),
            np.repeat(sizes, [len(level.seen) for level in levels]),
            np.concatenate([level.allowed for level in levels]),
            np.concatenate([packed(level.seen) for level in levels]),
            packed(program.base >= np.arange(1, program.threshold + 1)[:, None]),
            weights,
            program.window,
        )

    def single(self, groups: Int[np.ndarray, "C n"]) -> Bool[np.ndarray, " C"]:
        """Choices of which every group is one place."""
        return (self.size[groups] == 1).all(axis=1)

    def divided(self, groups: Int[np.ndarray, "C n"]) -> tuple[Int[np.ndarray, "D n"], Float[np.ndarray, " D"]]:
        """Choices with either half of their largest group, as far as they are allowed, and their worths."""
        found = [self._divided(groups[first : first + BLOCK]) for first in range(0, len(groups), BLOCK)]
        parts, worths = zip((groups[:0], np.zeros(0)), *found, strict=True)
        return np.concatenate(parts), np.concatenate(worths)

    def _divided(self, groups: Int[np.ndarray, "C n"]) -> tuple[Int[np.ndarray, "D n"], Float[np.ndarray, " D"]]:
        row, n_places = np.arange(len(groups)), self.first[-1] + 1
        largest = self.size[groups].argmax(axis=1)
        others = groups[np.arange(groups.shape[1]) != largest[:, None]].reshape(len(groups), -1)
        enough = [np.repeat(some[None], len(groups), axis=0) for some in self.enough]
        for column in others.T:
            views = self.seen[column]
            for k in range(len(enough) - 1, 0, -1):
                enough[k] |= enough[k - 1] & views
            enough[0] |= views
        parts, worths = [], []
        for half in (0, 1):
            part = groups.copy()
            part[row, largest] = chosen = 2 * groups[row, largest] + self.n_first + half
            views = self.seen[chosen]
            met = enough[-1] | (enough[-2] & views if len(enough) > 1 else views)
            worth = (np.bitwise_count(met).astype(np.float64) @ self.weights).min(axis=1)
            begin = self.first[part]
            gap = np.concatenate([begin[:, 1:], begin[:, :1] + n_places], axis=1) - begin
            gap += np.roll(self.size[part], -1, axis=1) - 1  # the farthest that two cameras may be apart
            may = self.allowed[chosen] & ((gap >= self.window).all(axis=1) | (groups.shape[1] == 1))
            parts.append(part[may])
            worths.append(worth[may])
        return np.concatenate(parts), np.concatenate(worths)


def _words(program: GridProgram) -> tuple[Int[np.ndarray, " B"], Float[np.ndarray, "W S"]]:
    """Points in an order in which words of 64 count alike, the number of points for none; what each word counts."""
    unit = float(program.weights.min(initial=np.inf))
    times = np.round(program.weights / unit)
    if (np.abs(program.weights - times * unit) > WHOLE * program.weights).any():
        unit = ROUNDING * float(program.weights.mean())
        times = np.ceil(program.weights / unit)
    times, order, weights = times.astype(np.int64), [np.zeros(0, dtype=np.int64)], [np.zeros((0, program.n_sites))]
    # A point that counts 5 times stands among those that count once and among those that count four times.
    for site in range(program.n_sites):
        for digit in range(int(times.max(initial=0)).bit_length()):
            chosen = np.flatnonzero((program.site == site) & (times >> digit & 1 > 0))
            n_words = -(-len(chosen) // WORD)
            order.append(np.pad(chosen, (0, n_words * WORD - len(chosen)), constant_values=len(times)))
            weights.append(np.zeros((n_words, program.n_sites)))
            weights[-1][:, site] = unit * (1 + WHOLE) * 2.0**digit
    return np.concatenate(order), np.concatenate(weights)
