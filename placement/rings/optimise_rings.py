"""Which camera sits on which of several rings, and where."""

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import exact
from exact.requests import checked_demand, demand_keywords, refuse_unknown, shows
from exact.workers import available_cores
from placement.errors import PlacementError, refusing
from placement.layouts.constraints import Constraints, checked_seed, on_ring
from placement.problem import ASKED, Problem
from placement.progress import Progress, nothing
from placement.proof.certificate import grid_places
from placement.proof.surface import is_usual
from placement.results import Placement, SearchRecord, library_versions
from placement.rings.ring_places import Places, RingsSpace, distinct_places
from placement.rings.rings_bound import RingsBound, bounded, measured
from placement.rings.rings_coverage import RingsCoverage
from placement.rings.rings_placement import OneRing, RingsCandidate, RingsPlacement
from placement.rings.rings_samples import RingsSamples
from placement.rings.rings_scoring import RingsScorer
from placement.rings.rings_search import accurate_rings, feasible, rings_search
from placement.search.proposal import GIVE_UP
from placement.search.ring_maximum import Memory, RingMaximum
from placement.settings import Settings
from placement.sites import Objective, Surfaces, checked_sites, scene_keywords

# Every view of all rings takes part in the bound: steps of 15° unless other settings are given.
USUAL = Settings(certificate_step=float(np.radians(15.0)))
# One sample in so many tells layouts apart by their errors.
THINNING = 4
# Layouts of each ring alone that are started from.
N_ALONE = 4


