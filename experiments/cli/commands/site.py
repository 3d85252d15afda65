"""camring site: the built-in reference sites as mesh files."""

from pathlib import Path

import meshes
from experiments.files.errors import InputError
from experiments.files.whole import output_file, written_whole
from experiments.request.meshes import subject
from experiments.terminal.console import print_json, table, terminal


def run(
    name: str | None,
    depth: float | None,
    detail: str | None,
    listing: bool,
    out: Path | None,
    gallery: Path | None,
    force: bool,
    as_json: bool = False,
) -> None:
    """List the sites, draw them all, or write one."""
    if gallery is not None:
        if name is not None or depth is not None or out is not None or listing:
            raise InputError("--gallery draws all sites; leave out NAME, --depth, --out and --list, or leave it out")
        _draw_gallery(gallery, detail or "middle", force, as_json)
        return
    if listing and as_json:
        sites = [
            {"name": site.name, "depths_mm": site.depths, "fov_mm": site.fov, "title": site.title}
            for site in meshes.SITES.values()
        ]
        print_json({"sites": sites, "details": meshes.DETAILS})
        return
    if listing:
        shown = table("site", "depths [mm]", "field of view [mm]", "what it shows")
        for site in meshes.SITES.values():
            depths = ", ".join(f"{d:g}" for d in site.depths)
            shown.add_row(site.name, depths, f"{site.fov[0]:g} x {site.fov[1]:g}", site.title)
        terminal().print(shown)
        return
    if name is None:
        raise InputError("which site? Give its name, or --list or --gallery to see them all")
    if out is None:
        raise InputError("where to? Give --out with a mesh file, as in --out site.stl")
    if name not in meshes.SITES:
        raise meshes.MeshError(f"there is no site {name!r}; choose one of {', '.join(meshes.SITES)}")
    if out.suffix.lower() not in (".stl", ".ply", ".obj"):
        raise InputError(f"--out is {out}; its ending must be .stl, .ply or .obj")
    output_file(out, force)
    about = subject(name, depth, detail)
    with written_whole(out) as temporary:
        if out.suffix.lower() == ".stl":
            temporary.write_bytes(meshes.stl_bytes(about.mesh))
        else:
            data = about.mesh.export(file_type=out.suffix.lower()[1:])
            temporary.write_bytes(data if isinstance(data, bytes) else str(data).encode())
    size = about.mesh.extents.tolist()
    if as_json:
        figures = {"n_faces": len(about.mesh.faces), "area_mm2": float(about.mesh.area), "extents_mm": size}
        print_json({"files": [str(out)], "name": about.name, **figures})
        return
    print(
        f"{out}: {about.name}, {len(about.mesh.faces)} faces, {about.mesh.area:.1f} mm², "
        f"{size[0]:.1f} x {size[1]:.1f} x {size[2]:.1f} mm, watertight"
    )


def _draw_gallery(path: Path, detail: str, force: bool, as_json: bool) -> None:
    from experiments.figures.site_gallery import (  # matplotlib is heavy, and the rest needs none
        gallery_rows,
        write_gallery,
    )

    if path.suffix.lower() != ".png":
        raise InputError(f"--gallery is {path}; its ending must be .png")
    output_file(path, force)
    rows = gallery_rows()
    write_gallery(path, rows, detail)
    if as_json:
        print_json({"files": [str(path)]})
        return
    n_sites = sum(len(row) for row in rows)
    print(f"{path}: {n_sites} site{'s' if n_sites > 1 else ''} cut open, detail {detail}")
