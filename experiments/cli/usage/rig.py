"""How `camring rig` is called."""

from pathlib import Path
from typing import Annotated

import typer

import experiments.cli.options as opt

app = typer.Typer(help="Rig files: all settings of a request, for --rig.", no_args_is_help=True)


@app.callback()
def rig_files() -> None:
    """Rig files: all settings of a request, for --rig."""


@app.command("init")
def rig_init(
    path: Annotated[Path, typer.Argument(help="file to write")] = Path("rig.toml"),
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Write a commented rig file that holds every setting with its default and unit.

    Example: camring rig init rig.toml
    """
    from experiments.cli.commands import rig as command_rig

    command_rig.init(path, force, json)
