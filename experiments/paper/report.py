"""The page about all of it: in short, where ours differ from the published numbers and why, figures, fits, tables."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tabulate import tabulate

from experiments.files.whole import written_whole
from experiments.paper.areas import Area
from experiments.paper.cases import CIRCULAR, Case
from experiments.paper.fits import FitRow, determined
from experiments.paper.tables import TABLES, Entry, TableSpec, entries, markdown

# What the page shows of each figure: its file, what it is, what to look for.
CAPTIONS = {
    "figure_8": "Fig. 8: circular sites. Each part has the colour of the least number of equidistant cameras of which "
    "two see it. Two cameras leave out what lies to the left and right, as their fields of view are 24 mm wide there.",
    "figure_9": "Fig. 9: close-up. Behind and under the arteries the number of cameras matters most.",
    "figure_10": "Fig. 10: elliptical sites under the field of view of the others, which is narrower than the opening.",
    "figure_11": "Fig. 11: areas and fitted decays.",
    "figure_11_residuals": "What the fits leave.",
    "figure_12": "Fig. 12: the elliptical sites once more, with a field of view of 60 × 60 mm.",
}
NOT_THE_CAMERAS = """\
- **Not in the cameras.** The share of the top surface, area with it less area without, is the published one to
  {:.3f} mm² for all numbers of cameras and all circular sites: ring, field of view and the count of views are those of
  the paper."""
WHY = """\
- **In the models.** The paper's were cut from a scan of a head and are not public; ours are of the same kind. What lies
  at the bottom of a channel, and how much of it is hidden from how many cameras, is not the same tissue.
- **In the opening of the elliptical sites.** Of its outline only the area is known. With 36 × 24 mm the field of view
  ends on the walls, whose shape then decides what another camera adds; with 60 × 60 mm it does not.
- **Hardly in the method.** The paper orders faces by their nearest vertex, which is wrong for long or slanted ones; on
  our sites that alone moves an area by 0 to 0.09 % (`camring bench exact`)."""
SHOWN_TABLES = ("A2", "3")


@dataclass(frozen=True)
class Difference:
    """Of ours from the published numbers of one kind.

    Attributes
    ----------
    what : str
        Which numbers.
    mean_percent, greatest_percent : float
        Without sign: of areas in percent of the published one, of normalised areas in percentage points.
    where : str
        The site and number of cameras of the greatest.
    """

    what: str
    mean_percent: float
    greatest_percent: float
    where: str


def write_report(
    path: Path,
    areas: Sequence[Area],
    fits: Sequence[FitRow],
    cases: Sequence[Case],
    figures: Sequence[str],
    tables: str = "",
    images: str = "",
) -> None:
    """Write the page.

    Parameters
    ----------
    path : Path
    areas, fits, cases : sequence
    figures : sequence of str
        Names of the files there are.
    tables, images : str
        What stands before the names of tables and figures in links.
    """
    of_table = {spec.number: entries(spec, areas, cases) for spec in TABLES}
    text = [
        "# Wachter 2021, repeated",
        "",
        "What the paper reports, computed exactly on the reference sites (`camring site --list`) and set beside its",
        "numbers: *ours*, *published* (its Tables A1 to A3 and what follows from them), and the difference. Cameras",
        "sit equidistantly on the ring; a point counts when at least two see it. Made by `camring paper`.",
        "",
        *_in_short(of_table["3"]),
        *_differences(of_table),
        "## Figures",
        "",
    ]
    for stem, caption in CAPTIONS.items():
        if f"{stem}.png" in figures:
            text += [f"![{caption}]({images}{stem}.png)", "", f"*{caption}*", ""]
    text += _fits(fits)
    text += ["## Tables", "", *_links(tables), ""]
    text += [markdown(spec, of_table[spec.number], "###") for spec in TABLES if spec.number in SHOWN_TABLES]
    with written_whole(path) as temporary:
        temporary.write_text("\n".join(text).rstrip() + "\n", encoding="utf-8")


def _in_short(rows: Sequence[Entry]) -> list[str]:
    """How much few cameras reconstruct, over all sites."""
    counts = sorted({row.n_cameras for row in rows if row.ours is not None and row.n_cameras < 360})
    if not counts:
        return []
    header, lines = ["cameras"], [[str(n)] for n in counts]
    for kind, circular in (("circular", True), ("elliptical", False)):
        of_kind = [row for row in rows if row.ours is not None and (row.site in CIRCULAR) == circular]
        for who in ("ours", "published") if of_kind else ():
            header.append(f"{kind}, {who}")
            for n, line in zip(counts, lines, strict=True):
                line.append(_spread(who, [row for row in of_kind if row.n_cameras == n]))
    return [
        "## In short",
        "",
        "Part of the area of 360 cameras that fewer reconstruct, top surface not counted: mean over the circular and",
        "the elliptical sites, in parentheses the least and the greatest [%].",
        "",
        tabulate(lines, header, tablefmt="github", disable_numparse=True),
        "",
    ]


def _spread(who: str, rows: Sequence[Entry]) -> str:
    values = np.array([getattr(row, who) for row in rows])
    return f"{values.mean():.2f} ({values.min():.2f} to {values.max():.2f})"


def differences(of_table: dict[str, list[Entry]]) -> list[Difference]:
    """How much ours differ, top surface not counted; of the kinds of numbers that there are."""
    found = []
    for name, number, chosen in (
        ("areas, circular sites", "A2", lambda row: row.site in CIRCULAR),
        ("areas, elliptical sites", "A2", lambda row: row.site not in CIRCULAR),
        ("areas, wide field of view", "A3", lambda row: not row.top_surface_included),
        ("normalised areas, circular sites", "3", lambda row: row.site in CIRCULAR),
        ("normalised areas, elliptical sites", "3", lambda row: row.site not in CIRCULAR),
        ("normalised areas, wide field of view", "6",
         lambda row: row.quantity == "fraction" and not row.top_surface_included),
    ):  # fmt: skip
        rows = [row for row in of_table[number] if row.difference is not None and chosen(row)]
        if rows:
            worst = max(rows, key=_relative)
            where = f"{worst.site} {worst.depth_mm} mm, n = {worst.n_cameras}"
            mean = float(np.mean([_relative(row) for row in rows]))
            found.append(Difference(name, mean, _relative(worst), where))
    return found


def _differences(of_table: dict[str, list[Entry]]) -> list[str]:
    """Where ours differ, measured, and why that may be."""
    lines = [[one.what, f"{one.mean_percent:.2f}", f"{one.greatest_percent:.2f}", one.where]
             for one in differences(of_table)]  # fmt: skip
    rim = _top_surface(of_table)
    text = [
        "## Where ours differ, and why",
        "",
        "Top surface not counted; differences of areas in percent of the published area, those of normalised areas in",
        "percentage points.",
        "",
        tabulate(lines, ["what", "mean", "greatest", "where"], tablefmt="github", disable_numparse=True),
        "",
    ]
    if rim is not None:
        text.append(NOT_THE_CAMERAS.format(rim))
    return [*text, WHY, ""]


def _relative(row: Entry) -> float:
    assert row.difference is not None and row.published is not None
    return abs(row.difference) * (100 / row.published if row.unit == "mm²" else 1.0)


def _top_surface(of_table: dict[str, list[Entry]]) -> float | None:
    """Greatest difference [mm²] of the top surface's share of circular sites between ours and the published."""
    shares: dict[tuple, list[float]] = {}
    for row in (*of_table["A1"], *of_table["A2"]):
        if row.site in CIRCULAR and row.difference is not None:
            shares.setdefault((row.site, row.depth_mm, row.n_cameras), []).append(row.difference)
    differences = [abs(one - other) for one, other in (pair for pair in shares.values() if len(pair) == 2)]
    return max(differences, default=None)


