"""The tasks of the study: one layout request each, for one reference site or for all of them together."""

from collections.abc import Callable, Sequence
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
from placement.recommend import bounded_by_more

# Equidistant rings are followed until they, too, reach the highest target on most sites.
MOST_EQUIDISTANT = 48
# Phases of the equidistant ring that are all scored exactly where the certificate is asked for; else the few best.
PHASES = 36
# The certificate's time for each request [s]; a bound that is not proven by then holds all the same.
CERTIFICATE_SECONDS = 20.0
# Layouts that are polished for each request: the leading one, as each search starts from those of one camera less.
POLISHED = 1
# What else is asked of a layout, in the part of the study about constraints.
SEPARATIONS = (0.0, 3.0, 5.0, 8.0)
ANGLES_DEG = (1.0, 2.0)
DEFAULT_SEPARATION = 5.0
# Pixels to a square millimetre that a surface needs to count, in the part about walls.
DENSITY = 300.0


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
    dense_counts : tuple of int
        Those for which a surface counts only where enough pixels see it.
    shared_counts : tuple of int
        Those of one layout for all sites together.
    equidistant_counts : tuple of int
        Numbers of cameras of equidistant rings.
    detail : str
    """

    sites: tuple[tuple[str, int], ...]
    counts: tuple[int, ...]
    constrained_counts: tuple[int, ...]
    dense_counts: tuple[int, ...]
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
            return Plan(sites, (2, 3), (3,), (2,), (2,), tuple(range(2, 9)), detail)
        few, some, many = (tuple(range(2, 1 + most)) for most in (6, 8, 12))
        return Plan(sites, many, (4,), some, few, tuple(range(2, MOST_EQUIDISTANT + 1)), detail)


@lru_cache(maxsize=1)
def _problem(
    sites: tuple[tuple[str, int, str], ...], detail: str, objective, certify: bool, min_pixel_density: float | None
) -> placement.Problem:
    """Several tasks about the same sites in the same process share what does not depend on the cameras."""
    built = [site_mesh(name, depth, detail, mesh_hash) for name, depth, mesh_hash in sites]
    settings = replace(placement.Settings(), polish_candidates=POLISHED)
    if certify:
        settings = replace(settings, exact_phases=PHASES, certificate_seconds=CERTIFICATE_SECONDS)
    masks = [meshes.top_surface(mesh) for mesh in built]
    return placement.Problem(
        built, exact.Ring(), exclude=masks, settings=settings, objective=objective, workers=1,
        limits=exact.Limits(min_pixel_density=min_pixel_density),
    )  # fmt: skip


def placed(
    sites: Sequence[Sequence], detail: str, objective: str, counts: Sequence[int], min_separation: float,
    min_angle_deg: float, min_pixel_density: float | None, certify: bool,
) -> dict[str, Any]:  # fmt: skip
    """Layouts of these numbers of cameras in turn, each search starting from those of one camera less.

    Parameters
    ----------
    sites : sequence of (name, depth [mm], fingerprint)
        Without their top surface.
    detail, objective
        Of the meshes; over several sites.
    counts : sequence of int
        Numbers of cameras, increasing by one.
    min_separation, min_angle_deg : float
        Of a layout [mm, degrees].
    min_pixel_density : float or None
        What a point needs of two cameras to count [px/mm²].
    certify : bool

    Returns
    -------
    dict
        "layouts": for each number of cameras the layout with the greatest area, the one proposed, the equidistant ring
        at phase 0 and at its best phase, and the certificate, as the columns of `LayoutRow`.

    Examples
    --------
    >>> from experiments.paper.cases import Case
    >>> site = ["circ_flat", 50, Case("circ_flat", 50, "36x24").mesh_hash("coarse")]
    >>> found = placed([site], "coarse", "mean", [2], 5.0, 0.0, None, certify=False)["layouts"][0]
    >>> found["most_area_fraction"] >= found["best_equidistant_fraction"] >= found["equidistant_fraction"]
    True
    """
    key = tuple((str(name), int(depth), str(mesh_hash)) for name, depth, mesh_hash in sites)
    problem = _problem(key, detail, objective, certify, min_pixel_density)
    constraints = placement.Constraints(min_separation, min_angle=float(np.radians(min_angle_deg)))
    placements, starts = [], ()
    for n in counts:
        found = problem.optimise(n, constraints, certify=certify, starts=starts)
        starts = tuple(dict.fromkeys((found.most_area.angles, found.angles)))
        placements.append(found)
    score = problem.scorer(constraints).fraction
    return {"layouts": [_columns(found, score) for found in bounded_by_more(placements) if found is not None]}


def _columns(found: placement.Placement, score: Callable[[tuple[float, ...]], float]) -> dict[str, Any]:
    certificate, most = found.certificate, found.most_area
    columns = {
        "fraction": found.fraction,
        "error_rms_mm": found.error_rms,
        "angles_deg": np.degrees(found.angles).tolist(),
        "most_area_fraction": most.fraction,
        "most_area_error_rms_mm": found.most_area_error_rms,
        "most_area_angles_deg": np.degrees(most.angles).tolist(),
        "equidistant_fraction": found.equidistant_fraction,
        "equidistant_error_rms_mm": found.equidistant_error_rms,
        "best_equidistant_fraction": found.best_equidistant_fraction,
        "best_equidistant_error_rms_mm": found.best_equidistant_error_rms,
        "best_phase_deg": float(np.degrees(found.best_equidistant_phase)),
        "sampled_fraction": most.sampled_fraction,
        "site_fractions": [site.fraction for site in found.sites],
        "area_mm2": found.area,
        "ring_area_mm2": found.ring_area,
        "smallest_separation_mm": found.smallest_separation,
    }
    if certificate is not None:
        surface = certificate.surface
        grid = certificate.grid_angles if surface is None else surface.angles
        columns |= {
            "bound_fraction": certificate.bound_fraction,
            "proven": certificate.proven,
            "grid_layout_fraction": None if grid is None else score(grid),
            "surface_bound_fraction": None if surface is None else surface.bound_fraction,
            "surface_proven": None if surface is None else surface.proven,
        }
    return columns


def equidistant(site: Sequence, detail: str, counts: Sequence[int]) -> dict[str, Any]:
    """What equidistant rings of these numbers of cameras reach at phase 0, top surface excluded.

    Returns
    -------
    dict
        "fractions" of the ring maximum, and "errors_rms_mm", along depth.

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
    (whole,) = exact.areas(mesh, [ring.cameras(ring.equidistant(placement.Settings().ring_cameras))], exclude=top)
    found = [exact.evaluate(mesh, ring.cameras(ring.equidistant(n)), exclude=top, all_views=True) for n in counts]
    return {
        "fractions": [float(one.area / whole) for one in found],
        "errors_rms_mm": [one.errors.rms() for one in found],
    }


