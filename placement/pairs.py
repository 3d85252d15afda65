"""Which pairs of cameras to reconstruct from: by the area they see, and by the accuracy they leave."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float

import exact
from placement.samples.sampled_coverage import SampledCoverage
from placement.samples.viewed_samples import pair_matches, variances_of

# Pairs are listed until the rest of them would add less than this part of the area.
ENOUGH = 1e-3
# Accurate pairs reconstruct at least this part of what all cameras do, with at most so many times their error.
KEPT, WITHIN = 0.99, 1.1
# To choose them, a point that none of them sees counts as if it had so many times the error of all cameras.
UNSEEN = 10.0
# While pairs chosen on samples turn out to have a greater error than that, they are chosen again for so much less.
TIGHTER, N_TIGHTER = 0.995, 20


@dataclass(frozen=True)
class Pair:
    """Two cameras of a layout.

    Attributes
    ----------
    cameras : (int, int)
        Their indices in the layout, ring angles increasing.
    area : float
        Reconstructable area that both see [mm²], summed over the sites.
    together : float
        The same for this pair and all those listed before it: what they reconstruct as pairs.
    error : float
        Root mean square of the predicted errors [mm] over that area, from this pair and those before it; infinite where
        it is not finite for all cameras.
    """

    cameras: tuple[int, int]
    area: float
    together: float
    error: float


class Pairs:
    """The pairs of cameras of one layout, and what they reconstruct.

    Parameters
    ----------
    sets : sequence of exact.ViewSets
        Of the layout's cameras, at each site.
    coverage : SampledCoverage
        With what makes a point count.
    angles : (M,) ndarray
        The layout's ring angles [rad].
    allowed : (M, M) bool
        Pairs that are far enough apart.
    """

    def __init__(
        self,
        sets: Sequence[exact.ViewSets],
        coverage: SampledCoverage,
        angles: Float[np.ndarray, " M"],
        allowed: Bool[np.ndarray, "M M"],
    ):
        self._sets, self._coverage, self._angles = sets, coverage, angles
        self.every = [(int(i), int(j)) for i, j in np.argwhere(np.triu(allowed, k=1))]
        areas, both = zip(*(of_site.paired(self.every, demand=coverage.demand) for of_site in sets), strict=True)
        self._areas = np.concatenate(areas)
        self._both = dict(zip(self.every, np.concatenate(both).T, strict=True))
        self._errors: dict[frozenset[tuple[int, int]] | None, float] = {}

    def by_area(self) -> tuple[Pair, ...]:
        """First the pair that sees most of what is reconstructed, then whichever adds most, until all is there."""
        return self._listed(self._ordered(self.every, ENOUGH))

    def accurate(self) -> tuple[Pair, ...]:
        """As few pairs as are found that keep the area of all cameras to 1 %, and their error to 10 %.

        A point is triangulated from all cameras that see it together with a partner in one of the pairs. Pairs are
        chosen on samples; areas and errors are exact. Empty where errors are not finite.
        """
        error = self.error(None)
        if not (np.isfinite(error) and self.every):
            return ()
        within, points = WITHIN, _Points.of(self._coverage, self._angles)
        for _ in range(N_TIGHTER):
            chosen = self._fewest(points, within)
            found = self._listed(self._ordered(chosen, 0.0))
            if found[-1].error <= WITHIN * error or len(chosen) == len(self.every):
                break
            within *= TIGHTER  # samples are not exact
        return found

    def error(self, pairs: Sequence[tuple[int, int]] | None) -> float:
        """Root mean square of the predicted errors [mm] over all that pairs, or all cameras, reconstruct."""
        key = None if pairs is None else frozenset(pairs)
        if key not in self._errors:
            self._errors[key] = self._error(pairs)
        return self._errors[key]

    def _error(self, pairs: Sequence[tuple[int, int]] | None) -> float:
        demand, matrix = self._coverage.demand, None
        if pairs is not None:
            matrix = np.zeros((len(self._angles),) * 2, dtype=bool)
            matrix[tuple(np.transpose(pairs))] = True
            matrix |= matrix.T
        every = [of_site.errors(demand=demand, pairs=matrix) for of_site in self._sets]
        squares = sum(float(errors.weights @ getattr(errors, demand.error) ** 2) for errors in every)
        total = sum(float(errors.weights.sum()) for errors in every)
        return float(np.sqrt(squares / total)) if total > 0 else np.inf

    def _ordered(self, pairs: Sequence[tuple[int, int]], enough: float) -> list[tuple[int, int]]:
        """Whichever adds most area first, until the rest adds less than this part; with 0 all of them."""
        left, order, rest = self._areas.copy(), [], list(pairs)
        reached = float(self._areas @ np.any([self._both[pair] for pair in pairs], axis=0)) if rest else 0.0
        least = enough * reached
        while rest and (enough == 0 or reached > least):
            best = max(rest, key=lambda pair: (float(left @ self._both[pair]), float(self._areas @ self._both[pair])))
            reached -= float(left @ self._both[best])
            left[self._both[best]] = 0.0
            rest.remove(best)
            order.append(best)
        return order

    def _listed(self, order: Sequence[tuple[int, int]]) -> tuple[Pair, ...]:
        found, seen = [], np.zeros(len(self._areas), dtype=bool)
        for number, pair in enumerate(order, start=1):
            seen |= self._both[pair]
            alone, together = float(self._areas @ self._both[pair]), float(self._areas @ seen)
            found.append(Pair(pair, alone, together, self.error(order[:number])))
        return tuple(found)

    def _fewest(self, points: "_Points", within: float) -> list[tuple[int, int]]:
        """Add whichever pair leaves least error until that is enough, then leave out what is not needed after all."""
        chosen: list[tuple[int, int]] = []
        while not points.suffice(chosen, within) and len(chosen) < len(self.every):
            rest = [pair for pair in self.every if pair not in chosen]
            chosen.append(min(rest, key=lambda pair: points.variance([*chosen, pair])))
        while True:
            fewer = [[pair for pair in chosen if pair != out] for out in chosen]
            fewer = [pairs for pairs in fewer if points.suffice(pairs, within)]
            if not fewer:
                return chosen
            chosen = min(fewer, key=points.variance)


@dataclass(frozen=True)
class _Points:
    """Samples that all cameras reconstruct, those together that the same cameras see and pairs match."""

    coverage: SampledCoverage
    angles: Float[np.ndarray, " M"]
    seen: Bool[np.ndarray, "M G"]
    weights: Float[np.ndarray, " G"]
    noise: Float[np.ndarray, " G"]
    heights: Float[np.ndarray, "3 G"]

    @staticmethod
    def of(coverage: SampledCoverage, angles: Float[np.ndarray, " M"]) -> "_Points":
        covered, profiles = coverage.covered(angles), coverage.profiles
        if coverage.demand.max_disparity_gradient is not None:
            kept = profiles.subset(covered)
            return _Points(coverage, angles, kept.at(angles), kept.weights, kept.noise, kept.heights)
        seen, group = np.unique(profiles.at(angles)[:, covered], axis=1, return_inverse=True)
        weights = np.bincount(group.reshape(-1), profiles.weights[covered])
        noise = np.bincount(group.reshape(-1), (profiles.weights * profiles.noise)[covered]) / weights
        return _Points(coverage, angles, seen, weights, noise, np.zeros((3, len(weights))))

    def _used(self, pairs: Sequence[tuple[int, int]]) -> Bool[np.ndarray, "M G"]:
        used = np.zeros_like(self.seen)
        for first, second in pairs:
            both = self.seen[first] & self.seen[second]
            used[first] |= both
            used[second] |= both
        return used

    def _reconstructed(self, pairs: Sequence[tuple[int, int]]) -> Bool[np.ndarray, " G"]:
        demand, found = self.coverage.demand, np.zeros(len(self.weights), dtype=bool)
        for pair in pairs:
            both = self.seen[list(pair)].all(axis=0)
            if demand.max_disparity_gradient is not None:
                both &= pair_matches(self.angles[list(pair)], demand, self.coverage.ring, self.heights)
            found |= both
        return found

    def _variances(self, used: Bool[np.ndarray, "M G"]) -> Float[np.ndarray, " G"]:
        return variances_of(used, self.angles, self.coverage.ring, self.noise)

    @cached_property
    def _everyone(self) -> float:
        """Mean variance [mm²] from all cameras."""
        return self._mean(self._variances(self.seen), slice(None))

    def _mean(self, variances: Float[np.ndarray, " G"], which) -> float:
        return float(np.average(variances[which], weights=self.weights[which]))

    def variance(self, pairs: Sequence[tuple[int, int]]) -> float:
        """Mean variance [mm²], points that no pair sees counting as very inaccurate."""
        return self._mean(np.minimum(self._variances(self._used(pairs)), UNSEEN**2 * self._everyone), slice(None))

    def suffice(self, pairs: Sequence[tuple[int, int]], within: float) -> bool:
        """Whether these pairs see enough, with at most so many times the error of all cameras."""
        used = self._used(pairs)
        which = self._reconstructed(pairs)
        if self.weights[which].sum() < KEPT * self.weights.sum():
            return False
        return self._mean(self._variances(used), which) <= within**2 * self._everyone
