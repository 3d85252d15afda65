"""The page of the study, study.md, with its figures, from the rows on disk."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from tabulate import tabulate

from experiments.files.whole import written_whole
from experiments.study.figures import write_figures
from experiments.study.rows import EquidistantRow, LayoutRow
from experiments.study.savings import TARGETS, Saving, headline, percent, savings, sites_of

CAPTIONS = {
    "study_curves.png": "What each layout misses of the ring maximum, site by site.",
    "study_savings.png": "The fewest cameras that reach a target.",
    "study_constraints.png": "What a separation and a least triangulation angle cost.",
}


def write_report(folder: Path, layouts: Sequence[LayoutRow], even: Sequence[EquidistantRow]) -> str:
    """Write study.md and the figures; give the headline."""
    found = savings(layouts, even)
    figures = write_figures(folder, layouts, even, found)
    with written_whole(folder / "study.md") as temporary:
        temporary.write_text(page(layouts, even, figures), encoding="utf-8")
    return "\n".join(headline(found))


def page(layouts: Sequence[LayoutRow], even: Sequence[EquidistantRow], figures: Sequence[str], images: str = "") -> str:
    """The page in Markdown, with figures of these names in the folder `images`."""
    found = savings(layouts, even)
    parts = [
        "# Optimised against equidistant rings",
        "Reference sites without their top surface, field of view 36 × 24 mm, ring 30 mm at 400 mm, two views, cameras "
        "at least 5 mm apart unless said. All fractions are exact areas over the ring maximum, that of 360 equidistant "
        "cameras. `camring study` makes this page.",
        "\n".join(f"- {sentence}" for sentence in headline(found)),
        *(f"![{CAPTIONS[name]}]({images}{name})\n\n{CAPTIONS[name]}" for name in figures),
        "## Fewest cameras: optimised / equidistant",
        _savings_table(found),
        "## Every number of cameras",
        "Percent of the ring maximum. *Bound*: no layout at any angles reconstructs more of the samples (in italics "
        "where the best layout on the 5° grid was not proven to 0.2 % within the time limit; the bound holds all the "
        "same). The samples' own error, about 0.1 %, comes on top.",
        *(f"### {site}, {depth} mm\n\n{_site_table(layouts, site, depth)}" for site, depth in sites_of(layouts)),
        *_certificates(layouts),
        *_all_sites(layouts),
        *_failures(layouts, even),
    ]
    return "\n\n".join(parts) + "\n"


def _savings_table(found: Sequence[Saving]) -> str:
    lines = []
    for site, depth in dict.fromkeys((one.site, one.depth_mm) for one in found):
        of = {one.target: one for one in found if (one.site, one.depth_mm) == (site, depth)}
        cells = [f"{of[target].optimised or '–'} / {of[target].equidistant or '–'}" for target in TARGETS]
        lines.append([f"{site}, {depth} mm", *cells])
    return _table(lines, ["site", *(percent(target) for target in TARGETS)])


def _site_table(layouts: Sequence[LayoutRow], site: str, depth: int) -> str:
    of = [row for row in layouts if row.part == "layouts" and (row.site, row.depth_mm) == (site, depth)]
    lines = []
    for row in of:
        bound = _cell(row.bound_fraction)
        lines.append(
            [
                str(row.n_cameras), _cell(row.equidistant_fraction), _cell(row.best_equidistant_fraction),
                _cell(row.fraction), bound if row.proven else f"*{bound}*",
                ", ".join(f"{angle:.1f}" for angle in row.angles_deg),
            ]
        )  # fmt: skip
    return _table(lines, ["cameras", "equidistant", "best phase", "optimised", "bound", "ring angles [°]"])


def _certificates(layouts: Sequence[LayoutRow]) -> list[str]:
    """How the layouts stand to the best on the grid and to the best phase."""
    of = [row for row in layouts if row.part == "layouts" and row.fraction is not None]
    below = _differences([(row.grid_layout_fraction, row.fraction) for row in of])
    over = _differences([(row.fraction, row.best_equidistant_fraction) for row in of])
    proven = sum(bool(row.proven) for row in of)
    if not below:
        return []
    return [
        "## How good the search is",
        f"- {proven} of {len(of)} certificates were proven to 0.2 % on the 5° grid within their time limit.\n"
        f"- The certificate's layout on the grid, scored exactly, is at most {100 * max(0.0, *below):.2f} % of the "
        f"ring maximum better than the optimised one (mean {100 * np.mean(below):+.2f} %).\n"
        f"- Optimised layouts reconstruct {100 * min(over):+.2f} % to {100 * max(over):+.2f} % more than the best of "
        f"36 equidistant phases (mean {100 * np.mean(over):+.2f} %).",
    ]


def _differences(pairs: Sequence[tuple[float | None, float | None]]) -> list[float]:
    return [first - second for first, second in pairs if first is not None and second is not None]


def _all_sites(layouts: Sequence[LayoutRow]) -> list[str]:
    of = [row for row in layouts if row.part == "all sites"]
    if not of:
        return []
    lines = [
        [str(row.n_cameras), _cell(row.equidistant_fraction), _cell(row.best_equidistant_fraction),
         _cell(row.fraction), ", ".join(f"{angle:.1f}" for angle in row.angles_deg)]
        for row in sorted(of, key=lambda row: row.n_cameras)
    ]  # fmt: skip
    return [
        "## One layout for all sites together",
        "Percent of the ring maximum at the site where it is least, which is maximised.",
        _table(lines, ["cameras", "equidistant", "best phase", "optimised", "ring angles [°]"]),
    ]


def _failures(layouts: Sequence[LayoutRow], even: Sequence[EquidistantRow]) -> list[str]:
    failed = [f"- {row.site} {row.depth_mm}, {row.n_cameras} cameras: {row.failure}" for row in (*layouts, *even)
              if row.failure]  # fmt: skip
    return ["## Failed", "\n".join(failed)] if failed else []


def _cell(fraction: float | None) -> str:
    return "–" if fraction is None else f"{100 * fraction:.2f}"


def _table(lines: list[list[str]], header: list[str]) -> str:
    return tabulate(lines, header, tablefmt="github", disable_numparse=True)
