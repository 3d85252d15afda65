"""Fig. 11: reconstructable area over the number of cameras with the fitted decays, and what the fits leave."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator, ScalarFormatter

from experiments.files.whole import written_whole
from experiments.paper.areas import Area, curve
from experiments.paper.cases import Case
from experiments.paper.fits import FitRow, chosen_fit, fitted

SITE_COLOURS = {
    "circ_flat": "#0072b2", "circ_angled": "#d55e00", "circ_artery": "#009e73", "circ_overhang": "#7b3fa0",
    "elliptical": "#444444",
}  # fmt: skip
# 50 mm, 100 mm; the wide field of view has open markers.
DEPTH_STYLES = {50: ("-", "o"), 100: ("--", "s")}
PANELS = {False: "without the top surface", True: "with the top surface"}
POINTS_OF_CURVE = 400


def write_curve_figures(
    folder: Path, areas: Sequence[Area], fits: Sequence[FitRow], cases: Sequence[Case]
) -> list[str]:
    """Draw figure_11 and, where there are fits, figure_11_residuals, as PNG and PDF; the names of the files."""
    figures = {"figure_11": _curves(areas, fits, cases)}
    if fits:
        figures["figure_11_residuals"] = _residuals(areas, fits, cases)
    names = []
    for stem, figure in figures.items():
        for ending in ("png", "pdf"):
            names.append(f"{stem}.{ending}")
            with written_whole(folder / names[-1]) as temporary:
                figure.savefig(temporary, metadata={"CreationDate": None} if ending == "pdf" else {})
    return names


def _curves(areas: Sequence[Area], fits: Sequence[FitRow], cases: Sequence[Case]) -> Figure:
    figure, axes = _panels(areas, cases)
    for ax, included in zip(axes, PANELS, strict=True):
        for case in cases:
            n, area = curve(areas, case, included)
            colour, line, marker, face = _style(case)
            fit = chosen_fit(fits, case, included)
            if fit is not None:
                fine = np.geomspace(n.min(), n.max(), POINTS_OF_CURVE)
                ax.plot(fine, fitted(fit, fine), color=colour, linestyle=line, linewidth=1.2)
            ax.plot(n, area, linestyle="none", color=colour, marker=marker, mfc=face, ms=5.5)
        ax.set_ylabel("reconstructable area [mm²]")
        ax.set_ylim(bottom=0)
    lines = "; lines: fitted decays" if fits else ""
    figure.suptitle(f"Area that equidistant cameras reconstruct (points{lines})", fontsize=14)
    _legend(figure, cases)
    return figure


def _residuals(areas: Sequence[Area], fits: Sequence[FitRow], cases: Sequence[Case]) -> Figure:
    figure, axes = _panels(areas, cases)
    for ax, included in zip(axes, PANELS, strict=True):
        ax.axhline(0, color="0.6", linewidth=1)
        for case in cases:
            fit = chosen_fit(fits, case, included)
            if fit is None:
                continue
            n, area = curve(areas, case, included)
            colour, line, marker, face = _style(case)
            left = 100 * (area - fitted(fit, n)) / fit.plateau
            ax.plot(n, left, linestyle=line, linewidth=0.8, color=colour, marker=marker, mfc=face, ms=5)
        ax.set_ylabel("area less fitted area [% of the plateau]")
    figure.suptitle("What the fitted decays leave", fontsize=14)
    _legend(figure, cases)
    return figure


def _panels(areas: Sequence[Area], cases: Sequence[Case]) -> tuple[Figure, Sequence[Axes]]:
    figure = Figure(figsize=(13.0, 7.4), dpi=100, layout="constrained")
    axes = figure.subplots(1, 2)
    counts = sorted({area.n_cameras for area in areas})
    for ax, title in zip(axes, PANELS.values(), strict=True):
        ax.set_xscale("log")
        ax.xaxis.set_major_locator(FixedLocator([n for n in counts if n != 6]))
        ax.xaxis.set_minor_locator(NullLocator())
        ax.xaxis.set_major_formatter(ScalarFormatter())
        ax.set_xlabel("number of cameras n")
        ax.set_title(title, fontsize=12)
        ax.spines[["top", "right"]].set_visible(False)
        ax.grid(axis="y", color="0.9")
    return figure, axes


def _style(case: Case) -> tuple[str, str, str, str]:
    """Colour, line, marker and the marker's inside."""
    line, marker = DEPTH_STYLES[case.depth]
    colour = SITE_COLOURS[case.site]
    return colour, line, marker, colour if case.fov == "36x24" else "white"


def _legend(figure: Figure, cases: Sequence[Case]) -> None:
    handles = []
    for case in sorted(cases, key=lambda case: (list(SITE_COLOURS).index(case.site), case.fov, case.depth)):
        colour, line, marker, face = _style(case)
        handle = figure.axes[0].plot([], [], color=colour, linestyle=line, marker=marker, mfc=face, label=case.title)
        handles += handle
    figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=10, frameon=False)
