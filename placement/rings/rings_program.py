"""The best choice of places on a grid of several rings, and an upper bound that holds for every choice.

Choose M of C places, of each ring as many as it takes and none too near another, so that the weight of the points seen
from at least T of them is greatest. By two ways:

- *enumeration* of all choices, put together from two halves as on one ring, where there are not too many;
- a *mixed-integer program*, max Σ w y, T y_p <= Σ x over the places that see p, for what is too many. When its time is
  over its dual bound holds.
"""

import itertools
import time
from dataclasses import dataclass
from functools import cached_property

import highspy
import numpy as np
import scipy.sparse as sparse
from jaxtyping import Bool, Float, Int

from placement.proof.enumeration import BLOCK, QUICK_MULTIPLICATIONS
from placement.proof.grid_program import SINGLE_PRECISION, GridSolution
from placement.proof.linear_program import LinearProgram

MILP = "mixed-integer program"
# Choices of half of the cameras beyond which they are not even counted.
MOST_HALVES = 100_000
# Choices that are looked at one by one, at most, because of what they promise, and how many at a time.
MOST_TRIED, ONE_BY_ONE = 50_000, 64


@dataclass(frozen=True, eq=False)
class RingsProgram:
    """Choose `n_free` of C places, beside fixed ones.

    Attributes
    ----------
    seen : (C, P) ndarray of bool
        Which points each place sees.
    weights : (P,) ndarray
        Of the points.
    site : (P,) ndarray of int
        Sum to which each point belongs; the least of the sums is maximised.
    n_sites : int
    n_free, threshold : int
        Places to choose, and how many cameras must see a point.
    ring : (C,) ndarray of int
        Ring of each place.
    most : (K,) ndarray of int
        Places of each ring that may be chosen.
    compatible : (C, C) ndarray of bool
        Which two places may be chosen together; on the diagonal, which may be chosen twice.
    fixed : (F, P) ndarray of bool
        Which points each fixed camera sees.
    far : (C + F, C + F) ndarray of bool or None
        Pairs of places, fixed ones last, of which one must see a point; None where any two will do. The bound knows of
        it that a view without any such partner is of no use, if the threshold is 2.
    """

    seen: Bool[np.ndarray, "C P"]
    weights: Float[np.ndarray, " P"]
    site: Int[np.ndarray, " P"]
    n_sites: int
    n_free: int
    threshold: int
    ring: Int[np.ndarray, " C"]
    most: Int[np.ndarray, " K"]
    compatible: Bool[np.ndarray, "C C"]
    fixed: Bool[np.ndarray, "F P"]
    far: Bool[np.ndarray, "A A"] | None = None

    @cached_property
    def _every(self) -> Bool[np.ndarray, "A P"]:
        return np.concatenate([self.seen, self.fixed])

    def worths(self, choices: Int[np.ndarray, "B N"]) -> Float[np.ndarray, " B"]:
        """(B,) weight of the points that each of (B, N) choices reconstructs; the least of the sums."""
        fixed = np.arange(len(self.seen), len(self._every))
        index = np.concatenate([choices, np.broadcast_to(fixed, (len(choices), len(fixed)))], axis=1).T
        seen = self._every[index]
        met = seen.sum(axis=0) >= self.threshold
        if self.far is not None:
            paired = np.zeros_like(met)
            for one, other in itertools.combinations(range(len(index)), 2):
                paired |= seen[one] & seen[other] & self.far[index[one], index[other]][:, None]
            met &= paired
        return np.stack([met @ (self.weights * (self.site == k)) for k in range(self.n_sites)]).min(axis=0)

    def value(self, places) -> float:
        """The same of one choice."""
        return float(self.worths(np.asarray(places, dtype=np.int64).reshape(1, -1))[0])

    def useful(self) -> tuple[Bool[np.ndarray, "C P"], Int[np.ndarray, " P"]]:
        """Views that can be of use, and (P,) how many of the fixed cameras' are."""
        if self.far is None or self.threshold != 2:
            return self.seen, self.fixed.sum(axis=0)
        every = self._every
        every = every & (self.far.astype(np.float32) @ every.astype(np.float32) > 0)
        return every[: len(self.seen)], every[len(self.seen) :].sum(axis=0)