def study_tasks(plan: Plan) -> list[tuple[dict[str, Any], Task]]:
    """Every task with what it is about: its part of the study and the columns that name its rows."""
    named = {
        (name, depth): [name, depth, meshes.EXPECTED[name, float(depth), plan.detail].fingerprint]
        for name, depth in plan.sites
    }
    tasks = []

    def request(
        part: str, chosen, counts: Sequence[int], cost: float, separation=DEFAULT_SEPARATION, angle=0.0, density=None,
        objective="mean",
    ):  # fmt: skip
        asked = dict(
            min_separation=separation, min_angle_deg=angle, min_pixel_density=density, objective=objective,
            certify=part == "layouts", counts=list(counts),
        )  # fmt: skip
        name, depth = chosen[0] if len(chosen) == 1 else (f"all {len(chosen)}", None)
        about = dict(
            part=part, site=name, depth_mm=depth, counts=list(counts), min_separation_mm=separation,
            min_angle_deg=angle, min_pixel_density=density, objective=objective,
        )  # fmt: skip
        inputs = dict(sites=[named[site] for site in chosen], detail=plan.detail, **asked)
        tasks.append((about, Task(placed, inputs, cost=cost * len(counts))))

    # Site by site, so that tasks that follow each other in one process are about the same one.
    for site in plan.sites:
        request("layouts", [site], plan.counts, cost=5.0)
        request("dense", [site], plan.dense_counts, cost=2.0, density=DENSITY)
        for n in plan.constrained_counts:
            for separation in SEPARATIONS:
                if separation != DEFAULT_SEPARATION:
                    request("constraints", [site], [n], cost=1.0, separation=separation)
            for angle in ANGLES_DEG:
                request("constraints", [site], [n], cost=1.0, angle=angle)
        inputs = {"site": named[site], "detail": plan.detail, "counts": list(plan.equidistant_counts)}
        about = {"part": "equidistant", "site": site[0], "depth_mm": site[1]}
        tasks.append((about, Task(equidistant, inputs, cost=6.0, packages=("meshes", "exact"))))
    request("all sites", plan.sites, plan.shared_counts, cost=30.0, objective="worst")
    return tasks
