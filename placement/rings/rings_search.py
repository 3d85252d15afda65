"""Candidates on several rings: from what each ring does alone, and from anywhere, by moves on the samples alone."""

import numpy as np

from placement.rings.ring_places import Places, RingsSpace, distinct_places
from placement.rings.rings_coverage import RingsCoverage
from placement.search.accurate import PENALTY, RESERVE
from placement.settings import Settings

# Layouts with little error: how many good ones to start from.
N_ACCURATE = 6


def rings_search(
    coverage: RingsCoverage, known: list[Places], settings: Settings, seed: int
) -> tuple[list[Places], int]:
    """Distinct layouts, the one that reconstructs most of the samples first, and how many starts there were.

    `known` are good layouts to start from, beside random ones.
    """
    rng = np.random.default_rng([seed, 7])
    drawn = [coverage.space.random(rng) for _ in range(settings.n_starts)]
    starts = [*known, *(one for one in drawn if one is not None)]
    found = ranked(coverage, [coverage.improved(start) for start in starts], settings.distinct_tolerance)
    more = [coverage.improved_by_pairs(layout) for layout in found[: settings.n_pair_searches]]
    return ranked(coverage, more + found, settings.distinct_tolerance), len(starts)


def accurate_rings(coverage: RingsCoverage, starts: list[Places], give_up: float, settings: Settings) -> list[Places]:
    """Distinct layouts with little error whose sampled coverage is within `give_up` of the first of the starts.

    As `accurate_layouts` on one ring.
    """
    worth, error = coverage.measured(starts[0])
    if not np.isfinite(error):
        return []
    least = worth - (1 - RESERVE) * give_up

    def value(worth: np.ndarray, error: np.ndarray) -> np.ndarray:
        with np.errstate(divide="ignore"):
            return np.asarray(-np.log(error) - PENALTY * np.maximum(least - worth, 0.0))

    def worth_of(layout: Places) -> float:
        worth, error = coverage.measured(layout)
        return float(value(np.array([worth]), np.array([error]))[0])

    found = [coverage.improved(start, 3, value) for start in starts[:N_ACCURATE]]
    found.sort(key=worth_of, reverse=True)
    return [found[i] for i in distinct_places(found, settings.distinct_tolerance)]


def ranked(coverage: RingsCoverage, layouts: list[Places], tolerance: float) -> list[Places]:
    """Best on the samples first, one of each group of nearly equal layouts."""
    best_first = sorted(layouts, key=lambda layout: -coverage.worth(layout))
    return [best_first[i] for i in distinct_places(best_first, tolerance)]


def feasible(space: RingsSpace, layouts: list[Places]) -> list[Places]:
    """Those that meet the constraints."""
    return [layout for layout in layouts if not space.violations(layout)]
