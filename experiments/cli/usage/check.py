"""How `camring check` is called."""

from pathlib import Path
from typing import Annotated

import typer

import experiments.cli.options as opt


@opt.asking(*opt.RING, "scale")
def check(
    mesh: Annotated[str, typer.Argument(help="STL, OBJ, PLY or OFF file")],
    *,
    options: opt.Given,
    rig: opt.RigFile = None,
    out: Annotated[
        Path | None, typer.Option(help="picture of the mesh, of its fronts, backs and borders, to write: .png")
    ] = None,
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """All about a mesh file that matters to an area on it, before anything is computed.

    Its size and likely unit, whether it is closed and wound alike, what is mended without being asked and what --repair
    would do, where it lies, which way it opens, and which side of it the cameras see. The exit status is 2 if the mesh
    would be refused without --repair.

    Example: camring check scan.stl --out scan.png
    """
    from experiments.cli.commands import check as command_check

    command_check.run(mesh, rig, options, out=out, force=force, as_json=json)
