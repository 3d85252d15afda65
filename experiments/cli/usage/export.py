"""How `camring export` is called."""

from pathlib import Path
from typing import Annotated

import typer

import experiments.cli.options as opt


@opt.asking("repair", "two_sided", otherwise={"repair": "what layout.json says", "two_sided": "what layout.json says"})
def export(
    layout: Annotated[Path, typer.Argument(help="layout.json")],
    format: Annotated[
        str,
        typer.Option(
            help="one or more of colmap, transforms, opencv, glb, csv, separated by commas",
            autocompletion=opt.completing(opt.FORMATS),
        ),
    ],
    mesh: Annotated[
        str | None,
        typer.Option(
            help="the mesh the layout was made for, which glb shows: a file, or a built-in site",
            autocompletion=opt.completing(opt.SITES),
        ),
    ] = None,
    *,
    options: opt.Given,
    depth: opt.Depth = None,
    detail: opt.Detail = None,
    resolution: Annotated[
        str | None,
        typer.Option(help="image size, width x height [pixels]", show_default="longer side 3600, pixels square"),
    ] = None,
    out: opt.Out = Path("out"),
    force: Annotated[
        bool, typer.Option("--force", help="replace results that are there; allow another mesh than the layout's")
    ] = False,
    json: opt.Json = False,
) -> None:
    """Write the cameras of a layout in the formats of other programs.

    For COLMAP, nerfstudio (transforms), OpenCV, Blender and viewers of glTF (glb), or as a table (csv).

    Example: camring export out/layout.json --format colmap,transforms --out out/
    """
    from experiments.cli.commands import export as command_export

    command_export.run(layout, format, mesh, depth, detail, options, resolution, out, force, as_json=json)
