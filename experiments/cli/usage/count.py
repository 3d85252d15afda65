"""How `camring count` is called."""

from pathlib import Path
from typing import Annotated

import typer

import experiments.cli.options as opt


@opt.asking(*opt.REQUEST)
def count(
    meshes: opt.Meshes,
    target: Annotated[float, typer.Option(help="part of the ring maximum to reach, or the exit status is 1")] = 0.99,
    max_cameras: Annotated[int, typer.Option(help="most cameras to try")] = 16,
    *,
    options: opt.Given,
    rig: opt.RigFile = None,
    depth: opt.Depth = None,
    detail: opt.Detail = None,
    out: opt.Out = Path("out"),
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Find how many cameras reach a target, well placed and equidistant.

    Writes count.csv, anew after every number of cameras, count.png, and layout.json of the fewest cameras that reach
    the target. Takes a minute or so for each number of cameras; most of it is the bound, which --no-certify leaves out.

    Example: camring count scan.stl --target 0.97 --max-cameras 8 --out count/
    """
    from experiments.cli.commands import count as command_count

    command_count.run(
        meshes, rig, options, target=target, max_cameras=max_cameras, depth=depth, detail=detail, out=out, force=force,
        as_json=json,
    )  # fmt: skip