@shows(ASKED)
def optimise_rings(
    mesh: Surfaces,
    rings: Sequence[exact.Ring] | exact.Ring,
    n_cameras: int = 4,
    *,
    most: Sequence[int | None] | None = None,
    constraints: Constraints | Sequence[Constraints] | None = None,
    certify: bool = True,
    give_up: float = GIVE_UP,
    settings: Settings | None = None,
    seed: int = 0,
    site_weights: Sequence[float] | None = None,
    objective: Objective = "mean",
    workers: int | None = None,
    progress: Progress | None = None,
    memory: Memory | None = None,
    **asked: Any,
) -> RingsPlacement:
    """Find where `n_cameras` cameras on several rings reconstruct the most of one site or several.

    The search decides which camera sits on which ring. Each ring is optimised alone too, with all cameras on it, so
    that one sees what the others are good for.

    Parameters
    ----------
    mesh : trimesh.Trimesh, exact.Scene, or sequence of them
        One site or several [mm].
    rings : (K,) sequence of exact.Ring, or exact.Ring
        Where cameras may be. The rings need share nothing. A ring 0.001 mm wide is one camera on the axis, if it takes
        only one; its ring angle is the roll of that camera.
    n_cameras : int
        Number of cameras M on all of them together.
    most : (K,) sequence of int or None, optional
        The most cameras that each ring takes; None for as many as there is room for.
    constraints : Constraints, or (K,) sequence of them, optional
        What every layout must meet, on all rings or on each; by default cameras at least 5 mm apart. `min_separation`
        and `min_baseline` are distances of camera centres, also between rings: of two rings the stricter separation
        holds, and of all rings the greatest baseline. Fixed cameras and forbidden arcs are those of a ring.
    certify : bool
        Also bound what layouts on a grid of `settings.certificate_step` on all rings could reconstruct, by exact areas,
        where that takes less than half a minute or so, or if `settings.certify_on` is "surface"; a better layout found
        on the way is taken.
    give_up : float
        Coverage that may be given up for accuracy, as a fraction of the maximum of all rings: of layouts within so much
        of the greatest exact area found, that reconstruct no less than the one proposed for any ring alone, the one
        with the least error is proposed.
    settings : Settings, optional
        How layouts are searched for; by default as for one ring, with a grid of 15° for the bound.
    seed, site_weights, objective, workers, progress, memory, exclude, face_weights, threshold, min_baseline, demand
        See `Problem`. Depth is measured along the axis of the first ring, unless the demand says along what.

    Returns
    -------
    RingsPlacement
        `most_area` is never worse than the layout with the most area of any ring alone that meets the constraints.

    Raises
    ------
    PlacementError
        If the request cannot be met; the message says why and what would be feasible.

    Examples
    --------
    >>> import trimesh
    >>> step = trimesh.util.concatenate([trimesh.creation.box((30, 30, 1)), trimesh.creation.box((1, 8, 30))])
    >>> quick = Settings(n_samples=500, n_angles=36, n_starts=4, n_start_phases=2, ring_cameras=16, polish_steps=())
    >>> rings = exact.Ring(), exact.Ring(diameter=16.0)
    >>> found = optimise_rings(step, rings, 3, most=(None, 1), settings=quick, certify=False)
    >>> found.area >= found.alone[0].placement.area, found.ring_of.count(1) <= 1, found.smallest_separation >= 5.0
    (True, True, True)
    >>> found.alone[1].refused
    'it takes at most 1 of the 3 cameras'
    """
    refuse_unknown(asked, {*scene_keywords(), *demand_keywords(), "demand"})
    seed, report = checked_seed(seed), progress or nothing
    rings = _checked_rings(rings)
    settings = USUAL if settings is None else settings
    if certify and settings.certify_on == "samples":
        raise PlacementError(
            'settings: certify_on is "samples"; layouts on several rings are bounded on the surface alone: ask for '
            '"surface" or "auto", or with certify=False for no bound'
        )
    if not (isinstance(give_up, int | float | np.number) and 0 <= give_up < 1):
        raise PlacementError(f"give_up is {give_up!r}; it must be at least 0 and below 1, a part of the maximum")
    most = (None,) * len(rings) if most is None else tuple(most)
    if len(most) != len(rings):
        raise PlacementError(f"most is {most!r}; it must give a number or None for each of the {len(rings)} rings")
    of_rings = _checked_constraints(constraints, len(rings))
    space = RingsSpace(rings, n_cameras, most, of_rings)
    with refusing():
        whole = on_ring(checked_demand(asked), rings[0])
        demand = _demanded(whole, space)
        demand.refuse_fewer(space.n_cameras)
    workers, memory = available_cores() if workers is None else workers, {} if memory is None else memory
    about = {name: asked.get(name) for name in scene_keywords()}
    sites = checked_sites(mesh, site_weights=site_weights, objective=objective, **about)
    settings = settings.for_faces(sites.n_faces)
    maximum = RingMaximum(
        sites, rings[0] if len(rings) == 1 else rings, whole, n_cameras=settings.ring_cameras, workers=workers,
        memory=memory,
    )  # fmt: skip
    seconds, begun = {}, time.perf_counter()

    def lap(name: str) -> None:
        nonlocal begun
        seconds[name], begun = round(time.perf_counter() - begun, 3), time.perf_counter()

    def alone(k: int) -> Placement | str:
        if space.most[k] < space.n_cameras:
            return f"it takes at most {space.most[k]} of the {space.n_cameras} cameras"
        scenes = [site.scene for site in sites.members]
        own = replace(of_rings[k], min_baseline=max(of_rings[k].min_baseline, demand.min_baseline), min_angle=0.0)
        try:
            problem = Problem(
                scenes, rings[k], settings=settings, seed=seed, site_weights=site_weights, objective=objective,
                workers=workers, progress=progress, memory=memory, demand=whole,
            )  # fmt: skip
            return problem.optimise(space.n_cameras, own, certify=False, give_up=give_up, progress=progress)
        except PlacementError as error:
            return str(error)

    found_alone = [alone(k) for k in range(len(rings))]
    lap("rings alone")
    report("searching all rings", 0, 1)
    samples = RingsSamples.of(sites, rings, demand, settings, seed)
    thin = RingsCoverage(samples.thinned(THINNING), space, demand)
    coverage = RingsCoverage(samples, space, demand) if demand.max_error is None else thin
    layouts = _layouts_alone(space, found_alone)
    pool, n_starts = rings_search(coverage, [layout for _, layout in layouts], settings, seed)
    if not pool:
        raise PlacementError(
            f"no layout of {space.n_cameras} cameras was found that keeps cameras of different rings apart; ask for "
            "less separation, or for fewer cameras"
        )
    layouts += [("search", layout) for layout in pool[: settings.exact_candidates]]
    lap("search")
    if give_up > 0:
        accurate = accurate_rings(thin, coverage, pool, give_up, settings)
        layouts += [("accuracy", layout) for layout in accurate]
        lap("accuracy")
    scorer = RingsScorer(sites, space, demand, maximum, workers)
    certificate = None
    n_places = len(rings) * grid_places(settings)
    if certify and (settings.certify_on == "surface" or is_usual(sites, n_places)):
        report("bounding layouts on the grid", 0, 1)
        certificate, on_grid = bounded(scorer, settings)
        layouts += [("certificate", on_grid)] if on_grid is not None and not space.violations(on_grid) else []
        lap("certificate")
    report("scoring exactly", 0, 1)
    scored = _scored(scorer, layouts)
    lap("scoring")
    report("polishing", 0, 1)
    ends, n_moves = _polished(scorer, scored, settings)
    scored = _scored(scorer, [*[(one.origin, one.places) for one in scored], *[("polish", end) for end in ends]])
    lap("polish")
    proposed, error, most_error = _proposed(scorer, thin, scored, found_alone, give_up)
    lap("errors")
    report("polishing", 1, 1)
    return RingsPlacement(
        ring_of=proposed.ring_of,
        angles=proposed.angles,
        areas=proposed.areas,
        fraction=proposed.fraction,
        error_rms=error,
        most_area_error_rms=most_error,
        alone=tuple(_one_ring(scorer, one) for one in found_alone),
        maximum_areas=scorer.maximum,
        objective=sites.objective,
        candidates=tuple(scored),
        certificate=_with_gap(certificate, proposed),
        search=SearchRecord(n_starts, 0, 0, len(pool), scorer.n_scored, n_moves, seconds),
        rings=rings,
        n_cameras=space.n_cameras,
        most=most,
        demand=demand,
        give_up=float(give_up),
        constraints=of_rings,
        settings=settings,
        seed=seed,
        mesh_hashes=tuple(site.scene.mesh_hash for site in sites.members),
        versions=library_versions(),
    )


