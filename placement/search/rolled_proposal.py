"""Propose a layout; where rolls are free, one whose cameras each have their own, beside those that are radial."""

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from placement.layouts.arcs import LayoutSpace
from placement.progress import Progress, nothing
from placement.results import Candidate, Placement
from placement.samples.rolled_samples import RolledSamples, canonical_rolled
from placement.search.proposal import GIVE_UP, least_proposed, propose
from placement.search.rolled_coverage import RolledCoverage, RolledLayout
from placement.search.rolled_scoring import RolledScorer
from placement.search.rolled_search import accurate_rolled, rolled_search

if TYPE_CHECKING:
    from placement.problem import Problem


def propose_layout(
    problem: "Problem",
    space: LayoutSpace,
    certify: bool = True,
    progress: Progress | None = None,
    give_up: float = GIVE_UP,
    target: float = 0.0,
    starts: Sequence = (),
) -> Placement:
    """`propose`; with free rolls from there on with rolls, without a certificate; `starts` are radial."""
    if problem.ring.roll != "free":
        return propose(problem, space, certify, progress, give_up, target, starts)
    radial = propose(problem, space, False, progress, give_up, target, starts)
    begun, report, settings = time.perf_counter(), progress or nothing, problem.settings
    report("searching rolls", 0, 1)
    coverage = RolledCoverage(
        RolledSamples.of(problem.sampled, problem.sites, problem.ring, radial.demand), radial.demand
    )
    pool = rolled_search(problem, space, coverage, [np.array(found.angles) for found in radial.candidates])
    layouts = [("search", layout) for layout in pool[: settings.exact_candidates]]
    if give_up > 0:
        report("searching accurate layouts", 0, 1)
        layouts += [("accuracy", layout) for layout in accurate_rolled(problem, space, coverage, pool, give_up)]
    scorer = RolledScorer(problem.scorer(space.constraints), problem.workers)
    report("scoring exactly", 0, 1)
    scorer.many([layout for _, layout in layouts])

    def candidate(layout: RolledLayout, origin: str) -> Candidate:
        angles, rolls = (tuple(values.tolist()) for values in canonical_rolled(*layout))
        sampled = coverage.fraction(layout)
        return Candidate(
            angles, origin, sampled, sampled, scorer.fraction(layout), scorer.many([layout])[0], rolls
        )  # fmt: skip

    scored = [candidate(layout, origin) for origin, layout in layouts]
    scored += [replace(found, rolls=(0.0,) * space.n_cameras) for found in radial.candidates]
    scored.sort(key=lambda found: -found.fraction)
    n_moves, n_exact = 0, len(layouts)
    if settings.polish_steps:
        report("polishing", 0, 1)
        polished, n_moves = scorer.polished(space, _layout(scored[0]), settings.polish_steps, settings.polish_sweeps)
        n_exact += 1
        if scorer.fraction(polished) > scored[0].fraction:
            scored.insert(0, candidate(polished, "polish"))
    report("polishing", 1, 1)
    even = [found.fraction for found in radial.candidates if found.origin == "equidistant"]
    least = least_proposed(scored[0].fraction, give_up, target, even)
    near = [found for found in scored if found.fraction >= least]
    proposed = scored[0] if len(near) == 1 else min(near, key=lambda found: coverage.error(_layout(found)))
    errors = [scorer.error(_layout(found)) if space.n_cameras > 1 else np.inf for found in (proposed, scored[0])]
    if errors[1] < errors[0]:  # samples are not exact
        proposed, errors[0] = scored[0], errors[1]
    record = radial.search
    seconds = record.seconds | {"rolls": round(time.perf_counter() - begun, 3)}
    return replace(
        radial,
        angles=proposed.angles,
        rolls=proposed.rolls,
        fraction=proposed.fraction,
        error_rms=errors[0],
        most_area_error_rms=errors[1],
        sites=tuple(replace(site, area=area) for site, area in zip(radial.sites, proposed.areas, strict=True)),
        candidates=tuple(scored),
        search=replace(record, n_exact=record.n_exact + n_exact, n_moves=record.n_moves + n_moves, seconds=seconds),
    )


def _layout(found: Candidate) -> RolledLayout:
    angles = np.array(found.angles)
    return RolledLayout(angles, np.zeros(len(angles)) if found.rolls is None else np.array(found.rolls))
