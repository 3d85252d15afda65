"""Search on the samples themselves: move one camera at a time to the best angle of a fine grid.

The coverage of the samples for every grid angle of one camera, the others held, costs one matrix product. It needs
no gradient and no temperature, and it can jump over a fixed camera or a forbidden arc.
"""

import itertools
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse import csr_array

import exact
from exact.demand import Criterion
from placement.errors import PlacementError
from placement.layouts.arcs import LayoutSpace
from placement.samples.profiles import RingProfiles

# Angles for moving two cameras at once: 3 degrees, which one camera at a time then refines.
PAIR_GRID = 120
# Cameras whose squared distances from their centre add up to less [mm²] are in one place.
LEAST_SPREAD = 1e-9
# How much the mean of several sites counts beside the least: enough to lead over flat stretches, too little to decide.
MEAN_SHARE = 0.01
# Errors on a ring follow its formula to 0.3 %.
NEARLY_EXACT = 1.003


class SampledCoverage:
    """Which part of the samples layouts on and off a grid of angles reconstruct.

    Where the profiles make several sums (`RingProfiles.site`), the least of them is what a layout is worth. To get on
    where that one cannot be raised by a single move, the search also looks a little at their mean.

    Parameters
    ----------
    profiles : RingProfiles
        Points that can be covered or not; others only cost time.
    demand : exact.Demand
        What makes a point count.
    ring : exact.Ring
        Where cameras may be.
    n_grid : int
        Angles a camera may be moved to, evenly around the ring.

    Examples
    --------
    >>> right, left = np.cos([0.0, 1.0, 2.0, 3.0, 4.0, 5.0]), -np.cos([0.0, 1.0, 2.0, 3.0, 4.0, 5.0])
    >>> profiles = RingProfiles.of(np.stack([right, left], axis=1), np.array([2.0, 1.0]))
    >>> SampledCoverage(profiles, exact.Demand(), exact.Ring()).fraction([0.1, -0.1])
    2.0
    """

    def __init__(
        self,
        profiles: RingProfiles,
        demand: exact.Demand,
        ring: exact.Ring,
        n_grid: int = 720,
    ):
        self.profiles = profiles
        self.demand = demand
        self.ring = ring
        self.grid = 2 * np.pi * np.arange(n_grid) / n_grid
        stride = max(1, round(n_grid / PAIR_GRID))
        self.pair_grid = self.grid[::stride]
        self._stride = stride
        self._weights = profiles.weights.astype(np.float32)
        self._known: dict[bytes, Float[np.ndarray, " G"]] = {}  # of `worth_with_one_more`: many starts lead to one end

    @cached_property
    def _seen(self) -> Float[np.ndarray, "N G"]:
        """(N, n_grid), points first: only the few that still wait for a view are taken. Single, for matrix products."""
        return np.ascontiguousarray(self.profiles.at(self.grid).T, dtype=np.float32)

    @cached_property
    def _seen_pairs(self) -> Float[np.ndarray, "N G"]:
        return np.ascontiguousarray(self._seen[:, :: self._stride])

    def covered(self, angles) -> Bool[np.ndarray, " N"]:
        """(N,) bool: which samples the layout of (M,) ring angles [rad] reconstructs."""
        theta = np.asarray(angles, dtype=np.float64)
        return samples_met(self.profiles.at(theta), theta, self.demand, self.ring, self.profiles.noise)

    def error(self, angles) -> float:
        """Root mean square of the predicted errors over the samples that a layout reconstructs [mm]; inf for none."""
        theta = np.asarray(angles, dtype=np.float64)
        seen = self.profiles.at(theta)
        covered = samples_met(seen, theta, self.demand, self.ring, self.profiles.noise)
        weights = self.profiles.weights[covered]
        variances = variances_of(seen[:, covered], theta, self.ring, self.profiles.noise[covered])
        return float(np.sqrt(weights @ variances / weights.sum())) if weights.sum() > 0 else np.inf

    def fraction(self, angles) -> float:
        """Weight of the samples that the layout of (M,) ring angles [rad] reconstructs; the least of several sums."""
        return float(self.profiles.sums(self.covered(angles)).min())

    def worth(self, angles) -> float:
        """What the search compares: `fraction` and, of several sums, a little of their mean."""
        return float(_worth(self.profiles.sums(self.covered(angles))))

    def worth_with_one_more(self, angles) -> Float[np.ndarray, " G"]:
        """(n_grid,) `worth` of the (M - 1,) ring angles [rad] and one more camera at each grid angle."""
        theta = np.sort(np.asarray(angles, dtype=np.float64))
        key = theta.tobytes()
        if key not in self._known:
            self._known[key] = self._with_one_more(theta)
        return self._known[key].copy()

    def _with_one_more(self, theta: Float[np.ndarray, " M"]) -> Float[np.ndarray, " G"]:
        seen = self.profiles.at(theta)
        count = seen.sum(axis=0)
        threshold = self.demand.threshold
        if self.demand.baseline == 0 and self.demand.max_error is None:
            already = self.profiles.sums(count >= threshold)
            return _worth(self._sums(np.flatnonzero(count == threshold - 1)) + already[:, None])
        # One camera more undoes nothing: it only adds baselines and lessens errors.
        done = samples_met(seen, theta, self.demand, self.ring, self.profiles.noise)
        waiting = np.flatnonzero((count >= threshold - 1) & ~done)
        now_seen = self._seen[waiting] > 0
        won = self._covered_with_one_more(theta, seen[:, waiting], now_seen, self.grid)
        if self.demand.max_error is not None:
            noise = self.profiles.noise[waiting]
            won &= self._variances(theta, seen[:, waiting], now_seen, self.grid, noise) <= self.demand.max_error**2
        weights = self._weights[waiting] * (self.profiles.site[waiting] == np.arange(self.profiles.n_sites)[:, None])
        gained = weights.astype(np.float32) @ won.astype(np.float32)
        return _worth(gained.astype(np.float64) + self.profiles.sums(done)[:, None])

    def measured_with_one_more(self, angles, grid=None) -> tuple[Float[np.ndarray, " G"], Float[np.ndarray, " G"]]:
        """`worth` and `error` of (M - 1,) ring angles [rad] and one more at each of `grid`, by default `pair_grid`.

        What makes points of one site differ that the same cameras see is their noise alone, by which variances grow.
        """
        theta = np.asarray(angles, dtype=np.float64)
        seen_from = self._seen_pairs if grid is None else self.profiles.at(grid).T
        grid = self.pair_grid if grid is None else np.asarray(grid, dtype=np.float64)
        seen = self.profiles.at(theta)
        which = np.flatnonzero(seen.sum(axis=0) >= self.demand.threshold - 1)
        key = np.concatenate([np.packbits(seen[:, which], axis=0), self.profiles.site[None, which]])
        order = np.lexsort(key)
        which, key = which[order], key[:, order]
        begins = np.append(0, np.flatnonzero((key[:, 1:] != key[:, :-1]).any(axis=0)) + 1)[: len(which)]
        sets, site = seen[:, which[begins]], self.profiles.site[which[begins]]
        ends = np.append(begins, len(which))
        alone, joined = self._unit_variances(theta, sets, grid)
        weight, noise = self.profiles.weights[which], self.profiles.noise[which]
        now = seen_from[which].astype(np.float64)
        without = 1 - now
        if self.demand.max_error is not None:
            group, most = np.repeat(np.arange(len(begins)), np.diff(ends)), self.demand.max_error**2
            with np.errstate(invalid="ignore"):
                without[~(noise * alone[group] <= most)] = 0.0
                now[~(noise[:, None] * joined[group] <= most)] = 0.0
        columns, n = np.arange(len(which)), (len(begins), len(which))
        sums = [csr_array((values, columns, ends), shape=n) for values in (weight, weight * noise)]
        counts = self._covered_with_one_more(theta, sets, np.ones((len(begins), len(grid)), dtype=bool), grid)
        weights, squares = _counted(sums[0] @ now, sums[1] @ now, joined, counts)
        counts = self._covered_with_one_more(theta, sets, np.zeros((len(begins), 1), dtype=bool), grid[:1])
        if counts.any():
            more = _counted(sums[0] @ without, sums[1] @ without, alone[:, None], counts)
            weights, squares = weights + more[0], squares + more[1]
        total, squares = weights.sum(axis=0), squares.sum(axis=0)
        error = np.sqrt(np.divide(squares, total, out=np.full(len(grid), np.inf), where=total > 0))
        return _worth(np.stack([weights[site == k].sum(axis=0) for k in range(self.profiles.n_sites)])), error

    def _unit_variances(
        self, theta: Float[np.ndarray, " M"], sets: Bool[np.ndarray, "M S"], grid: Float[np.ndarray, " G"]
    ) -> tuple[Float[np.ndarray, " S"], Float[np.ndarray, "S G"]]:
        """Variances of points of unit noise that these sets of cameras see, without and with one more of `grid`."""
        joined = self._variances(
            theta, sets, np.ones((sets.shape[1], len(grid)), dtype=bool), grid, np.ones(sets.shape[1])
        )
        return variances_of(sets, theta, self.ring, np.ones(sets.shape[1])), joined

    def _covered_with_one_more(
        self,
        theta: Float[np.ndarray, " M"],
        seen: Bool[np.ndarray, "M W"],
        now_seen: Bool[np.ndarray, "W G"],
        grid: Float[np.ndarray, " G"],
    ) -> Bool[np.ndarray, "W G"]:
        """Whether cameras enough see W points, and far enough apart, with one more at each of `grid`."""
        covered = seen.sum(axis=0)[:, None] + now_seen >= self.demand.threshold
        if self.demand.baseline > 0:
            paired = Criterion(2, _far(theta, theta, self.demand, self.ring)).enough(seen.T)
            partner = seen.T.astype(np.float32) @ _far(theta, grid, self.demand, self.ring).astype(np.float32) > 0
            covered &= paired[:, None] | (partner & now_seen)
        return covered

    def _variances(
        self,
        theta: Float[np.ndarray, " M"],
        seen: Bool[np.ndarray, "M W"],
        now_seen: Bool[np.ndarray, "W G"],
        grid: Float[np.ndarray, " G"],
        noise: Float[np.ndarray, " W"],
    ) -> Float[np.ndarray, "W G"]:
        """Variances [mm²] of the errors of W points with one more camera at each of `grid`."""
        moment = (np.exp(1j * theta) @ seen)[:, None] + np.where(now_seen, np.exp(1j * grid), 0)
        return _variances(seen.sum(axis=0)[:, None] + now_seen, moment, self.ring, noise[:, None])

    def worth_with_two_more(self, angles) -> Float[np.ndarray, "G G"]:
        """(G, G) `worth` of (M - 2,) ring angles [rad] and two more on `pair_grid`.

        With a baseline only for a threshold of 2, and with no bound on the error.
        """
        theta = np.asarray(angles, dtype=np.float64)
        if self.demand.baseline > 0:
            return self._with_two_far_more(theta)
        count = self.profiles.at(theta).sum(axis=0)
        short = self.demand.threshold - count
        sums = []
        for site, already in enumerate(self.profiles.sums(short <= 0)):
            # A point one view short is won by either camera, one two views short only by both.
            one = np.flatnonzero((short == 1) & (self.profiles.site == site))
            two = np.flatnonzero((short == 2) & (self.profiles.site == site))
            either, both = self._seen_pairs[one], self._seen_pairs[two]
            alone = self._weights[one] @ either
            gained = alone[:, None] + alone[None, :] - (either.T * self._weights[one]) @ either
            sums.append((gained + (both.T * self._weights[two]) @ both).astype(np.float64) + already)
        return _worth(np.stack(sums))

    def _with_two_far_more(self, theta: Float[np.ndarray, " M"]) -> Float[np.ndarray, "G G"]:
        """The same with a baseline: a point is won by either camera with one that is there, or by both together."""
        seen = self.profiles.at(theta)
        done = samples_met(seen, theta, self.demand, self.ring, self.profiles.noise)
        partner = _far(theta, self.pair_grid, self.demand, self.ring).astype(np.float32)
        together = _far(self.pair_grid, self.pair_grid, self.demand, self.ring)
        sums = []
        for site, already in enumerate(self.profiles.sums(done)):
            waiting = np.flatnonzero(~done & (self.profiles.site == site))
            now_seen, weights = self._seen_pairs[waiting], self._weights[waiting]
            lost = 1 - now_seen * (seen[:, waiting].T.astype(np.float32) @ partner > 0)
            both = lost * now_seen
            left = (lost.T * weights) @ lost - together * ((both.T * weights) @ both)
            sums.append((weights.sum() - left).astype(np.float64) + already)
        return _worth(np.stack(sums))

    def _sums(self, waiting: Int[np.ndarray, " W"]) -> Float[np.ndarray, "S G"]:
        """(n_sites, n_grid) weight of the `waiting` samples that each grid angle sees."""
        sums = []
        for site in range(self.profiles.n_sites):
            of_site = waiting[self.profiles.site[waiting] == site]
            # einsum, not BLAS: for products this small, threads that wait for each other cost more than they bring.
            sums.append(np.einsum("n,ng->g", self._weights[of_site], self._seen[of_site]).astype(np.float64))
        return np.stack(sums)

    def improve(self, space: LayoutSpace, angles, max_sweeps: int = 10) -> Float[np.ndarray, " M"]:
        """Move one free camera at a time to its best grid angle until no move gains anything.

        Parameters
        ----------
        space : LayoutSpace
            What is allowed; the layout stays in it.
        angles : (M,) array_like
            Ring angles [rad] to start from.
        max_sweeps : int
            Times each camera is tried at most.

        Returns
        -------
        (M,) ndarray
            Ring angles [rad] worth at least as much as the start.
        """
        theta = np.array(angles, dtype=np.float64)
        value = self.worth(theta)
        gain_worth = 1e-6 * float(self.profiles.weights.sum())  # single precision in the matrix product
        for _ in range(max_sweeps):
            before = value
            for camera in space.free_cameras(theta):
                others = np.delete(theta, camera)
                worths = self.worth_with_one_more(others)
                worths[~space.allowed(self.grid, others)] = -np.inf
                best = _middle_of_best(worths, gain_worth)
                if worths[best] > value + gain_worth:
                    theta[camera] = self.grid[best]
                    value = self.worth(theta)
            if value <= before + gain_worth:
                break
        return theta

    def improve_pairs(self, space: LayoutSpace, angles, max_sweeps: int = 3) -> Float[np.ndarray, " M"]:
        """Move two free cameras at once, then each alone, until nothing is gained; leaves most local optima.

        Parameters and result as for `improve`. With a bounded error, or a baseline and a threshold other than 2, only
        single cameras are moved.
        """
        theta = self.improve(space, angles)
        if self.demand.max_error is not None or (self.demand.baseline > 0 and self.demand.threshold != 2):
            return theta
        half_gap = np.sin(space.minimum_gap / 2)
        apart = np.abs(np.sin((self.pair_grid[:, None] - self.pair_grid[None, :]) / 2)) >= half_gap
        gain_worth = 1e-6 * float(self.profiles.weights.sum())
        for _ in range(max_sweeps):
            before = self.worth(theta)
            for pair in itertools.combinations(space.free_cameras(theta), 2):
                others = np.delete(theta, pair)
                fits = space.allowed(self.pair_grid, others)
                worths = np.where(apart & fits[:, None] & fits[None, :], self.worth_with_two_more(others), -np.inf)
                best = np.unravel_index(worths.argmax(), worths.shape)
                if worths[best] > self.worth(theta) + gain_worth:
                    theta[list(pair)] = self.pair_grid[list(best)]
                    theta = self.improve(space, theta)
            if self.worth(theta) <= before + gain_worth:
                break
        return theta


