"""How `camring site` is called."""

from pathlib import Path
from typing import Annotated

import typer

import experiments.cli.options as opt


def site(
    name: Annotated[
        str | None, typer.Argument(help="name of a built-in site", autocompletion=opt.completing(opt.SITES))
    ] = None,
    depth: opt.Depth = None,
    detail: opt.Detail = None,
    listing: Annotated[bool, typer.Option("--list", help="list the built-in sites")] = False,
    out: Annotated[Path | None, typer.Option(help="mesh file to write: .stl, .ply or .obj")] = None,
    gallery: Annotated[Path | None, typer.Option(help="picture of all sites, cut open, to write: .png")] = None,
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Write a built-in reference site to a mesh file, list them, or draw them all.

    Example: camring site circ_artery --depth 50 --out artery.stl
    """
    from experiments.cli.commands import site as command_site

    command_site.run(name, depth, detail, listing, out, gallery, force, json)
