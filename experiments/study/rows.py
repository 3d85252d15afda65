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

    `part` is "layouts" (one site, with certificate), "constraints" or "all sites": one layout for all of them, whose
    fractions are the least over the sites.
    """

    part: str
    site: str
    depth_mm: int | None
    n_cameras: int
    min_separation_mm: float
    min_angle_deg: float
    objective: str
    fraction: float | None = None
    equidistant_fraction: float | None = None
    best_equidistant_fraction: float | None = None
    best_phase_deg: float | None = None
    sampled_fraction: float | None = None
    bound_fraction: float | None = None
    grid_bound_fraction: float | None = None
    grid_layout_fraction: float | None = None
    proven: bool | None = None
    smallest_separation_mm: float | None = None
    area_mm2: float | None = None
    ring_area_mm2: float | None = None
    angles_deg: tuple[float, ...] = ()
    site_fractions: tuple[float, ...] = ()
    failure: str = ""


@dataclass(frozen=True)
class EquidistantRow:
    """What an equidistant ring at phase 0 reaches, as an exact fraction of the ring maximum."""

    site: str
    depth_mm: int
    n_cameras: int
    fraction: float | None
    failure: str = ""


def layout_row(about: dict[str, Any], outcome: Outcome) -> LayoutRow:
    """The row of a task of `study_tasks`; columns without a value where it failed."""
    found: dict[str, Any] = {
        name: tuple(value) if isinstance(value, list) else value for name, value in (outcome.result or {}).items()
    }
    return LayoutRow(**about, **found, failure=outcome.failure)


def equidistant_rows(about: dict[str, Any], counts: Sequence[int], outcome: Outcome) -> list[EquidistantRow]:
    """The rows of a task about equidistant rings of these numbers of cameras."""
    found = [None] * len(counts) if outcome.result is None else outcome.result["fractions"]
    return [
        EquidistantRow(about["site"], about["depth_mm"], n, fraction, outcome.failure)
        for n, fraction in zip(counts, found, strict=True)
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
    >>> rows = [EquidistantRow("circ_flat", 50, 4, 0.925), EquidistantRow("circ_flat", 50, 5, None, "no memory")]
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
