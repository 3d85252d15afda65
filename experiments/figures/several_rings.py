"""several_rings.png: what the best ring alone and all rings together see, and the cameras from above."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

import exact
from experiments.figures.coverage import add_legend, add_surfaces
from experiments.figures.palette import BLUE, ORANGE
from experiments.figures.text import figure_text
from experiments.files.whole import written_whole
from experiments.tables.several_rings import LayoutOnRings

COLOURS = (BLUE, ORANGE, "#2a9d3f", "#b5179e")


def write_several_rings(
    path: Path,
    name: str,
    scene: exact.Scene,
    rings: Sequence[exact.Ring],
    layouts: Sequence[LayoutOnRings],
    demand: exact.Demand,
) -> None:
    """Draw layouts side by side to a PNG file, the last of them from above too.

    Parameters
    ----------
    path : pathlib.Path
    name : str
        Of the site.
    scene : exact.Scene
    rings : (K,) sequence of exact.Ring
    layouts : sequence of LayoutOnRings
    demand : exact.Demand
    """
    figure = Figure(figsize=(5.0 * len(layouts) + 5.2, 6.7), dpi=150, layout="constrained")
    axes = figure.subplots(1, len(layouts) + 1, width_ratios=[5.0] * len(layouts) + [4.6])
    titled = [(f"{one.name}\n{100 * one.fraction:.2f} % of what all rings see", one.cameras(rings)) for one in layouts]
    handles = add_surfaces(axes[:-1], scene, rings[0], titled, demand)
    _from_above(axes[-1], rings, layouts[-1].ring_of, layouts[-1].angles)
    figure.suptitle(figure_text(f"{name}: one ring alone, and all rings together"), fontsize=14)
    add_legend(figure, handles, demand)
    with written_whole(path) as temporary:
        figure.savefig(temporary)


def _from_above(ax: Axes, rings: Sequence[exact.Ring], ring_of: Sequence[int], angles: Sequence[float]) -> None:
    """Rings and cameras as they lie across the axis of the first ring."""
    frame, focus = rings[0].frame, np.array(rings[0].focus)
    reach = 0.0
    for k, ring in enumerate(rings):
        colour = COLOURS[k % len(COLOURS)]
        around = (ring.positions(np.linspace(0, 2 * np.pi, 97)) - focus) @ frame
        reach = max(reach, float(np.abs(around[:, :2]).max()))
        ax.plot(around[:, 0], around[:, 1], color=colour, linewidth=1.2)
        own = [angle for of, angle in zip(ring_of, angles, strict=True) if of == k]
        label = f"ring {k + 1}: {ring.diameter:g} x {ring.working_distance:g} mm, {len(own)} of {len(angles)} cameras"
        at = (ring.positions(own) - focus) @ frame if own else np.zeros((0, 3))
        ax.plot(at[:, 0], at[:, 1], linestyle="none", marker="s", ms=9, color=colour, label=label)
        for angle, (x, y, _) in zip(own, at, strict=True):
            words = f"{np.degrees(angle) % 360:.1f}°"
            ax.annotate(words, (x, y), (7, 7), textcoords="offset points", fontsize=10, color=colour)
    ax.add_patch(Circle((0, 0), 0.01 * reach, color="black"))
    limit = 1.35 * reach
    # Above the rings there is room for what is which.
    top = limit + 0.2 * reach * len(rings)
    ax.set(xlim=(-limit, limit), ylim=(-limit, top), aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
    ax.set_title("cameras of the layout on all rings\n(from above)", fontsize=12)
    ax.legend(loc="upper left", frameon=False, fontsize=10)
    ax.spines[["top", "right"]].set_visible(False)
