"""How `camring ring` is called."""

from pathlib import Path
from typing import Annotated

import typer

import experiments.cli.options as opt
from experiments.request.options import keys

# Said here for several rings, or of no concern.
OWN = ("fov", "diameter", "working_distance", "certify")
LENGTHS = "lengths [mm]: first:last:step, as in 20:40:5, or separated by commas"


def _default(name: str) -> str:
    """What holds of a ring where nothing is said."""
    return keys("Ring")[name].shown_default


@opt.asking("count", *(name for name in opt.REQUEST if name not in OWN))
def ring(
    meshes: opt.Meshes,
    options: opt.Given,
    diameter: Annotated[
        str | None, typer.Option(help=f"diameters of the ring; {LENGTHS}", show_default=_default("diameter"))
    ] = None,
    working_distance: Annotated[
        str | None,
        typer.Option(
            help=f"distances of the ring's plane from the focus; {LENGTHS}", show_default=_default("working_distance")
        ),
    ] = None,
    fov: Annotated[
        str | None,
        typer.Option(
            help="fields of view at the focus [mm], separated by commas, as in 36x24,48x32",
            show_default=_default("fov"),
        ),
    ] = None,
    refine: Annotated[
        bool,
        typer.Option(
            "--refine",
            help="from each ring that no other beats, move diameter, distance and cameras together within these ranges",
        ),
    ] = False,
    rig: opt.RigFile = None,
    depth: opt.Depth = None,
    detail: opt.Detail = None,
    scheduler: opt.Scheduler = None,
    out: opt.Out = Path("out/ring"),
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Compare rings: on each the proposed layout, with exact area and error, and what a wider or nearer one buys.

    Writes rings.csv, rings.png and a layout file for each ring. All rings have the same field of view at the focus.
    A run that was stopped goes on where it was when the same command is given again.

    Example: camring ring scan.stl --diameter 20:40:10 --working-distance 300,400 --cameras 4 --out rings/
    """
    from experiments.cli.commands import ring as command_ring

    command_ring.run(
        meshes, rig, options, diameter=diameter, working_distance=working_distance, fov=fov, refine=refine, depth=depth,
        detail=detail, scheduler=scheduler, out=out, force=force, as_json=json,
    )  # fmt: skip
