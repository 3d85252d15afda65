"""camring tradeoff: what accuracy costs in area."""

from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

import placement
from exact.workers import background
from experiments.cli.results_folder import results_folder
from experiments.figures.tradeoff import write_tradeoff
from experiments.files.table import finite, write_table
from experiments.request import rig as rig_file
from experiments.request.request import request
from experiments.terminal.console import note, print_json, table, terminal
from experiments.terminal.progress import progress_stages
from placement.search.search import import_descent

TABLE, PICTURE = OUTPUTS = ("tradeoff.csv", "tradeoff.png")


def run(
    meshes: list[str],
    rig_path: Path | None,
    options: dict[str, Any],
    *,
    depth: float | None,
    detail: str | None,
    out: Path,
    force: bool,
    as_json: bool,
) -> None:
    """Find the layouts, print and write; `options` are those of the rig, by the names of their keys."""
    asked = request(meshes, depth, detail, rig_file.rig(rig_path, **options))
    asked.check_cameras(asked.rig.n_cameras)
    results_folder(out, OUTPUTS, asked.subjects[0], force)
    background(import_descent)  # while the site is sampled
    with progress_stages() as progress:
        problem, limits = asked.problem(progress), asked.rig.constraints
        found = problem.tradeoff(asked.rig.n_cameras, limits, certify=asked.rig.certify, progress=progress)
    rows = _rows(found)
    write_table(out / TABLE, rows)
    write_tradeoff(out / PICTURE, f"{asked.name}, {asked.rig.n_cameras} cameras", asked.of, found)
    if as_json:
        print_json(
            {
                "n_cameras": asked.rig.n_cameras,
                "bound_fraction": found.bound_fraction,
                "in_words": found.words,
                "layouts": rows,
            }
        )
    else:
        console = terminal()
        console.print(_table(found))
        if found.bound_fraction is not None:
            console.print(f"No layout at any angles reconstructs more than {found.bound_fraction:.2%} of the samples.")
        console.print(found.words)
        most, knee = found.layouts[0], found.knee
        if most.fraction > knee.fraction:
            give_up = np.ceil(1e4 * (most.fraction - knee.fraction)) / 1e4
            console.print(f"camring optimise --give-up {give_up:g} proposes one like the knee, marked with *.")
    note(f"wrote {', '.join(str(out / name) for name in OUTPUTS)}")


def _rows(found: placement.TradeOff) -> list[dict[str, Any]]:
    """Every layout's figures, those that no other beats in both first."""
    others = [layout for layout in found.compared if layout not in found.layouts]
    return [
        {
            "layout": layout.kind,
            "undominated": layout in found.layouts,
            "knee": layout == found.knee,
            "area_mm2": layout.area,
            "fraction_of_ring_maximum": layout.fraction,
            "rms_error_mm": finite(layout.error_rms),
            "ring_angles_deg": np.degrees(layout.angles).tolist(),
        }
        for layout in (*found.layouts, *others)
    ]


def _table(found: placement.TradeOff) -> Table:
    shown = table("layout", "exact area\n[mm²]", "of the ring\nmaximum", "RMS error\n[mm]", "ring angles [°]")
    for layout in found.layouts:
        shown.add_row(
            layout.kind + (" *" if layout == found.knee else ""),
            f"{layout.area:.2f}",
            f"{100 * layout.fraction:.2f} %",
            f"{layout.error_rms:.4f}",
            ", ".join(f"{angle:.1f}" for angle in np.degrees(layout.angles)),
        )
    return shown
