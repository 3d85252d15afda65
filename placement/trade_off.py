"""Area against accuracy: the layouts of which none has both more area and less error."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from placement.errors import PlacementError
from placement.layouts.arcs import LayoutSpace
from placement.layouts.distinct import canonical, distinct
from placement.progress import Progress, nothing
from placement.proof.certificate import certify_samples
from placement.samples.sampled_coverage import SampledCoverage
from placement.search.accurate import accurate_layouts, with_more_coverage
from placement.search.search import search
from placement.settings import Settings

if TYPE_CHECKING:
    from placement.problem import Problem

# Coverage given up, in parts of the ring maximum: layouts with the least error are looked for at each of these.
GIVEN_UP = (0.0005, 0.001, 0.002, 0.003, 0.005, 0.008, 0.012, 0.018, 0.025, 0.035, 0.05, 0.07, 0.1, 0.15, 0.25, 0.5)
# Random layouts that each of them starts from too, where a search has so many starts; else in proportion.
N_FRESH, OF_STARTS = 10, Settings.n_starts
# Further such searches where the curve found so far takes its widest steps.
N_FILLED = 6
# Layouts on each side along the curve from which more coverage is looked for at the error of one of them.
N_BESIDE = 2
# Leading layouts of the search, which have the most area.
N_SCORED = 3
# Layouts are scored exactly that others beat on the samples by no more than this, in area and in parts of the error.
SLACK = 0.001
# Layouts with which the search goes on for the next.
N_LAYOUTS = 6
# Opposite pairs to compare with, turned against each other in equal steps.
N_PAIR_LAYOUTS = 4
N_PHASES = 6


# What is looked at in the beginning: one in so many of the samples, cameras at these angles [rad], so many choices of
# all but one of them for each start of a search (all choices of three of four), and the best in each step of coverage.
THINNING, COARSE, CHOICES_PER_START, WORTH_STEP = 8, np.radians(10.0) * np.arange(36), 300, 0.002
# How many of those start a search, in the same proportion.
N_WITHIN = 10


class _Rough(NamedTuple):
    layout: np.ndarray
    worth: float
    error: float


@dataclass(frozen=True)
class TradedLayout:
    """A layout with its exact area and error.

    Attributes
    ----------
    angles : tuple of float
        Ring angles [rad], increasing in [0, 2 pi).
    kind : str
        "searched", "equidistant" or "opposite pairs".
    area : float
        Exact reconstructable area [mm²], summed over the sites.
    fraction : float
        The same as a fraction of the ring maximum.
    error_rms : float
        Root mean square of the predicted errors over it [mm].
    """

    angles: tuple[float, ...]
    kind: str
    area: float
    fraction: float
    error_rms: float


@dataclass(frozen=True)
class TradeOff:
    """What accuracy costs in area.

    Attributes
    ----------
    layouts : tuple of TradedLayout
        Those of which none has both more area and less error, greatest area first.
    compared : tuple of TradedLayout
        Equidistant rings at several phases and opposite pairs, where they are allowed.
    bound_fraction : float or None
        No layout reconstructs more of the samples; None without a certificate.
    """

    layouts: tuple[TradedLayout, ...]
    compared: tuple[TradedLayout, ...]
    bound_fraction: float | None

    @property
    def knee(self) -> TradedLayout:
        """The layout from which less error costs much area, and more area much accuracy.

        The one farthest from the straight line between the ends of the curve, with area and the logarithm of the error
        each scaled to 1 between them.

        Examples
        --------
        >>> three = [TradedLayout((0.0, 1.0), "searched", 1.0, *at) for at in ((0.9, 0.4), (0.89, 0.1), (0.8, 0.08))]
        >>> TradeOff(tuple(three), (), None).knee.fraction
        0.89
        """
        fraction = np.array([layout.fraction for layout in self.layouts])
        error = np.log([layout.error_rms for layout in self.layouts])
        below = np.zeros(len(fraction))
        for values in (fraction, -error):
            width = np.ptp(values)
            below += (values - values.min()) / width if width > 0 else 0.0
        return self.layouts[int(below.argmax())]

    @property
    def words(self) -> str:
        """What the knee says."""
        most, knee, least = self.layouts[0], self.knee, self.layouts[-1]
        if len(self.layouts) == 1:
            return "One layout has both the most area and the least error."
        words = []
        if knee is not most:
            words.append(
                f"Giving up {most.fraction - knee.fraction:.2%} of the ring maximum lessens the error from "
                f"{most.error_rms:.4f} to {knee.error_rms:.4f} mm"
            )
        if knee is not least:
            words.append(
                f"{'giving up another' if words else 'Giving up'} {knee.fraction - least.fraction:.2%} lessens it "
                f"{'only ' if words else ''}to {least.error_rms:.4f} mm"
            )
        return "; ".join(words) + "."


def trade(
    problem: "Problem",
    space: LayoutSpace,
    certify: bool = True,
    progress: Progress | None = None,
) -> TradeOff:
    """Trade area for accuracy within `space`; result and errors as for `placement.tradeoff`."""
    report = progress or nothing
    demand = problem.demanded(space.constraints, space.n_cameras)
    scorer, (coverage, _) = problem.scorer(space.constraints), problem.coverage(space.constraints)
    if space.n_cameras < 2 or demand.threshold < 2:
        raise PlacementError(
            f"{space.n_cameras} cameras of which {demand.threshold} must see a point triangulate nothing: errors take "
            "two; ask for more cameras, and a threshold of at least 2"
        )
    report("searching", 0, 1)
    pool, _, _ = search(problem, space)
    rng = np.random.default_rng([problem.seed, 4])
    searched: list[np.ndarray] = list(pool[:N_SCORED])
    broad = _broadly(coverage, space, rng, CHOICES_PER_START * problem.settings.n_starts)
    last: list[np.ndarray] = []
    n_fresh, n_within = (max(1, round(n * problem.settings.n_starts / OF_STARTS)) for n in (N_FRESH, N_WITHIN))
    for number in range(len(GIVEN_UP) + N_FILLED):
        report("trading area for accuracy", number, len(GIVEN_UP) + N_FILLED)
        # What gives up a little less is a good place to start from, after a search of its own for the first, but not
        # the only one.
        given_up, starts = GIVEN_UP[min(number, len(GIVEN_UP) - 1)], last
        if number >= len(GIVEN_UP):
            given_up, starts = _widest_step(coverage, searched, coverage.worth(pool[0]))
        if starts:
            fresh = [space.random(rng) for _ in range(n_fresh)]
            starts = [*starts, *fresh, *_within(broad, coverage.worth(pool[0]) - given_up)[:n_within]]
        last = accurate_layouts(problem, space, pool, given_up, starts)[:N_LAYOUTS]
        searched += last
    compared = [(kind, layout) for kind, layout in compared_layouts(space) if space.allows(layout)]
    searched += _raised(coverage, space, [*searched, *(layout for _, layout in compared)])
    report("trading area for accuracy", 1, 1)
    found = [("searched", searched[i]) for i in _leading(coverage, searched)]
    layouts = found + compared
    bound = None
    if certify:
        report("bounding any layout", 0, 1)
        settings, of = problem.settings, problem.sites.of
        bound = certify_samples(problem.profiles, space, demand, settings, of, pool[:N_SCORED]).bound_fraction
    ranked = sorted(range(len(layouts)), key=lambda i: -coverage.worth(layouts[i][1]))
    kept = [ranked[i] for i in distinct([layouts[i][1] for i in ranked], problem.settings.distinct_tolerance)]
    angles = [canonical(layouts[i][1]) for i in kept]
    scorer.with_progress(angles, report)
    report("errors", 0, 1)
    errors = scorer.errors(angles)
    traded = []
    for i, theta, error in zip(kept, angles, errors, strict=True):
        areas = scorer.areas(theta)
        traded.append(
            TradedLayout(tuple(theta.tolist()), layouts[i][0], float(sum(areas)), scorer.combined(areas), error)
        )
    report("errors", 1, 1)
    return TradeOff(
        undominated([one for one in traded if np.isfinite(one.error_rms)]),
        tuple(one for one in traded if one.kind != "searched"),
        bound,
    )


def _broadly(coverage: SampledCoverage, space: LayoutSpace, rng: np.random.Generator, most: int) -> list[_Rough]:
    """The least error among very many layouts, for each of some amounts of coverage, on few of the samples.

    All cameras but one at multiples of a coarse step, all such choices or `most` at random, and the one anywhere.
    """
    thin = SampledCoverage(coverage.profiles.thinned(THINNING), coverage.demand, coverage.ring, len(coverage.grid))
    n_free, fixed = space.n_free, np.array(space.constraints.fixed)
    if n_free < 1:
        return []
    places = np.flatnonzero(space.allowed(COARSE, fixed))
    choices: list = []
    if math.comb(len(places), n_free - 1) <= most:
        choices = list(itertools.combinations(places.tolist(), n_free - 1))
    elif len(places) >= n_free:
        choices = [rng.choice(places, n_free - 1, replace=False) for _ in range(most)]
    best: dict[int, _Rough] = {}
    for chosen in choices:
        others = np.concatenate([COARSE[list(chosen)], fixed])
        worths, errors = thin.measured_with_one_more(others)
        errors = np.where(space.allowed(thin.pair_grid, others), errors, np.inf)
        steps = np.floor(worths / WORTH_STEP).astype(int)
        for step in np.unique(steps):
            at = np.flatnonzero(steps == step)[errors[steps == step].argmin()]
            if errors[at] < (best[step].error if step in best else np.inf):
                layout = np.append(others, thin.pair_grid[at])
                if space.allows(layout):
                    best[step] = _Rough(layout, float(worths[at]), float(errors[at]))
    return list(best.values())


def _within(broad: list[_Rough], least: float) -> list[np.ndarray]:
    """Of those with about that coverage or more, the ones with the least error."""
    within = [one for one in broad if one.worth > least - WORTH_STEP]
    return [one.layout for one in sorted(within, key=lambda one: one.error)]


def _leading(coverage: SampledCoverage, layouts: Sequence[np.ndarray]) -> list[int]:
    """Those that on the samples no other beats clearly both in area and error, greatest area first."""
    worth = np.array([coverage.worth(layout) for layout in layouts])
    error = np.array([coverage.error(layout) for layout in layouts])
    order = np.argsort(-worth, kind="stable").tolist()
    return [i for i in order if not ((worth > worth[i] + SLACK) & (error < error[i] * (1 - SLACK))).any()]


def _raised(coverage: SampledCoverage, space: LayoutSpace, layouts: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Layouts with the errors of those of the curve and more coverage, where there are any."""
    curve = [layouts[i] for i in _leading(coverage, layouts)]
    errors = [coverage.error(layout) for layout in curve]
    raised = [
        with_more_coverage(coverage, space, error, curve[max(at - N_BESIDE, 0) : at + N_BESIDE + 1])
        for at, error in enumerate(errors)
        if np.isfinite(error)
    ]
    return [layout for layout in raised if layout is not None]


