"""How `camring simulate` is called."""

from pathlib import Path
from typing import Annotated

import typer

import experiments.cli.options as opt


@opt.asking("Demand", "Simulation", *opt.RING, *opt.MESH, "seed")
def simulate(
    mesh: opt.Mesh,
    layout: Annotated[
        Path | None, typer.Option(help="layout.json; it brings its own ring, threshold, baseline and optics")
    ] = None,
    cameras: Annotated[int | None, typer.Option(help="that many equidistant cameras instead")] = None,
    *,
    options: opt.Given,
    rig: opt.RigFile = None,
    depth: opt.Depth = None,
    detail: opt.Detail = None,
    quick: Annotated[bool, typer.Option("--quick", help="images of at most 900 pixels along the longer side")] = False,
    equidistant: Annotated[bool, typer.Option(help="simulate equidistant cameras, too, as many of them")] = True,
    out: opt.Out = Path("sim"),
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Render what the cameras see, match the images, reconstruct, and compare that with the surface and the prediction.

    Writes images with camera files, the reconstruction coloured by its error, depth maps, simulation.json and .csv,
    prediction.png and errors.png. A run that was stopped goes on where it was: no image is rendered twice. Needs the
    extra simulate: pip install 'camring[simulate]'

    Example: camring simulate scan.stl --layout out/layout.json --quick --out sim/
    """
    from experiments.cli.commands import simulate as command_simulate

    command_simulate.run(
        mesh, rig, {"count": cameras} | options, layout=layout, depth=depth, detail=detail, quick=quick,
        beside_equidistant=equidistant, out=out, force=force, as_json=json,
    )  # fmt: skip
