"""The grid program by branch and bound, on linear programs that HiGHS solves one after another.

Points see arcs of places, so with cumulative counts X_k = x_0 + ... + x_k the number of cameras that see a point is a
sum of few differences of X, which keeps the programs sparse: T y_p <= sum over arcs [a, b] of X_b - X_(a-1).

Cameras that must lie far apart do not all sit in one window of neighbouring places: y_p <= the views outside it, for
every window in which no two places are far enough apart. Nor do more than j cameras sit in j windows that exclude each
other, so (T - j) y_p <= the views outside those. Only the rows that a solution breaks are taken: a program that lacks
some bounds the same from above.

A ring looks much the same from everywhere, so the solution with parts of cameras is smeared all around it, and to
settle single places changes little. What tells layouts apart is first where their widest gap ends: n cameras leave one
of at least K / n places, and behind it sits a camera. Nodes hold the sector that it sits in, halved until it is one
place; then cameras are counted in the sectors that follow.
"""

import heapq
import itertools
import time
from dataclasses import dataclass

import highspy
import numpy as np
import scipy.sparse as sparse
from jaxtyping import Bool, Float, Int

from placement.proof.grid_program import SINGLE_PRECISION, GridProgram, GridSolution, in_windows
from placement.proof.linear_program import LinearProgram

METHOD = "branch and bound"
# How much of a total of 1 rows must be broken by for the rest not to matter, and the share of it that is mended in a
# round.
LEAST_VIOLATION = 1e-4
MOST_OF = 0.9
# Rounds of rows at the root and at any other node, and what one must win, of a total of 1, to be followed by another.
ROOT_ROUNDS, NODE_ROUNDS = 20, 4
LEAST_GAIN = 1e-4
# Rows are dropped that solutions do not rest on when there are this many times as many as after the last time.
GROWTH = 2
# Counts of cameras closer than this to a whole number are whole.
WHOLE = 1e-6

# Places from a first to a last one, around the circle, and how many cameras they hold, from and to.
Counts = dict[tuple[int, int], tuple[float, float]]


def branch_and_bound(
    program: GridProgram, seconds: float, gap: float, nodes: int | None = None, known: tuple[int, ...] | None = None
) -> GridSolution:
    """Solve within `seconds` [s] and `nodes` to a relative `gap`; the bound holds in any case."""
    end = time.perf_counter() + seconds
    if program.n_free == 0:
        value = program.value(())
        return GridSolution((), value, value, METHOD, True)
    best, choice = (-np.inf, None) if known is None else (program.value(known), tuple(known))
    relaxed, unsolved = _Relaxed(program), 0.0
    number = itertools.count()  # of two nodes with the same bound the older comes first
    first = relaxed.solved(_Node(relaxed.most, {}), ROOT_ROUNDS, end)
    waiting = [] if first is None else [(-first.bound, next(number), first)]
    while waiting and -waiting[0][0] > best * (1 + gap):
        if time.perf_counter() > end or (nodes is not None and relaxed.n_solved > nodes):
            break
        node = heapq.heappop(waiting)[2]
        places, halves = node.places(program), _halves(program, node)
        if places is not None:
            value = program.value(places)
            best, choice = (value, places) if value > best else (best, choice)
        elif not halves:  # one layout that the solver failed on
            unsolved = max(unsolved, node.bound)
        for counts in halves:
            child = relaxed.solved(_Node(node.bound, counts), NODE_ROUNDS, end)
            if child is not None and child.bound > best:
                heapq.heappush(waiting, (-child.bound, next(number), child))
    bound = max(-waiting[0][0] if waiting else 0.0, best, unsolved)
    finished = bound <= best * (1 + gap) or (choice is None and not waiting and unsolved == 0)
    if choice is None:
        return GridSolution(None, 0.0, 0.0 if finished else bound, METHOD, finished)
    return GridSolution(choice, best, bound, METHOD, finished)


