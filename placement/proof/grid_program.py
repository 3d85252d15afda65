"""The best choice of cameras from a grid: the problem that is solved to the end to get a certificate.

From K places on the circle choose n so that the weight of the points seen from at least T of them, of which two are
far enough apart, is greatest. Places closer than the window exclude each other. Points may belong to several sums
(sites), of which the least is maximised.
"""

import itertools
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int

# Rounding of the single-precision matrix products, on weights that add up to 1.
SINGLE_PRECISION = 1e-5


@dataclass(frozen=True, eq=False)
class GridProgram:
    """Choose `n_free` of K places.

    Attributes
    ----------
    seen : (K, P) ndarray of bool
        Which points each place sees.
    weights : (P,) ndarray
        Of the points; any positive scale.
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
    apart : (P,) ndarray
        Steps around the circle, the shorter way, that some two cameras which see the point must lie apart; 0 where any
        will do.
    fixed : (F, P) ndarray of bool
        Which points each camera sees that is there whatever is chosen.
    fixed_at : (F,) ndarray
        Where those are [steps].
    n_sites : int
        Number of sums.
    slack : int
        How many steps further apart than their numbers two cameras may lie: 0 on a grid, 1 if places are cells.
    """

    seen: Bool[np.ndarray, "K P"]
    weights: Float[np.ndarray, " P"]
    n_free: int
    threshold: int
    window: int
    allowed: Bool[np.ndarray, " K"]
    site: Int[np.ndarray, " P"]
    apart: Float[np.ndarray, " P"]
    fixed: Bool[np.ndarray, "F P"]
    fixed_at: Float[np.ndarray, " F"]
    n_sites: int = 1
    slack: int = 0

    @cached_property
    def base(self) -> Int[np.ndarray, " P"]:
        """(P,) how many cameras see each point whatever is chosen."""
        return self.fixed.sum(axis=0)

    @cached_property
    def is_spread(self) -> bool:
        """Whether some point takes cameras that are far enough apart."""
        return bool((self.apart > 0).any())

    @cached_property
    def window_of(self) -> Int[np.ndarray, " P"]:
        """(P,) how many neighbouring places there are at most of which no two are far enough apart for a point."""
        return np.ceil(self.apart).astype(int)

    @cached_property
    def of_sites(self) -> Float[np.ndarray, "P S"]:
        """(P, n_sites) the weight of each point in the sum it belongs to."""
        return self.weights[:, None] * (self.site[:, None] == np.arange(self.n_sites))

    def sums(self, covered: Bool[np.ndarray, "*C P"]) -> Float[np.ndarray, "*C S"]:
        """(..., n_sites) weight of the points that each (..., P) mask `covered` chooses."""
        return covered @ self.of_sites

    def merged(self) -> "GridProgram":
        """The same program with points of equal profile merged, and those that cannot be decided left out."""
        program = self._with_partners() if self.is_spread else self
        most = program.base + self.n_free * program.seen.any(axis=0)
        if self.window > 0:
            most = program.base + np.minimum(self.n_free, program.seen[self.allowed].sum(axis=0))
        kept = (most >= self.threshold) & (self.weights > 0)
        # Which fixed cameras see a point matters where they must be far apart, else only how many do.
        fixed = np.packbits(program.fixed[:, kept], axis=0) if self.is_spread else np.zeros((0, kept.sum()), np.uint8)
        others = np.stack([program.base[kept], self.site[kept], self.window_of[kept]])
        others = others.astype(np.int32).view(np.uint8).reshape(3, -1, 4)
        key = np.concatenate([np.packbits(program.seen[:, kept], axis=0), fixed, *others.transpose(0, 2, 1)])
        _, first, group = np.unique(key.T, axis=0, return_index=True, return_inverse=True)
        # Of no points at all it gives whole numbers.
        weights = np.bincount(group.reshape(-1), weights=self.weights[kept], minlength=len(first)).astype(np.float64)
        return replace(
            program, seen=program.seen[:, kept][:, first], weights=weights, site=self.site[kept][first],
            apart=self.apart[kept][first], fixed=program.fixed[:, kept][:, first],
        )  # fmt: skip

    def _with_partners(self) -> "GridProgram":
        """Without the views that have no other far enough away; if two are needed, no others help.

        Of two views one cannot do without the other; with a higher threshold lone ones count too, beside a pair.
        """
        n_places = len(self.seen)
        may = self.seen & self.allowed[:, None]
        # All but those nearer than `apart`, on both sides.
        near = in_windows(may.astype(float), 2 * self.window_of - 1)
        start = (np.arange(n_places)[:, None] - self.window_of + 1) % n_places
        partners = may.sum(axis=0) - np.round(np.take_along_axis(near, start, axis=0)).astype(int)
        for at, sees in zip(self.fixed_at, self.fixed, strict=True):
            partners += sees & (around(np.arange(n_places) - at, n_places)[:, None] >= self.apart)
        paired = may & ((partners > 0) | (self.apart <= 0))
        fixed = np.zeros_like(self.fixed)
        for k, (at, sees) in enumerate(zip(self.fixed_at, self.fixed, strict=True)):
            far = may & (around(np.arange(n_places) - at, n_places)[:, None] >= self.apart)
            among = self.fixed & (around(self.fixed_at - at, n_places)[:, None] >= self.apart)
            fixed[k] = sees & (far.any(axis=0) | among.any(axis=0) | (self.apart <= 0))
        if self.threshold == 2:
            return replace(self, seen=paired, fixed=fixed)
        hopeless = ~(paired.any(axis=0) | fixed.any(axis=0))
        return replace(self, seen=self.seen & ~hopeless, fixed=self.fixed & ~hopeless)

    def worths(self, choices: Int[np.ndarray, "C N"]) -> Float[np.ndarray, " C"]:
        """(C,) weight of the points seen by cameras enough, for (C, N) chosen places; the least of the sums."""
        chosen = self.seen[choices.T]
        covered = self.base + chosen.sum(axis=0) >= self.threshold
        if self.is_spread:
            seen, at = [*chosen, *self.fixed[:, None]], [*choices.T, *self.fixed_at[:, None]]
            far = np.broadcast_to(self.apart <= 0, covered.shape).copy()
            for one, other in itertools.combinations(range(len(at)), 2):
                far |= seen[one] & seen[other] & (around(at[one] - at[other], len(self.seen))[:, None] >= self.apart)
            covered &= far
        return self.sums(covered).min(axis=1)

    def value(self, places) -> float:
        """The same for one choice."""
        return float(self.worths(np.asarray(places, dtype=int).reshape(1, -1))[0])


def in_windows(amount: Float[np.ndarray, "K P"], width: Int[np.ndarray, " P"]) -> Float[np.ndarray, "K P"]:
    """(K, P) what (K, P) `amount` adds up to in the (P,) `width` places that begin at each place."""
    n_places, n_points = amount.shape
    until = np.zeros((2 * n_places + 1, n_points))
    np.cumsum(np.concatenate([amount, amount]), axis=0, out=until[1:])
    width = np.minimum(width, n_places)
    if len(width) and (width == width[0]).all():
        return until[width[0] : n_places + width[0]] - until[:n_places]
    begin = np.arange(n_places)[:, None]
    return until[begin + width, np.arange(n_points)] - until[:n_places]


def around(steps, n_places: int):
    """Distance around the circle of places that lie so many steps apart, the shorter way."""
    steps = np.mod(steps, n_places)
    return np.minimum(steps, n_places - steps)


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
        "enumeration" or "branch and bound".
    finished : bool
        Whether the solver came to its end within the time.
    """

    places: tuple[int, ...] | None
    value: float
    bound: float
    method: str
    finished: bool
