"""The tasks of the study: one layout request each, for one reference site or for all of them together."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

import exact
import meshes
import placement
from experiments.paper.areas import site_mesh
from experiments.paper.cases import cases
from experiments.sweeps.task import Task

# Equidistant rings are followed until they, too, reach the highest target on most sites.
MOST_EQUIDISTANT = 48
# Phases of the equidistant ring that are all scored exactly where the certificate is asked for; else the few best.
PHASES = 36
# The certificate's time for each request [s]; a bound that is not proven by then holds all the same.
CERTIFICATE_SECONDS = 20.0
# What else is asked of a layout, in the part of the study about constraints.
SEPARATIONS = (0.0, 3.0, 5.0, 8.0)
ANGLES_DEG = (1.0, 2.0)
DEFAULT_SEPARATION = 5.0


@dataclass(frozen=True)
class Plan:
    """What is studied.

    Attributes
    ----------
    sites : tuple of (str, int)
        Reference sites and their depths [mm].
    counts : tuple of int
        Numbers of cameras.
    constrained_counts : tuple of int
        Those for which the constraints are varied.
    shared_counts : tuple of int
        Those of one layout for all sites together.
    equidistant_counts : tuple of int
        Numbers of cameras of equidistant rings.
    detail : str
    """

    sites: tuple[tuple[str, int], ...]
    counts: tuple[int, ...]
    constrained_counts: tuple[int, ...]
    shared_counts: tuple[int, ...]
    equidistant_counts: tuple[int, ...]
    detail: str

    @staticmethod
    def of(quick: bool, detail: str) -> "Plan":
        """The ten sites of Wachter 2021 with 2 to 12 cameras; or with `quick` two of them with few.

        Examples
        --------
        >>> len(Plan.of(False, "coarse").sites), Plan.of(True, "coarse").counts
        (10, (2, 3))
        """
        sites = tuple(dict.fromkeys((case.site, case.depth) for case in cases(quick)))
        if quick:
            return Plan(sites, (2, 3), (3,), (2,), tuple(range(2, 9)), detail)
        every = tuple(range(2, 13))
        return Plan(sites, every, (4, 8), every, tuple(range(2, MOST_EQUIDISTANT + 1)), detail)


@lru_cache(maxsize=1)
def _problem(sites: tuple[tuple[str, int, str], ...], detail: str, objective, certify: bool) -> placement.Problem:
    """Several tasks about the same sites in the same process share what does not depend on the cameras."""
    built = [site_mesh(name, depth, detail, mesh_hash) for name, depth, mesh_hash in sites]
    settings = placement.Settings()
    if certify:
        settings = replace(settings, exact_phases=PHASES, certificate_seconds=CERTIFICATE_SECONDS)
    masks = [meshes.top_surface(mesh) for mesh in built]
    return placement.Problem(built, exact.Ring(), exclude=masks, settings=settings, objective=objective, workers=1)


def placed(
    sites: Sequence[Sequence], detail: str, objective: str, n_cameras: int, min_separation: float,
    min_angle_deg: float, certify: bool,
) -> dict[str, Any]:  # fmt: skip
    """The best layout of one request, the equidistant ring at its best phase, and the certificate.

    Parameters
    ----------
    sites : sequence of (name, depth [mm], fingerprint)
        Without their top surface.
    detail, objective
        Of the meshes; over several sites.
    n_cameras, min_separation, min_angle_deg : number
        Of the layout; lengths in mm, angles in degrees.
    certify : bool

    Examples
    --------
    >>> from experiments.paper.cases import Case
    >>> site = ["circ_flat", 50, Case("circ_flat", 50, "36x24").mesh_hash("coarse")]
    >>> found = placed([site], "coarse", "mean", 2, 5.0, 0.0, certify=False)
    >>> found["fraction"] >= found["best_equidistant_fraction"] >= found["equidistant_fraction"]
    True
    """
    key = tuple((str(name), int(depth), str(mesh_hash)) for name, depth, mesh_hash in sites)
    problem = _problem(key, detail, objective, certify)
    constraints = placement.Constraints(min_separation, min_angle=float(np.radians(min_angle_deg)))
    found = problem.optimise(n_cameras, constraints, certify=certify, give_up=0.0)
    certificate = found.certificate
    grid_fraction = None
    if certificate is not None and certificate.grid_angles is not None:
        grid_fraction = problem.scorer(constraints).fraction(certificate.grid_angles)
    return {
        "angles_deg": np.degrees(found.angles).tolist(),
        "fraction": found.fraction,
        "equidistant_fraction": found.equidistant_fraction,
        "best_equidistant_fraction": found.best_equidistant_fraction,
        "best_phase_deg": float(np.degrees(found.best_equidistant_phase)),
        "site_fractions": [site.fraction for site in found.sites],
        "area_mm2": found.area,
        "ring_area_mm2": found.ring_area,
        "smallest_separation_mm": found.smallest_separation,
        "bound_fraction": None if certificate is None else certificate.bound_fraction,
        "grid_bound_fraction": None if certificate is None else certificate.grid_bound_fraction,
        "grid_layout_fraction": grid_fraction,
        "proven": None if certificate is None else certificate.proven,
        "sampled_fraction": found.candidates[0].sampled_fraction,
    }


def equidistant(site: Sequence, detail: str, counts: Sequence[int]) -> dict[str, Any]:
    """Fractions of the ring maximum that equidistant rings of these numbers of cameras reach, top surface excluded.

    Examples
    --------
    >>> from experiments.paper.cases import Case
    >>> site = ["circ_flat", 50, Case("circ_flat", 50, "36x24").mesh_hash("coarse")]
    >>> [round(fraction, 2) for fraction in equidistant(site, "coarse", [2, 4])["fractions"]]
    [0.64, 1.0]
    """
    name, depth, mesh_hash = site
    mesh, ring = site_mesh(name, depth, detail, mesh_hash), exact.Ring()
    top = meshes.top_surface(mesh)
    most = placement.Settings().ring_cameras
    layouts = [ring.cameras(ring.equidistant(n)) for n in (*counts, most)]
    *areas, whole = exact.areas(mesh, layouts, exclude=top).tolist()
    return {"fractions": [area / whole for area in areas]}


def study_tasks(plan: Plan) -> list[tuple[dict[str, Any], Task]]:
    """Every task with what it is about: its part of the study and the columns that name its row."""
    named = {
        (name, depth): [name, depth, meshes.EXPECTED[name, float(depth), plan.detail].fingerprint]
        for name, depth in plan.sites
    }
    tasks = []

    def request(part: str, chosen, n: int, cost=1.0, separation=DEFAULT_SEPARATION, angle=0.0, objective="mean"):
        certify = part == "layouts"
        of = [named[site] for site in chosen]
        inputs = dict(
            sites=of, detail=plan.detail, objective=objective, n_cameras=n, min_separation=separation,
            min_angle_deg=angle, certify=certify,
        )  # fmt: skip
        name, depth = chosen[0] if len(chosen) == 1 else (f"all {len(chosen)}", None)
        about = dict(
            part=part, site=name, depth_mm=depth, n_cameras=n, min_separation_mm=separation, min_angle_deg=angle,
            objective=objective,
        )  # fmt: skip
        tasks.append((about, Task(placed, inputs, cost=cost)))

    # Site by site, so that tasks that follow each other in one process are about the same one.
    for site in plan.sites:
        for n in plan.counts:
            request("layouts", [site], n, cost=3.0)
        for n in plan.constrained_counts:
            for separation in SEPARATIONS:
                if separation != DEFAULT_SEPARATION:
                    request("constraints", [site], n, separation=separation)
            for angle in ANGLES_DEG:
                request("constraints", [site], n, angle=angle)
        inputs = {"site": named[site], "detail": plan.detail, "counts": list(plan.equidistant_counts)}
        about = {"part": "equidistant", "site": site[0], "depth_mm": site[1]}
        tasks.append((about, Task(equidistant, inputs, cost=2.0, packages=("meshes", "exact"))))
    for n in plan.shared_counts:
        request("all sites", plan.sites, n, cost=10.0, objective="worst")
    return tasks
