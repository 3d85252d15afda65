"""camring export: a layout in the formats of other programs."""

from pathlib import Path
from typing import Any

from experiments.exports import formats
from experiments.exports.cameras import named_cameras, named_on_rings, parse_resolution
from experiments.files.errors import InputError
from experiments.layouts import layout_file
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
    made = layout_file.read(layout, several=True)
    shows_site = [name for name in names if formats.FORMATS[name].needs_site]
    if mesh is None and shows_site:
        names_known = list(dict.fromkeys(made.made_for.values()))
        hint = f", {names_known[0]!r}," if names_known else ""
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
    if len(made.rings) > 1:
        cameras = named_on_rings(made.rings, made.ring_of, made.angles, size)
    else:
        cameras = named_cameras(made.ring, made.angles, size, made.rolls)
    formats.write(out, names, cameras, site)
    sizes = list(dict.fromkeys(camera.size for camera in cameras))
    if as_json:
        names = [camera.name for camera in cameras]
        files_written = [str(out / file) for file in files]
        print_json({"cameras": names, "resolution_px": list(sizes[0]), "files": files_written})
    else:
        each = " or ".join(f"{width} x {height}" for width, height in sizes)
        print(f"{len(cameras)} camera{'s' if len(cameras) > 1 else ''}, {each} pixels each")
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
