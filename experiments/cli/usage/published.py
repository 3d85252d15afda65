"""How `camring paper` and `camring study`, what repeats published and committed results, are called."""

from pathlib import Path
from typing import Annotated

import typer

import experiments.cli.options as opt


def paper(
    quick: Annotated[bool, typer.Option("--quick", help="two sites, up to 16 cameras: a first look")] = False,
    report_only: opt.ReportOnly = False,
    detail: opt.Detail = None,
    scheduler: opt.Scheduler = None,
    out: opt.Out = Path("out/paper"),
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Repeat the tables, fits and figures of Wachter 2021, beside its numbers; takes minutes.

    A run that was stopped goes on where it was when the same command is given again.

    Example: camring paper --out out/paper
    """
    from experiments.cli.commands import paper as command_paper

    command_paper.run(quick, report_only, detail or "coarse", scheduler, out, force, json)


def study(
    quick: Annotated[bool, typer.Option("--quick", help="two sites, 2 and 3 cameras: a first look")] = False,
    simulated: Annotated[
        bool,
        typer.Option("--simulated", help="instead, what comes out of rendered images of layouts for four sites: hours"),
    ] = False,
    report_only: opt.ReportOnly = False,
    detail: opt.Detail = None,
    scheduler: opt.Scheduler = None,
    out: opt.Out = Path("out/study"),
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Optimised against equidistant rings on the ten sites of Wachter 2021, with certificates; takes an hour.

    A run that was stopped goes on where it was when the same command is given again.

    Example: camring study --out out/study
    """
    from experiments.cli.commands import study as command_study

    command_study.run(
        quick, report_only, detail or "coarse", scheduler, out, force, json, simulated=simulated
    )  # fmt: skip