def _checked_rings(rings: Sequence[exact.Ring] | exact.Ring) -> tuple[exact.Ring, ...]:
    several = (rings,) if isinstance(rings, exact.Ring) else tuple(rings)
    if not several:
        raise PlacementError("there is no ring; give at least one")
    for number, ring in enumerate(several, start=1):
        if not isinstance(ring, exact.Ring):
            raise PlacementError(f"ring {number} is a {type(ring).__name__}; an exact.Ring is needed")
        if ring.roll == "free":
            raise PlacementError(
                f"the rolls of ring {number} are free, which is known for one ring only (placement.optimise); ask with "
                'roll="radial", "tangential" or a number'
            )
    return several


def _checked_constraints(constraints, n_rings: int) -> tuple[Constraints, ...]:
    if constraints is None or isinstance(constraints, Constraints):
        one = Constraints() if constraints is None else constraints
        if n_rings > 1 and (one.fixed or one.forbidden):
            raise PlacementError(
                "fixed cameras and forbidden arcs are those of a ring; with several rings give one Constraints for each"
            )
        return (one,) * n_rings
    several = tuple(constraints)
    if len(several) != n_rings or not all(isinstance(one, Constraints) for one in several):
        raise PlacementError(f"constraints are {several!r}; give one Constraints for all rings, or {n_rings} of them")
    return several


def _demanded(demand: exact.Demand, space: RingsSpace) -> exact.Demand:
    """The demand with the greatest baseline of the constraints, if some two cameras can keep it."""
    if len(space.rings) == 1:
        baseline = space.constraints[0].baseline(space.rings[0])
    elif any(one.min_angle > 0 for one in space.constraints):
        raise PlacementError(
            "min_angle is known for one ring only, whose cameras are all equally far from the focus; with several "
            "rings ask for a min_baseline"
        )
    else:
        baseline = max(float(one.min_baseline) for one in space.constraints)
    whole = replace(demand, min_baseline=max(demand.min_baseline, baseline))
    if whole.baseline > 0:
        widest = _widest(space)
        if space.n_cameras == 1 or whole.baseline > widest:
            raise PlacementError(
                f"no two of {space.n_cameras} cameras on these rings are {whole.baseline:.4g} mm apart; ask for a "
                f"baseline of at most {widest if space.n_cameras > 1 else 0:.4g} mm"
            )
    return whole


