"""Candidates: soft descent from many starts, then moves of one and two cameras on the samples; the distinct ends."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from placement.layouts.arcs import LayoutSpace
from placement.layouts.distinct import distinct
from placement.layouts.layout_parameters import Arcs
from placement.settings import Settings
from placement.surrogate.surrogate import Surrogate

if TYPE_CHECKING:
    from placement.problem import Problem
    from placement.surrogate.descent import DescentEnd

# Layouts found without those that are known to start from.
N_ALONE = 2


def import_descent() -> None:
    """Import what a search needs, JAX with it: a second or two that may pass in a thread, beside other work."""
    import placement.surrogate.descent  # noqa: F401


def search(
    problem: "Problem", space: LayoutSpace, known: Sequence[np.ndarray] = ()
) -> tuple[list[np.ndarray], list[np.ndarray], dict[str, int]]:
    """Distinct layouts, the one that reconstructs most of the samples first, and counts of what happened.

    `known` are layouts to start from beside those of the settings. The best found without them come by themselves too:
    layouts with one camera more than a good one, wherever it sits, would leave no room for any other.
    """
    problem.ring_maximum.begin()  # other processes are at it while this one searches
    if space.n_free == 0:
        return [np.array(space.constraints.fixed)], [], dict(n_starts=0, n_failed=0, n_flat=0, n_distinct=1)
    settings, (coverage, surrogate) = problem.settings, problem.coverage(space.constraints)
    rng = np.random.default_rng([problem.seed, 1])
    starts = _starts(problem, space, rng)
    ends = _descended(starts, surrogate, space, settings)
    lost = ends.flat | ends.failed
    n_flat, n_failed = int(ends.flat.sum()), int(ends.failed.sum())
    if lost.any() and not lost.all():
        # Once more from elsewhere; all together, since a batch of another size would be compiled anew.
        starts = [space.random(rng) if anew else start for start, anew in zip(starts, lost, strict=True)]
        ends = _descended(starts, surrogate, space, settings)
    usable = [end for end, failed in zip(ends.angles, ends.failed, strict=True) if not failed and space.allows(end)]
    # From the starts too: where the soft landscape leads all starts past an optimum, moving one camera may find it.
    alone = usable + [coverage.improve(space, layout) for layout in (*usable, *starts)]
    found = alone + [coverage.improve(space, layout) for layout in known]
    leading = _distinct(found, problem, space)[: settings.n_pair_searches]
    found += [coverage.improve_pairs(space, layout) for layout in leading]
    kept = _distinct(found, problem, space)
    counts = dict(n_starts=len(starts), n_failed=n_failed, n_flat=n_flat, n_distinct=len(kept))
    if not known:
        return kept, [], counts
    best = max(alone, key=coverage.worth)
    return kept, _distinct([*alone, coverage.improve_pairs(space, best)], problem, space)[:N_ALONE], counts


def _descended(starts: list[np.ndarray], surrogate: Surrogate, space: LayoutSpace, settings: Settings) -> "DescentEnd":
    from placement.surrogate.descent import descend  # JAX takes a second to import, and what does not search needs none

    parameters, arcs = zip(*(space.parameters(start) for start in starts), strict=True)
    stacked = None
    if not space.is_whole:
        stacked = Arcs(*(np.stack([getattr(a, name) for a in arcs]) for name in Arcs._fields))
    return descend(
        np.stack(parameters),
        stacked,
        surrogate,
        minimum_gap=space.minimum_gap,
        temperatures=settings.temperatures,
        max_steps=settings.max_steps,
    )


def _distinct(layouts: list[np.ndarray], problem: "Problem", space: LayoutSpace) -> list[np.ndarray]:
    """Best on the samples first, one of each group of nearly equal layouts."""
    coverage, _ = problem.coverage(space.constraints)
    ranked = sorted(layouts, key=lambda layout: -coverage.worth(layout))
    return [ranked[i] for i in distinct(ranked, problem.settings.distinct_tolerance)]


def _starts(problem: "Problem", space: LayoutSpace, rng: np.random.Generator) -> list[np.ndarray]:
    """Equidistant layouts at several phases where they are allowed, then random ones."""
    settings = problem.settings
    phases = 2 * np.pi / space.n_cameras * np.arange(settings.n_start_phases) / max(settings.n_start_phases, 1)
    even = [space.ring.equidistant(space.n_cameras, phase) for phase in phases]
    starts = [layout for layout in even if space.allows(layout)][: settings.n_starts]
    return starts + [space.random(rng) for _ in range(settings.n_starts - len(starts))]
