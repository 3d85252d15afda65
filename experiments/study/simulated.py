"""camring study --simulated: what is predicted of layouts, and what is reconstructed from rendered images of them."""

import time
from dataclasses import asdict
from pathlib import Path

from experiments.files.errors import InputError
from experiments.files.whole import output_folder
from experiments.study.rows import read_rows, write_rows
from experiments.study.simulated_layouts import named
from experiments.study.simulated_report import FIGURE, PAGE, write_report
from experiments.study.simulated_rows import LimitRow, SimulatedRow, limit_rows, limits_of, simulated_row
from experiments.study.simulated_tasks import Plan, area_tasks, layout_tasks, simulation_tasks
from experiments.sweeps import command as sweep_command
from experiments.sweeps.command import RECORD, SweepReport, SweepRequest
from experiments.sweeps.record import write_record
from experiments.sweeps.sweep import shown_sweep

LAYOUTS, LIMITS, TASKS = "layouts.csv", "limits.csv", "tasks"
SEED = 0


def run(asked: SweepRequest) -> None:
    """Compute unless only the report is wanted, then report from what is on disk.

    Raises
    ------
    InputError, TargetMissed
    """
    sweep_command.run(asked, _compute, _report)


def _compute(asked: SweepRequest) -> None:
    """Write rows and, last, the record."""
    out, plan, folder = asked.out, Plan.of(asked.quick), asked.out / TASKS
    started = time.monotonic()
    output_folder(out, [RECORD], asked.force)
    found = layout_tasks(plan, asked.detail)
    first = [task for *_, task in found]
    searched, pool, n_resumed = shown_sweep("layouts", first, folder, asked.scheduler)
    angles = {}
    for (site, n, _), one in zip(found, searched, strict=True):
        if one.result is None:
            raise InputError(f"no layout of {n} cameras for {site[0]}: {one.failure}; the same command tries it again")
        angles[site, n] = one.result
    simulations = simulation_tasks(plan, asked.detail, angles, SEED)
    second = [task for _, task in simulations]
    simulated, _, n_more = shown_sweep("simulations", second, folder, asked.scheduler)
    limits = limit_rows([(about, one) for (about, _), one in zip(simulations, simulated, strict=True)])
    ways = limits_of(limits, plan.width)
    asked_areas = area_tasks(simulations, list(ways.values()))
    third = [task for tasks in asked_areas for task in tasks]
    areas, _, n_most = shown_sweep("exact areas", third, folder, asked.scheduler)
    rows = []
    for number, ((about, _), one) in enumerate(zip(simulations, simulated, strict=True)):
        rows.append(simulated_row(about, one, areas[number * len(ways) : (number + 1) * len(ways)]))
    write_rows(out / LAYOUTS, SimulatedRow, rows)
    write_rows(out / LIMITS, LimitRow, limits)
    settings = {
        "command": asked.command, "quick": asked.quick, "detail": asked.detail, "seed": SEED,
        **asdict(plan), "limits": ways,
    }  # fmt: skip
    hashes = {
        f"{site[0]} {site[1]} {asked.detail}": named(site, asked.detail)[2] for site in (*plan.sites, *plan.tested)
    }
    write_record(
        out / RECORD, settings, hashes, [*first, *second, *third], [*searched, *simulated, *areas], pool,
        time.monotonic() - started, n_resumed + n_more + n_most,
    )  # fmt: skip


def _report(out: Path) -> SweepReport:
    """Write the figure and the page from what is on disk."""
    rows, limits = read_rows(out / LAYOUTS, SimulatedRow), read_rows(out / LIMITS, LimitRow)
    words = write_report(out, rows, limits)
    return SweepReport(words, [LAYOUTS, LIMITS, FIGURE, PAGE], {"headline": words.splitlines()})
