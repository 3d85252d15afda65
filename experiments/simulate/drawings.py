"""Pictures of a simulated reconstruction: prediction beside measurement, errors on the surface, depth maps."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.ticker import NullFormatter, PercentFormatter

from experiments.figures.palette import BLUE, GREY, ORANGE
from experiments.figures.text import figure_text
from experiments.files.whole import written_whole
from experiments.simulate.compare import TOLERANCE
from experiments.simulate.simulation import Simulated
from experiments.simulate.tables import classes

# Errors that the colours tell apart [mm]; greater ones look like the greatest.
SHOWN_ERROR = 0.3
# Cells along the longer side of a picture from above: as fine as samples are.
CELLS = 130
# Classes that are drawn on a logarithmic scale.
LOGARITHMIC = ("density [px/mm²]", "disparity gradient", "predicted error [mm]")
LINES = (BLUE, ORANGE, "#4a8f3c", GREY)


def write_prediction(path: Path, name: str, found: Sequence[Simulated]) -> None:
    """prediction.png: what came out by incidence, density, disparity gradient and views, and errors as predicted."""
    figure = Figure(figsize=(15.0, 8.2), dpi=110, layout="constrained")
    axes = figure.subplots(2, 3)
    for one, colour in zip(found, LINES, strict=False):
        rows = list(classes(one))
        for ax, by in ((axes[0, 0], "incidence [degrees]"), (axes[0, 1], "density [px/mm²]"),
                       (axes[0, 2], "disparity gradient"), (axes[1, 2], "views")):  # fmt: skip
            _shares(ax, [row for row in rows if row["by"] == by], colour, one.asked.name)
        _errors(axes[1, 0], [row for row in rows if row["by"] == "incidence [degrees]"], colour, one.asked.name)
        _measured_over_predicted(
            axes[1, 1], [row for row in rows if row["by"] == "predicted error [mm]"], colour, one.asked.name
        )
    axes[0, 0].set(xlabel="incidence, second best view [°]", title="what comes out, by incidence")
    axes[0, 1].set(xlabel="pixels to a mm² of surface, second best view", title="… by density of pixels", xscale="log")
    axes[0, 2].set(
        xlabel="disparity gradient [pixels to a pixel]", title="… by how unlike two images are", xscale="log"
    )
    axes[1, 2].set(xlabel="cameras that see it", title="… by number of views")
    axes[1, 0].set(xlabel="incidence, second best view [°]", ylabel="standard deviation along the normal [mm]",
                   title="accuracy: predicted (dotted) and measured", yscale="log")  # fmt: skip
    axes[1, 1].set(xlabel="predicted standard deviation along the normal [mm]", ylabel="measured [mm]",
                   title="measured over predicted", xscale="log", yscale="log")  # fmt: skip
    axes[1, 1].xaxis.set_minor_formatter(NullFormatter())  # less than a decade has no room for more
    low, high = axes[1, 1].get_xlim()
    axes[1, 1].plot([low, high], [low, high], color=GREY, linestyle=":", label="as predicted")
    for ax in axes.flat:
        ax.grid(color="0.9")
        ax.spines[["top", "right"]].set_visible(False)
        ax.legend(frameon=False, fontsize=9)
    figure.suptitle(figure_text(f"{name}: prediction and simulated reconstruction"))
    with written_whole(path) as temporary:
        figure.savefig(temporary)


def _middles(rows: Sequence[dict]) -> list[float]:
    return [row["from"] if row["by"] == "views" else np.sqrt(max(row["from"], row["to"] / 4) * row["to"])
            if row["by"] in LOGARITHMIC else (row["from"] + row["to"]) / 2 for row in rows]  # fmt: skip


def _shares(ax: Axes, rows: Sequence[dict], colour: str, name: str) -> None:
    for tolerance, style in ((0.1, ":"), (TOLERANCE, "-")):
        label = f"{name}, within {tolerance:g} mm"
        ax.plot(_middles(rows), [row[f"within_{tolerance:g}_mm"] for row in rows], style, marker="o", ms=3,
                color=colour, label=label)  # fmt: skip
    ax.set(ylim=(-0.02, 1.02), ylabel="share of the area that is seen")
    ax.yaxis.set_major_formatter(PercentFormatter(1.0))


def _errors(ax: Axes, rows: Sequence[dict], colour: str, name: str) -> None:
    for key, style, label in (("normal_std_mm", "-", name), ("predicted_normal_std_mm", ":", None)):
        values = [np.nan if row[key] is None else row[key] for row in rows]
        ax.plot(_middles(rows), values, style, marker="o", ms=3, color=colour, label=label)


def _measured_over_predicted(ax: Axes, rows: Sequence[dict], colour: str, name: str) -> None:
    both = [(row["predicted_normal_std_mm"], row["normal_std_mm"]) for row in rows]
    shown = np.array([pair for pair in both if None not in pair], dtype=np.float64).reshape(-1, 2)
    ax.plot(*shown.T, "o-", ms=4, color=colour, label=name)


def write_errors(path: Path, name: str, found: Sequence[Simulated]) -> None:
    """errors.png: the surface from above, what is predicted to count and how far off it came out, layout by layout."""
    figure = Figure(figsize=(11.5, 0.6 + 5.0 * len(found)), dpi=130, layout="constrained")
    axes = figure.subplots(len(found), 2, squeeze=False)
    shown: AxesImage | None = None
    for row, one in zip(axes, found, strict=True):
        samples, demand = one.comparison.samples, one.asked.demand
        frame = _across(np.asarray(one.asked.ring.axis, dtype=np.float64), one.asked.ring.zero_towards)
        place = (samples.points - np.asarray(one.asked.ring.focus)) @ frame.T
        counted = samples.within(demand.limits, demand, demand.max_error, demand.optics.match_noise)
        if demand.max_disparity_gradient is not None:
            counted &= one.gradient <= demand.max_disparity_gradient
        _from_above(row[0], place, counted, cmap=ListedColormap([ORANGE, BLUE]), vmin=0, vmax=1)
        title = f"{one.asked.name}: predicted to count (blue), {one.predicted.area:.0f} mm², or not"
        row[0].set_title(figure_text(title))
        distance = np.minimum(one.comparison.distance, SHOWN_ERROR)
        shown = _from_above(row[1], place, distance, cmap="magma_r", vmin=0.0, vmax=SHOWN_ERROR)
        row[1].set_title(figure_text(f"measured within {TOLERANCE:g} mm: {one.comparison.area():.0f} mm²"))
    if shown is not None:
        figure.colorbar(shown, ax=axes[:, 1], label=f"to the nearest reconstructed point [mm], at most {SHOWN_ERROR:g}")
    figure.suptitle(figure_text(f"{name}, from the ring"))
    with written_whole(path) as temporary:
        figure.savefig(temporary)


def _from_above(ax: Axes, place: np.ndarray, values: np.ndarray, **how: Any) -> AxesImage:
    """Draw values at places (N, 3) [mm] into cells, in each the one that lies nearest to the ring."""
    low, high = place[:, :2].min(axis=0), place[:, :2].max(axis=0)
    cell = float((high - low).max()) / CELLS
    column, row = ((place[:, :2] - low) / cell).astype(np.int64).T
    picture = np.full((row.max() + 1, column.max() + 1), np.nan)
    order = np.argsort(place[:, 2])
    picture[row[order], column[order]] = values[order]
    ax.set(xlabel="[mm]", ylabel="[mm]")
    extent = (low[0], low[0] + cell * picture.shape[1], low[1], low[1] + cell * picture.shape[0])
    return ax.imshow(picture, origin="lower", extent=extent, interpolation="nearest", **how)


def _across(axis: np.ndarray, zero_towards: tuple[float, float, float] | None) -> np.ndarray:
    """(3, 3) rows: where ring angle 0 lies, where 90° does, and the axis."""
    axis = axis / np.linalg.norm(axis)
    towards = np.array((1.0, 0.0, 0.0) if zero_towards is None else zero_towards)
    if abs(towards @ axis) > 0.9 * np.linalg.norm(towards):
        towards = np.array((0.0, 1.0, 0.0))
    x = towards - (towards @ axis) * axis
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(axis, x), axis])


def write_depths(path: Path, found: Simulated) -> None:
    """depths.png: each camera's image of depths as they were found, and how far off they are."""
    n = len(found.depths)
    finite = np.concatenate([one.depth[np.isfinite(one.depth)] for one in found.truths])
    low, high = np.quantile(finite, [0.001, 0.999])
    height, width = found.depths[0].shape
    figure = Figure(figsize=(10.0, 0.8 + n * 4.6 * height / width), dpi=110, layout="constrained")
    axes = figure.subplots(n, 2, squeeze=False)
    maps = [None, None]
    for row, one, depth, truth in zip(axes, found.asked.cameras, found.depths, found.truths, strict=True):
        maps[0] = row[0].imshow(depth, cmap="viridis_r", vmin=low, vmax=high, interpolation="nearest")
        maps[1] = row[1].imshow(
            depth - truth.depth, cmap="RdBu", vmin=-SHOWN_ERROR, vmax=SHOWN_ERROR, interpolation="nearest"
        )
        row[0].set_title(f"{one.name}: depth found", fontsize=10)
        row[1].set_title("found less true", fontsize=10)
        for ax in row:
            ax.set(xticks=[], yticks=[], facecolor="0.8")
    for column, (one, label) in enumerate(zip(maps, ("depth [mm]", "error of depth [mm]"), strict=True)):
        if one is not None:
            figure.colorbar(one, ax=axes[:, column], label=label, orientation="horizontal", shrink=0.8, aspect=40)
    figure.suptitle(figure_text(f"{found.asked.name}: depth maps (grey: no match)"))
    with written_whole(path) as temporary:
        figure.savefig(temporary)


def write_cloud(path: Path, found: Simulated) -> None:
    """reconstruction.ply: reconstructed points coloured by how far they are from the surface."""
    error = found.comparison.error
    shade = np.clip(np.abs(error) / SHOWN_ERROR, 0.0, 1.0)
    colours = np.round(255 * colormaps["magma_r"](shade)).astype(np.uint8)
    with written_whole(path) as temporary:
        trimesh.PointCloud(found.comparison.points, colours).export(temporary)