def samples_met(
    seen: Bool[np.ndarray, "M N"],
    angles: Float[np.ndarray, " M"],
    demand: exact.Demand,
    ring: exact.Ring,
    noise: Float[np.ndarray, " N"],
) -> Bool[np.ndarray, " N"]:
    """(N,) bool: which samples the cameras at these ring angles [rad] reconstruct; `noise` as of `RingProfiles`."""
    far = _far(angles, angles, demand, ring) if demand.baseline > 0 else None
    met = Criterion(demand.threshold, far).enough(seen.T)
    if demand.max_error is not None:
        met[met] = variances_of(seen[:, met], angles, ring, noise[met]) <= demand.max_error**2
    return met


def _far(
    first: Float[np.ndarray, " A"], second: Float[np.ndarray, " B"], demand: exact.Demand, ring: exact.Ring
) -> Bool[np.ndarray, "A B"]:
    """(A, B) bool: ring angles [rad] that are far enough apart."""
    return demand.apart(ring.diameter * np.abs(np.sin((first[:, None] - second[None, :]) / 2)))


def variances_of(
    seen: Bool[np.ndarray, "M N"], angles: Float[np.ndarray, " M"], ring: exact.Ring, noise: Float[np.ndarray, " N"]
) -> Float[np.ndarray, " N"]:
    """(N,) predicted variances [mm²] of samples that the cameras at these ring angles [rad] see; `noise` in [mm⁴]."""
    # By einsum, not BLAS, whose threads wait for each other.
    return _variances(seen.sum(axis=0), np.einsum("m,mn->n", np.exp(1j * angles), seen), ring, noise)


