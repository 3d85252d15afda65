"""camring ring: the same request on many rings."""

import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import exact
import placement
from experiments.cli.results_folder import results_folder
from experiments.figures.rings import write_rings
from experiments.files.errors import InputError, TargetMissed
from experiments.files.table import write_table
from experiments.files.whole import output_folder
from experiments.layouts import layout_content
from experiments.request import rig as rig_file
from experiments.request.option_text import parse_fov, parse_steps
from experiments.request.request import Request, request
from experiments.rings.tasks import Asked
from experiments.sweeps.record import write_record
from experiments.sweeps.sweep import shown_sweep
from experiments.sweeps.task import Outcome
from experiments.tables.rings import mark_undominated, refined_row, refined_table, ring_row, ring_table
from experiments.terminal.console import note, print_json, terminal
from placement.search.refined_ring import counted_area

TABLE, PICTURE, RECORD = OUTPUTS = ("rings.csv", "rings.png", "record.json")
REFINED, LAYOUTS, REFINED_LAYOUTS, TASKS = "refined.csv", "layouts", "refined", "tasks"
# More rings are a slip of a step, or a matter of days.
MOST_RINGS = 2000


def run(
    meshes: list[str],
    rig_path: Path | None,
    options: dict[str, Any],
    *,
    diameter: str | None,
    working_distance: str | None,
    fov: str | None,
    refine: bool,
    depth: float | None,
    detail: str | None,
    scheduler: str | None,
    out: Path,
    force: bool,
    as_json: bool,
) -> None:
    """Compute what is not on disk, print and write; `options` are those of the rig, by the names of their keys."""
    started = time.monotonic()
    first = None if fov is None else fov.partition(",")[0]
    asked = request(meshes, depth, detail, rig_file.rig(rig_path, **options, fov=first, certify=False))
    every = rings(asked.ring, diameter, working_distance, fov)
    if refine and len({(ring.diameter, ring.working_distance) for ring in every}) == 1:
        raise InputError("--refine needs room: give --diameter or --working-distance a range, as in 20:40:5")
    refused = {number: why for number, ring in enumerate(every) if (why := _why_not(asked, ring))}
    if len(refused) == len(every):
        raise placement.PlacementError(
            f"none of the {len(every)} rings can hold the cameras; of the first, {refused[0]}"
        )
    # The record is written last: a folder without it is that of a run to go on with.
    results_folder(out, (RECORD,), asked.subjects[0], force or not (out / RECORD).exists())
    sweep = Asked(tuple(meshes), depth, detail, asked)
    tasks = {number: sweep.task(ring) for number, ring in enumerate(every) if number not in refused}
    outcomes, pool, n_resumed = shown_sweep("rings", list(tasks.values()), out / TASKS, scheduler)
    found: dict[int, Outcome] = dict(zip(tasks, outcomes, strict=True))
    results = [_result(found.get(number), refused.get(number, "")) for number in range(len(every))]
    counted = [counted_area(pose.scene) for pose in asked.poses]
    shares = None if asked.rig.objective == "worst" else _shares(asked)
    rows = [
        ring_row(layout_content.ring_content(ring), result, counted, shares)
        for ring, result in zip(every, results, strict=True)
    ]
    mark_undominated(rows)
    failures = [outcome.failure for outcome in outcomes if outcome.failure]
    if all(row["area_mm2"] is None for row in rows) and not failures:
        raise placement.PlacementError(
            f"none of the {len(every)} rings has a layout; of the first, {rows[0]['refused']}"
        )
    starts = [result["layout"] for row, result in zip(rows, results, strict=True) if refine and row["undominated"]]
    further = [sweep.refinement(start, *_bounds(every)) for start in starts]
    moved, _, n_moved = shown_sweep("refining", further, out / TASKS, scheduler) if further else ([], "", 0)
    tasks |= {len(every) + number: task for number, task in enumerate(further)}
    outcomes, n_resumed = [*outcomes, *moved], n_resumed + n_moved
    failures += [outcome.failure for outcome in moved if outcome.failure]
    refined = [
        refined_row(start, outcome.result)
        for start, outcome in zip(starts, moved, strict=True) if outcome.result is not None
    ]  # fmt: skip
    if refined:
        write_table(out / REFINED, refined)
    write_table(out / TABLE, rows)
    _write_layouts(out / LAYOUTS, [result["layout"] for result in results if "layout" in result])
    _write_layouts(out / REFINED_LAYOUTS, [outcome.result["layout"] for outcome in moved if outcome.result is not None])
    if any(row["area_mm2"] is not None for row in rows):
        n = asked.rig.n_cameras
        write_rings(out / PICTURE, f"{asked.name}: {n} camera{'s' if n > 1 else ''} on rings of each size", rows)
    settings = {"command": "camring ring", "rig": tasks[min(tasks)].inputs["rig"], "rings": len(every)}
    hashes = {pose.name: pose.scene.mesh_hash for pose in asked.poses}
    wall = time.monotonic() - started
    write_record(out / RECORD, settings, hashes, list(tasks.values()), outcomes, pool, wall, n_resumed)
    if as_json:
        print_json({"counted_area_mm2": sum(counted) / asked.n_poses, "rings": rows, "refined": refined})
    else:
        _print(asked, counted, rows)
        if refined:
            terminal().print(refined_table(refined))
    files = (*OUTPUTS, *[REFINED] * bool(refined), LAYOUTS, *[REFINED_LAYOUTS] * bool(refined))
    note(f"wrote {', '.join(str(out / name) for name in files)}")
    if failures:
        raise TargetMissed(f"{len(failures)} of {len(tasks)} rings failed, the first with {failures[0]}")