def _widest_step(
    coverage: SampledCoverage, layouts: Sequence[np.ndarray], most: float
) -> tuple[float, list[np.ndarray]]:
    """What to give up of the greatest coverage to end between two layouts of the curve, and those to start from."""
    curve = [layouts[i] for i in _leading(coverage, layouts)]
    worth = np.array([coverage.worth(layout) for layout in curve])
    error = np.log([coverage.error(layout) for layout in curve])
    steps = (worth[:-1] - worth[1:]) * np.maximum(error[:-1] - error[1:], 0.0)
    at = int(steps.argmax()) if len(steps) else 0
    middle = float(worth[at : at + 2].mean())
    return max(most - middle, 0.0), curve[max(at - 2, 0) : at + 4]


def compared_layouts(space: LayoutSpace) -> list[tuple[str, np.ndarray]]:
    """Equidistant rings at phases, and opposite pairs turned against each other, with any camera over at angle 0."""
    n = space.n_cameras
    even = [space.ring.equidistant(n, phase) for phase in 2 * np.pi / n * np.arange(N_PHASES) / N_PHASES]
    pairs = []
    for first in np.pi * np.arange(N_PAIR_LAYOUTS) / N_PAIR_LAYOUTS:
        for turn in np.pi / (n // 2) * np.arange(1, N_PAIR_LAYOUTS) / N_PAIR_LAYOUTS if n > 3 else (0.0,):
            half = first + turn * np.arange(n // 2)
            pairs.append(np.concatenate([half, half + np.pi, np.zeros(n % 2)]))
    return [("equidistant", layout) for layout in even] + [("opposite pairs", layout) for layout in pairs]


def undominated(layouts: Sequence[TradedLayout]) -> tuple[TradedLayout, ...]:
    """Layouts of which none has both more area and less error, greatest area first.

    Examples
    --------
    >>> three = [TradedLayout((0.0, 1.0), "searched", 1.0, *at) for at in ((0.8, 0.1), (0.9, 0.2), (0.7, 0.3))]
    >>> [layout.fraction for layout in undominated(three)]
    [0.9, 0.8]
    """
    best, least = [], np.inf
    for layout in sorted(layouts, key=lambda one: (-one.fraction, one.error_rms)):
        if layout.error_rms < least:
            best.append(layout)
            least = layout.error_rms
    return tuple(best)
