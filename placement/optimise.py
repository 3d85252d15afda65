"""Propose a layout: search on samples from many starts, score the distinct ends exactly, polish the best."""

import time
from collections.abc import Callable

import numpy as np
import trimesh

import exact
from meshes import fingerprint
from placement.arcs import LayoutSpace
from placement.certificate import certify_samples, measure
from placement.constraints import Constraints, checked_threshold
from placement.descent import descend
from placement.exchange import SampledCoverage
from placement.layout import Arcs
from placement.results import Candidate, Placement, SearchRecord, library_versions
from placement.sampled_site import SampledSite, sample_site
from placement.sampling import checked_exclude
from placement.scoring import ExactScorer, canonical, distinct, polish
from placement.settings import Settings

Progress = Callable[[str, int, int], object]
"""Called with what is being done, how many steps of it are done, and how many there are."""
Found = tuple[np.ndarray, float | None]
"""A layout and its soft coverage, where it was asked for."""


def optimise(
    mesh: trimesh.Trimesh,
    ring: exact.Ring,
    n_cameras: int = 4,
    threshold: int = 2,
    exclude: np.ndarray | None = None,
    constraints: Constraints | None = None,
    settings: Settings | None = None,
    seed: int = 0,
    progress: Progress | None = None,
    certify: bool = True,
) -> Placement:
    """Find where `n_cameras` cameras on `ring` reconstruct the most of `mesh`.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        The site [mm].
    ring : exact.Ring
        Where cameras may be.
    n_cameras : int
        Number of cameras M.
    threshold : int
        How many cameras must see a point, 1 to M.
    exclude : (F,) ndarray of bool, optional
        Faces that do not count, such as `meshes.top_surface(mesh)`; they still hide what is behind them.
    constraints : Constraints, optional
        What every layout must meet; by default cameras at least 5 mm apart.
    settings : Settings, optional
        How it is searched for.
    seed : int
        Of samples and starts. The same request with the same seed gives the same layout, bit for bit.
    progress : callable, optional
        Called with (what, done, total).
    certify : bool
        Also bound what any layout could reconstruct (`Placement.certificate`), within
        `settings.certificate_seconds`; a better layout found on the way is taken.

    Returns
    -------
    Placement
        Never worse than the best equidistant layout tried that meets the constraints.

    Raises
    ------
    PlacementError
        If the request cannot be met; the message says why and what would be feasible.

    Examples
    --------
    >>> from dataclasses import replace
    >>> step = trimesh.util.concatenate([trimesh.creation.box((30, 30, 1)), trimesh.creation.box((1, 8, 30))])
    >>> quick = replace(Settings(), n_samples=500, n_angles=36, n_starts=4, n_start_phases=2, ring_cameras=16)
    >>> result = optimise(step, exact.Ring(), n_cameras=3, settings=replace(quick, polish_steps=()))
    >>> bool(result.area >= result.best_equidistant_area), bool(result.smallest_separation >= 5.0)
    (True, True)
    """
    constraints = Constraints() if constraints is None else constraints
    settings = Settings() if settings is None else settings
    report = progress or (lambda what, done, total: None)
    space = LayoutSpace(ring, n_cameras, constraints)
    threshold = checked_threshold(threshold, space.n_cameras, constraints)
    excluded = checked_exclude(mesh, exclude)
    baseline = constraints.baseline(ring)
    clock = _Clock()

    report("tracing ring profiles", 0, 1)
    site = sample_site(mesh, ring, threshold, excluded, settings, seed)
    coverage = SampledCoverage(site.profiles, threshold, ring.diameter, baseline, settings.n_grid)
    clock.lap("profiles")

    report("searching", 0, 1)
    phases = 2 * np.pi / space.n_cameras * np.arange(settings.n_phases) / settings.n_phases
    pool, record = _search(space, site, coverage, threshold, baseline, settings, seed)
    clock.lap("search")

    certificate = None
    if certify:
        report("bounding any layout", 0, 1)
        certificate = certify_samples(site, space, threshold, settings)
        best_on_grid = certificate.grid_angles
        if best_on_grid is not None and space.allows(best_on_grid):
            pool = _distinct_pool([*pool, (np.array(best_on_grid), None)], coverage, settings)
        clock.lap("certificate")

    sampled_phases = np.array([coverage.area(ring.equidistant(space.n_cameras, phase)) for phase in phases])
    leading = np.argsort(-sampled_phases, kind="stable")[: settings.exact_phases]
    compared = sorted({0, *leading.tolist()})
    n_layouts = len(compared) + min(len(pool), settings.exact_candidates)
    n_polish = settings.polish_evaluations if settings.polish_steps and space.n_free else 0
    total, done = n_layouts + n_polish + 1, 0

    def on_evaluation():
        nonlocal done
        report("scoring exactly", min(done, total - 1), total)
        done += 1

    scorer = ExactScorer(mesh, ring, threshold, excluded, baseline, on_evaluation)

    def candidate(angles, origin: str, soft: float | None = None) -> Candidate:
        theta = canonical(angles)
        return Candidate(tuple(theta.tolist()), origin, soft, coverage.area(theta), scorer.area(theta))

    equidistant = {
        phase: candidate(ring.equidistant(space.n_cameras, phase), "equidistant") for phase in phases[compared]
    }
    scored = [found for found in equidistant.values() if space.allows(np.array(found.angles))]
    scored += [candidate(angles, "search", soft) for angles, soft in pool[: settings.exact_candidates]]
    scored.sort(key=lambda found: -found.area)
    clock.lap("scoring")
    if n_polish:
        polished = polish(scorer, space, scored[0].angles, settings.polish_steps, settings.polish_evaluations)
        if scorer.area(polished) > scored[0].area:
            scored.insert(0, candidate(polished, "polish"))
    clock.lap("polish")
    ring_area = scorer.area(ring.equidistant(settings.ring_cameras))
    clock.lap("ring maximum")
    report("scoring exactly", total, total)

    best_phase = max(equidistant, key=lambda phase: equidistant[phase].area)
    return Placement(
        angles=scored[0].angles,
        area=scored[0].area,
        equidistant_area=equidistant[phases[0]].area,
        best_equidistant_area=equidistant[best_phase].area,
        best_equidistant_phase=float(best_phase),
        ring_area=ring_area,
        candidates=tuple(scored),
        certificate=None if certificate is None else measure(certificate, site, scored[0].angles, threshold),
        search=SearchRecord(**record, n_exact=scorer.n_evaluations, seconds=clock.seconds),
        mesh_hash=fingerprint(mesh),
        n_excluded=int(excluded.sum()),
        ring=ring,
        n_cameras=space.n_cameras,
        threshold=threshold,
        constraints=constraints,
        settings=settings,
        seed=seed,
        versions=library_versions(),
    )


