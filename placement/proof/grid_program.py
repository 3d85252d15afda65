"""The best choice of cameras from a grid: the problem that is solved to the end to get a certificate.

From K places on the circle choose n so that the weight of the points seen from at least T of them is greatest.
Places closer than the window exclude each other. Two solvers, each with an upper bound that holds for every choice:

- *enumeration*, all choices, each put together from two halves: with counts c_A and c_B a point is missed if
  c_A = t and c_B <= T - 1 - t for some t < T, so T matrix products give the missed weight of all pairs of halves;
- a *mixed-integer program* (HiGHS) for what is too many. Points see arcs of places, so with cumulative counts
  X_k = x_0 + ... + x_k the number of cameras that see a point is a sum of few differences of X, which keeps the
  program sparse: T y_p <= sum over arcs [a, b] of X_b - X_(a-1).

Points may belong to several sums (sites), of which the least is maximised.
"""

import time
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from jaxtyping import Bool, Float, Int
from scipy.optimize import Bounds, LinearConstraint, milp

# Rounding of the single-precision matrix products, on weights that add up to 1.
SINGLE_PRECISION = 1e-5
# Halves per block: blocks this large keep the matrix products fast and fit the cache of intermediate results.
BLOCK = 512
# Multiplications up to which enumeration is taken at once, within seconds, and at all, within a minute.
QUICK_MULTIPLICATIONS = 2e11
MOST_MULTIPLICATIONS = 1.5e12
# Nodes of the branch-and-bound tree after which enumeration takes over, where it is possible.
FIRST_NODES = 5


@dataclass(frozen=True, eq=False)
class GridProgram:
    """Choose `n_free` of K places.

    Attributes
    ----------
    seen : (K, P) ndarray of bool
        Which points each place sees.
    weights : (P,) ndarray
        Of the points; any positive scale.
    base : (P,) ndarray of int
        Cameras that see each point whatever is chosen (fixed ones).
    n_free : int
        Places to choose, 0 or more.
    threshold : int
        Cameras that must see a point.
    window : int
        Two chosen places are at least this many steps apart, around the circle too; 0 allows the same one twice.
    allowed : (K,) ndarray of bool
        Places that may be chosen.
    site : (P,) ndarray of int
        Sum to which each point belongs.
    n_sites : int
        Number of sums.
    """

    seen: Bool[np.ndarray, "K P"]
    weights: Float[np.ndarray, " P"]
    base: Int[np.ndarray, " P"]
    n_free: int
    threshold: int
    window: int
    allowed: Bool[np.ndarray, " K"]
    site: Int[np.ndarray, " P"]
    n_sites: int = 1

    def sums(self, covered: Bool[np.ndarray, " P"]) -> Float[np.ndarray, " S"]:
        """(n_sites,) weight of the points that the (P,) mask `covered` chooses."""
        # Of no points at all it gives whole numbers.
        return np.bincount(self.site, weights=self.weights * covered, minlength=self.n_sites).astype(np.float64)

    def merged(self) -> "GridProgram":
        """The same program with points of equal profile merged, and those that cannot be decided left out."""
        most = self.base + self.n_free * self.seen.any(axis=0)
        if self.window > 0:
            most = self.base + np.minimum(self.n_free, self.seen[self.allowed].sum(axis=0))
        kept = (most >= self.threshold) & (self.weights > 0)
        others = np.stack([self.base[kept], self.site[kept]]).astype(np.int32).view(np.uint8).reshape(2, -1, 4)
        key = np.concatenate([np.packbits(self.seen[:, kept], axis=0), *others.transpose(0, 2, 1)])
        _, first, group = np.unique(key.T, axis=0, return_index=True, return_inverse=True)
        # Of no points at all it gives whole numbers.
        weights = np.bincount(group.reshape(-1), weights=self.weights[kept], minlength=len(first)).astype(np.float64)
        return GridProgram(
            self.seen[:, kept][:, first], weights, self.base[kept][first], self.n_free, self.threshold, self.window,
            self.allowed, self.site[kept][first], self.n_sites,
        )  # fmt: skip

    def value(self, places) -> float:
        """Weight of the points seen by at least `threshold` cameras, for chosen places; the least of the sums."""
        count = self.base + self.seen[np.asarray(places, dtype=int)].sum(axis=0)
        return float(self.sums(count >= self.threshold).min())


