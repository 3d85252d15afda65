"""camring optimise: propose a layout, compare it with equidistant ones, write and draw it."""

from pathlib import Path
from typing import Any

import numpy as np
import trimesh

import exact
import placement
from experiments import coverage_mesh, layout_file, layout_table, rig_file
from experiments.coverage_figure import Panel, write_coverage
from experiments.exports import formats
from experiments.exports.cameras import named_cameras
from experiments.files import output_folder
from experiments.inputs import Request, request
from experiments.progress import progress_stages
from experiments.target import checked_target, reach
from experiments.terminal import note, print_json, terminal

OUTPUTS = ("layout.json", "layouts.csv", "coverage.png")


def run(
    mesh: str,
    rig_path: Path | None,
    options: dict[str, Any],
    *,
    depth: float | None,
    detail: str | None,
    target: float | None,
    export: str | None,
    out: Path,
    force: bool,
    as_json: bool,
) -> None:
    """Optimise, print and write; `options` are those of the rig, by the names of their keys."""
    checked_target(target)
    names = () if export is None else formats.parse_formats(export, "--export", (*formats.FORMATS, "mesh"))
    asked = request(mesh, depth, detail, rig_file.rig(rig_path, **options))
    meshes_too = coverage_mesh.FILES if "mesh" in names else ()
    names = tuple(name for name in names if name in formats.FORMATS)
    output_folder(out, (*OUTPUTS, *meshes_too), force)
    files = formats.prepare(out, names, force)
    with progress_stages() as progress:
        result = placement.optimise(
            asked.about.mesh,
            asked.ring,
            asked.rig.n_cameras,
            asked.rig.threshold,
            asked.excluded.mask,
            asked.rig.constraints,
            asked.rig.settings,
            seed=asked.rig.seed,
            progress=progress,
            certify=asked.rig.certify,
        )
        progress("drawing", 0, 1)
        content = layout_file.placement_content(result, asked.about.name, asked.excluded.words)
        content["mesh"]["scale"] = asked.rig.scale
        layout_file.write(out / OUTPUTS[0], content)
        rows = _rows(result, asked.about.mesh, asked.excluded.mask)
        layout_table.write_csv(out / OUTPUTS[1], rows)
        _draw(out / OUTPUTS[2], asked, rows)
        formats.write(out, names, named_cameras(asked.ring, np.array(result.angles)), asked.about)
        if meshes_too:
            files += _write_meshes(out, asked, result)
    if as_json:
        print_json(content | {"layouts": [layout_table.figures(row) for row in rows]})
    else:
        _print(asked, result, rows)
    note(f"wrote {', '.join(str(out / name) for name in (*OUTPUTS, *files))}")
    reach(target, result.fraction, f"the optimised {asked.rig.n_cameras} cameras")


def _draw(path: Path, asked: Request, rows: list[layout_table.Row]) -> None:
    panels = [
        Panel(row.name, row.angles, f"{row.area:.1f} mm², {100 * row.fraction:.2f} % of the ring maximum")
        for row in (rows[0], rows[-1])
    ]
    write_coverage(
        path, asked.about.name, asked.about.mesh, asked.ring, panels, asked.rig.threshold, asked.excluded.mask
    )


def _write_meshes(out: Path, asked: Request, result: placement.Placement) -> tuple[str, ...]:
    cameras = result.ring.cameras(np.array(result.angles))
    baseline = result.constraints.baseline(result.ring)
    seen = exact.evaluate(asked.about.mesh, cameras, result.threshold, asked.excluded.mask, baseline)
    return coverage_mesh.write(out, asked.about.mesh, asked.excluded.mask, seen)


def _print(asked: Request, result: placement.Placement, rows: list[layout_table.Row]) -> None:
    console = terminal()
    baseline = result.constraints.baseline(result.ring)
    apart = f", two of them at least {baseline:.4g} mm apart" if baseline > 0 else ""
    console.print(
        f"{asked.about.name}: {len(asked.about.mesh.faces)} faces; not counted: {asked.excluded.words}\n"
        f"ring maximum ({result.settings.ring_cameras} cameras): {result.ring_area:.2f} mm²; a point counts when at "
        f"least {result.threshold} of the {result.n_cameras} cameras see it{apart}",
    )
    console.print(layout_table.layout_table(rows, "equidistant"))
    console.print(
        "optimised ring angles [degrees]: " + ", ".join(f"{angle:.3f}" for angle in np.degrees(result.angles)),
    )
    if result.certificate is not None:
        console.print(result.certificate.statement)


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