def _search(
    space: LayoutSpace,
    site: SampledSite,
    coverage: SampledCoverage,
    threshold: int,
    baseline: float,
    settings: Settings,
    seed: int,
) -> tuple[list[Found], dict[str, int]]:
    """Distinct layouts with their soft coverage, most sampled area first, and counts of what happened."""
    if space.n_free == 0:
        return [(np.array(space.constraints.fixed), None)], dict(n_starts=0, n_failed=0, n_flat=0, n_distinct=1)
    starts = _starts(space, settings, np.random.default_rng([seed, 1]))
    parameters, arcs = zip(*(space.parameters(start) for start in starts), strict=True)
    stacked = None
    if not space.is_whole:
        stacked = Arcs(*(np.stack([getattr(a, name) for a in arcs]) for name in Arcs._fields))  # pyright: ignore[reportArgumentType]
    ends = descend(
        np.stack(parameters),
        stacked,
        site.profiles.signed_distance,
        site.profiles.weights,
        minimum_gap=space.minimum_gap,
        threshold=threshold,
        baseline=(space.ring.diameter, baseline) if baseline > 0 else None,
        temperatures=settings.temperatures,
        max_steps=settings.max_steps,
    )
    scale = float(site.profiles.weights.sum()) / site.ring_area
    found: list[Found] = [
        (end, float(soft) * scale)
        for end, soft, failed in zip(ends.angles, ends.soft_coverage, ends.failed, strict=True)
        if not failed and space.allows(end)
    ]
    # From the starts too: where the soft landscape leads all starts past an optimum, moving one camera may find it.
    found += [(coverage.improve(space, layout), None) for layout in [end for end, _ in found] + starts]
    found.sort(key=lambda layout: -coverage.area(layout[0]))
    leading = distinct([layout for layout, _ in found], settings.distinct_tolerance)[: settings.n_pair_searches]
    found += [(coverage.improve_pairs(space, found[i][0]), None) for i in leading]
    kept = _distinct_pool(found, coverage, settings)
    counts = dict(
        n_starts=len(starts), n_failed=int(ends.failed.sum()), n_flat=int(ends.flat.sum()), n_distinct=len(kept)
    )
    return kept, counts


def _distinct_pool(found: list[Found], coverage: SampledCoverage, settings: Settings) -> list[Found]:
    """Sort by sampled area, best first, and keep one of each group of nearly equal layouts."""
    found = sorted(found, key=lambda layout: -coverage.area(layout[0]))
    return [found[i] for i in distinct([layout for layout, _ in found], settings.distinct_tolerance)]


def _starts(space: LayoutSpace, settings: Settings, rng: np.random.Generator) -> list[np.ndarray]:
    """Equidistant layouts at several phases where they are allowed, then random ones."""
    phases = 2 * np.pi / space.n_cameras * np.arange(settings.n_start_phases) / max(settings.n_start_phases, 1)
    even = [space.ring.equidistant(space.n_cameras, phase) for phase in phases]
    starts = [layout for layout in even if space.allows(layout)][: settings.n_starts]
    return starts + [space.random(rng) for _ in range(settings.n_starts - len(starts))]


class _Clock:
    """Seconds spent on each part, in order."""

    def __init__(self):
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, name: str) -> None:
        now = time.perf_counter()
        self.seconds[name] = round(now - self._last, 3)
        self._last = now
