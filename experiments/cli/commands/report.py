"""camring report: the page of a layout that was made before."""

import re
from pathlib import Path
from typing import Any

import numpy as np

import exact
import meshes
from experiments.files.errors import InputError
from experiments.files.whole import output_folder
from experiments.layouts import layout_file
from experiments.report import NAME
from experiments.report import page as report
from experiments.request.meshes import Subject, exclusion, subject
from experiments.terminal.console import note, print_json
from experiments.terminal.progress import working


def run(
    folder: Path,
    mesh: str | None,
    exclude: str | None,
    options: dict[str, Any],
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Read, check, write. `folder` holds layout.json, or is that file."""
    layout = folder if folder.is_file() else folder / "layout.json"
    made = layout_file.read(layout)
    report.check(made)
    out = layout.parent if out is None else out
    output_folder(out, [NAME], force)
    about = _mesh(made, mesh, options)
    shown = exact.Scene(about.mesh, exclude=_excluded(made, about, exclude))
    with working("writing the report"):
        report.write(out / NAME, made, shown)
    if as_json:
        print_json({"files": [str(out / NAME)]})
    note(f"wrote {out / NAME}")


def _mesh(made: layout_file.LayoutFile, mesh: str | None, options: dict[str, Any]) -> Subject:
    """The mesh that the layout was made for, the first of several."""
    first = made.content["meshes"][0]
    if mesh is None:
        known = next((key for key, site in meshes.EXPECTED.items() if site.fingerprint == first["sha256"]), None)
        named = re.fullmatch(r"(\w+), depth (\S+) mm", first["name"])
        if known is not None:
            about = subject(f"{known[0]}@{known[1]:g}", None, known[2])
        elif named is not None and named[1] in meshes.SITES:
            about = subject(f"{named[1]}@{named[2]}", None, None)
        else:
            raise InputError(
                f"{made.path} was made for {first['name']!r}, a file; say where it is, as in --mesh scan.stl"
            )
    else:
        about = subject(mesh, None, None, ring=made.ring, **made.loaded(mesh, options))
    if meshes.fingerprint(about.mesh) != first["sha256"]:
        raise InputError(
            f"{made.path} was made for {first['name']!r}, and {about.name} is not the same mesh; give that one with "
            "--mesh"
        )
    return about


def _excluded(made: layout_file.LayoutFile, about: Subject, choice: str | None) -> np.ndarray:
    """The faces that did not count, found again."""
    first = made.content["meshes"][0]
    words = first["excluded"]
    if choice is None:
        if " listed in " in words:
            raise InputError(f"{made.path}: not counted were {words}; give that file again, as in --exclude faces.txt")
        choice = "none" if words == "nothing" else "top"
    mask = exclusion(about, choice).mask
    if mask.sum() != first["n_excluded_faces"]:
        raise InputError(
            f"--exclude {choice} leaves {mask.sum()} faces out, and {made.path} says {first['n_excluded_faces']} "
            f"({words}); give what it was made with"
        )
    return mask
