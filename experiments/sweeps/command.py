"""What `camring paper` and `camring study` share: what may be asked of them, and how they end."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import meshes
from experiments.files.errors import InputError, TargetMissed
from experiments.terminal.console import print_json

# Written last by a run: a folder that holds it holds all the rest, and is not written to again without --force.
RECORD = "record.json"


@dataclass(frozen=True)
class SweepRequest:
    """What was asked for.

    Attributes
    ----------
    command : str
        As it is typed, such as "camring study".
    quick : bool
        A small part of it.
    report_only : bool
        Compute nothing; report from what is on disk.
    detail : str
        Size of the reference sites.
    scheduler : str or None
        Address of a Dask scheduler; None for the processors of this machine.
    out : Path
        Folder of the results.
    force : bool
        Replace them.
    as_json : bool
        Say what came out as JSON.

    Raises
    ------
    InputError
        If it makes no sense.
    """

    command: str
    quick: bool
    report_only: bool
    detail: str
    scheduler: str | None
    out: Path
    force: bool
    as_json: bool

    def __post_init__(self):
        if self.report_only and (self.quick or self.scheduler is not None):
            raise InputError("--report-only draws what is on disk; leave out --quick and --scheduler, or leave it out")
        if self.detail not in meshes.DETAILS:
            raise InputError(f"--detail is {self.detail!r}; choose one of {', '.join(meshes.DETAILS)}")
        if self.report_only and not (self.out / RECORD).exists():
            raise InputError(f"{self.out} holds no finished run; run `{self.command} --out {self.out}` first")


@dataclass(frozen=True)
class SweepReport:
    """What a report from disk has made: what it says, the names of the files of the run, and the same as data."""

    words: str
    files: list[str]
    figures: dict[str, Any]


def run(asked: SweepRequest, compute: Callable[[SweepRequest], object], report: Callable[[Path], SweepReport]) -> None:
    """Compute unless only the report is wanted, report from what is on disk, and say so.

    Raises
    ------
    TargetMissed
        If tasks failed, when all is written.
    """
    if not asked.report_only:
        compute(asked)
    made = report(asked.out)
    tasks = json.loads((asked.out / RECORD).read_text(encoding="utf-8"))["tasks"]
    failures = [task["failure"] for task in tasks if "failure" in task]
    if asked.as_json:
        files = [str(asked.out / name) for name in (RECORD, *made.files)]
        done = {"done": len(tasks) - len(failures), "failed": len(failures), "failures": failures}
        print_json({"files": files, "tasks": done, **made.figures})
    else:
        print(made.words)
    if failures:
        raise TargetMissed(
            f"{len(failures)} of {len(tasks)} tasks failed, the first with {failures[0]}. {asked.out / RECORD} names "
            f"all; {asked.command} --force tries them again"
        )
