"""count.png: what cameras of each number reconstruct, well placed and equidistant, and what none could exceed."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, PercentFormatter

import placement
from experiments.figures.palette import BLUE, GREY, ORANGE
from experiments.figures.text import figure_text
from experiments.files.whole import written_whole


def write_count(path: Path, name: str, of: str, found: placement.Recommendation) -> None:
    """Draw the curves over the number of cameras to a PNG file.

    Parameters
    ----------
    path : pathlib.Path
    name : str
        Of the mesh or meshes, for the heading.
    of : str
        What a fraction is a fraction of.
    found : placement.Recommendation
    """
    figure = Figure(figsize=(8.4, 5.6), dpi=150, layout="constrained")
    ax = figure.subplots()
    counts = found.counts
    numbers = [counted.n_cameras for counted in counts]
    placed = [counted.placement for counted in counts]
    bounds = [np.nan if p is None or p.certificate is None else p.certificate.bound_fraction for p in placed]
    if np.isfinite(bounds).any():
        ax.plot(numbers, bounds, "v:", color=ORANGE, ms=6, label="no layout exceeds this (certificate, on samples)")
    fractions = [np.nan if counted.fraction is None else counted.fraction for counted in counts]
    ax.plot(numbers, fractions, "s-", color=BLUE, ms=6, label="optimised (exact area)")
    best_phase = [counted.best_equidistant_fraction for counted in counts]
    ax.plot(numbers, best_phase, "o--", color=GREY, mfc="white", ms=6, label="equidistant, best phase (exact area)")
    even = [counted.equidistant_fraction for counted in counts]
    ax.plot(numbers, even, "o-", color=GREY, ms=6, label="equidistant (exact area)")
    ax.axhline(found.target, color="black", linewidth=1.2, linestyle=(0, (6, 3)))
    ax.annotate(
        f"target {100 * found.target:g} %", (0, found.target), xycoords=("axes fraction", "data"), xytext=(6, 4),
        textcoords="offset points", ha="left", va="bottom",
    )  # fmt: skip
    for number, values, colour, below in (
        (found.n_cameras, fractions, BLUE, False), (found.n_equidistant, even, GREY, True),
    ):  # fmt: skip
        if number is not None:
            ax.annotate(
                f"{number} camera{'' if number == 1 else 's'}", (number, values[numbers.index(number)]),
                xytext=(0, -26 if below else 18), textcoords="offset points", ha="center", color=colour,
                arrowprops=dict(arrowstyle="-", color=colour),
            )  # fmt: skip
    lowest = min(even + best_phase)
    ax.set(
        xlabel="number of cameras on the ring", ylabel=f"reconstructable area, part of\n{of}",
        xlim=(numbers[0] - 0.5, numbers[-1] + 0.5), ylim=(max(0.0, lowest - 0.08 * (1 - lowest) - 0.01), 1.02),
    )  # fmt: skip
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.yaxis.set_major_formatter(PercentFormatter(1.0, symbol=" %"))
    ax.grid(color="0.9")
    ax.spines[["top", "right"]].set_visible(False)
    ax.set_title(figure_text(f"{name}: how many cameras?"))
    ax.legend(loc="lower right", frameon=True, framealpha=0.9, edgecolor="none")
    with written_whole(path) as temporary:
        figure.savefig(temporary)
