"""camring compare: several layouts scored on the same mesh."""

from pathlib import Path
from typing import Any

import exact
import placement
from experiments.cli.commands.evaluate import refuse_unseen
from experiments.figures.coverage import Panel, write_coverage
from experiments.files.errors import InputError
from experiments.files.whole import output_folder
from experiments.request import layout_file
from experiments.request.meshes import exclusion, subject
from experiments.request.rig import demanded
from experiments.tables import layouts as layout_table
from experiments.terminal.console import note, print_json, terminal
from experiments.terminal.progress import progress_bar

OUTPUTS = ("layouts.csv", "coverage.png")
# Equidistant cameras whose exact area is the ring maximum (Wachter 2021, Table A1).
RING_CAMERAS = placement.Settings().ring_cameras


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
        if one.ring != read[0].ring:
            raise InputError(
                f"{one.path} and {read[0].path} are layouts of different rings ({one.ring} and {read[0].ring}); "
                "areas and fractions compare on one ring only: score each with camring evaluate --layout"
            )
    # One demand for all, or their areas would not compare: the strictest that any of them was made for.
    strictest = max(one.min_baseline for one in read)
    asked = demanded(options, threshold=read[0].threshold, min_baseline=strictest)
    threshold, baseline = asked.threshold, asked.baseline
    scale = 1.0 if options["scale"] is None else options["scale"]
    about = subject(mesh, depth, detail, bool(options["repair"]), scale)
    for one in read:
        one.refuse_other_mesh(about.mesh, about.name, force)
    excluded = exclusion(about, options["exclude"])
    if out is not None:
        output_folder(out, OUTPUTS, force)
    rig, rows = read[0].ring, []
    with progress_bar("scoring exactly", RING_CAMERAS + sum(len(one.angles) for one in read)) as advance:

        def area(angles, apart: float) -> float:
            cameras = rig.cameras(angles)
            result = exact.evaluate(
                about.mesh, cameras, threshold=threshold, exclude=excluded.mask, min_baseline=apart, report=advance
            )
            refuse_unseen(about, result)
            return result.area

        areas = [area(one.angles, baseline) for one in read]
        maximum = area(rig.equidistant(RING_CAMERAS), 0.0)  # whatever the baseline
    for one, found in zip(read, areas, strict=True):
        spread = placement.triangulation(about.mesh, rig, one.angles, threshold, excluded.mask, min_baseline=baseline)
        gain = None if one is read[0] else (found - areas[0]) / maximum
        rows.append(layout_table.row(str(one.path), one.angles, found, found / maximum, gain, spread))
    content: dict[str, Any] = {
        "mesh": {"name": about.name, "excluded": excluded.words, "scale": scale},
        "ring": layout_file.ring_content(rig),
        "threshold": threshold,
        "min_baseline_mm": baseline,
        "ring_maximum_mm2": maximum,
        "layouts": [layout_table.figures(row) for row in rows],
    }
    if as_json:
        print_json(content)
    else:
        apart = f", two of them at least {baseline:.4g} mm apart" if baseline > 0 else ""
        console = terminal()
        console.print(
            f"{about.name}: {len(about.mesh.faces)} faces; not counted: {excluded.words}\n"
            f"ring maximum ({RING_CAMERAS} cameras): {maximum:.2f} mm²; a point counts when at least {threshold} "
            f"cameras see it{apart}",
        )
        console.print(layout_table.layout_table(rows, "the first"))
    if out is None:
        return
    layout_table.write_csv(out / OUTPUTS[0], rows)
    panels = [
        Panel(row.name, row.angles, f"{row.area:.1f} mm², {100 * row.fraction:.2f} % of the ring maximum")
        for row in rows
    ]
    write_coverage(out / OUTPUTS[1], about.name, about.mesh, rig, panels, threshold, excluded.mask)
    note(f"wrote {', '.join(str(out / name) for name in OUTPUTS)}")