def _fits(fits: Sequence[FitRow]) -> list[str]:
    if not fits:
        return []
    header = ["site", "", "plateau [mm²]", "lacking at n = 2 [mm²]", "1/e in [cameras]", "R²"]
    text = [
        "## Fits",
        "",
        "A_r(n) = plateau − Σ aₖ exp(−(n − 2)/dₖ) with two or three phases, as AICc decides: in parentheses standard",
        "errors; *?* is what the data do not tell: of a phase that is over before n = 4, or of two that are as fast.",
        "All of them, also those not chosen, are in `fits.csv`.",
        "",
    ]
    for included in (False, True):
        lines = []
        for row in fits:
            if row.chosen and row.top_surface_included == included:
                amplitudes = zip(row.amplitudes, row.amplitude_errors, strict=True)
                decays = zip(row.decays, row.decay_errors, strict=True)
                lines.append(
                    [
                        row.case.title, row.source, _with_error(row.plateau, row.plateau_error, 1),
                        ", ".join(_with_error(*pair, 1) for pair in amplitudes),
                        ", ".join(_with_error(*pair, 2) for pair in decays), f"{row.r_squared:.5f}",
                    ]
                )  # fmt: skip
        text += [
            f"{'With' if included else 'Without'} the top surface:",
            "",
            tabulate(lines, header, tablefmt="github", disable_numparse=True),
            "",
        ]
    return text


def _with_error(value: float, error: float, digits: int) -> str:
    return f"{value:.{digits}f} ({error:.{digits}f})" if determined(error, value) else "?"


def _links(folder: str) -> list[str]:
    def line(spec: TableSpec) -> str:
        files = ", ".join(f"[{kind}]({folder}table_{spec.number}.{kind})" for kind in ("csv", "md", "tex"))
        return f"- Table {spec.number}. {spec.title}: {files}"

    return [
        "A1 to A3 are areas, by top surface and field of view; 2 to 6 are what follows from them, for the published",
        "areas as for ours: normalised by the area of 360 cameras, and the increase over the previous number of",
        "cameras, absolute and in percent.",
        "",
        *(line(spec) for spec in TABLES),
        "",
        f"All areas in one file: [areas.csv]({folder}areas.csv), with the [record]({folder}record.json) of the run.",
    ]
