"""camring study: optimised against equidistant rings on the reference sites, with certificates and constraints."""

import time
from dataclasses import asdict
from pathlib import Path

import exact
import meshes
from experiments.cli.extras import refuse_without
from experiments.files.whole import output_folder
from experiments.study.report import CAPTIONS, write_report
from experiments.study.rows import EquidistantRow, LayoutRow, equidistant_rows, layout_rows, read_rows, write_rows
from experiments.study.savings import accuracy, headline, savings
from experiments.study.tasks import CERTIFICATE_SECONDS, DENSITY, PHASES, POLISHED, Plan, study_tasks
from experiments.sweeps import command as sweep_command
from experiments.sweeps.command import RECORD, SweepReport, SweepRequest
from experiments.sweeps.record import write_record
from experiments.sweeps.sweep import shown_sweep
from placement.search.proposal import GIVE_UP

LAYOUTS, EQUIDISTANT, TASKS, PAGE = "layouts.csv", "equidistant.csv", "tasks", "study.md"


def run(
    quick: bool, report_only: bool, detail: str, scheduler: str | None, out: Path, force: bool, as_json: bool,
    *, simulated: bool = False,
) -> None:  # fmt: skip
    """Compute unless only the report is wanted, then report from what is on disk."""
    command = "camring study --simulated" if simulated else "camring study"
    asked = SweepRequest(command, quick, report_only, detail, scheduler, out, force, as_json)
    if simulated:
        refuse_without("simulate", command)
        from experiments.study import simulated as study_simulated  # it brings the extra along

        study_simulated.run(asked)
    else:
        sweep_command.run(asked, _compute, _report)


def _compute(asked: SweepRequest) -> None:
    """Write rows and, last, the record."""
    out, plan = asked.out, Plan.of(asked.quick, asked.detail)
    started = time.monotonic()
    output_folder(out, [RECORD], asked.force)
    named = study_tasks(plan)
    tasks = [task for _, task in named]
    outcomes, pool, n_resumed = shown_sweep("study", tasks, out / TASKS, asked.scheduler)
    layouts, even = [], []
    for (about, _), outcome in zip(named, outcomes, strict=True):
        if about["part"] == "equidistant":
            even += equidistant_rows(about, plan.equidistant_counts, outcome)
        else:
            layouts += layout_rows(about, outcome)
    write_rows(out / LAYOUTS, LayoutRow, layouts)
    write_rows(out / EQUIDISTANT, EquidistantRow, even)
    settings = {
        "command": asked.command, "quick": asked.quick, "detail": plan.detail, "threshold": 2, "seed": 0,
        "ring_diameter_mm": 30.0, "working_distance_mm": 400.0, "fov_mm": [36.0, 24.0], "exact_phases": PHASES,
        "certificate_seconds": CERTIFICATE_SECONDS, "polish_candidates": POLISHED, "give_up": GIVE_UP,
        "min_pixel_density": DENSITY, "resolution_px": list(exact.Optics().resolution),
        "match_noise_px": exact.Optics().match_noise, "n_cameras": list(plan.counts),
    }  # fmt: skip
    hashes = {
        f"{site} {depth} {plan.detail}": meshes.EXPECTED[site, float(depth), plan.detail].fingerprint
        for site, depth in plan.sites
    }
    write_record(out / RECORD, settings, hashes, tasks, outcomes, pool, time.monotonic() - started, n_resumed)


def _report(out: Path) -> SweepReport:
    """Write figures and the page from what is on disk."""
    layouts, even = read_rows(out / LAYOUTS, LayoutRow), read_rows(out / EQUIDISTANT, EquidistantRow)
    words, found = write_report(out, layouts, even), savings(layouts, even)
    figures = [f"{Path(name).stem}.{ending}" for name in CAPTIONS for ending in ("png", "pdf")]
    return SweepReport(
        words,
        [LAYOUTS, EQUIDISTANT, *(name for name in figures if (out / name).exists()), PAGE],
        {"headline": [*headline(found), *accuracy(layouts)], "fewest_cameras": [asdict(one) for one in found]},
    )
