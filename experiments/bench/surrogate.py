"""camring bench surrogate: whether what the search maximises ranks layouts as the exact area does."""

import csv
from collections.abc import Callable, Sequence
from dataclasses import asdict, astuple, dataclass, field, fields, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from tabulate import tabulate

from experiments.bench.surrogate_accuracy import Accuracy, Sampling, Truth, accuracy, sampling, true_areas
from experiments.bench.surrogate_figure import draw
from experiments.bench.surrogate_stages import Stages, stages
from experiments.bench.surrogate_tables import accuracy_table, sampling_table, stages_table
from experiments.files.errors import TargetMissed
from experiments.files.whole import output_folder, written_whole
from experiments.terminal.console import note, print_json, table, terminal
from experiments.terminal.progress import progress_stages
from placement.settings import Settings

OUTPUTS = (
    "bench_surrogate.csv", "bench_surrogate_sampling.csv", "bench_surrogate_stages.csv", "bench_surrogate.md",
    "bench_surrogate.png",
)  # fmt: skip
LEAST_RANK_CORRELATION = 0.99
GREATEST_MEAN_ERROR = 0.003  # of the ring maximum


@dataclass(frozen=True)
class Plan:
    """What is measured; every part of `Settings` that is not varied keeps its default."""

    cases: tuple[tuple[str, float], ...] = (
        ("circ_angled", 50), ("circ_artery", 50), ("circ_overhang", 100), ("elliptical", 50),
    )  # fmt: skip
    camera_counts: tuple[int, ...] = (3, 4, 6, 8)
    layouts_each: int = 50
    settings: Settings = field(default_factory=Settings)
    more_temperatures: tuple[float, ...] = (0.5, 0.2, 0.08, 0.03, 0.02, 0.01, 0.005)
    n_samples: tuple[int, ...] = (1024, 2048, 4096, 8192, 16384)
    sample_seeds: tuple[int, ...] = (0, 1)
    n_angles: tuple[int, ...] = (36, 72, 120, 240)
    bisections: tuple[int, ...] = (0, 2, 5, 8)
    sequences: tuple[tuple[float, ...], ...] = (
        (0.03,), (0.2, 0.03), (0.2, 0.08, 0.03, 0.01), (0.5, 0.2, 0.08, 0.03, 0.01),
    )  # fmt: skip
    n_starts: int = 16
    workers: int = 2

    @property
    def temperatures(self) -> tuple[float, ...]:
        """All temperatures at which soft coverage is compared [rad], falling."""
        return tuple(sorted({*self.settings.temperatures, *self.more_temperatures}, reverse=True))

    @property
    def choices(self) -> list[tuple[Settings, int]]:
        """Settings and seed of each way to sample: one number varied at a time."""
        own, seeds = self.settings, self.sample_seeds
        choices = [(replace(own, n_samples=n), seed) for n in (*self.n_samples, own.n_samples) for seed in seeds]
        choices += [(replace(own, n_angles=n), seeds[0]) for n in (*self.n_angles, own.n_angles)]
        choices += [(replace(own, bisections=n), seeds[0]) for n in (*self.bisections, own.bisections)]
        return list(dict.fromkeys(choices))


PLAN = Plan()


@dataclass(frozen=True)
class Bound:
    """One figure beside what it must be, and whether it holds."""

    what: str
    value: float
    wanted: str
    holds: bool


class Measured(NamedTuple):
    """All that is measured on one site."""

    truth: Truth
    rows: list[Accuracy]
    estimates: dict[float, np.ndarray]
    samplings: list[Sampling]
    searches: list[Stages]


def run(out: Path, force: bool, as_json: bool = False) -> None:
    """Measure, print, write tables and a picture.

    Raises
    ------
    TargetMissed
        If a bound does not hold; everything is written all the same.
    """
    plan = PLAN
    output_folder(out, OUTPUTS, force)
    with progress_stages() as progress:
        measured = [measure(plan, _truth(plan, *case, progress), progress) for case in plan.cases]
    report(measured, plan, out, as_json)