def solve(program: RingsProgram, seconds: float, gap: float) -> GridSolution:
    """Best choice and upper bound within `seconds` [s], or to a relative `gap`.

    Examples
    --------
    >>> seen = np.array([[1, 1, 0], [1, 0, 0], [0, 1, 1], [0, 0, 1]], dtype=bool)
    >>> weights, alone, none = np.array([1.0, 2.0, 4.0]), ~np.eye(4, dtype=bool), np.zeros((0, 3), bool)
    >>> ring, most = np.array([0, 0, 1, 1]), np.array([2, 1])
    >>> program = RingsProgram(seen, weights, np.zeros(3, int), 1, 2, 2, ring, most, alone, none)
    >>> found = solve(program, seconds=10.0, gap=1e-3)  # ring 2 would have seen the third point twice
    >>> found.places, found.value
    ((0, 2), 2.0)
    """
    end = time.perf_counter() + seconds
    found = _enumerated(program, end)
    return found or _mixed_integer(program, max(end - time.perf_counter(), 1.0), gap)


def _halves(program: RingsProgram, size: int) -> Int[np.ndarray, "H {size}"] | None:
    """(H, size) every increasing choice of `size` places that go together; None if there are too many."""
    n_places, chosen = len(program.seen), np.zeros((1, 0), dtype=np.int64)
    for _ in range(size):
        if len(chosen) * n_places > MOST_HALVES * 100:
            return None
        last = chosen[:, -1] if chosen.shape[1] else np.full(1, -1)
        fits = _follows(program, last, np.arange(n_places))
        for column in chosen.T:
            fits &= program.compatible[column]
        row, place = np.nonzero(fits)
        chosen = np.concatenate([chosen[row], place[:, None]], axis=1)
        chosen = chosen[(_numbers(program, chosen) <= program.most).all(axis=1)]
    return chosen if len(chosen) <= MOST_HALVES else None


def _follows(program: RingsProgram, last: np.ndarray, begin: np.ndarray) -> Bool[np.ndarray, "H B"]:
    """(H, B) whether each choice comes once if one half ends and the other begins so."""
    return (last[:, None] < begin) | ((last[:, None] == begin) & np.diag(program.compatible)[begin])


def _numbers(program: RingsProgram, chosen: np.ndarray) -> Int[np.ndarray, "H K"]:
    """(H, K) how many places of each ring are chosen."""
    return (program.ring[chosen][..., None] == np.arange(len(program.most))).sum(axis=1)


