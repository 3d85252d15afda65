"""camring compare: several layouts scored on the same mesh."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import exact
import placement
from experiments.cli.commands.evaluate import refuse_unseen
from experiments.cli.results_folder import results_folder
from experiments.figures.coverage import Panel, write_coverage
from experiments.files.errors import InputError
from experiments.layouts import layout_content, layout_file
from experiments.request.exact_work import ring_maximum, workers_for
from experiments.request.meshes import exclusion, subject
from experiments.request.rig import checked_place, overridden
from experiments.tables import layouts as layout_table
from experiments.terminal.console import note, print_json, terminal
from experiments.terminal.progress import progress_bar

OUTPUTS = ("layouts.csv", "coverage.png")


def run(
    layouts: list[Path],
    mesh: str,
    options: dict[str, Any],
    *,
    depth: float | None,
    detail: str | None,
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Score, print and write. `options` are those of the rig, by their keys."""
    if len(layouts) < 2:
        raise InputError(f"{len(layouts)} layout is given; at least two are needed to compare")
    read = [layout_file.read(path) for path in layouts]
    for one in read[1:]:
        if _turned(one.ring) != _turned(read[0].ring):
            raise InputError(
                f"{one.path} and {read[0].path} are layouts of different rings ({one.ring} and {read[0].ring}); "
                "areas and fractions compare on one ring only: score each with camring evaluate --layout"
            )
    # One demand for all, or their areas would not compare: of baselines the strictest that any of them was made for.
    strictest = replace(read[0].demand, min_baseline=max(one.demand.min_baseline for one in read))
    loaded = read[0].loaded(mesh, options)
    about = subject(mesh, depth, detail, ring=read[0].ring, place=checked_place(options) == "auto", **loaded)
    rig = read[0].ring if about.ring is None else about.ring
    for one in read:
        one.refuse_other_mesh(about.mesh, about.name, force)
    moved = replace(read[0], demand=strictest).moved_to(rig)
    demand = overridden(moved, options)
    excluded = exclusion(about, options["exclude"])
    scene = exact.Scene(about.mesh, exclude=excluded.mask)
    if out is not None:
        results_folder(out, OUTPUTS, about, force)
    rows, n_ring = [], placement.Settings().for_faces(scene.n_faces).ring_cameras
    n_cameras = sum(len(one.angles) for one in read)
    with progress_bar("scoring exactly", n_ring + n_cameras) as advance:
        workers = workers_for(scene, n_cameras)
        results = []
        for one in read:
            cameras = rig.cameras(one.angles, one.rolls)
            results.append(
                exact.evaluate(scene, cameras, demand=demand, workers=workers, report=advance, all_views=True)
            )
            refuse_unseen(about, results[-1], rig)
        areas, errors = [result.area for result in results], [result.error_rms for result in results]
        maximum = ring_maximum(scene, (rig,), demand, n_ring, advance)
    for one, found, error in zip(read, areas, errors, strict=True):
        spread = placement.triangulation(scene, rig, one.angles, rolls=one.rolls, demand=demand)
        gain = None if one is read[0] else (found - areas[0]) / maximum
        rows.append(layout_table.row(str(one.path), one.angles, found, found / maximum, gain, spread, error))
    content: dict[str, Any] = {
        "mesh": {"name": about.name, "excluded": excluded.words, "scale": loaded["scale"], **about.told},
        "ring": layout_content.ring_content(rig),
        "threshold": demand.threshold,
        "min_baseline_mm": demand.min_baseline,
        "ring_maximum_mm2": maximum,
        "layouts": [layout_table.figures(row) for row in rows],
    }
    if as_json:
        print_json(content)
    else:
        console = terminal()
        console.print(
            f"{about.name}: {len(about.mesh.faces)} faces; not counted: {excluded.words}\n"
            f"ring maximum ({n_ring} cameras): {maximum:.2f} mm²; a point counts when "
            f"{demand.clause()}",
        )
        console.print(layout_table.layout_table(rows, "the first"))
    if out is None:
        return
    layout_table.write_csv(out / OUTPUTS[0], rows)
    panels = [
        Panel(row.name, row.angles, f"{row.area:.1f} mm², {100 * row.fraction:.2f} % of the ring maximum", one.rolls)
        for row, one in zip(rows, read, strict=True)
    ]
    write_coverage(out / OUTPUTS[1], about.name, scene, rig, panels, demand)
    note(f"wrote {', '.join(str(out / name) for name in OUTPUTS)}")


def _turned(ring: exact.Ring) -> exact.Ring:
    """The ring of equidistant cameras: of free rolls the radial one, whose maximum is the same."""
    return replace(ring, roll="radial") if ring.roll == "free" else ring
