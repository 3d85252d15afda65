"""Candidates on several rings: from what each ring does alone, and from anywhere, by moves on the samples alone."""

import numpy as np

from placement.rings.ring_places import Places, RingsSpace, distinct_places
from placement.rings.rings_coverage import RingsCoverage
from placement.samples.value import Value, less_error, value_of_one
from placement.search.accurate import N_PLACES, RESERVE, WINDOWS
from placement.settings import Settings

# Layouts with little error: how many good ones to start from, and how many are refined.
N_ACCURATE, N_REFINED = 6, 3


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


def accurate_rings(
    thin: RingsCoverage, coverage: RingsCoverage, starts: list[Places], give_up: float, settings: Settings
) -> list[Places]:
    """Distinct layouts with little error whose sampled coverage is within `give_up` of the first of the starts.

    As `accurate_layouts` on one ring: on few samples, `thin`, from place to place, and on all to refine the best.
    """
    if not np.isfinite(thin.measured(starts[0])[1]):
        return []

    def best_first(of: RingsCoverage, layouts: list[Places]) -> list[Places]:
        value = _value_of(of, starts[0], give_up)
        worth = [value_of_one(value, *of.measured(layout)) for layout in layouts]
        ordered = [layouts[i] for i in np.argsort(-np.array(worth), kind="stable")]
        return [ordered[i] for i in distinct_places(ordered, settings.distinct_tolerance)]

    value = _value_of(thin, starts[0], give_up)
    found = best_first(thin, [thin.improved(start, 3, value) for start in starts[:N_ACCURATE]])[:N_REFINED]
    value = _value_of(coverage, starts[0], give_up)
    for window in WINDOWS:
        found = [coverage.improved(one, 1, value, window * np.linspace(-1, 1, N_PLACES)) for one in found]
    return best_first(coverage, found)


def _value_of(coverage: RingsCoverage, first: Places, give_up: float) -> Value:
    # The same samples that are compared decide what the best of them is.
    return less_error(coverage.worth(first) - (1 - RESERVE) * give_up)


def ranked(coverage: RingsCoverage, layouts: list[Places], tolerance: float) -> list[Places]:
    """Best on the samples first, one of each group of nearly equal layouts."""
    best_first = sorted(layouts, key=lambda layout: -coverage.worth(layout))
    return [best_first[i] for i in distinct_places(best_first, tolerance)]


def feasible(space: RingsSpace, layouts: list[Places]) -> list[Places]:
    """Those that meet the constraints."""
    return [layout for layout in layouts if not space.violations(layout)]
