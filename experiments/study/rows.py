"""What the study found, one row a request: written as CSV, read back for tables and figures."""

import csv
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, get_args, get_type_hints

from experiments.files.whole import written_whole
from experiments.sweeps.task import Outcome


@dataclass(frozen=True)
class LayoutRow:
    """One layout request; fractions are exact and of the ring maximum, and None where the task failed.

    `part` is "layouts" (one site, with certificate), "dense" (a surface counts where enough pixels see it),
    "constraints" or "all sites": one layout for all of them, whose fractions are the least over the sites. `fraction`,
    `error_rms_mm`, areas and `angles_deg` are those of the layout proposed. Errors are predicted along depth.
    """

    part: str
    site: str
    depth_mm: int | None
    n_cameras: int
    min_separation_mm: float
    min_angle_deg: float
    min_pixel_density: float | None
    objective: str
    fraction: float | None = None
    error_rms_mm: float | None = None
    most_area_fraction: float | None = None
    most_area_error_rms_mm: float | None = None
    equidistant_fraction: float | None = None
    equidistant_error_rms_mm: float | None = None
    best_equidistant_fraction: float | None = None
    best_equidistant_error_rms_mm: float | None = None
    best_phase_deg: float | None = None
    sampled_fraction: float | None = None
    bound_fraction: float | None = None
    proven: bool | None = None
    surface_bound_fraction: float | None = None
    surface_proven: bool | None = None
    grid_layout_fraction: float | None = None
    smallest_separation_mm: float | None = None
    area_mm2: float | None = None
    ring_area_mm2: float | None = None
    angles_deg: tuple[float, ...] = ()
    most_area_angles_deg: tuple[float, ...] = ()
    site_fractions: tuple[float, ...] = ()
    failure: str = ""


@dataclass(frozen=True)
class EquidistantRow:
    """What an equidistant ring at phase 0 reaches: exact fraction of the ring maximum, and predicted error in depth."""

    site: str
    depth_mm: int
    n_cameras: int
    fraction: float | None
    error_rms_mm: float | None
    failure: str = ""


def layout_rows(about: dict[str, Any], outcome: Outcome) -> list[LayoutRow]:
    """The rows of a task of `study_tasks`; columns without a value where it failed."""
    asked = {name: value for name, value in about.items() if name != "counts"}
    found = [{}] * len(about["counts"]) if outcome.result is None else outcome.result["layouts"]
    rows = []
    for n, columns in zip(about["counts"], found, strict=True):
        of: dict[str, Any] = {name: tuple(one) if isinstance(one, list) else one for name, one in columns.items()}
        rows.append(LayoutRow(**asked, n_cameras=n, **of, failure=outcome.failure))
    return rows


def equidistant_rows(about: dict[str, Any], counts: Sequence[int], outcome: Outcome) -> list[EquidistantRow]:
    """The rows of a task about equidistant rings of these numbers of cameras."""
    none = [None] * len(counts)
    found = {"fractions": none, "errors_rms_mm": none} if outcome.result is None else outcome.result
    return [
        EquidistantRow(about["site"], about["depth_mm"], n, fraction, error, outcome.failure)
        for n, fraction, error in zip(counts, found["fractions"], found["errors_rms_mm"], strict=True)
    ]


def write_rows(path: Path, kind: type, rows: Sequence[Any]) -> None:
    """Write rows of one kind, every figure in full."""
    with written_whole(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(field.name for field in fields(kind))
        for row in rows:
            writer.writerow(_text(value) for value in asdict(row).values())


def read_rows(path: Path, kind: type) -> list[Any]:
    """Read what `write_rows` wrote.

    Examples
    --------
    >>> import tempfile
    >>> rows = [EquidistantRow("circ_flat", 50, 4, 0.925, 0.08), EquidistantRow("circ_flat", 50, 5, None, None, "no")]
    >>> path = Path(tempfile.mkdtemp()) / "rows.csv"
    >>> write_rows(path, EquidistantRow, rows)
    >>> read_rows(path, EquidistantRow) == rows
    True
    """
    types = get_type_hints(kind)
    with path.open(newline="", encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    return [kind(**{name: _value(text, types[name]) for name, text in line.items()}) for line in lines]


def _text(value: Any) -> str:
    if isinstance(value, tuple | list):
        return " ".join(repr(float(number)) for number in value)
    return "" if value is None else repr(value) if isinstance(value, float) else str(value)


def _value(text: str, kind: Any) -> Any:
    if kind is str:
        return text
    options = get_args(kind)
    if options and options[-1] is Ellipsis:
        return tuple(float(word) for word in text.split())
    if text == "":
        return None
    for plain, read in ((bool, lambda word: word == "True"), (int, int), (float, float)):
        if kind is plain or plain in options:
            return read(text)
    raise TypeError(f"no way to read {kind}")
