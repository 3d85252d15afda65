"""camring study: optimised against equidistant rings on the reference sites, with certificates and constraints."""

import sys
import time
from pathlib import Path

import meshes
from experiments.errors import InputError
from experiments.files import output_folder
from experiments.study_report import write_report
from experiments.study_rows import EquidistantRow, LayoutRow, equidistant_rows, layout_row, read_rows, write_rows
from experiments.study_tasks import CERTIFICATE_SECONDS, PHASES, Plan, study_tasks
from experiments.sweep import shown_sweep
from experiments.sweep_record import write_record
from experiments.terminal import note

LAYOUTS, EQUIDISTANT, RECORD, TASKS = "layouts.csv", "equidistant.csv", "record.json", "tasks"


def run(quick: bool, report_only: bool, detail: str, scheduler: str | None, out: Path, force: bool) -> None:
    """Compute unless only the report is wanted, then report from what is on disk."""
    if report_only and (quick or scheduler is not None):
        raise InputError("--report-only draws what is on disk; leave out --quick and --scheduler, or leave it out")
    if detail not in meshes.DETAILS:
        raise InputError(f"--detail is {detail!r}; choose one of {', '.join(meshes.DETAILS)}")
    if report_only and not (out / RECORD).exists():
        raise InputError(f"{out} holds no finished run; run `camring study --out {out}` first")
    failures = [] if report_only else _compute(Plan.of(quick, detail), quick, scheduler, out, force)
    words = write_report(out, read_rows(out / LAYOUTS, LayoutRow), read_rows(out / EQUIDISTANT, EquidistantRow))
    print(words)
    if failures:
        note(
            f"{len(failures)} tasks failed, the first of them: {failures[0]}; the same command with --force tries again"
        )
        sys.exit(1)


def _compute(plan: Plan, quick: bool, scheduler: str | None, out: Path, force: bool) -> list[str]:
    """Write rows and the record; the reasons of the tasks that failed.

    The record comes last: a folder that holds it holds all the rest, and is not written to again without `force`.
    """
    started = time.monotonic()
    output_folder(out, [RECORD], force)
    named = study_tasks(plan)
    tasks = [task for _, task in named]
    outcomes, pool, n_resumed = shown_sweep("study", tasks, out / TASKS, scheduler)
    layouts, even = [], []
    for (about, _), outcome in zip(named, outcomes, strict=True):
        if about["part"] == "equidistant":
            even += equidistant_rows(about, plan.equidistant_counts, outcome)
        else:
            layouts.append(layout_row(about, outcome))
    write_rows(out / LAYOUTS, LayoutRow, layouts)
    write_rows(out / EQUIDISTANT, EquidistantRow, even)
    settings = {
        "command": "camring study", "quick": quick, "detail": plan.detail, "threshold": 2, "seed": 0,
        "ring_diameter_mm": 30.0, "working_distance_mm": 400.0, "fov_mm": [36.0, 24.0], "exact_phases": PHASES,
        "certificate_seconds": CERTIFICATE_SECONDS, "n_cameras": list(plan.counts),
    }  # fmt: skip
    hashes = {
        f"{site} {depth} {plan.detail}": meshes.EXPECTED[site, float(depth), plan.detail].fingerprint
        for site, depth in plan.sites
    }
    write_record(out / RECORD, settings, hashes, tasks, outcomes, pool, time.monotonic() - started, n_resumed)
    return [outcome.failure for outcome in outcomes if outcome.failure]
