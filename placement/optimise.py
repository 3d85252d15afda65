"""Propose a layout: search on samples from many starts, score the distinct ends exactly, polish the best."""

import time
from collections.abc import Sequence

import numpy as np
import trimesh

import exact
from placement.arcs import LayoutSpace
from placement.certificate import Certificate, certify_samples, measure
from placement.constraints import Constraints, checked_threshold
from placement.equidistant import compared_phases
from placement.problem import Problem, Progress
from placement.results import Candidate, Placement, SearchRecord, SiteResult, library_versions
from placement.scoring import canonical, polish
from placement.search import search
from placement.settings import Settings
from placement.sites import Objective


def optimise(
    mesh: trimesh.Trimesh | Sequence[trimesh.Trimesh],
    ring: exact.Ring,
    n_cameras: int = 4,
    threshold: int = 2,
    exclude: np.ndarray | Sequence[np.ndarray | None] | None = None,
    constraints: Constraints | None = None,
    settings: Settings | None = None,
    seed: int = 0,
    progress: Progress | None = None,
    certify: bool = True,
    face_weights: np.ndarray | Sequence[np.ndarray | None] | None = None,
    site_weights: Sequence[float] | None = None,
    objective: Objective = "mean",
    workers: int | None = None,
) -> Placement:
    """Find where `n_cameras` cameras on `ring` reconstruct the most of one site or several.

    Parameters
    ----------
    mesh, ring, threshold, exclude, settings, seed, progress, face_weights, site_weights, objective, workers
        See `Problem`. The same request with the same seed gives the same layout, bit for bit.
    n_cameras : int
        Number of cameras M.
    constraints : Constraints, optional
        What every layout must meet; by default cameras at least 5 mm apart.
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
    # Refused before anything is computed.
    checked_threshold(threshold, LayoutSpace(ring, n_cameras, constraints).n_cameras, constraints)
    problem = Problem(
        mesh, ring, threshold, exclude, settings, seed, face_weights, site_weights, objective, workers, progress
    )
    return place(problem, n_cameras, constraints, certify, progress)


def certify(
    mesh: trimesh.Trimesh | Sequence[trimesh.Trimesh],
    ring: exact.Ring,
    n_cameras: int = 4,
    threshold: int = 2,
    exclude: np.ndarray | Sequence[np.ndarray | None] | None = None,
    constraints: Constraints | None = None,
    settings: Settings | None = None,
    seed: int = 0,
    layout=None,
    face_weights: np.ndarray | Sequence[np.ndarray | None] | None = None,
    site_weights: Sequence[float] | None = None,
    objective: Objective = "mean",
) -> Certificate:
    """Bound what any layout of a request can reconstruct.

    Parameters
    ----------
    mesh, ring, n_cameras, threshold, exclude, constraints, settings, seed, face_weights, site_weights, objective
        The request, as for `optimise`; `settings.certificate_step` and `settings.certificate_seconds` say how.
    layout : (M,) array_like, optional
        Ring angles [rad] whose gap to the bounds is wanted.

    Raises
    ------
    PlacementError
        If the request cannot be met.

    Examples
    --------
    >>> from dataclasses import replace
    >>> step = trimesh.util.concatenate([trimesh.creation.box((30, 30, 1)), trimesh.creation.box((1, 8, 30))])
    >>> quick = replace(Settings(), n_samples=500, n_angles=36, certificate_step=float(np.radians(10)))
    >>> found = certify(step, exact.Ring(), n_cameras=2, settings=quick)
    >>> found.proven, bool(found.grid_fraction <= found.grid_bound_fraction <= found.bound_fraction <= 1)
    (True, True)
    """
    space = LayoutSpace(ring, n_cameras, Constraints() if constraints is None else constraints)
    threshold = checked_threshold(threshold, space.n_cameras, space.constraints)
    problem = Problem(mesh, ring, threshold, exclude, settings, seed, face_weights, site_weights, objective, workers=1)
    certificate = certify_samples(problem.profiles, space, threshold, problem.settings, problem.sites.of)
    return certificate if layout is None else measure(certificate, problem.profiles, layout, threshold)


def place(
    problem: Problem,
    n_cameras: int = 4,
    constraints: Constraints | None = None,
    certify: bool = True,
    progress: Progress | None = None,
) -> Placement:
    """Find the best layout of a `Problem`; parameters, result and errors as for `optimise`.

    Examples
    --------
    >>> from dataclasses import replace
    >>> quick = replace(Settings(), n_samples=500, n_angles=36, n_starts=4, ring_cameras=16, exact_candidates=2)
    >>> problem = Problem(trimesh.creation.box((30, 30, 5)), exact.Ring(), settings=quick)
    >>> [len(place(problem, n, certify=False).angles) for n in (2, 3)]
    [2, 3]
    """
    report = progress or (lambda what, done, total: None)
    settings, ring, profiles = problem.settings, problem.ring, problem.profiles
    space = LayoutSpace(ring, n_cameras, Constraints() if constraints is None else constraints)
    threshold = checked_threshold(problem.threshold, space.n_cameras, space.constraints)
    scorer, (coverage, surrogate) = problem.scorer(space.constraints), problem.coverage(space.constraints)
    clock = _Clock()

    report("searching", 0, 1)
    pool, counts = search(problem, space)
    layouts = [("search", layout) for layout in pool[: settings.exact_candidates]]
    clock.lap("search")

    certificate = None
    if certify:
        report("bounding any layout", 0, 1)
        certificate = certify_samples(
            profiles, space, threshold, settings, problem.sites.of, pool[: settings.exact_candidates]
        )
        if certificate.grid_angles is not None and space.allows(certificate.grid_angles):
            layouts.append(("certificate", np.array(certificate.grid_angles)))
        clock.lap("certificate")

    phases = compared_phases(problem, space)
    even = [ring.equidistant(space.n_cameras, phase) for phase in phases]
    layouts += [("equidistant", layout) for layout in even if space.allows(layout)]
    to_score = [layout for _, layout in layouts] + even
    n_exact = len({canonical(layout).tobytes() for layout in to_score})
    done, total = 0, len(problem.sites.members) * n_exact

    def on_evaluation(steps: int) -> None:
        nonlocal done
        done += steps
        report("scoring exactly", min(done, total), total)

    scorer.many(to_score, on_evaluation)
    report("scoring exactly", total, total)
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
        report("polishing", 0, 1)
        polished, n_moves = polish(scorer, space, scored[0].angles, settings.polish_steps, settings.polish_sweeps)
        n_exact += 1
        if scorer.fraction(polished) > scored[0].fraction:
            scored.insert(0, candidate(polished, "polish"))
    clock.lap("polish")
    report("polishing", 1, 1)

    best = max(range(len(even)), key=lambda i: scorer.fraction(even[i]))
    areas = zip(scored[0].areas, scorer.areas(even[0]), scorer.areas(even[best]), scorer.ring_areas, strict=True)
    sites = tuple(
        SiteResult(*four_areas, site.share, site.mesh_hash, int(site.excluded.sum()), site.face_weights is not None)
        for site, four_areas in zip(problem.sites.members, areas, strict=True)
    )
    return Placement(
        angles=scored[0].angles,
        fraction=scored[0].fraction,
        equidistant_fraction=scorer.fraction(even[0]),
        best_equidistant_fraction=scorer.fraction(even[best]),
        best_equidistant_phase=phases[best],
        sites=sites,
        objective=problem.sites.objective,
        candidates=tuple(scored),
        certificate=None if certificate is None else measure(certificate, profiles, scored[0].angles, threshold),
        search=SearchRecord(**counts, n_exact=n_exact, n_moves=n_moves, seconds=clock.seconds),
        ring=ring,
        n_cameras=space.n_cameras,
        threshold=threshold,
        constraints=space.constraints,
        settings=settings,
        seed=problem.seed,
        versions=library_versions(),
    )


class _Clock:
    """Seconds spent on each part, in order."""

    def __init__(self):
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, name: str) -> None:
        now = time.perf_counter()
        self.seconds[name] = round(now - self._last, 3)
        self._last = now
