"""Negative exponential decays through our areas and the published ones, as a table: the data of Fig. 11."""

import csv
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.files.whole import written_whole
from experiments.paper.areas import Area, curve
from experiments.paper.cases import Case
from experiments.paper.published import FIRST, published_areas

MOST_PHASES = 3
COLUMNS = (
    "source", "site", "depth_mm", "fov_mm", "top_surface_included", "phases", "chosen", "r_squared", "aicc",
    "plateau_mm2", "plateau_error_mm2",
    *(
        f"{what}_{phase}{unit}"
        for phase in range(1, MOST_PHASES + 1)
        for what, unit in (
            ("amplitude", "_mm2"), ("amplitude_error", "_mm2"), ("decay", "_cameras"), ("decay_error", "_cameras"))
    ),
)  # fmt: skip


@dataclass(frozen=True)
class FitRow:
    """One fit of one curve; numbers that the data do not determine are nan, those of phases there are none of None."""

    source: str
    case: Case
    top_surface_included: bool
    phases: int
    chosen: bool
    r_squared: float
    aicc: float
    plateau: float
    plateau_error: float
    amplitudes: tuple[float, ...]
    amplitude_errors: tuple[float, ...]
    decays: tuple[float, ...]
    decay_errors: tuple[float, ...]


def fit_rows(areas: Sequence[Area], cases: Sequence[Case]) -> list[FitRow]:
    """Fit every curve that has points enough; of each, the fit with the least AICc is the chosen one."""
    if all(len(curve(areas, case, False)[0]) < 8 for case in cases):
        return []  # none has enough, and jax takes a while to come up
    from experiments.paper.decay import fit_decays

    rows = []
    for source, case, included, n, area in _curves(areas, cases):
        for rank, fit in enumerate(fit_decays(n, area)):
            rows.append(
                FitRow(
                    source, case, included, fit.n_phases, rank == 0, fit.r_squared, fit.aicc, fit.plateau,
                    fit.plateau_error, fit.amplitudes, fit.amplitude_errors, fit.decays, fit.decay_errors,
                )
            )  # fmt: skip
    return rows


def _curves(areas: Sequence[Area], cases: Sequence[Case]) -> Iterator[tuple]:
    published = published_areas()
    for included in (True, False):
        for case in cases:
            n, ours = curve(areas, case, included)
            yield "ours", case, included, n, ours
            theirs = [published[case.site, case.depth, case.fov, included, int(count)] for count in n]
            yield "published", case, included, n, theirs


def write_fits(path: Path, rows: Sequence[FitRow]) -> None:
    """Write all fits in full."""
    with written_whole(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row in rows:
            phases: list[float | None] = []
            per_phase = zip(row.amplitudes, row.amplitude_errors, row.decays, row.decay_errors, strict=True)
            for phase in per_phase:
                phases += phase
            phases += [None] * (4 * MOST_PHASES - len(phases))
            numbers = (row.r_squared, row.aicc, row.plateau, row.plateau_error, *phases)
            writer.writerow(
                [row.source, row.case.site, row.case.depth, row.case.fov, int(row.top_surface_included), row.phases,
                 int(row.chosen), *("" if number is None else repr(float(number)) for number in numbers)]
            )  # fmt: skip


def read_fits(path: Path) -> list[FitRow]:
    """Read what `write_fits` has written."""
    with path.open(newline="", encoding="utf-8") as file:
        return [_row(line) for line in csv.DictReader(file)]


def _row(line: dict[str, str]) -> FitRow:
    def phases(what: str, unit: str) -> tuple[float, ...]:
        return tuple(float(line[f"{what}_{phase}{unit}"]) for phase in range(1, int(line["phases"]) + 1))

    return FitRow(
        line["source"], Case(line["site"], int(line["depth_mm"]), line["fov_mm"]), line["top_surface_included"] == "1",
        int(line["phases"]), line["chosen"] == "1", float(line["r_squared"]), float(line["aicc"]),
        float(line["plateau_mm2"]), float(line["plateau_error_mm2"]), phases("amplitude", "_mm2"),
        phases("amplitude_error", "_mm2"), phases("decay", "_cameras"), phases("decay_error", "_cameras"),
    )  # fmt: skip


def chosen_fit(rows: Sequence[FitRow], case: Case, included: bool, source: str = "ours") -> FitRow | None:
    """The fit with the least AICc of one curve; None if it had too few points."""
    for row in rows:
        if row.chosen and (row.source, row.case, row.top_surface_included) == (source, case, included):
            return row
    return None


def fitted(row: FitRow, n_cameras) -> np.ndarray:
    """Area [mm²] on a fitted curve."""
    n = np.asarray(n_cameras, dtype=np.float64)
    return row.plateau - np.exp(-(n[..., None] - FIRST) / np.array(row.decays)) @ np.array(row.amplitudes)


def determined(error: float, value: float) -> bool:
    """Whether the data tell a parameter: its standard error is known and less than itself."""
    return math.isfinite(error) and error < abs(value)
