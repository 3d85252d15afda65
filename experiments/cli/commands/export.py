"""camring export: a layout in the formats of other programs."""

from pathlib import Path
from typing import Any

from experiments.exports import formats
from experiments.exports.cameras import named_cameras, parse_resolution
from experiments.files.errors import InputError
from experiments.request import layout_file
from experiments.request.meshes import Subject, subject
from experiments.terminal.console import note, print_json


def run(
    layout: Path,
    format: str,
    mesh: str | None,
    depth: float | None,
    detail: str | None,
    options: dict[str, Any],
    resolution: str | None,
    out: Path,
    force: bool,
    as_json: bool = False,
) -> None:
    """Read, check, write."""
    if "mesh" in {word.strip().lower() for word in format.split(",")}:
        raise InputError(
            "--format: mesh is no format of cameras; the reconstructable and the coloured meshes are written by "
            f"camring evaluate MESH --layout {layout} --out FOLDER, and by camring optimise --export mesh"
        )
    names = formats.parse_formats(format, "--format")
    size = None if resolution is None else parse_resolution(resolution)
    made = layout_file.read(layout)
    shows_site = [name for name in names if formats.FORMATS[name].needs_site]
    if mesh is None and shows_site:
        origin = made.content.get("mesh")
        hint = f", {origin['name']!r}," if isinstance(origin, dict) and "name" in origin else ""
        raise InputError(
            f"{shows_site[0]} shows the site with the cameras; give the mesh{hint} that the layout was made for, "
            "as in --mesh scan.stl"
        )
    if mesh is not None and not shows_site:
        wanted = " or ".join(name for name, chosen in formats.FORMATS.items() if chosen.needs_site)
        raise InputError(f"--mesh is for {wanted} only; add it to --format, or leave --mesh out")
    if mesh is None and (depth is not None or detail is not None or any(options.values())):
        raise InputError(
            "--depth, --detail, --repair and --two-sided say which mesh; give --mesh too, or leave them out"
        )
    site = None if mesh is None else _site(made, mesh, depth, detail, options, force)
    files = formats.prepare(out, names, force)
    cameras = named_cameras(made.ring, made.angles, size, made.rolls)
    formats.write(out, names, cameras, site)
    width, height = cameras[0].size
    if as_json:
        names = [camera.name for camera in cameras]
        print_json({"cameras": names, "resolution_px": [width, height], "files": [str(out / file) for file in files]})
    else:
        print(f"{len(cameras)} camera{'s' if len(cameras) > 1 else ''}, {width} x {height} pixels each")
    note(f"wrote {', '.join(str(out / file) for file in files)}")


def _site(
    made: layout_file.LayoutFile,
    mesh: str,
    depth: float | None,
    detail: str | None,
    options: dict[str, Any],
    force: bool,
) -> Subject:
    site = subject(mesh, depth, detail, ring=made.ring, **made.loaded(mesh, options))
    made.refuse_other_mesh(site.mesh, site.name, force)
    return site