def report(measured: Sequence[Measured], plan: Plan, out: Path, as_json: bool) -> None:
    """Print and write what was measured on each site; raises as `run` does."""
    rows = [row for one in measured for row in one.rows]
    samplings = [row for one in measured for row in one.samplings]
    searches = [row for one in measured for row in one.searches]
    bounds = check(rows, plan.settings.temperatures[-1])
    tables = (
        accuracy_table(rows, (*plan.settings.temperatures, 0.0)), sampling_table(samplings, plan.settings),
        stages_table(searches),
    )  # fmt: skip
    _print(bounds, tables, as_json, rows, samplings, searches)
    for name, content in zip(OUTPUTS, (rows, samplings, searches), strict=False):
        _write(out / name, content)
    with written_whole(out / OUTPUTS[3]) as temporary:
        parts = [tabulate(lines, header, tablefmt="github", disable_numparse=True) for header, lines in tables]
        temporary.write_text("\n\n".join(parts) + "\n", encoding="utf-8")
    truths, estimates = [one.truth for one in measured], [one.estimates for one in measured]
    draw(out / OUTPUTS[4], truths, estimates, rows, samplings, plan.settings)
    note("wrote " + ", ".join(str(out / name) for name in OUTPUTS))
    missed = [bound for bound in bounds if not bound.holds]
    if missed:
        raise TargetMissed(
            f"{len(missed)} of {len(bounds)} bounds do not hold: "
            + "; ".join(f"{bound.what} is {bound.value:.4g}, {bound.wanted}" for bound in missed)
        )


def measure(plan: Plan, truth: Truth, progress: Callable[[str, int, int], object]) -> Measured:
    """Measure one site; `progress` is told what is being done, how far it is, and how far it goes."""
    progress(f"soft coverage, {truth.site}", 0, 1)
    rows, estimates = accuracy(truth, plan.settings, plan.temperatures)
    samplings, rays = [], {}
    for number, (settings, seed) in enumerate(plan.choices):
        progress(f"samples and angles, {truth.site}", number, len(plan.choices))
        samplings.append(sampling(truth, settings, seed, rays))
    progress(f"temperatures, {truth.site}", 0, 1)
    sequences = (plan.settings.temperatures, *plan.sequences)
    searches = stages(truth, plan.settings, sequences, plan.camera_counts[-2], plan.n_starts)
    return Measured(truth, rows, estimates, samplings, searches)


def check(rows: Sequence[Accuracy], temperature: float) -> list[Bound]:
    """Tell which bounds hold: rank correlation at the final temperature [rad], mean error of hard coverage.

    Both over all layouts of a site, whatever their number of cameras. Where there is nothing to rank, nothing holds.
    """
    bounds = []
    for row in rows:
        if row.n_cameras != "all":
            continue
        if row.temperature_rad == temperature:
            value = -1.0 if row.rank_correlation is None else row.rank_correlation
            what = f"rank correlation at {temperature:g} rad, {row.site} {row.depth_mm:g}"
            wanted = f"at least {LEAST_RANK_CORRELATION:g}"
            bounds.append(Bound(what, value, wanted, value >= LEAST_RANK_CORRELATION))
        elif row.temperature_rad == 0:
            what = f"mean error of hard coverage, {row.site} {row.depth_mm:g}"
            wanted = f"at most {GREATEST_MEAN_ERROR:g} of the ring maximum"
            bounds.append(Bound(what, row.mean_error, wanted, row.mean_error <= GREATEST_MEAN_ERROR))
    return bounds


def _truth(plan: Plan, name: str, depth: float, progress) -> Truth:
    total = len(plan.camera_counts) * plan.layouts_each
    done = 0

    def report(steps: int) -> None:
        nonlocal done
        done += steps
        progress(f"exact areas, {name}", done, total)

    ring_cameras = plan.settings.ring_cameras
    return true_areas(name, depth, plan.camera_counts, plan.layouts_each, ring_cameras, plan.workers, report)


def _print(bounds, tables, as_json, rows, samplings, searches) -> None:
    if as_json:
        parts = {"bounds": bounds, "accuracy": rows, "sampling": samplings, "stages": searches}
        print_json({name: [asdict(row) for row in part] for name, part in parts.items()})
        return
    for header, lines in tables:
        shown = table(*header)
        for line in lines:
            shown.add_row(*line)
        terminal().print(shown)
    for bound in bounds:
        print(f"{'holds' if bound.holds else 'FAILS'}: {bound.what}: {bound.value:.4f} ({bound.wanted})")


def _write(path: Path, rows: Sequence[Accuracy] | Sequence[Sampling] | Sequence[Stages]) -> None:
    with written_whole(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(field.name for field in fields(rows[0]))
        writer.writerows(astuple(row) for row in rows)
