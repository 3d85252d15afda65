"""camring check: all about a mesh file that matters to an area on it."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

import exact
import meshes
from experiments.files.errors import InputError
from experiments.files.whole import output_file
from experiments.request import placing
from experiments.request import rig as rig_file
from experiments.request.meshes import USUAL_FOV, is_site, printable
from experiments.request.outlook import IN_VIEW, forecast, places, seen, unit_words
from experiments.terminal.console import note, print_json, table, terminal
from experiments.terminal.progress import working


def run(
    mesh: str, rig_path: Path | None, options: dict[str, Any], *, out: Path | None, force: bool, as_json: bool
) -> None:
    """Read, look at it from all sides, print and draw; in the end, refuse what every other command would refuse.

    `options` are those of the rig, by the names of their keys.
    """
    if is_site(mesh):
        raise InputError(f"{mesh} is a built-in site, and sound; give a mesh file")
    rig = rig_file.rig(rig_path, **options)
    ring = rig.ring(USUAL_FOV)
    if out is not None:
        if out.suffix.lower() != ".png":
            raise InputError(f"--out is {out}; its ending must be .png")
        output_file(out, force)
    read, place = meshes.read(mesh, rig.scale), None
    if rig.place == "auto":
        ring, place = placing.over(placing.before_repair(read, True, mesh, False), ring)
    with working("looking at the mesh from all sides"):
        found = meshes.inspect(read, mesh, seen_from=places(ring))
        sight = seen(read, ring)
    unit = unit_words(max(found.extents), rig.scale)
    name = printable(Path(mesh).name)
    refused = meshes.MeshError(found.refused).at_command_line
    if as_json:
        content = asdict(found) | {"refused": refused or None, "in_view": sight.in_view, "unit": unit}
        content["place"] = placing.content(place)
        content = {"bounds_mm" if key == "bounds" else "area_mm2" if key == "area" else key: value
                   for key, value in content.items()}  # fmt: skip
        print_json({"mesh": name, **content, "files": [] if out is None else [str(out)]})
    else:
        _print(name, found, sight.in_view, unit, refused, ring)
    if place is not None:
        note(f"placed: {mesh}: {placing.words(place)}")
    if out is not None:
        from experiments.figures.mesh_views import write_views  # matplotlib is heavy, and the rest needs none

        write_views(out, name, read, ring)
        note(f"wrote {out}")
    if refused:
        raise InputError(refused)


def _print(
    name: str, found: meshes.Inspection, in_view: float, unit: str | None, refused: str, ring: exact.Ring
) -> None:
    low, high = found.bounds
    open_bodies = found.n_bodies - found.n_closed
    rows = [
        ("faces", f"{found.n_faces} triangles of {found.n_vertices} vertices"
                  + (f", {found.n_file_faces} faces in the file" if found.n_file_faces != found.n_faces else "")),
        ("size", f"{' x '.join(f'{side:.4g}' for side in found.extents)} mm, {found.area:.6g} mm²"),
        ("unit", unit or "millimetres, by its size"),
        ("where it lies", ", ".join(f"{axis} {a:.4g} to {b:.4g}" for axis, a, b in zip("xyz", low, high, strict=True))
                          + f" mm; the cameras look at {', '.join(f'{one:g}' for one in ring.focus)}"),
        ("closed", "yes" if found.watertight else
                   f"no: {found.n_border_edges} edges of one face, {found.n_crowded_edges} of more than two"),
        ("bodies", f"{found.n_bodies}, of which {open_bodies} open"),
        ("winding", _winding(found)),
        ("on top of others", found.overlapping or "no face"),
        ("opens towards", _direction(found.opening)),
        ("seen by the cameras", f"{100 * in_view:.1f} % of its surface, of which {100 * (found.back_share or 0):.1f} % "
                                "from behind"
                                + ("; --place auto finds a place for the ring" if in_view < IN_VIEW else "")),
        ("eight cameras take", forecast(found.n_faces)),
        ("mended unasked", "; ".join(found.notes) or "nothing"),
        ("--repair", _repair(found)),
        ("without --repair", f"refused: {refused}" if refused else "used as it is"),
    ]  # fmt: skip
    shown = table(name, "")
    for row in rows:
        shown.add_row(*row)
    terminal().print(shown)


def _winding(found: meshes.Inspection) -> str:
    if found.one_sided:
        return "one-sided: a part is joined on crosswise"
    if found.n_mixed:
        return f"mixed: {found.n_mixed} pairs of neighbours in opposite senses"
    return f"alike, {found.n_inside_out} bodies inside-out" if found.n_inside_out else "alike"


def _repair(found: meshes.Inspection) -> str:
    if found.repairs:
        return "; ".join(found.repairs)
    return "cannot mend it; --two-sided counts both sides" if found.one_sided else "changes nothing"


def _direction(opening: tuple[float, ...] | None) -> str:
    if opening is None:
        return "nowhere: it has no hollow"
    axis = int(np.argmax(np.abs(opening)))
    near = f"{'-' if opening[axis] < 0 else '+'}{'xyz'[axis]}"
    vector = ", ".join(f"{one:.2f}" for one in opening)
    return f"{near} ({vector})"
