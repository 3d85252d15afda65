"""The tasks of the simulated study: layouts of several sites, and what is reconstructed from rendered images."""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import exact
import meshes
from experiments.paper.areas import site_mesh
from experiments.request.simulation import Simulation
from experiments.simulate.compare import TOLERANCE
from experiments.simulate.simulation import Asked, Simulated, simulate
from experiments.simulate.tables import classes, summary
from experiments.study.simulated_layouts import KINDS, Site, layouts, named
from experiments.sweeps.task import Task

# What the matcher is expected to do to a pixel, standard deviation [pixels].
MATCH_NOISE = 0.1
# Predicted standard deviation along the normal with which a point counts: two of them are the tolerance [mm].
MAX_ERROR = TOLERANCE / 2
# Limits that are tried: greatest incidence [degrees], least density of pixels [px/mm²], and greatest disparity
# gradient.
INCIDENCES_DEG = tuple(np.arange(60.0, 90.1, 0.5).round(1).tolist())
DENSITIES = tuple(np.geomspace(1.0, 1000.0, 61).round(3).tolist())
GRADIENTS = tuple(np.geomspace(0.03, 30.0, 61).round(4).tolist())
# Other parts of camring that make a result.
PACKAGES = ("meshes", "exact", "experiments.simulate")


@dataclass(frozen=True)
class Plan:
    """What is studied.

    Attributes
    ----------
    sites, tested : tuple of (str, int)
        Reference sites and their depths [mm], all for the default field of view. Limits are chosen on the former, and
        tested on the latter.
    counts, tested_counts : tuple of int
        Numbers of cameras on the former, and on the latter.
    width : int
        Pixels along the longer side of the images.
    further_widths : tuple of int
        Others, with which the first site is studied once more, with `further_count` cameras.
    further_count : int
    """

    sites: tuple[Site, ...]
    tested: tuple[Site, ...]
    counts: tuple[int, ...]
    tested_counts: tuple[int, ...]
    width: int
    further_widths: tuple[int, ...]
    further_count: int

    @staticmethod
    def of(quick: bool) -> "Plan":
        """Four sites with 2 to 8 cameras and four for a test; or with `quick` one with two and four, in small images.

        Examples
        --------
        >>> plan = Plan.of(False)
        >>> len(plan.requests), len(Plan.of(True).requests)
        (24, 2)
        """
        if quick:
            return Plan((("circ_artery", 50),), (), (2, 4), (), 360, (), 4)
        sites = (("circ_artery", 50), ("circ_overhang", 50), ("elliptical", 50), ("spine_disc", 50))
        tested = (("circ_angled", 50), ("circ_flat", 50), ("circ_overhang", 100), ("elliptical", 100))
        return Plan(sites, tested, (2, 4, 6, 8), (2, 4), 720, (360, 1800), 4)

    @property
    def requests(self) -> list[tuple[Site, int]]:
        """Every site with each of its numbers of cameras."""
        return [(site, n) for site in self.sites for n in self.counts] + [
            (site, n) for site in self.tested for n in self.tested_counts
        ]