@dataclass(frozen=True)
class GridSolution:
    """What came out.

    Attributes
    ----------
    places : tuple of int or None
        Best choice found; None if there is none or none was found.
    value : float
        Its weight.
    bound : float
        No choice has more.
    method : str
        "enumeration" or "mixed-integer program".
    finished : bool
        Whether the solver came to its end within the time.
    """

    places: tuple[int, ...] | None
    value: float
    bound: float
    method: str
    finished: bool


def solve(program: GridProgram, seconds: float, gap: float, known: tuple[int, ...] | None = None) -> GridSolution:
    """Best choice and upper bound, by enumeration where that is quick enough.

    Parameters
    ----------
    program : GridProgram
        The problem.
    seconds : float
        Time limit [s]; when it runs out the bound still holds.
    gap : float
        The mixed-integer program stops when bound and value differ by less than this fraction.
    known : tuple of int, optional
        A choice that is allowed, and taken if the program finds no better one in time. HiGHS takes no first solution
        from SciPy, and to demand no less than what is known made its bounds worse.

    Examples
    --------
    >>> seen = np.array([[1, 1, 0], [1, 0, 0], [0, 1, 1], [0, 0, 1]], dtype=bool)
    >>> zeros = np.zeros(3, int)
    >>> program = GridProgram(seen, np.array([1.0, 2.0, 4.0]), zeros, 2, 2, 1, np.ones(4, bool), site=zeros)
    >>> found = solve(program, seconds=10.0, gap=1e-3)
    >>> found.places, found.value, found.method
    ((2, 3), 4.0, 'enumeration')
    """
    end = time.perf_counter() + seconds
    small = program.merged()
    cost = multiplications(small)
    if cost > QUICK_MULTIPLICATIONS:
        # Counted in nodes, not in seconds, so that the same request takes the same way.
        found = mixed_integer(small, seconds, gap, FIRST_NODES if cost <= MOST_MULTIPLICATIONS else None, known)
        if found.finished or cost > MOST_MULTIPLICATIONS:
            return found
    return enumerate_all(small, end) or mixed_integer(small, max(end - time.perf_counter(), 1.0), gap, known=known)


def multiplications(program: GridProgram) -> float:
    """About how many multiplications enumeration takes: one for each choice, point and count below the threshold."""
    n, free = program.n_free, int(program.allowed.sum()) - max(program.window - 1, -1) * (program.n_free - 1)
    choices = np.prod([max(free - i, 0) / (i + 1) for i in range(n)]) if n else 1.0
    return 2 * float(choices) * program.threshold * len(program.weights)  # 2: blocks hold choices in vain


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


