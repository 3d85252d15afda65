"""camring optimise: propose a layout, compare it with equidistant ones, write and draw it."""

from pathlib import Path

import numpy as np
import trimesh

import placement
from experiments import layout_file, layout_table
from experiments.coverage_figure import Panel, write_coverage
from experiments.files import output_folder
from experiments.inputs import exclusion, ring, subject
from experiments.progress import progress_stages
from experiments.terminal import terminal

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
    certify: bool,
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
            about.mesh,
            rig,
            n_cameras,
            threshold,
            excluded.mask,
            constraints,
            seed=seed,
            progress=progress,
            certify=certify,
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
    console = terminal()
    console.print(
        f"{about.name}: {len(about.mesh.faces)} faces; not counted: {excluded.words}\n"
        f"ring maximum ({result.settings.ring_cameras} cameras): {result.ring_area:.2f} mm²; a point counts when at "
        f"least {threshold} of the {n_cameras} cameras see it",
    )
    console.print(layout_table.layout_table(rows, "equidistant"))
    console.print(
        "optimised ring angles [degrees]: " + ", ".join(f"{angle:.3f}" for angle in np.degrees(result.angles)),
    )
    if result.certificate is not None:
        console.print(result.certificate.statement)
    console.print(f"wrote {', '.join(str(out / name) for name in OUTPUTS)}")


def _rows(result: placement.Placement, mesh: trimesh.Trimesh, excluded: np.ndarray) -> list[layout_table.Row]:
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
    rows = []
    for name, angles, area in layouts:
        spread = placement.triangulation(mesh, result.ring, angles, result.threshold, excluded)
        gain = None if name == "equidistant" else (area - result.equidistant_area) / result.ring_area
        rows.append(layout_table.row(name, angles, area, result.ring_area, gain, spread))
    return rows