def refuse_unmet(profiles: RingProfiles, demand: exact.Demand, ring: exact.Ring, n_cameras: int) -> None:
    """Refuse a bound on the error that no layout meets at any of the samples.

    However many cameras see a point, their squared distances from their centre add up to (d/2)² each at most.

    Raises
    ------
    PlacementError
        With the least error that can be met.
    """
    if demand.max_error is None or len(profiles.noise) == 0:
        return
    least = float(np.sqrt(profiles.noise.min() / n_cameras)) / (ring.diameter / 2)
    if least > NEARLY_EXACT * demand.max_error:
        raise PlacementError(
            f"max_error is {demand.max_error:g} mm; {n_cameras} cameras on this ring place no point of the surface "
            f"better than to {least:.3g} mm: allow a larger error, or take more cameras, a wider or nearer ring, more "
            "pixels or a lower noise of a match"
        )


def _variances(count: np.ndarray, moment: np.ndarray, ring: exact.Ring, noise: np.ndarray) -> np.ndarray:
    """The same from the number n of cameras that see each point and the sum m of their e^(i θ).

    The squared distances of the cameras from their centre add up to (d/2)² (n - |m|² / n).
    """
    spread = (ring.diameter / 2) ** 2 * (count - np.abs(moment) ** 2 / np.maximum(count, 1))
    return np.divide(noise, spread, out=np.full(np.broadcast(noise, spread).shape, np.inf), where=spread > LEAST_SPREAD)


def _counted(sums: np.ndarray, squares: np.ndarray, variance: np.ndarray, counts: np.ndarray):
    """Sums of weights that count, and of squares, from those of unit variance; infinite only where there is any."""
    sums, known = np.where(counts, sums, 0.0), np.isfinite(variance)
    squares = np.where(known & (sums > 0), squares, 0.0) * np.where(known, variance, 0.0)
    return sums, np.where(~known & (sums > 0), np.inf, squares)


def _worth(sums: Float[np.ndarray, "S ..."]) -> Float[np.ndarray, "..."]:
    """The least along the first axis and, where there are several, MEAN_SHARE of their mean."""
    return np.asarray(sums[0] if len(sums) == 1 else sums.min(axis=0) + MEAN_SHARE * sums.mean(axis=0))


def _middle_of_best(values: Float[np.ndarray, " G"], tolerance: float) -> int:
    """Index in the middle of the first run of values that equal the greatest: away from what would lose them."""
    best = int(values.argmax())
    end = best
    while end + 1 < len(values) and values[end + 1] >= values[best] - tolerance:
        end += 1
    return (best + end) // 2