def _widest(space: RingsSpace) -> float:
    """Greatest distance between two places of rings that take cameras [mm], to the step at which they are tried."""
    places = Places.grid(len(space.rings), 360)
    places = places.take(space.takes[places.ring] > 0)
    apart = space.distances(places, places)
    lone = (places.ring[:, None] == places.ring) & (space.takes[places.ring] < 2)[:, None]
    return float(np.where(lone, 0.0, apart).max())


def _layouts_alone(space: RingsSpace, found: Sequence[Placement | str]) -> list[tuple[str, Places]]:
    """The leading layouts of each ring alone that are layouts of all rings, too."""
    layouts = []
    for k, one in enumerate(found):
        if isinstance(one, Placement):
            every = [one.most_area.angles, one.angles, *(other.angles for other in one.candidates[:N_ALONE])]
            layouts += [Places.on(k, angles) for angles in dict.fromkeys(every)]
    return [("alone", layout) for layout in feasible(space, layouts)]


def _scored(scorer: RingsScorer, layouts: Sequence[tuple[str, Places]]) -> list[RingsCandidate]:
    """Each layout once, the one with the greatest exact fraction first."""
    areas = scorer.many([layout for _, layout in layouts])
    found = {}
    for (origin, layout), of_sites in zip(layouts, areas, strict=True):
        same = layout.canonical()
        ring_of, angles = tuple(same.ring.tolist()), tuple(same.angles.tolist())
        made = RingsCandidate(ring_of, angles, origin, scorer.combined(of_sites), of_sites)
        found.setdefault(layout.key, made)
    return sorted(found.values(), key=lambda one: -one.fraction)


def _polished(scorer: RingsScorer, scored: Sequence[RingsCandidate], settings: Settings) -> tuple[list[Places], int]:
    """Local optima of the exact area from the leading layouts, and how many places were tried."""
    if not settings.polish_steps or len(scorer.space.fixed.ring) == scorer.space.n_cameras:
        return [], 0
    every = [one.places for one in scored]
    leading = [every[i] for i in distinct_places(every, settings.distinct_tolerance)][: settings.polish_candidates]
    found = [scorer.polished(layout, settings, thorough=False) for layout in leading]
    ends = [end for end, _ in found]
    last, n_last = scorer.polished(max(ends, key=scorer.fraction), settings, thorough=True)
    return [last, *ends], n_last + sum(n for _, n in found)


def _proposed(
    scorer: RingsScorer, thin: RingsCoverage, scored: Sequence[RingsCandidate], alone: Sequence[Placement | str],
    give_up: float,
) -> tuple[RingsCandidate, float, float]:  # fmt: skip
    """The layout to propose, its error, and that of the one with the most area [mm]."""
    if scorer.space.n_cameras == 1:
        return scored[0], np.inf, np.inf
    # What is proposed for a ring alone must not be beaten by giving up more.
    others = [
        scorer.fraction(Places.on(k, one.angles)) for k, one in enumerate(alone)
        if isinstance(one, Placement) and not scorer.space.violations(Places.on(k, one.angles))
    ]  # fmt: skip
    least = max(scored[0].fraction - give_up, *others, 0.0)
    near = [one for one in scored if one.fraction >= least]
    best = near[0] if len(near) == 1 else min(near, key=lambda one: thin.measured(one.places)[1])
    errors = [scorer.error(one.places) for one in (best, scored[0])]
    if errors[1] < errors[0]:  # samples are not exact
        best, errors[0] = scored[0], errors[1]
    return best, errors[0], errors[1]


def _one_ring(scorer: RingsScorer, found: Placement | str) -> OneRing:
    if isinstance(found, str):
        return OneRing(None, None, None, None, found)
    areas = [
        [getattr(site, name) for site in found.sites] for name in ("area", "equidistant_area", "best_equidistant_area")
    ]
    proposed, even, best_even = (scorer.combined(one) for one in areas)
    return OneRing(found, proposed, even, best_even)


def _with_gap(certificate: RingsBound | None, proposed: RingsCandidate) -> RingsBound | None:
    return None if certificate is None else measured(certificate, proposed.fraction)
