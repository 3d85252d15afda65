"""The command `camring`: what it understands. What each subcommand does is in its own module.

Heavy libraries are imported by the subcommands, so that `camring --help` answers at once.
"""

import sys
from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(
    name="camring",
    help="Where the cameras of a ring should sit so that they reconstruct the most of a surface. "
    "Lengths in millimetres, angles in degrees.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)

Mesh = Annotated[str, typer.Argument(help="STL, OBJ or PLY file [mm], or the name of a built-in site")]
Depth = Annotated[float | None, typer.Option(help="depth of a built-in site [mm]", show_default="the site's first")]
Detail = Annotated[str | None, typer.Option(help="size of a built-in site: coarse, middle or fine")]
Repair = Annotated[bool, typer.Option("--repair", help="put right what can be: winding, faces without area")]
Threshold = Annotated[int, typer.Option(help="number of cameras that must see a point")]
Fov = Annotated[
    str | None,
    typer.Option(help="field of view at the focus, width x height [mm]", show_default="36x24, or the site's own"),
]
Diameter = Annotated[float, typer.Option(help="diameter of the ring [mm]")]
Distance = Annotated[float, typer.Option(help="distance of the ring's plane from the focus [mm]")]
Exclude = Annotated[
    str | None,
    typer.Option(
        help="faces that do not count: top (the top surface), none, or a file with one face index per line",
        show_default="top for built-in sites, none for files",
    ),
]
Out = Annotated[Path, typer.Option(help="folder for the results; it is made if need be")]
Force = Annotated[bool, typer.Option("--force", help="replace results that are already there")]


@app.command()
def optimise(
    mesh: Mesh,
    cameras: Annotated[int, typer.Option(help="number of cameras")] = 4,
    threshold: Threshold = 2,
    min_separation: Annotated[float, typer.Option(help="least distance between two cameras [mm]")] = 5.0,
    fov: Fov = None,
    diameter: Diameter = 30.0,
    working_distance: Distance = 400.0,
    exclude: Exclude = None,
    seed: Annotated[int, typer.Option(help="of the search; the same seed gives the same layout")] = 0,
    certify: Annotated[bool, typer.Option(help="bound what any layout could reconstruct")] = True,
    depth: Depth = None,
    detail: Detail = None,
    repair: Repair = False,
    out: Out = Path("out"),
    force: Force = False,
) -> None:
    """Find where the cameras should sit, and compare with equidistant ones.

    Writes layout.json, layouts.csv and coverage.png.

    Example: camring optimise scan.stl --cameras 4 --out out/
    """
    from experiments import command_optimise

    command_optimise.run(
        mesh, cameras, threshold, min_separation, fov, diameter, working_distance, exclude, seed, certify, depth,
        detail, repair, out, force,
    )  # fmt: skip


@app.command()
def evaluate(
    mesh: Mesh,
    cameras: Annotated[int | None, typer.Option(help="that many equidistant cameras")] = None,
    angles_deg: Annotated[str | None, typer.Option(help="ring angles, separated by commas [degrees]")] = None,
    layout: Annotated[Path | None, typer.Option(help="layout.json; it brings its own ring")] = None,
    threshold: Annotated[int | None, typer.Option(help="number of cameras that must see a point [default: 2]")] = None,
    min_baseline: Annotated[float, typer.Option(help="least distance of two cameras that see a point [mm]")] = 0.0,
    fov: Fov = None,
    diameter: Annotated[float | None, typer.Option(help="diameter of the ring [mm]", show_default="30")] = None,
    working_distance: Annotated[
        float | None, typer.Option(help="distance of the ring's plane from the focus [mm]", show_default="400")
    ] = None,
    exclude: Exclude = None,
    depth: Depth = None,
    detail: Detail = None,
    repair: Repair = False,
    out: Annotated[Path | None, typer.Option(help="folder for the reconstructable part as STL and PLY")] = None,
    force: Force = False,
) -> None:
    """Exact area that a given ring of cameras reconstructs.

    Give the cameras in one of three ways: --cameras, --angles-deg or --layout.

    Example: camring evaluate scan.stl --angles-deg 0,90,180 --out out/
    """
    from experiments import command_evaluate

    command_evaluate.run(
        mesh, cameras, angles_deg, layout, threshold, min_baseline, fov, diameter, working_distance, exclude, depth,
        detail, repair, out, force,
    )  # fmt: skip


@app.command()
def compare(
    layouts: Annotated[list[Path], typer.Argument(help="two or more layout.json files")],
    mesh: Annotated[str, typer.Option(help="STL, OBJ or PLY file [mm], or the name of a built-in site")],
    threshold: Annotated[int | None, typer.Option(help="number of cameras that must see a point [default: 2]")] = None,
    exclude: Exclude = None,
    depth: Depth = None,
    detail: Detail = None,
    repair: Repair = False,
    out: Annotated[Path | None, typer.Option(help="folder for layouts.csv and coverage.png")] = None,
    force: Force = False,
) -> None:
    """Score several layouts on the same mesh.

    Example: camring compare a/layout.json b/layout.json --mesh scan.stl
    """
    from experiments import command_compare

    command_compare.run(layouts, mesh, threshold, exclude, depth, detail, repair, out, force)


@app.command()
def export(
    layout: Annotated[Path, typer.Argument(help="layout.json")],
    format: Annotated[
        str, typer.Option(help="one or more of colmap, transforms, opencv, glb, csv, separated by commas")
    ],
    mesh: Annotated[
        str | None, typer.Option(help="the mesh the layout was made for, which glb shows: a file, or a built-in site")
    ] = None,
    depth: Depth = None,
    detail: Detail = None,
    repair: Repair = False,
    resolution: Annotated[
        str | None,
        typer.Option(help="image size, width x height [pixels]", show_default="longer side 3600, pixels square"),
    ] = None,
    out: Out = Path("out"),
    force: Annotated[
        bool, typer.Option("--force", help="replace results that are there; allow another mesh than the layout's")
    ] = False,
) -> None:
    """Write the cameras of a layout in the formats of other programs.

    For COLMAP, nerfstudio (transforms), OpenCV, Blender and viewers of glTF (glb), or as a table (csv).

    Example: camring export out/layout.json --format colmap,transforms --out out/
    """
    from experiments import command_export

    command_export.run(layout, format, mesh, depth, detail, repair, resolution, out, force)


@app.command()
def site(
    name: Annotated[str | None, typer.Argument(help="name of a built-in site")] = None,
    depth: Depth = None,
    detail: Detail = None,
    listing: Annotated[bool, typer.Option("--list", help="list the built-in sites")] = False,
    out: Annotated[Path | None, typer.Option(help="mesh file to write: .stl, .ply or .obj")] = None,
    gallery: Annotated[Path | None, typer.Option(help="picture of all sites, cut open, to write: .png")] = None,
    force: Force = False,
) -> None:
    """Write a built-in reference site to a mesh file, list them, or draw them all.

    Example: camring site circ_artery --depth 50 --out artery.stl
    """
    from experiments import command_site

    command_site.run(name, depth, detail, listing, out, gallery, force)


@app.command()
def bench(
    what: Annotated[
        str,
        typer.Argument(
            help="exact: the exact evaluator, its accuracy and speed; "
            "sites: the reference sites against the published areas"
        ),
    ],
    out: Out = Path("out"),
    force: Force = False,
) -> None:
    """Measure how right and how fast camring is on this machine; takes minutes.

    Example: camring bench exact --out out/
    """
    if what == "exact":
        from experiments import bench_exact

        bench_exact.run(out, force)
    elif what == "sites":
        from experiments import bench_sites

        bench_sites.run(out, force)
    else:
        from experiments.errors import InputError

        raise InputError(f"there is no benchmark {what!r}; choose exact or sites")


def main(arguments: list[str] | None = None) -> None:
    """Run `camring`; a request that cannot be met ends with one message and exit status 2."""
    try:
        app(arguments, prog_name="camring")
    except ValueError as error:
        from experiments.refusals import is_refusal

        if not is_refusal(error):
            raise
        print(f"camring: {error}", file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:
        print("camring: interrupted", file=sys.stderr)
        sys.exit(130)


if __name__ == "__main__":
    main()