def rings(first: exact.Ring, diameter: str | None, working_distance: str | None, fov: str | None) -> list[exact.Ring]:
    """Rings of all these sizes, at the place of the first; where nothing is said, as it is.

    Raises
    ------
    InputError, exact.ExactError

    Examples
    --------
    >>> [(ring.diameter, ring.working_distance) for ring in rings(exact.Ring(), "20:30:10", "300", None)]
    [(20.0, 300.0), (30.0, 300.0)]
    """
    diameters = (first.diameter,) if diameter is None else parse_steps(diameter, "--diameter")
    distances = (
        (first.working_distance,) if working_distance is None else parse_steps(working_distance, "--working-distance")
    )
    views = (first.fov,) if fov is None else tuple(parse_fov(part, "--fov") for part in fov.split(","))
    n = len(diameters) * len(distances) * len(views)
    if n > MOST_RINGS:
        raise InputError(f"these are {n} rings; ask for at most {MOST_RINGS}, with longer steps")
    return [
        replace(first, diameter=one, working_distance=distance, fov=view)
        for view in dict.fromkeys(views) for distance in distances for one in diameters
    ]  # fmt: skip


def _why_not(asked: Request, ring: exact.Ring) -> str:
    """Why a ring cannot hold the cameras under the constraints; empty if it can."""
    try:
        replace(asked, ring=ring).check_cameras(asked.rig.n_cameras)
    except placement.PlacementError as error:
        return str(error)
    return ""


def _result(outcome: Outcome | None, refused: str) -> dict[str, Any]:
    if outcome is None or outcome.result is None:
        return {"refused": refused or (outcome.failure if outcome else "")}
    return outcome.result


def _shares(asked: Request) -> np.ndarray:
    weights = np.array([pose.weight for pose in asked.poses])
    return weights / weights.sum()


def _bounds(every: Sequence[exact.Ring]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Least and greatest diameter and working distance [mm]."""
    diameters, distances = zip(*((ring.diameter, ring.working_distance) for ring in every), strict=True)
    return (min(diameters), max(diameters)), (min(distances), max(distances))


def _write_layouts(folder: Path, layouts: Sequence[dict[str, Any]]) -> None:
    """A file for each layout, named by its ring."""
    if layouts:
        output_folder(folder, (), force=True)
    for layout in layouts:
        layout_content.write(folder / f"{layout_name(layout['ring'])}.json", layout)


def layout_name(ring: dict[str, Any]) -> str:
    """Name of the layout file of a ring, as it stands in one, without its ending.

    Examples
    --------
    >>> layout_name(layout_content.ring_content(exact.Ring(diameter=22.5)))
    'd22.5_h400_fov36x24'
    """
    width, height = ring["fov_mm"]
    return f"d{ring['diameter_mm']:.9g}_h{ring['working_distance_mm']:.9g}_fov{width:.9g}x{height:.9g}"


def _print(asked: Request, counted: Sequence[float], rows: Sequence[dict[str, Any]]) -> None:
    console = terminal()
    n = asked.rig.n_cameras
    console.print(
        f"{asked.name}: {n} camera{'s' if n > 1 else ''} on each of {len(rows)} rings; a point counts when "
        f"{asked.demand.clause(f' of the {n}')}"
    )
    console.print(ring_table(rows))
    console.print(
        "* no other ring has both more area and less error. A ring's maximum is what "
        f"{asked.settings.ring_cameras} cameras on it reconstruct, and differs from ring to ring; the counted "
        f"area, {sum(counted) / asked.n_poses:.2f} mm², is that of all faces that count, seen or not."
    )
    for row in rows:
        if row["area_mm2"] is None:
            console.print(f"no layout on {row['diameter_mm']:g} x {row['working_distance_mm']:g}: {row['refused']}")
