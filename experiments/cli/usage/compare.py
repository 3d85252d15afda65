"""How `camring compare` is called."""

from pathlib import Path
from typing import Annotated

import typer

import experiments.cli.options as opt


@opt.asking(
    "Demand",
    *opt.MESH,
    "place",
    otherwise={"threshold": "the first layout's", "min_baseline": "the greatest of the layouts'"},
)
def compare(
    layouts: Annotated[list[Path], typer.Argument(help="two or more layout.json files")],
    mesh: Annotated[str, typer.Option(help=opt.MESH_HELP, autocompletion=opt.completing(opt.SITES))],
    options: opt.Given,
    depth: opt.Depth = None,
    detail: opt.Detail = None,
    out: Annotated[Path | None, typer.Option(help="folder for layouts.csv and coverage.png")] = None,
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Score several layouts on the same mesh.

    Example: camring compare a/layout.json b/layout.json --mesh scan.stl
    """
    from experiments.cli.commands import compare as command_compare

    command_compare.run(layouts, mesh, options, depth=depth, detail=detail, out=out, force=force, as_json=json)
