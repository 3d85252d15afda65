"""camring paper: everything that Wachter 2021 reports, on the reference sites, beside its numbers."""

import time
from dataclasses import asdict
from pathlib import Path

from experiments.files.whole import output_folder
from experiments.paper.areas import area_rows, area_tasks, read_areas, write_areas
from experiments.paper.cases import QUICK_COUNTS, cases
from experiments.paper.curve_figures import write_curve_figures
from experiments.paper.fits import fit_rows, read_fits, write_fits
from experiments.paper.picture_figures import FIGURES, write_picture_figure
from experiments.paper.pictures import picture_tasks, read_picture, write_picture
from experiments.paper.published import CAMERA_COUNTS
from experiments.paper.report import differences, write_report
from experiments.paper.tables import TABLES, cases_of, entries, write_table
from experiments.sweeps import command as sweep_command
from experiments.sweeps.command import RECORD, SweepReport, SweepRequest
from experiments.sweeps.record import write_record
from experiments.sweeps.sweep import shown_sweep

AREAS, FITS, PICTURES, TASKS, PAGE = "areas.csv", "fits.csv", "pictures", "tasks", "paper.md"


def run(
    quick: bool, report_only: bool, detail: str, scheduler: str | None, out: Path, force: bool, as_json: bool
) -> None:
    """Compute unless only the report is wanted, then report from what is on disk."""
    asked = SweepRequest("camring paper", quick, report_only, detail, scheduler, out, force, as_json)
    sweep_command.run(asked, _compute, _report)


def _compute(asked: SweepRequest) -> None:
    """Write areas, fits, the data of the pictures and, last, the record."""
    out, detail = asked.out, asked.detail
    started = time.monotonic()
    output_folder(out, [RECORD], asked.force)
    output_folder(out / PICTURES, (), force=True)
    chosen, counts = cases(asked.quick), QUICK_COUNTS if asked.quick else CAMERA_COUNTS
    of_areas, of_pictures = area_tasks(chosen, counts, detail), picture_tasks(chosen, counts, detail)
    tasks = of_areas + of_pictures
    outcomes, pool, n_resumed = shown_sweep("paper", tasks, out / TASKS, asked.scheduler)
    areas = area_rows(chosen, counts, outcomes[: len(of_areas)])
    write_areas(out / AREAS, areas)
    for case, outcome in zip(chosen, outcomes[len(of_areas) :], strict=True):
        if outcome.result is not None:
            write_picture(out / PICTURES, case, outcome.result)
    write_fits(out / FITS, fit_rows(areas, chosen))
    settings = {
        "command": asked.command, "quick": asked.quick, "detail": detail, "threshold": 2, "n_cameras": list(counts),
        "ring_diameter_mm": 30.0, "working_distance_mm": 400.0, "cases": [case.key for case in chosen],
        "seeds": "none: nothing is drawn at random",
    }  # fmt: skip
    hashes = {f"{case.site} {case.depth} {detail}": case.mesh_hash(detail) for case in chosen}
    write_record(out / RECORD, settings, hashes, tasks, outcomes, pool, time.monotonic() - started, n_resumed)


def _report(out: Path) -> SweepReport:
    """Write tables, figures and the page from what is on disk."""
    areas, fits = read_areas(out / AREAS), read_fits(out / FITS)
    shown = cases_of(areas)
    of_table = {spec.number: entries(spec, areas, shown) for spec in TABLES}
    tables = [name for spec in TABLES for name in write_table(out, spec, of_table[spec.number])]
    pictures = {case: found for case in shown if (found := read_picture(out / PICTURES, case)) is not None}
    files = [name for spec in FIGURES for name in write_picture_figure(out, spec, pictures)]
    files += write_curve_figures(out, areas, fits, shown)
    write_report(out / PAGE, areas, fits, shown, files)
    counts = {"n_areas": len(areas), "n_tables": len(TABLES), "n_figures": len(files) // 2}
    return SweepReport(
        f"{len(areas)} areas, {len(TABLES)} tables, {len(files) // 2} figures; read {out / PAGE}",
        [AREAS, FITS, *tables, *files, PAGE],
        counts | {"differences_from_published": [asdict(one) for one in differences(of_table)]},
    )
