"""Layouts that give no accuracy away: of those with about the greatest coverage, the ones with the least error.

Where cameras sit decides on the error of a point by the sum of their squared distances from their centre alone, and any
set of opposite pairs makes that as large as it can be. So there is much to choose from without losing accuracy, and
layouts with opposite pairs, equidistant or not, are good places to start from.
"""

from typing import TYPE_CHECKING

import numpy as np

from placement.layouts.arcs import LayoutSpace
from placement.layouts.distinct import distinct
from placement.samples.sampled_coverage import SampledCoverage
from placement.samples.value import Value, less_error, more_coverage, value_of_one

if TYPE_CHECKING:
    from placement.problem import Problem

# Starts of each kind: the leading layouts of the search, equidistant ones, and opposite pairs at random.
N_LEADING, N_EVEN, N_PAIRS = 6, 6, 12
# One in so many of the samples is enough to compare layouts by, and all of them for the best of these.
THINNING, N_REFINED = 4, 6
# What of the coverage that may be given up the search keeps as a reserve: samples are not exact.
RESERVE = 0.2
# Windows around each camera in which its place is refined [rad], and places in each.
WINDOWS, N_PLACES = (np.radians(4.0), np.radians(1.0)), 9


def accurate_layouts(
    problem: "Problem",
    space: LayoutSpace,
    pool: list[np.ndarray],
    give_up: float,
    starts: list[np.ndarray] | None = None,
) -> list[np.ndarray]:
    """Distinct layouts with little error whose sampled coverage is within `give_up` of the first of the pool.

    `starts` stand for layouts of the pool, equidistant ones and opposite pairs. Empty where errors do not depend on the
    layout, as those of a single camera.
    """
    coverage, _ = problem.coverage(space.constraints)
    if space.n_free == 0 or not np.isfinite(coverage.error(pool[0])):
        return []
    thin = SampledCoverage(coverage.profiles.thinned(THINNING), coverage.demand, coverage.ring, len(coverage.grid))
    # The same samples that are compared decide what the best of them is.
    thin_value, value = (less_error(one.worth(pool[0]) - (1 - RESERVE) * give_up) for one in (thin, coverage))
    starts = starts or _starts(problem, space, pool)
    found = [_improved(thin, space, start, thin_value) for start in starts]
    found.sort(key=lambda layout: -_valued(thin, layout, thin_value))
    leading = [found[i] for i in distinct(found, problem.settings.distinct_tolerance)][:N_REFINED]
    refined = [_refined(coverage, space, layout, value) for layout in leading]
    refined.sort(key=lambda layout: -_valued(coverage, layout, value))
    return [refined[i] for i in distinct(refined, problem.settings.distinct_tolerance)]


def with_more_coverage(
    coverage: SampledCoverage, space: LayoutSpace, greatest_error: float, starts: list[np.ndarray]
) -> np.ndarray | None:
    """The layout with the most sampled coverage that moves of single cameras lead to, with no more error [mm].

    None where no start leads to one with so little error.
    """
    value, best = more_coverage(greatest_error), None
    for start in starts:
        end = _refined(coverage, space, _improved(coverage, space, start, value), value)
        if coverage.error(end) <= greatest_error and (best is None or coverage.worth(end) > coverage.worth(best)):
            best = end
    return best


def _valued(coverage: SampledCoverage, angles, value: Value) -> float:
    return value_of_one(value, coverage.worth(angles), coverage.error(angles))


def _improved(coverage: SampledCoverage, space: LayoutSpace, angles, value: Value, max_sweeps: int = 3) -> np.ndarray:
    """Move one free camera at a time to its best place on the coarse grid until no move gains anything."""
    return _moved(coverage, space, angles, value, max_sweeps, lambda angle: None)


def _refined(coverage: SampledCoverage, space: LayoutSpace, angles, value: Value) -> np.ndarray:
    for window in WINDOWS:
        offsets = window * np.linspace(-1, 1, N_PLACES)
        angles = _moved(coverage, space, angles, value, 1, lambda angle, offsets=offsets: angle + offsets)
    return angles


def _moved(coverage: SampledCoverage, space: LayoutSpace, angles, value: Value, max_sweeps: int, places) -> np.ndarray:
    theta = np.array(angles, dtype=np.float64)
    best = _valued(coverage, theta, value)
    for _ in range(max_sweeps):
        before = best
        for camera in space.free_cameras(theta):
            others, grid = np.delete(theta, camera), places(theta[camera])
            values = value(*coverage.measured_with_one_more(others, grid))
            grid = coverage.pair_grid if grid is None else grid
            values[~space.allowed(grid, others)] = -np.inf
            at = int(values.argmax())
            if values[at] > best + 1e-9:
                theta[camera], best = grid[at], values[at]
        if best <= before + 1e-9:
            break
    return theta


def _starts(problem: "Problem", space: LayoutSpace, pool: list[np.ndarray]) -> list[np.ndarray]:
    """Leading layouts, equidistant ones, and opposite pairs with any that are over at random; all allowed."""
    rng = np.random.default_rng([problem.seed, 3])
    n = space.n_cameras
    starts = list(pool[:N_LEADING])
    starts += [space.ring.equidistant(n, phase) for phase in 2 * np.pi / n * np.arange(N_EVEN) / N_EVEN]
    for _ in range(N_PAIRS):
        half = rng.uniform(0, 2 * np.pi, n // 2)
        starts.append(np.concatenate([half, half + np.pi, rng.uniform(0, 2 * np.pi, n % 2)]))
    return [start for start in starts if space.allows(start)]
