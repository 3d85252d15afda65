"""How `camring evaluate` is called."""

from pathlib import Path
from typing import Annotated

import typer

import experiments.cli.options as opt


@opt.asking("Demand", *opt.RING, *opt.MESH)
def evaluate(
    mesh: opt.Mesh,
    cameras: Annotated[int | None, typer.Option(help="that many equidistant cameras")] = None,
    angles_deg: Annotated[str | None, typer.Option(help="ring angles, separated by commas [degrees]")] = None,
    layout: Annotated[
        Path | None, typer.Option(help="layout.json; it brings its own ring, threshold and baseline")
    ] = None,
    *,
    options: opt.Given,
    rig: opt.RigFile = None,
    depth: opt.Depth = None,
    detail: opt.Detail = None,
    target: opt.Target = None,
    out: Annotated[
        Path | None, typer.Option(help="folder for the reconstructable part and the coloured surface as meshes")
    ] = None,
    images: Annotated[
        Path | None, typer.Option(help="folder for a picture of what each camera sees, faces seen in part in red")
    ] = None,
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Exact area that a given ring of cameras reconstructs.

    Give the cameras in one of four ways: --cameras, --angles-deg, --layout, or their number in a --rig file.

    Example: camring evaluate scan.stl --angles-deg 0,90,180 --out out/
    """
    from experiments.cli.commands import evaluate as command_evaluate

    command_evaluate.run(
        mesh, rig, {"count": cameras} | options, angles_deg=angles_deg, layout=layout, depth=depth, detail=detail,
        target=target, out=out, images=images, force=force, as_json=json,
    )  # fmt: skip
