"""How `camring report` is called."""

from pathlib import Path
from typing import Annotated

import typer

import experiments.cli.options as opt


@opt.asking("repair", "two_sided", otherwise={"repair": "what layout.json says", "two_sided": "what layout.json says"})
def report(
    layout: Annotated[Path, typer.Argument(help="folder with a layout.json, or that file")],
    mesh: Annotated[
        str | None,
        typer.Option(
            help="the mesh that the layout was made for, the first of several: a file, or a built-in site",
            show_default="the built-in site it was made for",
            autocompletion=opt.completing(opt.SITES),
        ),
    ] = None,
    exclude: Annotated[
        str | None,
        typer.Option(help="faces that did not count, if a file lists them", show_default="what layout.json says"),
    ] = None,
    *,
    options: opt.Given,
    out: Annotated[
        Path | None, typer.Option(help="folder for the report", show_default="the layout's own folder")
    ] = None,
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Write a page that shows a layout and all that is known of it, for anyone with a browser.

    Writes report.html: tables, drawings and the surface in three dimensions, in one file that needs no network. Shows
    count.csv of camring count too, if it lies beside layout.json.

    Example: camring report out/ --mesh scan.stl
    """
    from experiments.cli.commands import report as command_report

    command_report.run(layout, mesh, exclude, options, out, force, json)
