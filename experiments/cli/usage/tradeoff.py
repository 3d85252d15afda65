"""How `camring tradeoff` is called."""

from pathlib import Path

import experiments.cli.options as opt


@opt.asking("count", *opt.REQUEST)
def tradeoff(
    meshes: opt.Meshes,
    options: opt.Given,
    rig: opt.RigFile = None,
    depth: opt.Depth = None,
    detail: opt.Detail = None,
    out: opt.Out = Path("out"),
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Find what accuracy costs in area: the layouts of which none has both more area and less error.

    Writes tradeoff.csv and tradeoff.png, with equidistant rings and opposite pairs to compare with.

    Example: camring tradeoff scan.stl --cameras 4 --no-certify --out tradeoff/
    """
    from experiments.cli.commands import tradeoff as command_tradeoff

    command_tradeoff.run(meshes, rig, options, depth=depth, detail=detail, out=out, force=force, as_json=json)