def _enumerated(program: RingsProgram, end: float) -> GridSolution | None:
    """Every choice tried; None if there are too many, or the time is over."""
    if program.n_free == 0:
        value = program.value(())
        return GridSolution((), value, value, "enumeration", True)
    first = _halves(program, (program.n_free + 1) // 2)
    second = None if first is None else _halves(program, program.n_free // 2)
    if first is None or second is None:
        return None
    seen, base = program.useful()
    work = 2.0 * len(first) * len(second) * seen.shape[1] * program.threshold
    if work > QUICK_MULTIPLICATIONS:
        return None
    total = float(program.weights.sum()) or 1.0
    scaled = (program.weights / total).astype(np.float32)
    numbers = [_numbers(program, half) for half in (first, second)]
    clash = (~program.compatible).astype(np.float32)
    bound, best, choice, n_tried = -np.inf, -np.inf, None, 0
    for j, i in itertools.product(range(0, len(second), BLOCK), range(0, len(first), BLOCK)):
        if time.perf_counter() > end:
            return None
        one, two = first[i : i + BLOCK], second[j : j + BLOCK]
        counts = [base + seen[one].sum(axis=1), seen[two].sum(axis=1)]
        worth = np.full((len(one), len(two)), np.inf, dtype=np.float32)
        for site in range(program.n_sites):
            of_site = np.flatnonzero(program.site == site)
            missed = np.zeros_like(worth)
            for t in range(program.threshold):
                waiting = np.where(counts[0][:, of_site] == t, scaled[of_site], np.float32(0))
                short = counts[1][:, of_site] <= program.threshold - 1 - t
                missed += waiting @ short.T.astype(np.float32)
            np.minimum(worth, scaled[of_site].sum() - missed, out=worth)
        last = one[:, -1] if one.shape[1] else np.full(len(one), -1)
        start = two[:, 0] if two.shape[1] else np.full(len(two), len(program.seen))
        allowed = _follows(program, last, np.minimum(start, len(program.seen) - 1)) | (start == len(program.seen))
        allowed &= (numbers[0][i : i + BLOCK, None] + numbers[1][None, j : j + BLOCK] <= program.most).all(axis=2)
        for place in two.T:
            allowed &= clash[one][:, :, place].sum(axis=1) == 0
        worth[~allowed] = -np.inf
        # What is summed is the choice itself, but for rounding; with a baseline it may promise more than there is.
        promising = np.flatnonzero(worth > best / total + SINGLE_PRECISION)
        promising = promising[np.argsort(-worth.ravel()[promising], kind="stable")]
        for begin in range(0, len(promising), ONE_BY_ONE):
            promised = float(worth.ravel()[promising[begin]])
            if promised <= best / total + SINGLE_PRECISION:
                break
            if n_tried >= MOST_TRIED:
                bound = max(bound, promised)
                break
            row, column = np.divmod(promising[begin : begin + ONE_BY_ONE], len(two))
            choices, n_tried = np.concatenate([one[row], two[column]], axis=1), n_tried + len(row)
            values = program.worths(choices)
            if values.max() > best:
                best, choice = float(values.max()), tuple(choices[int(values.argmax())].tolist())
    if choice is None:
        return GridSolution(None, 0.0, 0.0, "enumeration", True)
    # Once for what a choice promises, once for what is too near the best to be looked at.
    bound = max(bound * total, best) + 2 * SINGLE_PRECISION * total
    return GridSolution(choice, best, bound, "enumeration", True)


def _mixed_integer(program: RingsProgram, seconds: float, gap: float) -> GridSolution:
    """The program as HiGHS solves it: x (C), y (P), whole as a view too few is worth nothing, and the least sum."""
    seen, base = program.useful()
    n_places, n_points, n_sums = *seen.shape, program.n_sites
    total = float(program.weights.sum()) or 1.0
    weights = sparse.csr_array((program.weights / total, (program.site, np.arange(n_points))), (n_sums, n_points))
    of_ring = (program.ring == np.arange(len(program.most))[:, None]).astype(float)
    one, two = np.nonzero(np.triu(~program.compatible, 1))
    clash = sparse.csr_array(
        (np.ones(2 * len(one)), (np.tile(np.arange(len(one)), 2), np.concatenate([one, two]))), (len(one), n_places)
    )
    rows = sparse.block_array([
        [-seen.T.astype(float), program.threshold * sparse.eye_array(n_points), None],
        [None, -weights, np.ones((n_sums, 1))],
        [sparse.csr_array(of_ring), None, None],
        [np.ones((1, n_places)), None, None],
        [clash, None, None],
    ])  # fmt: skip
    high = np.concatenate([base, np.zeros(n_sums), program.most, [program.n_free], np.ones(len(one))])
    low = np.full(len(high), -np.inf)
    low[n_points + n_sums + len(program.most)] = program.n_free
    most = np.where(np.diag(program.compatible), max(program.n_free, 1), 1)
    solver = LinearProgram(mip_rel_gap=gap)
    solver.columns(np.zeros(n_places), np.zeros(n_places), most, whole=True)
    solver.columns(np.zeros(n_points), np.zeros(n_points), np.ones(n_points), whole=True)
    solver.columns([-1.0], [0.0], [1.0])
    solver.rows(rows, low, high)
    status, info = solver.solve_within(seconds), solver.getInfo()
    if status == highspy.HighsModelStatus.kInfeasible:
        return GridSolution(None, 0.0, 0.0, MILP, True)
    bound = min(1.0, -info.mip_dual_bound) * total + SINGLE_PRECISION * total
    if info.primal_solution_status != highspy.SolutionStatus.kSolutionStatusFeasible:
        return GridSolution(None, 0.0, bound, MILP, False)
    chosen = np.array(solver.getSolution().col_value[:n_places])
    places = tuple(np.repeat(np.arange(n_places), np.round(chosen).astype(int)).tolist())
    finished = status == highspy.HighsModelStatus.kOptimal
    return GridSolution(places, program.value(places), bound, MILP, finished)
