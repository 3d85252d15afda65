"""How `camring design` is called."""

from pathlib import Path
from typing import Annotated

import typer

import experiments.cli.options as opt


@opt.asking("Demand", "Constraints", *opt.RING, *opt.MESH, "seed")
def design(
    mesh: opt.Mesh,
    cameras: Annotated[int | None, typer.Option(help="that many cameras to begin with", show_default="4")] = None,
    layout: Annotated[
        Path | None, typer.Option(help="layout.json to begin with; it brings its own ring, threshold and baseline")
    ] = None,
    *,
    options: opt.Given,
    rig: opt.RigFile = None,
    depth: opt.Depth = None,
    detail: opt.Detail = None,
    port: Annotated[int, typer.Option(help="port on this machine; 0 for any that is free")] = 0,
    browser: Annotated[bool, typer.Option(help="open the page in the browser")] = True,
    fresh: Annotated[bool, typer.Option("--fresh", help="forget what was tried with this mesh before")] = False,
    json: opt.Json = False,
) -> None:
    """Move the cameras of a ring in the browser, and see at once what they reconstruct.

    Serves a page, to this machine alone, until it is interrupted (Ctrl-C). What was tried is kept, and there again the
    next time with the same mesh. Needs the extra design: pip install 'camring[design]'

    Example: camring design scan.stl --rig rig.toml
    """
    from experiments.cli.commands import design as command_design

    command_design.run(
        mesh, rig, {"count": cameras} | options, layout=layout, depth=depth, detail=detail, port=port,
        browser=browser, fresh=fresh, as_json=json,
    )  # fmt: skip
