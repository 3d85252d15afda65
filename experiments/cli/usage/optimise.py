"""How `camring optimise` is called."""

from pathlib import Path
from typing import Annotated

import typer

import experiments.cli.options as opt


@opt.asking("count", *opt.REQUEST, "give_up")
def optimise(
    meshes: opt.Meshes,
    options: opt.Given,
    robustness: Annotated[
        bool,
        typer.Option(
            "--robustness/--no-robustness",
            help="work out what is left when a camera fails or sits askew, and which pairs of cameras do the work",
        ),
    ] = True,
    ring: Annotated[
        list[str] | None,
        typer.Option(
            "--ring",
            help="one of several rings that cameras may sit on, given once for each: diameter x working distance [mm], "
            "then the most cameras it takes after a colon, as in --ring 30x400 --ring 16x380:1; a field of view of its "
            "own after @, as in 16x380@40x30",
            show_default="one ring, as the other options say",
        ),
    ] = None,
    rig: opt.RigFile = None,
    depth: opt.Depth = None,
    detail: opt.Detail = None,
    target: opt.Target = None,
    export: Annotated[
        str | None,
        typer.Option(
            help="also write the cameras as camring export does (colmap, transforms, opencv, glb, csv), or the results "
            "as meshes (mesh); several separated by commas",
            show_default="none",
            autocompletion=opt.completing((*opt.FORMATS, "mesh")),
        ),
    ] = None,
    report: Annotated[bool, typer.Option("--report", help="also write report.html, as camring report does")] = False,
    out: opt.Out = Path("out"),
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Find where the cameras should sit, and compare with equidistant ones.

    Writes layout.json, layouts.csv and coverage.png. With several rings (--ring) it finds which camera sits on which,
    compares with each ring alone, and writes several_rings.json, .csv and .png.

    Example: camring optimise scan.stl --cameras 4 --out out/
    """
    from experiments.cli.commands import optimise as command_optimise

    command_optimise.run(
        meshes, rig, options, rings=ring, depth=depth, detail=detail, target=target, robust=robustness, export=export,
        with_report=report, out=out, force=force, as_json=json,
    )  # fmt: skip
