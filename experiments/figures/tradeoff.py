"""tradeoff.png: area over error, of searched layouts, equidistant rings and opposite pairs."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, PercentFormatter, ScalarFormatter

import placement
from experiments.figures.palette import BLUE, GREY, ORANGE
from experiments.figures.text import figure_text
from experiments.files.whole import written_whole


def write_tradeoff(path: Path, name: str, of: str, found: placement.TradeOff) -> None:
    """Draw the trade-off to a PNG file.

    Parameters
    ----------
    path : pathlib.Path
    name : str
        Of the mesh or meshes and cameras, for the heading.
    of : str
        What a fraction is a fraction of.
    found : placement.TradeOff
    """
    figure = Figure(figsize=(8.4, 5.6), dpi=150, layout="constrained")
    ax = figure.subplots()

    def points(layouts) -> np.ndarray:
        return np.array([(layout.error_rms, layout.fraction) for layout in layouts]).reshape(-1, 2)

    if found.bound_fraction is not None:
        ax.axhline(
            found.bound_fraction, color=ORANGE, linestyle=":", label="no layout exceeds this (certificate, on samples)"
        )
    ax.plot(*points(found.layouts).T, "s-", color=BLUE, ms=6, label="none has both more area and less error")
    for kind, mark in (("equidistant", "o"), ("opposite pairs", "^")):
        of_kind = [layout for layout in found.compared if layout.kind == kind and np.isfinite(layout.error_rms)]
        if of_kind:
            label = f"{kind}, several phases" if kind == "equidistant" else kind
            ax.plot(*points(of_kind).T, mark, color=GREY, mfc="white", ms=7, label=label)
    knee = found.knee
    ax.annotate(
        f"knee: {100 * knee.fraction:.2f} %, {knee.error_rms:.3f} mm", (knee.error_rms, knee.fraction),
        xytext=(28, -34), textcoords="offset points", color=BLUE, arrowprops=dict(arrowstyle="-", color=BLUE),
    )  # fmt: skip
    shown = points([*found.layouts, *(one for one in found.compared if np.isfinite(one.error_rms))])
    # Far below, opposite pairs would flatten the rest.
    lowest = min(layout.fraction for layout in (*found.layouts, *found.compared) if layout.kind != "opposite pairs")
    highest = max(float(shown[:, 1].max()), found.bound_fraction or 0.0)
    room = 0.06 * (highest - lowest) + 0.002
    ax.set(
        xscale="log", xlabel="RMS of the predicted depth error [mm]", ylabel=f"reconstructable area, part of\n{of}",
        xlim=(0.94 * shown[:, 0].min(), 1.08 * shown[:, 0].max()), ylim=(max(0.0, lowest - room), highest + room),
    )  # fmt: skip
    ax.xaxis.set_major_locator(LogLocator(subs=(1, 1.5, 2, 3, 5, 7)))
    ax.xaxis.set_major_formatter(ScalarFormatter())
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.yaxis.set_major_formatter(PercentFormatter(1.0, symbol=" %"))
    ax.grid(color="0.9")
    ax.spines[["top", "right"]].set_visible(False)
    ax.set_title(figure_text(f"{name}: what accuracy costs"))
    ax.legend(loc="lower right", frameon=True, framealpha=0.9, edgecolor="none")
    with written_whole(path) as temporary:
        figure.savefig(temporary)
