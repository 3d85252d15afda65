"""`camring optimise` with several rings: which camera sits on which, computed, printed, written and drawn."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import exact
import placement
from experiments.exports import coverage_mesh, formats
from experiments.exports.cameras import named_on_rings
from experiments.files.errors import InputError
from experiments.files.ring_maximum_cache import RememberedAreas
from experiments.files.table import write_table
from experiments.layouts import layout_content
from experiments.layouts.rings_content import rings_content
from experiments.report import NAME as REPORT
from experiments.request import rig as rig_file
from experiments.request.option_text import parse_ring
from experiments.request.request import Request
from experiments.tables.several_rings import all_rings, best_alone, places_words, rings_rows, rings_table
from experiments.terminal.console import note, print_json, terminal
from experiments.terminal.progress import progress_stages

CONTENT, TABLE, PICTURE = RINGS_OUTPUTS = ("several_rings.json", "several_rings.csv", "several_rings.png")
# What --ring says itself.
SAID = {"diameter": "--diameter", "working_distance": "--working-distance"}
# Of the grid of the bound, unless a rig file says otherwise than for one ring.
STEP = float(np.radians(15.0))


class SeveralRings(NamedTuple):
    """Rings, and the most cameras that each takes, None for as many as there is room for."""

    rings: tuple[exact.Ring, ...]
    most: tuple[int | None, ...]


def refuse_for_several(options: Mapping[str, Any]) -> None:
    """Refuse options that are about one ring, or say what each of several says itself.

    Raises
    ------
    InputError
    """
    for name, flag in SAID.items():
        if options.get(name) is not None:
            raise InputError(f"each ring says what {flag} does; leave it out, or the rings")


def rings_asked(texts: Sequence[str], tables: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Of each ring the fields of `exact.Ring` and "most" that options give, or else the tables of a rig file.

    Raises
    ------
    InputError

    Examples
    --------
    >>> rings_asked(["30x400", "16x380@40x30:1"], [])[1]
    {'diameter': 16.0, 'working_distance': 380.0, 'fov': (40.0, 30.0), 'most': 1}
    """
    of_texts = [parse_ring(text)._asdict() for text in texts]
    return [{name: value for name, value in one.items() if value is not None} for one in of_texts] or list(tables)


def checked_rings(given: Sequence[dict[str, Any]], options: Mapping[str, Any], asked: Request) -> SeveralRings:
    """The rings, where they say nothing else as that of the request; `options` go before what they say.

    Raises
    ------
    InputError, exact.ExactError
    """
    kept = asked.rig.constraints
    if len(given) > 1 and (kept.fixed or kept.forbidden):
        raise InputError(
            "fixed cameras and forbidden arcs are those of one ring; with several, leave them out here and give each "
            "ring its own in placement.optimise_rings"
        )
    named = {"roll": "roll_deg"}
    rings = []
    for one in given:
        own = {
            name: value for name, value in one.items()
            if name != rig_file.MOST and options.get(name) is None and options.get(named.get(name, name)) is None
        }  # fmt: skip
        rings.append(replace(asked.ring, **own))
    return SeveralRings(tuple(rings), tuple(one.get(rig_file.MOST) for one in given))


def optimise_rings(
    several: SeveralRings, asked: Request, names: Sequence[str], meshes_too: bool, with_report: bool,
    files: Sequence[str], out: Path, as_json: bool,
) -> float:  # fmt: skip
    """Compute, print and write into the folder `out`, which is there; the fraction of what all rings see."""
    from experiments.figures.several_rings import write_several_rings  # drawing is heavy, and one ring needs none of it

    settings = asked.rig.settings
    if settings.certificate_step == placement.Settings().certificate_step:
        settings = replace(settings, certificate_step=STEP)
    scenes = [pose.scene for pose in asked.poses]
    with progress_stages() as progress:
        found = placement.optimise_rings(
            scenes, several.rings, asked.rig.n_cameras, most=several.most, constraints=asked.rig.constraints,
            certify=asked.rig.certify, give_up=asked.rig.give_up, settings=settings, seed=asked.rig.seed,
            site_weights=[pose.weight for pose in asked.poses], demand=asked.rig.demand, memory=RememberedAreas(),
            objective=asked.rig.objective,  # type: ignore[arg-type] - checked by it
            progress=progress,
        )  # fmt: skip
        progress("drawing", 0, 1)
        content, rows = rings_content(found, asked), rings_rows(found, asked.n_poses)
        layout_content.write(out / CONTENT, content)
        write_table(out / TABLE, rows)
        alone, together = best_alone(found), all_rings(found)
        shown = [together] if alone is None else [alone, together]
        write_several_rings(out / PICTURE, asked.poses[0].name, scenes[0], found.rings, shown, found.demand)
        formats.write(out, names, named_on_rings(found.rings, found.ring_of, found.angles), asked.subjects[0])
        if meshes_too:
            files = (*files, *coverage_mesh.write(out, exact.evaluate(scenes[0], found.cameras, demand=found.demand)))
        if with_report:
            from experiments.report import rings_page
            from experiments.report.request_text import Made

            made = Made(content, found.rings, found.demand)
            rings_page.write(out / REPORT, made, scenes[0], rows, alone, together)
            files = (*files, REPORT)
    if as_json:
        print_json(content | {"layouts": rows})
    else:
        _print(found, asked, rows)
    note(f"wrote {', '.join(str(out / name) for name in (*RINGS_OUTPUTS, *files))}")
    return found.fraction


def _print(found: placement.RingsPlacement, asked: Request, rows: Sequence[dict[str, Any]]) -> None:
    console = terminal()
    for about, excluded in zip(asked.subjects, asked.excluded, strict=True):
        console.print(f"{about.name}: {len(about.mesh.faces)} faces; not counted: {excluded.words}")
    console.print(
        f"all rings together ({found.settings.ring_cameras} cameras on each): {found.maximum_area / asked.n_poses:.2f} "
        f"mm²; a point counts when {found.demand.clause(f' of the {found.n_cameras}')}"
    )
    console.print(rings_table(rows))
    for row in rows:
        if row["refused"]:
            console.print(f"no layout of {row['layout']} alone: {row['refused']}")
    console.print(f"optimised cameras: {places_words(found)}")
    if found.certificate is not None:
        console.print(found.certificate.statement)
    elif asked.rig.certify:
        console.print("no bound: it would take long for so many faces and rings; --certify-on surface has it anyhow")
