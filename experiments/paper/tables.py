"""Tables A1 to A3 and 2 to 6 of Wachter 2021: our value, the published one, the difference; CSV, Markdown and LaTeX."""

import csv
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, fields
from itertools import pairwise
from pathlib import Path

from tabulate import tabulate

from experiments.files.whole import written_whole
from experiments.paper.areas import Area
from experiments.paper.cases import Case
from experiments.paper.published import published_areas

# Value by number of cameras; None for one that failed, which is what its successor's increase would be counted from.
Curve = Mapping[int, float | None]
# What is tabulated: from the areas, one value for each number of cameras that has one.
QUANTITIES: dict[str, tuple[str, str, int, Callable[[Curve], dict[int, float]]]] = {
    "area": ("reconstructable area", "mm²", 2, lambda areas: _known(areas)),
    "fraction": ("area over that of 360 cameras", "%", 2, lambda areas: _fractions(areas)),
    "increase": ("increase over the previous number of cameras", "mm²", 2, lambda areas: _increases(areas, False)),
    "increase_percent": ("increase over the previous number of cameras", "%", 2, lambda areas: _increases(areas, True)),
}


@dataclass(frozen=True)
class TableSpec:
    """One table: what it is about and which of the areas enter."""

    number: str
    title: str
    quantities: tuple[str, ...]
    fov: str
    top_surface: tuple[bool, ...]


TABLES = (
    TableSpec("A1", "Areas with the top surface", ("area",), "36x24", (True,)),
    TableSpec("A2", "Areas without the top surface", ("area",), "36x24", (False,)),
    TableSpec("A3", "Areas with the wide field of view", ("area",), "60x60", (True, False)),
    TableSpec("2", "Normalised areas with the top surface", ("fraction",), "36x24", (True,)),
    TableSpec("3", "Normalised areas without the top surface", ("fraction",), "36x24", (False,)),
    TableSpec("4", "Increases with the top surface", ("increase", "increase_percent"), "36x24", (True,)),
    TableSpec("5", "Increases without the top surface", ("increase", "increase_percent"), "36x24", (False,)),
    TableSpec(
        "6", "Normalised areas and increases with the wide field of view",
        ("fraction", "increase", "increase_percent"), "60x60", (True, False),
    ),
)  # fmt: skip


@dataclass(frozen=True)
class Entry:
    """One number of a table, ours and the published one; None where there is none, and then `failure` may say why."""

    table: str
    quantity: str
    unit: str
    site: str
    depth_mm: int
    fov_mm: str
    top_surface_included: bool
    n_cameras: int
    ours: float | None
    published: float | None
    difference: float | None
    failure: str


def entries(spec: TableSpec, areas: Sequence[Area], cases: Sequence[Case]) -> list[Entry]:
    """All numbers of a table, for the cases and numbers of cameras there are areas of."""
    published = published_areas()
    rows = []
    for quantity in spec.quantities:
        _, unit, _, derive = QUANTITIES[quantity]
        for included in spec.top_surface:
            for case in cases:
                if case.fov != spec.fov:
                    continue
                of_case = [area for area in areas if _is_of(area, case, included)]
                ours = derive({area.n_cameras: area.area_mm2 for area in of_case})
                every = {key[4]: value for key, value in published.items() if key[:4] == (*astuple(case), included)}
                theirs = derive(every)
                for area in of_case:
                    n = area.n_cameras
                    if n not in theirs:
                        continue
                    difference = ours[n] - theirs[n] if n in ours else None
                    rows.append(
                        Entry(
                            spec.number, quantity, unit, case.site, case.depth, case.fov, included, n, ours.get(n),
                            theirs[n], difference, area.failure,
                        )
                    )  # fmt: skip
    return rows


def cases_of(areas: Sequence[Area]) -> list[Case]:
    """The cases there are areas of, in their order."""
    return list(dict.fromkeys(Case(area.site, area.depth_mm, area.fov_mm) for area in areas))


def _is_of(area: Area, case: Case, included: bool) -> bool:
    return (area.site, area.depth_mm, area.fov_mm, area.top_surface_included) == (*astuple(case), included)


