"""camring paper: everything that Wachter 2021 reports, on the reference sites, beside its numbers."""

import sys
import time
from pathlib import Path

import meshes
from experiments.errors import InputError
from experiments.files import output_folder
from experiments.paper_areas import area_rows, area_tasks, read_areas, write_areas
from experiments.paper_cases import QUICK_COUNTS, cases
from experiments.paper_curve_figures import write_curve_figures
from experiments.paper_fits import fit_rows, read_fits, write_fits
from experiments.paper_picture_figures import FIGURES, write_picture_figure
from experiments.paper_pictures import picture_tasks, read_picture, write_picture
from experiments.paper_report import write_report
from experiments.paper_tables import TABLES, cases_of, entries, write_table
from experiments.published import CAMERA_COUNTS
from experiments.sweep import shown_sweep
from experiments.sweep_record import write_record
from experiments.terminal import note

AREAS, FITS, RECORD, PICTURES, TASKS, PAGE = "areas.csv", "fits.csv", "record.json", "pictures", "tasks", "paper.md"


def run(quick: bool, report_only: bool, detail: str, scheduler: str | None, out: Path, force: bool) -> None:
    """Compute unless only the report is wanted, then report from what is on disk."""
    if report_only and (quick or scheduler is not None):
        raise InputError("--report-only draws what is on disk; leave out --quick and --scheduler, or leave it out")
    if detail not in meshes.DETAILS:
        raise InputError(f"--detail is {detail!r}; choose one of {', '.join(meshes.DETAILS)}")
    if report_only and not (out / RECORD).exists():
        raise InputError(f"{out} holds no finished run; run `camring paper --out {out}` first")
    failures = [] if report_only else _compute(quick, detail, scheduler, out, force)
    _report(out)
    if failures:
        note(
            f"{len(failures)} tasks failed, the first of them: {failures[0]}. {out / RECORD} names all; "
            "the same command with --force tries them again"
        )
        sys.exit(1)


def _compute(quick: bool, detail: str, scheduler: str | None, out: Path, force: bool) -> list[str]:
    """Write areas, fits, the data of the pictures and the record; the reasons of the tasks that failed.

    The record comes last: a folder that holds it holds all the rest, and is not written to again without `force`.
    """
    started = time.monotonic()
    output_folder(out, [RECORD], force)
    output_folder(out / PICTURES, (), force=True)
    chosen, counts = cases(quick), QUICK_COUNTS if quick else CAMERA_COUNTS
    of_areas, of_pictures = area_tasks(chosen, counts, detail), picture_tasks(chosen, counts, detail)
    tasks = of_areas + of_pictures
    outcomes, pool, n_resumed = shown_sweep("paper", tasks, out / TASKS, scheduler)
    areas = area_rows(chosen, counts, outcomes[: len(of_areas)])
    write_areas(out / AREAS, areas)
    for case, outcome in zip(chosen, outcomes[len(of_areas) :], strict=True):
        if outcome.result is not None:
            write_picture(out / PICTURES, case, outcome.result)
    write_fits(out / FITS, fit_rows(areas, chosen))
    settings = {
        "command": "camring paper", "quick": quick, "detail": detail, "threshold": 2, "n_cameras": list(counts),
        "ring_diameter_mm": 30.0, "working_distance_mm": 400.0, "cases": [case.key for case in chosen],
        "seeds": "none: nothing is drawn at random",
    }  # fmt: skip
    hashes = {f"{case.site} {case.depth} {detail}": case.mesh_hash(detail) for case in chosen}
    write_record(out / RECORD, settings, hashes, tasks, outcomes, pool, time.monotonic() - started, n_resumed)
    return [outcome.failure for outcome in outcomes if outcome.failure]


def _report(out: Path) -> None:
    """Write tables, figures and the page from what is on disk."""
    areas, fits = read_areas(out / AREAS), read_fits(out / FITS)
    shown = cases_of(areas)
    for spec in TABLES:
        write_table(out, spec, entries(spec, areas, shown))
    pictures = {case: found for case in shown if (found := read_picture(out / PICTURES, case)) is not None}
    files = [name for spec in FIGURES for name in write_picture_figure(out, spec, pictures)]
    files += write_curve_figures(out, areas, fits, shown)
    write_report(out / PAGE, areas, fits, shown, files)
    print(f"{len(areas)} areas, {len(TABLES)} tables, {len(files) // 2} figures; read {out / PAGE}")
