"""The figures of the study: area missing and errors over the number of cameras, cameras saved, price of constraints."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from experiments.files.whole import written_whole
from experiments.paper.curve_figures import SITE_COLOURS
from experiments.study.rows import EquidistantRow, LayoutRow
from experiments.study.savings import TARGETS, Saving, percent, sites_of

EQUIDISTANT, BEST_PHASE, MOST_AREA, PROPOSED, BOUND = "#d55e00", "#e69f00", "#0072b2", "#009e73", "0.55"
# What is missing is shown down to this fraction of the ring maximum; what is less is drawn there.
LEAST_SHOWN = 2e-4


def write_figures(
    folder: Path, layouts: Sequence[LayoutRow], even: Sequence[EquidistantRow], found: Sequence[Saving]
) -> list[str]:
    """Draw them as PNG and PDF; the names of the PNG files."""
    figures = {
        "study_curves": _curves(layouts, even),
        "study_errors": _errors(layouts, even),
        "study_savings": _savings(found),
    }
    if any(row.part == "constraints" for row in layouts):
        figures["study_constraints"] = _constraints(layouts)
    for stem, figure in figures.items():
        for ending in ("png", "pdf"):
            with written_whole(folder / f"{stem}.{ending}") as temporary:
                figure.savefig(temporary, metadata={"CreationDate": None} if ending == "pdf" else {})
    return [f"{stem}.png" for stem in figures]


def _curves(layouts: Sequence[LayoutRow], even: Sequence[EquidistantRow]) -> Figure:
    figure, axes = _sites(layouts, even)
    for ax, of, ring in axes:
        _missing(ax, [(r.n_cameras, r.fraction) for r in ring], EQUIDISTANT, "o-", "equidistant")
        best_phase = [(r.n_cameras, r.best_equidistant_fraction) for r in of]
        _missing(ax, best_phase, BEST_PHASE, "^--", "equidistant, best of 36 phases")
        _missing(ax, [(r.n_cameras, r.most_area_fraction) for r in of], MOST_AREA, "s-", "most area")
        _missing(ax, [(r.n_cameras, r.fraction) for r in of], PROPOSED, "D-", "proposed")
        _missing(ax, [(r.n_cameras, r.bound_fraction) for r in of], BOUND, ":", "no layout misses less (certificate)")
        for target in TARGETS:
            label = ", ".join(percent(one) for one in TARGETS) if target == TARGETS[0] else None
            ax.axhline(1 - target, color="0.82", linewidth=1, zorder=0, label=label)
    first = axes[0][0]
    first.set_yscale("log")
    first.set_ylim(1.0, LEAST_SHOWN * 0.9)
    first.yaxis.set_major_formatter(FuncFormatter(lambda value, _: percent(value)))
    figure.supylabel("missing from the ring maximum (better is up)")
    return _named(figure, first)


def _errors(layouts: Sequence[LayoutRow], even: Sequence[EquidistantRow]) -> Figure:
    figure, axes = _sites(layouts, even)
    for ax, of, ring in axes:
        _curve(ax, [(r.n_cameras, r.error_rms_mm) for r in ring], EQUIDISTANT, "o-", "equidistant")
        _curve(ax, [(r.n_cameras, r.most_area_error_rms_mm) for r in of], MOST_AREA, "s-", "most area")
        _curve(ax, [(r.n_cameras, r.error_rms_mm) for r in of], PROPOSED, "D-", "proposed")
        ax.grid(color="0.93")
    first = axes[0][0]
    first.set_yscale("log")
    first.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    first.yaxis.set_minor_formatter(FuncFormatter(lambda value, _: f"{value:g}" if value in (0.05, 0.2, 0.5) else ""))
    figure.supylabel("RMS error in depth [mm] (better is down)")
    return _named(figure, first)


def _sites(
    layouts: Sequence[LayoutRow], even: Sequence[EquidistantRow]
) -> tuple[Figure, list[tuple[Axes, list[LayoutRow], list[EquidistantRow]]]]:
    """Axes for each site, with its rows."""
    sites = sites_of(layouts)
    columns = min(5, len(sites))
    rows = -(-len(sites) // columns)
    figure = Figure(figsize=(max(3.1 * columns, 7.0), 3.2 * rows + 1.1), dpi=130, layout="constrained")
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    most = max(row.n_cameras for row in layouts)
    made = []
    for ax, (site, depth) in zip(axes.flat, sites, strict=False):
        of = [row for row in layouts if row.part == "layouts" and (row.site, row.depth_mm) == (site, depth)]
        ring = [row for row in even if (row.site, row.depth_mm) == (site, depth) and row.n_cameras <= most]
        ax.set_title(f"{site}, {depth} mm", fontsize=10)
        made.append((ax, sorted(of, key=lambda row: row.n_cameras), ring))
    for ax in axes.flat[len(sites) :]:
        ax.set_axis_off()
    axes[0, 0].xaxis.set_major_locator(MaxNLocator(integer=True))
    figure.supxlabel("number of cameras")
    return figure, made


def _named(figure: Figure, ax: Axes) -> Figure:
    """With one legend for all axes."""
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=6 if len(figure.axes) > 2 else 3, frameon=False)
    return figure


def _missing(ax: Axes, points, colour: str, style: str, label: str) -> None:
    missing = [(n, None if fraction is None else max(1 - fraction, LEAST_SHOWN)) for n, fraction in points]
    _curve(ax, missing, colour, style, label)


def _curve(ax: Axes, points, colour: str, style: str, label: str) -> None:
    known = [point for point in points if point[1] is not None]
    if known:
        ax.plot(*zip(*known, strict=True), style, color=colour, label=label, markersize=4, linewidth=1.4)


def _savings(found: Sequence[Saving]) -> Figure:
    names = list(dict.fromkeys(f"{one.site}, {one.depth_mm} mm" for one in found))
    figure = Figure(figsize=(11.5, 0.42 * len(names) + 2.0), dpi=130, layout="constrained")
    axes = figure.subplots(1, len(TARGETS), sharey=True)
    for ax, target in zip(axes, TARGETS, strict=True):
        rows = [one for one in found if one.target == target]
        for y, one in enumerate(rows):
            ends = [n for n in (one.optimised, one.equidistant) if n is not None]
            ax.plot(ends, [y] * len(ends), color="0.75", linewidth=2.5, zorder=1)
            if one.as_accurate is not None:
                ax.plot(
                    one.as_accurate, y, "D", color=PROPOSED, zorder=2, markersize=9, mfc="none", label="as accurate"
                )
            if one.equidistant is not None:
                ax.plot(one.equidistant, y, "o", color=EQUIDISTANT, zorder=2, label="equidistant")
            if one.optimised is not None:
                ax.plot(one.optimised, y, "s", color=MOST_AREA, zorder=3, label="optimised")
            if not ends:
                ax.text(
                    0.5, y, "not reached", transform=ax.get_yaxis_transform(), va="center", ha="center", color="0.5"
                )
        ax.set_title(f"{percent(target)} of the ring maximum", fontsize=11)
        ax.set_xlabel("fewest cameras")
        ax.xaxis.set_major_locator(MaxNLocator(integer=True))
        ax.set_xlim(left=1)
        ax.grid(axis="x", color="0.92")
        ax.set_axisbelow(True)
    axes[0].set_yticks(range(len(names)), names)
    axes[0].set_ylim(len(names) - 0.5, -0.5)
    handles = {label: handle for ax in axes for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)}
    figure.legend(handles.values(), handles.keys(), loc="outside upper center", ncols=3, frameon=False)
    return figure


def _constraints(layouts: Sequence[LayoutRow]) -> Figure:
    of = [row for row in layouts if row.part == "constraints" and row.most_area_fraction is not None]
    counts = sorted({row.n_cameras for row in of})
    free = [row for row in layouts if row.part == "layouts" and row.n_cameras in counts and row.most_area_fraction]
    figure = Figure(figsize=(11.0, 4.3 * len(counts)), dpi=130, layout="constrained")
    axes = figure.subplots(len(counts), 2, sharey="row", squeeze=False)
    for row, n in enumerate(counts):
        here = [one for one in of + free if one.n_cameras == n]
        _price(axes[row, 0], [one for one in here if one.min_angle_deg == 0], "min_separation_mm")
        _price(axes[row, 1], [one for one in here if one.min_separation_mm == 5], "min_angle_deg")
        axes[row, 0].set_ylabel(f"{n} cameras, most area,\npercent of the ring maximum")
        axes[row, 0].set_xlabel("least separation [mm]")
        axes[row, 1].set_xlabel("least triangulation angle [°], separation 5 mm")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right center", frameon=False, fontsize=9)
    return figure


def _price(ax: Axes, rows: Sequence[LayoutRow], what: str) -> None:
    for site, depth in sites_of(rows):
        of = [row for row in rows if (row.site, row.depth_mm) == (site, depth)]
        points = sorted((getattr(row, what), 100 * float(row.most_area_fraction or 0)) for row in of)
        line = "-" if depth == 50 else "--"
        x, y = np.array(points).T
        ax.plot(x, y, line, marker="o", markersize=3.5, color=SITE_COLOURS[site], label=f"{site}, {depth} mm")
    ax.grid(color="0.93")
