"""The page of the study, study.md, with its figures, from the rows on disk."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from tabulate import tabulate

from experiments.files.whole import written_whole
from experiments.study.figures import write_figures
from experiments.study.rows import EquidistantRow, LayoutRow
from experiments.study.savings import LEEWAY, TARGETS, Saving, accuracy, headline, percent, savings, sites_of

CAPTIONS = {
    "study_curves.png": "What each layout misses of the ring maximum, site by site.",
    "study_errors.png": "Root mean square of the predicted error in depth, site by site.",
    "study_savings.png": "The fewest cameras that reach a target.",
    "study_constraints.png": "What a separation and a least triangulation angle cost.",
}


def write_report(folder: Path, layouts: Sequence[LayoutRow], even: Sequence[EquidistantRow]) -> str:
    """Write study.md and the figures; give the headline."""
    found = savings(layouts, even)
    figures = write_figures(folder, layouts, even, found)
    with written_whole(folder / "study.md") as temporary:
        temporary.write_text(page(layouts, even, figures), encoding="utf-8")
    return "\n".join([*headline(found), *accuracy(layouts)])


def page(layouts: Sequence[LayoutRow], even: Sequence[EquidistantRow], figures: Sequence[str], images: str = "") -> str:
    """The page in Markdown, with figures of these names in the folder `images`."""
    found = savings(layouts, even)
    parts = [
        "# Optimised against equidistant rings",
        "Reference sites without their top surface, field of view 36 × 24 mm, ring 30 mm at 400 mm, two views, cameras "
        "at least 5 mm apart unless said. All fractions are exact areas over the ring maximum, that of 360 equidistant "
        "cameras; errors are predicted along depth, RMS over the area that a layout reconstructs, at 3600 × 2400 "
        "pixels with a noise of half a pixel in each match. Each search starts from the layouts of one camera less "
        "too. `camring study` makes this page.",
        "\n".join(f"- {sentence}" for sentence in (*headline(found), *accuracy(layouts))),
        *(f"![{CAPTIONS[name]}]({images}{name})\n\n{CAPTIONS[name]}" for name in figures),
        "## Fewest cameras: optimised / as accurate / equidistant",
        f"*As accurate*: optimised, with at most {percent(LEEWAY)} more error than the fewest equidistant cameras that "
        "reach the target.",
        _savings_table(found),
        "## Every number of cameras",
        "Percent of the ring maximum, and RMS error in depth [mm]. *Most area* is the greatest found; *proposed* the "
        "most accurate of the layouts within 0.5 % of it. *On the grid*: no layout with cameras at multiples of 5° "
        "reconstructs more of the surface. *Any angle*: no layout whatever reconstructs more of the samples, whose own "
        "error, about 0.1 %, comes on top. In italics where the best layout on the grid was not proven to 0.2 % "
        "within the time limit; the bound holds all the same.",
        *(f"### {site}, {depth} mm\n\n{_site_table(layouts, site, depth)}" for site, depth in sites_of(layouts)),
        *_certificates(layouts),
        *_dense(layouts),
        *_all_sites(layouts),
        *_failures(layouts, even),
    ]
    return "\n\n".join(parts) + "\n"


def _savings_table(found: Sequence[Saving]) -> str:
    lines = []
    for site, depth in dict.fromkeys((one.site, one.depth_mm) for one in found):
        of = {one.target: one for one in found if (one.site, one.depth_mm) == (site, depth)}
        cells = []
        for target in TARGETS:
            one = of[target]
            cells.append(" / ".join(str(n or "–") for n in (one.optimised, one.as_accurate, one.equidistant)))
        lines.append([f"{site}, {depth} mm", *cells])
    return _table(lines, ["site", *(percent(target) for target in TARGETS)])


def _site_table(layouts: Sequence[LayoutRow], site: str, depth: int) -> str:
    of = [row for row in layouts if row.part == "layouts" and (row.site, row.depth_mm) == (site, depth)]
    lines = []
    for row in of:
        lines.append(
            [
                str(row.n_cameras),
                _cell(row.equidistant_fraction, row.equidistant_error_rms_mm),
                _cell(row.best_equidistant_fraction, row.best_equidistant_error_rms_mm),
                _cell(row.most_area_fraction, row.most_area_error_rms_mm),
                _cell(row.fraction, row.error_rms_mm),
                _bound(row.surface_bound_fraction, row.surface_proven),
                _bound(row.bound_fraction, row.proven),
                _angles(row),
            ]
        )
    header = ["equidistant", "best phase", "most area", "proposed", "on the grid", "any angle"]
    return _table(lines, ["cameras", *header, "ring angles proposed [°]"])


def _certificates(layouts: Sequence[LayoutRow]) -> list[str]:
    """How the layouts stand to the best on the grid, to the bounds, and to the best phase."""
    of = [row for row in layouts if row.part == "layouts" and row.most_area_fraction is not None]
    below = _differences([(row.grid_layout_fraction, row.most_area_fraction) for row in of])
    gaps = _differences([(row.bound_fraction, row.most_area_fraction) for row in of])
    over = _differences([(row.most_area_fraction, row.best_equidistant_fraction) for row in of])
    proven = sum(bool(row.surface_proven) for row in of)
    if not below:
        return []
    return [
        "## How good the search is",
        f"- {proven} of {len(of)} layouts on the 5° grid were proven on the surface, to 0.2 %, within their time "
        "limit.\n"
        f"- The best layout on the grid is at most {100 * max(0.0, *below):.2f} % of the ring maximum better than the "
        f"one found (mean {100 * np.mean(below):+.2f} %).\n"
        f"- The bound for any angle lies {100 * np.median(gaps):.2f} % above the most area found in the median, "
        f"{100 * max(gaps):.2f} % at most.\n"
        f"- The most area found is {100 * min(over):+.2f} % to {100 * max(over):+.2f} % more than that of the best of "
        f"36 equidistant phases (mean {100 * np.mean(over):+.2f} %).",
    ]


def _dense(layouts: Sequence[LayoutRow]) -> list[str]:
    """How the answer changes where a surface counts only if enough pixels see it."""
    of = [row for row in layouts if row.part == "dense"]
    if not of:
        return []
    counts = sorted({row.n_cameras for row in of})
    lines = []
    for site, depth in sites_of(of):
        here = {row.n_cameras: row for row in of if (row.site, row.depth_mm) == (site, depth)}
        cells = [
            f"{_cell(here[n].equidistant_fraction)} / {_cell(here[n].most_area_fraction)}" if n in here else "–"
            for n in counts
        ]
        fewest = [
            min((n for n, row in here.items() if (getattr(row, name) or 0.0) >= TARGETS[0]), default="–")
            for name in ("equidistant_fraction", "most_area_fraction")
        ]
        lines.append([f"{site}, {depth} mm", *cells, f"{fewest[0]} / {fewest[1]}"])
    return [
        "## Where walls must be dense enough in pixels",
        f"The same where a point counts only with at least {of[0].min_pixel_density:g} pixels to a square millimetre "
        "of its surface in two cameras, foreshortening included. Nearly all of a site can be seen so by some cameras "
        "of the ring, those opposite a wall, but not by the ones above it. Percent of the ring maximum under the same "
        f"limit, equidistant / most area found, and last the fewest cameras for {percent(TARGETS[0])}.",
        _table(lines, ["site", *(f"{n} cameras" for n in counts), "fewest"]),
    ]


def _differences(pairs: Sequence[tuple[float | None, float | None]]) -> list[float]:
    return [first - second for first, second in pairs if first is not None and second is not None]


def _all_sites(layouts: Sequence[LayoutRow]) -> list[str]:
    of = [row for row in layouts if row.part == "all sites"]
    if not of:
        return []
    lines = [
        [str(row.n_cameras), _cell(row.equidistant_fraction, row.equidistant_error_rms_mm),
         _cell(row.best_equidistant_fraction, row.best_equidistant_error_rms_mm),
         _cell(row.most_area_fraction, row.most_area_error_rms_mm), _cell(row.fraction, row.error_rms_mm),
         _angles(row)]
        for row in sorted(of, key=lambda row: row.n_cameras)
    ]  # fmt: skip
    return [
        "## One layout for all sites together",
        "Percent of the ring maximum at the site where it is least, which is maximised, and RMS error in depth over "
        "all sites [mm].",
        _table(lines, ["cameras", "equidistant", "best phase", "most area", "proposed", "ring angles proposed [°]"]),
    ]


def _failures(layouts: Sequence[LayoutRow], even: Sequence[EquidistantRow]) -> list[str]:
    failed = [f"- {row.site} {row.depth_mm}, {row.n_cameras} cameras: {row.failure}" for row in (*layouts, *even)
              if row.failure]  # fmt: skip
    return ["## Failed", "\n".join(failed)] if failed else []


def _cell(fraction: float | None, error: float | None = None) -> str:
    """Percent, and perhaps an error [mm]."""
    if fraction is None:
        return "–"
    return f"{100 * fraction:.2f}" + ("" if error is None else f", {error:.3f}")


def _bound(fraction: float | None, proven: bool | None) -> str:
    return _cell(fraction) if proven or fraction is None else f"*{_cell(fraction)}*"


def _angles(row: LayoutRow) -> str:
    return ", ".join(f"{angle:.1f}" for angle in row.angles_deg)


def _table(lines: list[list[str]], header: list[str]) -> str:
    return tabulate(lines, header, tablefmt="github", disable_numparse=True)
