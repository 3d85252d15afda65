"""Propose a layout: search on samples from many starts, score the distinct ends exactly, polish the best."""

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from placement.errors import PlacementError
from placement.layouts.arcs import LayoutSpace
from placement.layouts.distinct import canonical, distinct
from placement.progress import Progress, nothing
from placement.proof.certificate import Certificate
from placement.proof.surface import certified, measured
from placement.results import Candidate, Placement, SearchRecord, SiteResult, library_versions
from placement.samples.sampled_coverage import SampledCoverage
from placement.search.accurate import accurate_layouts
from placement.search.equidistant import compared_phases
from placement.search.extended import checked_starts, extended
from placement.search.polish import Slopes, polish, polish_several
from placement.search.scoring import ExactScorer
from placement.search.search import search
from placement.search.steps import polish_by_steps

if TYPE_CHECKING:
    from placement.problem import Problem

# Coverage that may be given up for accuracy, in parts of the ring maximum.
GIVE_UP = 0.005


def bound(problem: "Problem", space: LayoutSpace, layout=None) -> Certificate:
    """Bound what any layout of `space` can reconstruct, and the gap of `layout`, (M,) ring angles [rad], if given.

    Raises
    ------
    PlacementError
        If the request cannot be met, or `layout` is none that it bounds.
    """
    demand = problem.demanded(space.constraints, space.n_cameras)
    if layout is not None:
        _refuse_other(space, layout)
    certificate = certified(problem, space, demand, () if layout is None else (np.array(layout, dtype=np.float64),))
    return certificate if layout is None else measured(problem, certificate, space, layout, demand)


def _refuse_other(space: LayoutSpace, layout) -> None:
    """Refuse a layout that the bounds of `space` say nothing about."""
    theta = np.asarray(layout, dtype=np.float64)
    if theta.shape != (space.n_cameras,) or not np.isfinite(theta).all():
        raise PlacementError(
            f"layout is {layout!r}; the bound is for {space.n_cameras} cameras: give as many finite ring angles [rad], "
            f"or ask for n_cameras={theta.size}"
        )
    if broken := space.constraints.violations(space.ring, theta):
        raise PlacementError(
            f"the bound is for layouts that meet the constraints, and {broken[0]}; change the layout or the constraints"
        )


def propose(
    problem: "Problem",
    space: LayoutSpace,
    certify: bool = True,
    progress: Progress | None = None,
    give_up: float = GIVE_UP,
    target: float = 0.0,
    starts: Sequence = (),
) -> Placement:
    """Find the best layout of `space` for a `Problem`; result and errors as for `placement.optimise`.

    Of what reaches `target`, a fraction of the ring maximum, no more is given up than leaves it reached; if nothing
    does, nothing is given up.
    """
    if not (isinstance(give_up, int | float | np.number) and 0 <= give_up < 1):
        raise PlacementError(f"give_up is {give_up!r}; it must be at least 0 and below 1, a part of the ring maximum")
    starts = checked_starts(starts, space.n_cameras)
    report = progress or nothing
    settings, ring = problem.settings, problem.ring
    demand = problem.demanded(space.constraints, space.n_cameras)
    scorer, (coverage, surrogate) = problem.scorer(space.constraints), problem.coverage(space.constraints)
    clock = _Clock()

    report("searching", 0, 1)
    known = extended(problem, space, starts)
    pool, alone, counts = search(problem, space, known)
    layouts = [("search", layout) for layout in (*pool[: settings.exact_candidates], *alone)]
    layouts += [("start", layout) for layout in known]
    clock.lap("search")
    if give_up > 0:
        report("searching accurate layouts", 0, 1)
        accurate = accurate_layouts(problem, space, pool, give_up)[: settings.exact_candidates]
        layouts += [("accuracy", layout) for layout in accurate]
        clock.lap("accuracy")

    certificate = None
    if certify:
        report("bounding any layout", 0, 1)
        certificate = certified(problem, space, demand, pool[: settings.exact_candidates])
        on_surface = None if certificate.surface is None else certificate.surface.angles
        for angles in (certificate.grid_angles, on_surface):
            if angles is not None and space.allows(angles):
                layouts.append(("certificate", np.array(angles)))
        clock.lap("certificate")

    phases = compared_phases(problem, space)
    even = [ring.equidistant(space.n_cameras, phase) for phase in phases]
    layouts += [("equidistant", layout) for layout in even if space.allows(layout)]
    to_score = [layout for _, layout in layouts] + even
    n_exact = len({canonical(layout).tobytes() for layout in to_score})
    scorer.with_progress(to_score, report)
    clock.lap("scoring")
    report("ring maximum", 0, 1)
    _ = scorer.ring_areas
    clock.lap("ring maximum")

    def candidate(angles, origin: str) -> Candidate:
        theta = canonical(angles)
        return Candidate(
            tuple(theta.tolist()), origin, surrogate.at(theta, settings.temperatures[-1]), coverage.fraction(theta),
            scorer.fraction(theta), scorer.areas(theta),
        )  # fmt: skip

    scored = sorted((candidate(angles, origin) for origin, angles in layouts), key=lambda found: -found.fraction)
    scored = list({found.angles: found for found in reversed(scored)}.values())[::-1]
    n_moves = 0
    if settings.polish_steps and space.n_free:
        leading = [np.array(found.angles) for found in scored]
        ends, n_moves = _polished(problem, space, scorer, leading, alone, report)
        n_exact += len(ends)
        scored += [candidate(end, "polish") for end in ends]
        scored = list({found.angles: found for found in sorted(scored, key=lambda found: -found.fraction)}.values())
    clock.lap("polish")
    report("polishing", 2, 2)

    best = max(range(len(even)), key=lambda i: scorer.fraction(even[i]))
    least = least_proposed(
        scored[0].fraction, give_up, target, [scorer.fraction(one) for one in even if space.allows(one)]
    )
    proposed = _most_accurate(scored, coverage, least)
    compared = [proposed.angles, scored[0].angles, even[0], even[best]]
    errors = scorer.errors(compared) if space.n_cameras > 1 else [np.inf] * len(compared)
    if errors[1] < errors[0]:  # samples are not exact
        proposed, errors[0] = scored[0], errors[1]
    clock.lap("errors")
    areas = zip(proposed.areas, scorer.areas(even[0]), scorer.areas(even[best]), scorer.ring_areas, strict=True)
    sites = tuple(
        SiteResult(
            *four_areas, site.share, site.scene.mesh_hash, int((~site.scene.counted).sum()), site.scene.is_weighted
        )
        for site, four_areas in zip(problem.sites.members, areas, strict=True)
    )
    return Placement(
        angles=proposed.angles,
        fraction=proposed.fraction,
        error_rms=errors[0],
        most_area_error_rms=errors[1],
        equidistant_error_rms=errors[2],
        best_equidistant_error_rms=errors[3],
        equidistant_fraction=scorer.fraction(even[0]),
        best_equidistant_fraction=scorer.fraction(even[best]),
        best_equidistant_phase=phases[best],
        sites=sites,
        objective=problem.sites.objective,
        candidates=tuple(scored),
        certificate=None if certificate is None else measured(problem, certificate, space, proposed.angles, demand),
        search=SearchRecord(**counts, n_exact=n_exact, n_moves=n_moves, seconds=clock.seconds),
        ring=ring,
        n_cameras=space.n_cameras,
        demand=demand,
        give_up=float(give_up),
        constraints=space.constraints,
        starts=starts,
        settings=settings,
        seed=problem.seed,
        versions=library_versions(),
    )


