"""What a layout was made for: the meshes in words, and what it reconstructs of each of several."""

import numpy as np
from rich.table import Table

import placement
from experiments.request.request import Request
from experiments.terminal.console import table


def headings(asked: Request, result: placement.Placement, of_cameras: str = "") -> list[str]:
    """Lines above the tables: meshes, what does not count, the ring maximum, when a point counts.

    `of_cameras` says of how many cameras the layouts are, if all have as many: " of the 4".
    """
    lines = [
        f"{about.name}: {len(about.mesh.faces)} faces; not counted: {excluded.words}"
        for about, excluded in zip(asked.subjects, asked.excluded, strict=True)
    ]
    if len(asked.poses) > 1:
        lines.append(f"one layout for all: fractions are of {asked.of}; areas are {_areas(asked)}")
    if asked.n_poses > 1:
        lines.append(
            f"{asked.n_poses} poses of each mesh: as it is, and tilted by up to {asked.rig.tilt_deg:g}°, shifted by up "
            f"to {asked.rig.shift_mm:g} mm"
        )
    if asked.rig.falloff_mm is not None:
        lines.append(weights_words(asked.rig.falloff_mm))
    lines.append(
        f"ring maximum ({result.settings.ring_cameras} cameras): {result.ring_area / asked.n_poses:.2f} mm²; a point "
        f"counts when {result.demand.clause(of_cameras)}"
    )
    return lines


def weights_words(falloff_mm: float) -> str:
    """What it means that areas are weighted by the distance from the focus."""
    return f"areas are weighted: a face {falloff_mm:g} mm from the focus counts half, one twice as far 1/16"


def _areas(asked: Request) -> str:
    if len(asked.subjects) == 1:
        return "means over the poses"
    return "sums over the meshes" + (", each the mean over its poses" if asked.n_poses > 1 else "")


def site_table(asked: Request, result: placement.Placement) -> Table:
    """Fractions of each mesh's own ring maximum; of several poses the mean, and the worst in brackets."""
    worst = " (worst pose)" if asked.n_poses > 1 else ""
    weighted = asked.rig.objective == "mean"
    shown = table(
        "mesh", *["weight"] * weighted, "ring maximum\n[mm²]", f"equidistant{worst}", f"optimised{worst}"
    )  # fmt: skip
    for number, (about, weight) in enumerate(zip(asked.subjects, asked.weights, strict=True)):
        sites = result.sites[number * asked.n_poses : (number + 1) * asked.n_poses]
        even = [site.equidistant_area / site.ring_area for site in sites]
        best = [site.fraction for site in sites]
        shown.add_row(
            about.name,
            *[f"{weight:g}"] * weighted,
            f"{np.mean([site.ring_area for site in sites]):.2f}",
            *(
                f"{100 * np.mean(values):.2f} %" + (f" ({100 * min(values):.2f} %)" if worst else "")
                for values in (even, best)
            ),
        )
    return shown