@dataclass(frozen=True, eq=False)
class _Node:
    """Layouts with so many cameras in these sectors, none of which is worth more than `bound`."""

    bound: float
    counts: Counts
    cameras: Float[np.ndarray, " K"] | None = None  # how much of a camera at each place; None if time ran out

    def places(self, program: GridProgram) -> tuple[int, ...] | None:
        """The layout, if cameras are whole and sit where they may."""
        if self.cameras is None or (np.abs(self.cameras - np.round(self.cameras)) > WHOLE).any():
            return None
        return tuple(np.repeat(np.arange(len(program.seen)), np.round(self.cameras).astype(int)).tolist())


def _halves(program: GridProgram, node: _Node) -> list[Counts]:
    """Counts that divide the layouts of a node; none if it holds only one layout."""
    n_places, n_free, counts = len(program.seen), program.n_free, node.counts
    if not counts:
        length = -(-n_places // (2 * n_free))
        return [_gap_ends(program, at, min(length, n_places - at)) for at in range(0, n_places, length)]
    (first, last), _ = next(iter(counts.items()))  # where the widest gap ends
    length = (last - first) % n_places + 1
    if length > 1:
        half = length // 2
        return [_gap_ends(program, first, half), _gap_ends(program, first + half, length - half)]
    if node.cameras is None:
        fixed = [sector for sector, (low, high) in counts.items() if low == high]
        return _split(counts, next(((k, k) for k in range(n_places) if (k, k) not in fixed), None), 0.0)
    after = np.roll(node.cameras, -first - 1).cumsum()
    parts = np.abs(after - np.round(after))
    if parts.max() > WHOLE:
        at = int(np.abs(after - np.floor(after) - 0.5).argmin())
        return _split(counts, ((first + 1) % n_places, (first + 1 + at) % n_places), float(np.floor(after[at]) + 0.5))
    # All cameras are whole, yet points are covered in part: settle them one by one.
    for k in np.flatnonzero(np.round(node.cameras) > 0).tolist():
        here = float(np.round(node.cameras[k]))
        low, high = counts.get((k, k), (0.0, float(n_free)))
        if low < here:
            return _split(counts, (k, k), here - 0.5)
        if high > here:
            return _split(counts, (k, k), here + 0.5)
    return []


def _split(counts: Counts, sector: tuple[int, int] | None, between: float) -> list[Counts]:
    """Fewer than `between` cameras in the sector, or more."""
    if sector is None:
        return []
    low, high = counts.get(sector, (0.0, np.inf))
    fewer, more = float(np.floor(between)), float(np.floor(between) + 1)
    return [
        counts | {sector: (max(low, lowest), min(high, highest))}
        for lowest, highest in ((0.0, fewer), (more, np.inf))
        if max(low, lowest) <= min(high, highest)
    ]


def _gap_ends(program: GridProgram, first: int, length: int) -> Counts:
    """A camera sits in the sector, and the widest gap before it: no other in the places that are in every such gap."""
    n_places, n_free = len(program.seen), program.n_free
    first = first % n_places
    last = first + length - 1
    counts: Counts = {(first, last % n_places): (1.0, np.inf)}
    # The one before is at most at last - K / n; of cells, it may sit at the beginning of its own, the other at the end.
    begin = int(np.floor(last + program.slack - n_places / n_free + WHOLE)) + 1
    if n_free > 1 and begin < first:
        counts[begin % n_places, (first - 1) % n_places] = (0.0, 0.0)
    return counts


class _Relaxed:
    """The program with parts of cameras, and with the rows that solutions have broken so far."""

    def __init__(self, program: GridProgram):
        self.program = program
        self.n_solved = 0
        n_places, n_points = program.seen.shape
        n_free = program.n_free
        self.total = float(program.weights.sum()) or 1.0
        self.most = float(program.sums(np.ones(n_points, dtype=bool)).min())
        self._families = _families(program)
        self._sectors: dict[tuple[int, int], int] = {}
        # Few changes from one program to the next: the dual simplex goes on from the last, which presolve would undo.
        self._solver = LinearProgram(presolve="off", solver="simplex")
        lowest = np.zeros(n_places)
        lowest[-1] = n_free
        self._solver.columns(np.zeros(n_places), lowest, np.full(n_places, float(n_free)))
        one_sum = program.n_sites == 1
        worth = program.weights / self.total
        self._solver.columns(-worth if one_sum else 0 * worth, np.zeros(n_points), np.ones(n_points))
        if not one_sum:  # the last variable is at most each of the sums, and is maximised: the least of them
            self._solver.columns(-np.ones(1), np.zeros(1), np.ones(1))
            of_site = sparse.csr_matrix((worth, (program.site, np.arange(n_points))), (program.n_sites, n_points))
            none, least = sparse.csr_matrix((program.n_sites, n_places)), np.ones((program.n_sites, 1))
            self._solver.rows(sparse.hstack([none, -of_site, least]), -np.inf, 0.0)
        shift = sparse.identity(n_places) - sparse.eye(n_places, k=-1)
        self._solver.rows(shift, 0.0, np.where(program.allowed, n_free if program.window == 0 else 1, 0))
        if program.window > 1 and n_free > 1:
            masks = np.mod(np.arange(n_places)[:, None] - np.arange(n_places), n_places) < program.window
            cumulative, constant = _cumulative(masks, n_free)
            self._solver.rows(cumulative, -np.inf, 1 - constant)
        self._n_always = self._solver.getNumRow()
        self._most_rows = self._n_always

    def solved(self, node: _Node, rounds: int, end: float) -> _Node | None:
        """The node with its solution and a bound that is at most as high; None if it holds no layout."""
        self.n_solved += 1
        if self._solver.getNumRow() > self._most_rows:
            self._drop_slack()
        self._count(node.counts)
        n_places = len(self.program.seen)
        bound, cameras = node.bound, None
        for _ in range(rounds):
            left = end - time.perf_counter()
            if left <= 0:
                break
            status = self._solver.solve_within(left)
            if status == highspy.HighsModelStatus.kInfeasible:
                return None
            if status != highspy.HighsModelStatus.kOptimal:
                break
            found = (SINGLE_PRECISION - self._solver.getInfo().objective_function_value) * self.total
            gained, bound = bound - found, min(bound, found)
            solution = np.array(self._solver.getSolution().col_value)
            cameras = np.diff(solution[:n_places], prepend=0)
            if not self._take_broken(cameras, solution[n_places:]) or 0 <= gained < LEAST_GAIN * self.total:
                break
        return _Node(bound, node.counts, cameras)

    def _take_broken(self, cameras: Float[np.ndarray, " K"], covered: Float[np.ndarray, " V"]) -> bool:
        """Take rows that the solution breaks, of each point the worst of each family; False if there are none."""
        program = self.program
        n_places, n_points = program.seen.shape
        covered = covered[:n_points]
        views = program.seen * cameras[:, None]
        seen = views.sum(axis=0)
        worth = program.weights / self.total
        short = worth * (program.threshold * covered - program.base - seen) / program.threshold
        point = _most_of(short)
        self._enough(program.seen[:, point], point, program.threshold, program.base[point])
        taken = len(point)
        for family in self._families:
            # What a window holds of all cameras it holds of those that see a point, at most.
            widest = family.width.max(initial=0, keepdims=True)
            most_inside = in_windows(cameras[:, None], widest).max()
            chosen = np.flatnonzero(family.times * covered - seen + most_inside > LEAST_VIOLATION)
            outside = seen[chosen] - in_windows(views[:, chosen], family.width[chosen])
            broken = family.times * covered[chosen] - family.base[:, chosen] - outside
            broken = np.where(family.open[:, chosen], broken, -np.inf)
            most = _most_of(worth[chosen] * broken.max(axis=0, initial=-np.inf) / family.times)
            point, begin = chosen[most], broken[:, most].argmax(axis=0)
            inside = np.mod(np.arange(n_places)[:, None] - begin, n_places) < family.width[point]
            self._enough(program.seen[:, point] & ~inside, point, family.times, family.base[begin, point])
            taken += len(point)
        return taken > 0

    def _enough(
        self, views: Bool[np.ndarray, "K R"], point: Int[np.ndarray, " R"], times: int, base: Int[np.ndarray, " R"]
    ) -> None:
        """Times * y <= base + cameras among the (K, R) `views`, for R points."""
        cumulative, constant = _cumulative(views, self.program.n_free)
        shape = (len(point), self._solver.getNumCol() - len(views))
        covered = sparse.csr_matrix((np.full(len(point), float(times)), (np.arange(len(point)), point)), shape)
        self._solver.rows(sparse.hstack([-cumulative, covered]), -np.inf, base + constant)

    def _count(self, counts: Counts) -> None:
        """Ask for so many cameras in these sectors, and for nothing in any other."""
        n_places, n_free = len(self.program.seen), self.program.n_free
        for row in self._sectors.values():
            self._solver.changeRowBounds(row, -highspy.kHighsInf, highspy.kHighsInf)
        for (first, last), (low, high) in counts.items():
            inside = np.mod(np.arange(n_places) - first, n_places) <= (last - first) % n_places
            cumulative, constant = _cumulative(inside[:, None], n_free)
            low, high = low - constant[0], min(high, n_free) - constant[0]
            row = self._sectors.get((first, last))
            if row is None:
                self._sectors[first, last] = self._solver.getNumRow()
                self._solver.rows(cumulative, low, high)
            else:
                self._solver.changeRowBounds(row, low, high)

    def _drop_slack(self) -> None:
        """Drop what the last solution did not rest on; it is taken again where another breaks it."""
        basic = highspy.HighsBasisStatus.kBasic
        slack = np.array([status == basic for status in self._solver.getBasis().row_status])
        slack[: self._n_always] = False
        gone = np.flatnonzero(slack).astype(np.int32)
        self._solver.deleteRows(len(gone), gone)
        place = np.cumsum(~slack) - 1
        self._sectors = {sector: int(place[row]) for sector, row in self._sectors.items() if not slack[row]}
        self._most_rows = GROWTH * self._solver.getNumRow()


def _most_of(broken: Float[np.ndarray, " P"]) -> Int[np.ndarray, " R"]:
    """The rows that account for most of what is broken: the many small ones would cost more than they win."""
    order = np.argsort(-broken, kind="stable")
    order = order[broken[order] * len(broken) > LEAST_VIOLATION]
    until = np.cumsum(broken[order])
    return np.sort(order[: int(np.searchsorted(until, MOST_OF * until[-1])) + 1]) if len(order) else order


@dataclass(frozen=True, eq=False)
class _Family:
    """Rows times * y <= base + views outside a window of `width` places, where they are `open`."""

    width: Int[np.ndarray, " P"]
    times: int
    base: Int[np.ndarray, "K P"]
    open: Bool[np.ndarray, "K P"]


def _families(program: GridProgram) -> list[_Family]:
    """Windows that do not hold all cameras that a point takes, by where they begin."""
    shape = program.seen.shape
    begin = np.arange(shape[0])[:, None]
    families = []
    if program.is_spread:
        # A fixed camera that sees the point from outside makes the row an empty one.
        free = np.broadcast_to(program.apart > 0, shape).copy()
        for at, sees in zip(program.fixed_at, program.fixed, strict=True):
            free &= ~sees | (np.mod(at - begin, shape[0]) <= program.window_of - 1)
        families.append(_Family(program.window_of, 1, np.zeros(shape, dtype=int), free))
    base = np.broadcast_to(program.base, shape)
    for held in range(1, program.threshold):
        width = held * program.window
        if 0 < width < shape[0]:
            everywhere = np.broadcast_to(program.base + held <= program.threshold, shape)
            families.append(_Family(np.full(shape[1], width), program.threshold - held, base, everywhere))
    return families


def _cumulative(views: Bool[np.ndarray, "K R"], n_free: int) -> tuple[sparse.csr_matrix, Float[np.ndarray, " R"]]:
    """Cameras among R sets of places as (R, K) matrix for the cumulative counts, and (R,) constant beside it."""
    everywhere = views.all(axis=0)
    begins, ends = views & ~np.roll(views, 1, axis=0), views & ~np.roll(views, -1, axis=0)
    # The cumulative count before place 0 is 0, and an arc over place 0 holds all n less what it leaves out.
    matrix = sparse.csr_matrix(ends.T.astype(float)) - sparse.csr_matrix(np.roll(begins, -1, axis=0).T.astype(float))
    over_zero = views[0] & views[-1] & ~everywhere
    # An arc that begins at place 0 needs X_(-1) = 0, not X_(K-1) = n.
    constant = n_free * (over_zero.astype(float) + begins[0] + everywhere)
    return sparse.csr_matrix(matrix), constant