def _known(areas: Curve) -> dict[int, float]:
    return {n: area for n, area in areas.items() if area is not None}


def _fractions(areas: Curve) -> dict[int, float]:
    maximum = areas.get(360)
    return {} if maximum is None else {n: 100 * area / maximum for n, area in _known(areas).items()}


def _increases(areas: Curve, percent: bool) -> dict[int, float]:
    steps = {}
    for before, n in pairwise(sorted(areas)):
        first, second = areas[before], areas[n]
        if first is not None and second is not None:
            steps[n] = 100 * (second - first) / first if percent else second - first
    return steps


def write_table(folder: Path, spec: TableSpec, rows: Sequence[Entry]) -> list[str]:
    """Write table_<number>.csv, .md and .tex; their names."""
    stem = folder / f"table_{spec.number}"
    with (
        written_whole(stem.with_suffix(".csv")) as temporary,
        temporary.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(field.name for field in fields(Entry))
        for row in rows:
            numbers = ("" if value is None else repr(value) for value in (row.ours, row.published, row.difference))
            writer.writerow([*astuple(row)[:6], int(row.top_surface_included), row.n_cameras, *numbers, row.failure])
    with written_whole(stem.with_suffix(".md")) as temporary:
        temporary.write_text(markdown(spec, rows), encoding="utf-8")
    with written_whole(stem.with_suffix(".tex")) as temporary:
        temporary.write_text(_latex(spec, rows), encoding="utf-8")
    return [f"{stem.name}.{ending}" for ending in ("csv", "md", "tex")]


def markdown(spec: TableSpec, rows: Sequence[Entry], heading: str = "#") -> str:
    """A table for each quantity and choice of faces: a line each for ours, the published and the difference."""
    text = [f"{heading} Table {spec.number}. {spec.title}", ""]
    for caption, header, lines in _blocks(spec, rows):
        text += [f"{caption}.", "", _set(lines, header, "github"), ""]
    return "\n".join(text)


def _latex(spec: TableSpec, rows: Sequence[Entry]) -> str:
    text = [f"% Table {spec.number}. {spec.title}. Needs the package booktabs."]
    for caption, header, lines in _blocks(spec, rows):
        body = _set(lines, header, "latex_booktabs")
        text += [r"\begin{table}", rf"\caption{{{_escaped(spec.title)}: {_escaped(caption)}.}}", body, r"\end{table}"]
    return "\n".join(text) + "\n"


def _escaped(text: str) -> str:
    return text.replace("%", r"\%").replace("²", r"\textsuperscript{2}").replace("×", r"$\times$")


def _blocks(spec: TableSpec, rows: Sequence[Entry]) -> Iterator[tuple[str, list[str], list[list[str]]]]:
    """Caption, header and lines of each part of a table."""
    for quantity in spec.quantities:
        words, unit, digits, _ = QUANTITIES[quantity]
        for included in spec.top_surface:
            chosen = [row for row in rows if (row.quantity, row.top_surface_included) == (quantity, included)]
            counts = sorted({row.n_cameras for row in chosen})
            lines = []
            for case in dict.fromkeys((row.site, row.depth_mm) for row in chosen):
                by_count = {row.n_cameras: row for row in chosen if (row.site, row.depth_mm) == case}
                for who in ("ours", "published", "difference"):
                    name = f"{case[0]} {case[1]} mm" if who == "ours" else ""
                    lines.append([name, who, *(_cell(by_count[n], who, digits) for n in counts)])
            what = f"{words[0].upper()}{words[1:]} [{unit}], {'with' if included else 'without'} the top surface"
            yield what, ["site", "", *(f"n = {n}" for n in counts)], lines


def _cell(row: Entry, who: str, digits: int) -> str:
    value = getattr(row, who)
    if value is None:
        return "failed" if row.failure else "–"
    return f"{value:+z.{digits}f}" if who == "difference" else f"{value:.{digits}f}"


def _set(lines: list[list[str]], header: list[str], kind: str) -> str:
    align = ("left", "left", *("right" for _ in header[2:]))
    return tabulate(lines, header, tablefmt=kind, disable_numparse=True, colalign=align)
