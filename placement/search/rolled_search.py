"""Candidates with free rolls: from layouts without, and from anywhere, by moves on the samples alone.

A camera has one grid of places and rolls, whose views cost no more rays than its places alone. So single moves, and
those of two cameras at once, look at all of it, and no gradient is needed.
"""

from typing import TYPE_CHECKING

import numpy as np

from placement.layouts.arcs import LayoutSpace
from placement.layouts.distinct import distinct
from placement.samples.rolled_samples import canonical_rolled
from placement.samples.value import Value, less_error, value_of_one
from placement.search.accurate import RESERVE
from placement.search.rolled_coverage import RolledCoverage, RolledLayout

if TYPE_CHECKING:
    from placement.problem import Problem

# Leading layouts of radial sensors from which it starts, beside others.
N_RADIAL = 8
# Windows of angle and roll around each camera in which its place is refined [rad], and steps in each.
WINDOWS = ((np.radians(4.0), np.radians(6.0)), (np.radians(1.0), np.radians(1.5)))
N_STEPS = 5
# Of layouts that give no accuracy away: starts of equidistant rings and of opposite pairs, thinning of the samples to
# compare them by, grid to move on, and how many are refined.
N_EVEN, N_PAIRS, THINNING, N_REFINED = 4, 8, 4, 3
N_ACCURATE_ANGLES, N_ACCURATE_ROLLS = 36, 12


def rolled_search(
    problem: "Problem", space: LayoutSpace, coverage: RolledCoverage, radial: list[np.ndarray]
) -> list[RolledLayout]:
    """Distinct layouts, the one that reconstructs most of the samples first; `radial` are good ones without rolls."""
    rng, settings = np.random.default_rng([problem.seed, 5]), problem.settings
    starts = [RolledLayout(layout, np.zeros(len(layout))) for layout in radial[:N_RADIAL]]
    for _ in range(settings.n_starts):
        angles = space.random(rng)
        starts.append(RolledLayout(angles, rng.uniform(0, np.pi, len(angles))))
    found = ranked(coverage, [coverage.improved(space, start) for start in starts], settings.distinct_tolerance)
    more = [coverage.improved_by_pairs(space, layout) for layout in found[: settings.n_pair_searches]]
    found = ranked(coverage, found + more, settings.distinct_tolerance)
    refined = [_refined(coverage, space, layout) for layout in found[:N_REFINED]]
    return ranked(coverage, refined + found, settings.distinct_tolerance)


def accurate_rolled(
    problem: "Problem", space: LayoutSpace, coverage: RolledCoverage, pool: list[RolledLayout], give_up: float
) -> list[RolledLayout]:
    """Distinct layouts with little error whose sampled coverage is within `give_up` of the first of the pool.

    As `accurate_layouts` without rolls.
    """
    if not np.isfinite(coverage.error(pool[0])):
        return []
    rng, n = np.random.default_rng([problem.seed, 6]), space.n_cameras
    thin = RolledCoverage(coverage.samples.thinned(THINNING), coverage.demand, N_ACCURATE_ANGLES, N_ACCURATE_ROLLS)
    angles = [space.ring.equidistant(n, phase) for phase in 2 * np.pi / n * np.arange(N_EVEN) / N_EVEN]
    for _ in range(N_PAIRS):
        half = rng.uniform(0, 2 * np.pi, n // 2)
        angles.append(np.concatenate([half, half + np.pi, rng.uniform(0, 2 * np.pi, n % 2)]))
    starts = pool[:N_EVEN] + [RolledLayout(one, np.zeros(n)) for one in angles if space.allows(one)]

    # The same samples that are compared decide what the best of them is.
    thin_value, value = (less_error(one.worth(pool[0]) - (1 - RESERVE) * give_up) for one in (thin, coverage))
    found = [thin.improved(space, start, 3, thin_value) for start in starts]
    found.sort(key=lambda layout: -_valued(thin, layout, thin_value))
    leading = [found[i] for i in _distinct(found, problem.settings.distinct_tolerance)][:N_REFINED]
    refined = [_refined(coverage, space, layout, value) for layout in leading]
    return [refined[i] for i in _distinct(refined, problem.settings.distinct_tolerance)]


def ranked(coverage: RolledCoverage, layouts: list[RolledLayout], tolerance: float) -> list[RolledLayout]:
    """Best on the samples first, one of each group of nearly equal layouts."""
    best_first = sorted(layouts, key=lambda layout: -coverage.worth(layout))
    return [best_first[i] for i in _distinct(best_first, tolerance)]


def _distinct(layouts: list[RolledLayout], tolerance: float) -> list[int]:
    """Indices of layouts of which no other before differs by no more, in angle or roll [rad].

    Rolls are told apart on a circle of half a turn, as if their doubles were ring angles beyond those of the cameras.
    """
    kept: list[int] = []
    whole = [canonical_rolled(*layout) for layout in layouts]
    for i, (angles, rolls) in enumerate(whole):
        same = False
        for j in kept:
            if distinct([whole[j][0], angles], tolerance) == [0]:
                away = np.abs(np.sin(rolls - whole[j][1])).max()
                same = same or bool(away <= np.sin(tolerance))
        if not same:
            kept.append(i)
    return kept


def _refined(
    coverage: RolledCoverage, space: LayoutSpace, layout: RolledLayout, value: Value | None = None
) -> RolledLayout:
    for angle, roll in WINDOWS:
        steps = np.linspace(-1, 1, N_STEPS)
        layout = coverage.improved(space, layout, 1, value, (angle * steps, roll * steps))
    return layout


def _valued(coverage: RolledCoverage, layout: RolledLayout, value: Value) -> float:
    return value_of_one(value, coverage.worth(layout), coverage.error(layout))