def mixed_integer(
    program: GridProgram, seconds: float, gap: float, nodes: int | None = None, known: tuple[int, ...] | None = None
) -> GridSolution:
    """Solve by HiGHS within `seconds` [s] and `nodes` to a relative `gap`; the bound holds in any case."""
    n_places, n_points = program.seen.shape
    n_free, n_sites, total = program.n_free, program.n_sites, float(program.weights.sum()) or 1.0
    most_covered = float(program.sums(np.ones(n_points, dtype=bool)).min())
    everywhere = program.seen.all(axis=0)
    begins = program.seen & ~np.roll(program.seen, 1, axis=0)
    ends = program.seen & ~np.roll(program.seen, -1, axis=0)
    # The cumulative count before place 0 is 0, and an arc over place 0 holds all n less what it leaves out.
    counts = sparse.csr_matrix(ends.T.astype(float)) - sparse.csr_matrix(np.roll(begins, -1, axis=0).T.astype(float))
    over_zero = program.seen[0] & program.seen[-1] & ~everywhere
    last_begins = begins[0]  # an arc that begins at place 0 needs X_(-1) = 0, not X_(K-1) = n
    constant = program.base + n_free * (over_zero.astype(int) + last_begins + everywhere)
    spare = sparse.csr_matrix((n_points, 1))
    demands = LinearConstraint(
        sparse.hstack([-counts, program.threshold * sparse.identity(n_points), spare]).tocsr(), -np.inf, constant
    )
    shift = sparse.identity(n_places) - sparse.eye(n_places, k=-1)
    most = np.where(program.allowed, n_free if program.window == 0 else 1, 0)
    points = sparse.csr_matrix((n_places, n_points + 1))
    places = LinearConstraint(sparse.hstack([shift, points]).tocsr(), 0, most)  # pyright: ignore[reportArgumentType]
    constraints = [demands, places]
    if program.window > 1 and n_free > 1:
        k = np.arange(n_places)
        last = k + program.window - 1
        rows, inside = np.concatenate([k, k[1:]]), np.concatenate([last % n_places, k[:-1]])
        values = np.concatenate([np.ones(n_places), -np.ones(n_places - 1)])
        together = sparse.csr_matrix((values, (rows, inside)), shape=(n_places, n_places))
        limit = 1 - n_free * (last >= n_places)
        constraints.append(LinearConstraint(sparse.hstack([together, points]).tocsr(), ub=limit))  # pyright: ignore[reportArgumentType]
    # The last variable is at most each of the sums, and is maximised: the least of them.
    of_site = sparse.csr_matrix((program.weights / total, (program.site, np.arange(n_points))), (n_sites, n_points))
    one = sparse.csr_matrix(np.ones((n_sites, 1)))
    least = sparse.hstack([sparse.csr_matrix((n_sites, n_places)), -of_site, one])
    constraints.append(LinearConstraint(least.tocsr(), ub=0.0))  # pyright: ignore[reportArgumentType]
    low = np.zeros(n_places + n_points + 1)
    low[n_places - 1] = n_free
    high = np.concatenate([np.full(n_places, float(n_free)), np.ones(n_points + 1)])
    found = milp(
        np.append(np.zeros(n_places + n_points), -1.0),
        constraints=constraints,
        bounds=Bounds(low, high),  # pyright: ignore[reportArgumentType]
        integrality=np.append(np.ones(n_places + n_points), 0),
        options={"time_limit": seconds, "mip_rel_gap": gap} | ({} if nodes is None else {"node_limit": nodes}),
    )
    bound = getattr(found, "mip_dual_bound", None)
    # Without any bound of the solver there is still this one: every point that some choice covers.
    if bound is None or not np.isfinite(bound):
        bound = most_covered
    else:
        bound = min(most_covered, -bound * total + SINGLE_PRECISION * total)
    infeasible = found.status == 2
    if found.x is not None:
        chosen = np.diff(np.round(found.x[:n_places]), prepend=0).astype(int)
        places = tuple(np.repeat(np.arange(n_places), chosen).tolist())
        if known is None or program.value(places) > program.value(known):
            return GridSolution(places, program.value(places), bound, "mixed-integer program", found.status == 0)
    if known is not None and not infeasible:
        value = program.value(known)
        return GridSolution(known, value, max(bound, value), "mixed-integer program", found.status == 0)
    return GridSolution(None, 0.0, 0.0 if infeasible else bound, "mixed-integer program", infeasible)


def _halves(program: GridProgram, size: int) -> Int[np.ndarray, "H {size}"]:
    """(H, size) every increasing choice of `size` allowed places that keeps the window, the circle left open."""
    allowed = np.flatnonzero(program.allowed)
    chosen = np.zeros((1, 0), dtype=np.int64)
    for _ in range(size):
        last = chosen[:, -1] if chosen.shape[1] else np.full(1, -program.window)
        row, column = np.nonzero(allowed[None, :] >= last[:, None] + program.window)
        chosen = np.concatenate([chosen[row], allowed[column][:, None]], axis=1)
    return chosen
