"""Search on the samples themselves: move one camera at a time to the best angle of a fine grid.

The coverage of the samples for every grid angle of one camera, the others held, costs one matrix product. It needs
no gradient and no temperature, and it can jump over a fixed camera or a forbidden arc.
"""

import itertools
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float

import exact
from placement.layouts.arcs import LayoutSpace
from placement.samples.profiles import RingProfiles
from placement.samples.viewed_samples import ViewedSamples, far_apart, worth_of

# Angles for moving two cameras at once: 3 degrees, which one camera at a time then refines.
PAIR_GRID = 120


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
        self.viewed = ViewedSamples(profiles, demand, ring)
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
        return self.viewed.met(*self._seen_at(angles))

    def error(self, angles) -> float:
        """Root mean square of the predicted errors over the samples that a layout reconstructs [mm]; inf for none."""
        return self.viewed.error(*self._seen_at(angles))

    def fraction(self, angles) -> float:
        """Weight of the samples that the layout of (M,) ring angles [rad] reconstructs; the least of several sums."""
        return self.viewed.fraction(*self._seen_at(angles))

    def worth(self, angles) -> float:
        """What the search compares: `fraction` and, of several sums, a little of their mean."""
        return self.viewed.worth(*self._seen_at(angles))

    def _seen_at(self, angles) -> tuple[Bool[np.ndarray, "M N"], Float[np.ndarray, " M"]]:
        theta = np.asarray(angles, dtype=np.float64)
        return self.profiles.at(theta), theta

    def worth_with_one_more(self, angles) -> Float[np.ndarray, " G"]:
        """(n_grid,) `worth` of the (M - 1,) ring angles [rad] and one more camera at each grid angle."""
        theta = np.sort(np.asarray(angles, dtype=np.float64))
        key = theta.tobytes()
        if key not in self._known:
            self._known[key] = self.viewed.worth_with_one_more(self.profiles.at(theta), theta, self._seen, self.grid)
        return self._known[key].copy()

    def measured_with_one_more(self, angles, grid=None) -> tuple[Float[np.ndarray, " G"], Float[np.ndarray, " G"]]:
        """`worth` and `error` of (M - 1,) ring angles [rad] and one more at each of `grid`, by default `pair_grid`.

        What makes points of one site differ that the same cameras see is their noise alone, by which variances grow.
        """
        seen, theta = self._seen_at(angles)
        if grid is None:
            return self.viewed.measured_with_one_more(seen, theta, self._seen_pairs, self.pair_grid)
        return self.viewed.measured_with_one_more(
            seen, theta, self.profiles.at(grid).T, np.asarray(grid, dtype=np.float64)
        )

    def worth_with_two_more(self, angles) -> Float[np.ndarray, "G G"]:
        """(G, G) `worth` of (M - 2,) ring angles [rad] and two more on `pair_grid`.

        With a baseline or a bound on disparity only for a threshold of 2, and with no bound on the error.
        """
        theta = np.asarray(angles, dtype=np.float64)
        if self.demand.max_disparity_gradient is not None:
            return self.viewed.worth_with_two_matched_more(
                self.profiles.at(theta), theta, self._seen_pairs, self.pair_grid
            )
        if self.demand.baseline > 0:
            return self._with_two_far_more(theta)
        return self.viewed.worth_with_two_more(self.profiles.at(theta), self._seen_pairs)

    def _with_two_far_more(self, theta: Float[np.ndarray, " M"]) -> Float[np.ndarray, "G G"]:
        """The same with a baseline: a point is won by either camera with one that is there, or by both together."""
        seen = self.profiles.at(theta)
        done = self.viewed.met(seen, theta)
        partner = far_apart(theta, self.pair_grid, self.demand, self.ring).astype(np.float32)
        together = far_apart(self.pair_grid, self.pair_grid, self.demand, self.ring)
        sums = []
        for site, already in enumerate(self.profiles.sums(done)):
            waiting = np.flatnonzero(~done & (self.profiles.site == site))
            now_seen, weights = self._seen_pairs[waiting], self._weights[waiting]
            lost = 1 - now_seen * (seen[:, waiting].T.astype(np.float32) @ partner > 0)
            both = lost * now_seen
            left = (lost.T * weights) @ lost - together * ((both.T * weights) @ both)
            sums.append((weights.sum() - left).astype(np.float64) + already)
        return worth_of(np.stack(sums))

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

        Parameters and result as for `improve`. With a bounded error, or a baseline or bounded disparity and a threshold
        other than 2, only single cameras are moved.
        """
        theta = self.improve(space, angles)
        if self.demand.max_error is not None or not (self.demand.is_count or self.demand.threshold == 2):
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


def _middle_of_best(values: Float[np.ndarray, " G"], tolerance: float) -> int:
    """Index in the middle of the first run of values that equal the greatest: away from what would lose them."""
    best = int(values.argmax())
    end = best
    while end + 1 < len(values) and values[end + 1] >= values[best] - tolerance:
        end += 1
    return (best + end) // 2
