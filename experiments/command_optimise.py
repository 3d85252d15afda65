"""camring optimise: propose a layout, compare it with equidistant ones, write and draw it."""

from pathlib import Path

import numpy as np
from rich.console import Console

import exact
import placement
from experiments import layout_file, layout_table
from experiments.coverage_figure import Panel, write_coverage
from experiments.files import output_folder
from experiments.inputs import exclusion, ring, subject
from experiments.progress import progress_stages

OUTPUTS = ("layout.json", "layouts.csv", "coverage.png")


def run(
    mesh: str,
    n_cameras: int,
    threshold: int,
    min_separation: float,
    fov: str | None,
    diameter: float,
    working_distance: float,
    exclude: str | None,
    seed: int,
    depth: float | None,
    detail: str | None,
    repair: bool,
    out: Path,
    force: bool,
) -> None:
    """Optimise, print and write."""
    about = subject(mesh, depth, detail, repair)
    excluded = exclusion(about, exclude)
    rig = ring(about, fov, diameter, working_distance)
    constraints = placement.Constraints(min_separation=min_separation)
    output_folder(out, OUTPUTS, force)
    with progress_stages() as progress:
        result = placement.optimise(
            about.mesh, rig, n_cameras, threshold, excluded.mask, constraints, seed=seed, progress=progress
        )
        progress("drawing", 0, 1)
        layout_file.write(out / OUTPUTS[0], layout_file.placement_content(result, about.name, excluded.words))
        rows = _rows(result, about.mesh, excluded.mask)
        layout_table.write_csv(out / OUTPUTS[1], rows)
        panels = [
            Panel(row.name, row.angles, f"{row.area:.1f} mm², {100 * row.fraction:.2f} % of the ring maximum")
            for row in (rows[0], rows[-1])
        ]
        write_coverage(out / OUTPUTS[2], about.name, about.mesh, rig, panels, threshold, excluded.mask)
    console = Console()
    console.print(
        f"{about.name}: {len(about.mesh.faces)} faces; not counted: {excluded.words}\n"
        f"ring maximum ({result.settings.ring_cameras} cameras): {result.ring_area:.2f} mm²; a point counts when at "
        f"least {threshold} of the {n_cameras} cameras see it",
        highlight=False,
    )
    console.print(layout_table.table(rows, "equidistant"))
    console.print(
        "optimised ring angles [degrees]: " + ", ".join(f"{angle:.3f}" for angle in np.degrees(result.angles)),
        highlight=False,
    )
    console.print(f"wrote {', '.join(str(out / name) for name in OUTPUTS)}", highlight=False)


def _rows(result: placement.Placement, mesh, excluded: np.ndarray) -> list[layout_table.Row]:
    best_phase = result.best_equidistant_phase
    layouts = [
        ("equidistant", result.ring.equidistant(result.n_cameras), result.equidistant_area),
        (
            f"equidistant, best phase ({np.degrees(best_phase):.1f}°)",
            result.ring.equidistant(result.n_cameras, best_phase),
            result.best_equidistant_area,
        ),
        ("optimised", np.array(result.angles), result.area),
    ]
    return [
        layout_row(name, angles, area, result.ring_area, result.equidistant_area, mesh, result.ring, excluded)
        for name, angles, area in layouts
    ]


def layout_row(
    name: str, angles: np.ndarray, area: float, maximum: float, base: float, mesh, rig: exact.Ring, excluded: np.ndarray
) -> layout_table.Row:
    """The figures of one layout, compared with one of area `base`."""
    spread = placement.triangulation(mesh, rig, angles, excluded)
    gain = None if name == "equidistant" else (area - base) / maximum
    return layout_table.Row(
        name, angles, area, area / maximum, gain, spread.smallest_separation, spread.widest_angle, spread.mean_best_angle
    )