def _polished(
    problem: "Problem",
    space: LayoutSpace,
    scorer: ExactScorer,
    layouts: list[np.ndarray],
    alone: list[np.ndarray],
    report: Progress,
) -> tuple[list[np.ndarray], int]:
    """Local optima of the exact area from the leading of some layouts, best first; also the places tried.

    Known layouts have been polished before, and others would not stand up to them: of those found `alone` the best is
    polished too.
    """
    settings, demand = problem.settings, scorer.demand
    leading = [layouts[i] for i in distinct(layouts, settings.distinct_tolerance)][: settings.polish_candidates]
    if alone:
        both = [*leading, max(alone, key=scorer.fraction)]
        leading = [both[i] for i in distinct(both, settings.distinct_tolerance)]
    report("polishing", 0, 2)
    if not demand.has_derivative:
        end, n_moves = polish_by_steps(scorer, space, leading[0], settings.polish_steps, settings.polish_sweeps)
        return [end], n_moves
    slopes = Slopes.of(problem.sites, problem.ring, demand, scorer.ring_areas)
    found = polish_several(slopes, space, leading, settings.polish_sweeps, problem.workers)
    n_moves, ends = sum(n for _, n in found), [end for end, _ in found]
    report("polishing", 1, 2)
    best = max(ends, key=scorer.fraction)
    end, n = polish(slopes, space, best, settings.polish_sweeps, thorough=True)
    return [end, *ends], n_moves + n


def least_proposed(best: float, give_up: float, target: float, equidistant: Sequence[float]) -> float:
    """The least fraction that is proposed for the sake of accuracy, never less than equidistant layouts have.

    Examples
    --------
    >>> least_proposed(0.97, 0.01, 0.0, [0.95]), least_proposed(0.97, 0.01, 0.965, [0.95])
    (0.96, 0.965)
    >>> least_proposed(0.97, 0.01, 0.98, []), least_proposed(0.97, 0.05, 0.0, [0.94, 0.95])
    (0.97, 0.95)
    """
    return max(best - give_up, min(target, best), *equidistant)


def _most_accurate(scored: list[Candidate], coverage: SampledCoverage, least: float) -> Candidate:
    """Of the layouts with at least that fraction, the one with the least error; best first, as `scored` are."""
    if least >= scored[0].fraction:
        return scored[0]
    return min((found for found in scored if found.fraction >= least), key=lambda found: coverage.error(found.angles))


class _Clock:
    """Seconds spent on each part, in order."""

    def __init__(self):
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, name: str) -> None:
        now = time.perf_counter()
        self.seconds[name] = round(now - self._last, 3)
        self._last = now