def reconstructed(site: Sequence, detail: str, angles_deg: Sequence[float], width: int, seed: int) -> dict[str, Any]:
    """What is predicted of a layout, and what is measured on its rendered images.

    Parameters
    ----------
    site, detail
        As for `simulated_layouts.layouts`.
    angles_deg : sequence of float
        Ring angles [degrees].
    width : int
        Pixels along the longer side of the images.
    seed : int
        Of texture, noise and samples.
    """
    mesh = site_mesh(str(site[0]), int(site[1]), detail, str(site[2]))
    ring = exact.Ring()
    resolution = width, round(width * ring.fov[1] / ring.fov[0])
    optics = exact.Optics(resolution=resolution, match_noise=MATCH_NOISE)
    scene = exact.Scene(mesh, exclude=meshes.top_surface(mesh))
    asked = Asked(
        "layout", scene, ring, np.radians(angles_deg), exact.Demand(optics=optics), Simulation(), seed=seed
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        found = simulate(asked, Path(folder))
    return {"summary": summary(found), "classes": list(classes(found)), "limits": _limits(found)}


def predicted(
    site: Sequence, detail: str, angles_deg: Sequence[float], width: int, max_incidence_deg: float | None,
    min_pixel_density: float | None, max_disparity_gradient: float | None, max_error: float | None,
) -> dict[str, Any]:  # fmt: skip
    """The exact area [mm²] that a layout reconstructs under limits, arguments as for `reconstructed`."""
    mesh = site_mesh(str(site[0]), int(site[1]), detail, str(site[2]))
    ring = exact.Ring()
    incidence = None if max_incidence_deg is None else float(np.radians(max_incidence_deg))
    found = exact.evaluate(
        mesh,
        ring.cameras(np.radians(angles_deg)),
        exclude=meshes.top_surface(mesh),
        limits=exact.Limits(min_pixel_density=min_pixel_density, max_incidence=incidence),
        optics=exact.Optics((width, round(width * ring.fov[1] / ring.fov[0])), MATCH_NOISE),
        max_disparity_gradient=max_disparity_gradient,
        max_error=max_error,
        error="normal",
    )
    return {"area_mm2": found.area}


def _limits(found: Simulated) -> dict[str, Any]:
    """For each limit: sampled area [mm²] that meets it, and the part of that which was reconstructed."""
    samples, demand = found.comparison.samples, found.asked.demand
    near = found.comparison.distance <= TOLERANCE
    made: dict[str, Any] = {"reconstructed": float(samples.areas[near].sum())}
    gradient = found.gradient
    for ending, error in (("", None), (" and error", MAX_ERROR)):

        def met_by(limits: exact.Limits, largest: float | None = error) -> np.ndarray:
            return samples.within(limits, demand, largest, MATCH_NOISE)

        anywhere = met_by(exact.Limits())
        kinds = {
            "incidence": [
                met_by(exact.Limits(max_incidence=float(np.radians(min(one, 89.999))))) for one in INCIDENCES_DEG
            ],
            "density": [met_by(exact.Limits(min_pixel_density=one)) for one in DENSITIES],
            "gradient": [anywhere & (gradient <= one) for one in GRADIENTS],
        }
        for name, met in kinds.items():
            made[name + ending] = {
                "met": [float(samples.areas[one].sum()) for one in met],
                "both": [float(samples.areas[one & near].sum()) for one in met],
            }
    return made


def layout_tasks(plan: Plan, detail: str) -> list[tuple[Site, int, Task]]:
    """A task for each site and number of cameras."""
    return [
        (site, n, Task(layouts, {"site": named(site, detail), "detail": detail, "n_cameras": n}, cost=1.0 + n))
        for site, n in plan.requests
    ]


def simulation_tasks(
    plan: Plan, detail: str, angles: dict[tuple[Site, int], dict[str, list[float]]], seed: int
) -> list[tuple[dict[str, Any], Task]]:
    """A task for each layout, with what it is about; the same layout of two kinds is one task."""
    tasks = []
    for site, n in plan.requests:
        again = site == plan.sites[0] and n == plan.further_count
        for width in (plan.width, *(plan.further_widths if again else ())):
            for kind in KINDS:
                inputs = {
                    "site": named(site, detail), "detail": detail, "angles_deg": angles[site, n][kind],
                    "width": width, "seed": seed,
                }  # fmt: skip
                about = {
                    "site": site[0], "depth_mm": site[1], "n_cameras": n, "kind": kind, "width_px": width,
                    "tested": site in plan.tested,
                }  # fmt: skip
                cost = (n + n * (n - 1)) * (width / plan.width) ** 2
                tasks.append((about, Task(reconstructed, inputs, cost=cost, packages=PACKAGES)))
    return tasks


def area_tasks(
    simulations: Sequence[tuple[dict[str, Any], Task]], limits: Sequence[dict[str, float | None]]
) -> list[list[Task]]:
    """For each layout a task for each of several limits."""
    made = []
    for _, task in simulations:
        of = {name: task.inputs[name] for name in ("site", "detail", "angles_deg", "width")}
        made.append([Task(predicted, of | one, packages=("meshes", "exact")) for one in limits])
    return made
