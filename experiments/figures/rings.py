"""rings.png: area and error over diameter and working distance of the ring, and one over the other."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from experiments.figures.palette import BLUE, GREY, ORANGE
from experiments.figures.text import figure_text
from experiments.files.whole import written_whole

# Darker than this a cell takes white words.
DARK = 0.55
# Room for the words of a cell [inches].
CELL_WIDTH, CELL_HEIGHT = 0.86, 0.62

Row = dict[str, Any]


def write_rings(path: Path, heading: str, rows: Sequence[Row]) -> None:
    """Draw the table of rings (`experiments.tables.rings`) to a PNG file.

    Parameters
    ----------
    path : pathlib.Path
    heading : str
    rows : sequence of dict
        At least one ring with a layout.
    """
    views = list(dict.fromkeys((row["fov_width_mm"], row["fov_height_mm"]) for row in rows))
    across, up = (sorted({row[name] for row in rows}) for name in ("diameter_mm", "working_distance_mm"))
    wide, high = max(3.0, 1.2 + CELL_WIDTH * len(across)), max(2.4, 1.3 + CELL_HEIGHT * len(up))
    has_errors = any(row["rms_error_mm"] is not None for row in rows)
    figure = Figure(
        figsize=((1 + has_errors) * wide + 5.4 * has_errors, max(high * len(views), 4.4) + 0.9), dpi=130,
        layout="constrained",
    )  # fmt: skip
    maps = figure.add_gridspec(
        len(views), 1 + 2 * has_errors, width_ratios=[wide] * (1 + has_errors) + [5.4] * has_errors
    )
    for number, view in enumerate(views):
        of_view = [row for row in rows if (row["fov_width_mm"], row["fov_height_mm"]) == view]
        told = f"\nfield of view {view[0]:g} x {view[1]:g} mm" if len(views) > 1 else ""
        _map(
            figure.add_subplot(maps[number, 0]), of_view, rows, (across, up), "area_mm2", "viridis",
            f"area reconstructed [mm²]{told}\nbelow: of that ring's own maximum", _area_words,
        )  # fmt: skip
        if has_errors:
            _map(
                figure.add_subplot(maps[number, 1]), of_view, rows, (across, up), "rms_error_mm", "magma_r",
                f"RMS of the predicted errors [mm]{told}\nbelow: smallest separation of cameras [mm]", _error_words,
            )  # fmt: skip
    if has_errors:
        _area_over_error(figure.add_subplot(maps[:, 2]), rows, len(views) > 1)
    words = "black frame: no other ring has both more area and less error" if has_errors else "black frame: most area"
    figure.suptitle(figure_text(f"{heading}\n{words}"), fontsize=13)
    with written_whole(path) as temporary:
        figure.savefig(temporary)


def _area_words(row: Row) -> str:
    return f"{row['area_mm2']:.0f}\n{100 * row['fraction_of_ring_maximum']:.1f} %"


def _error_words(row: Row) -> str:
    separation = row["smallest_separation_mm"]
    return f"{row['rms_error_mm']:.3g}" + ("" if separation is None else f"\n{separation:.1f}")


def _map(
    ax: Axes, of_view: Sequence[Row], rows: Sequence[Row], axes: tuple[list[float], list[float]], name: str,
    colours: str, title: str, words: Callable[[Row], str],
) -> None:  # fmt: skip
    """One cell a ring, coloured alike in all maps of a kind."""
    across, up = axes
    every = [row[name] for row in rows if row[name] is not None]
    scale = Normalize(min(every), max(every) if max(every) > min(every) else min(every) + 1.0)
    values = np.full((len(up), len(across)), np.nan)
    shown = ax.imshow(values, cmap=colours, norm=scale, origin="lower", aspect="auto")
    for row in of_view:
        x, y = across.index(row["diameter_mm"]), up.index(row["working_distance_mm"])
        if row[name] is None:
            ax.add_patch(Rectangle((x - 0.5, y - 0.5), 1, 1, facecolor="0.93", edgecolor="0.7", hatch="//"))
            ax.text(x, y, "none", ha="center", va="center", fontsize=8, color="0.3")
            continue
        values[y, x] = row[name]
        red, green, blue, _ = shown.cmap(scale(row[name]))
        is_dark = 0.3 * red + 0.59 * green + 0.11 * blue < DARK
        ax.text(x, y, words(row), ha="center", va="center", fontsize=8.5, color="white" if is_dark else "black")
        if row["undominated"]:
            ax.add_patch(Rectangle((x - 0.47, y - 0.47), 0.94, 0.94, fill=False, edgecolor="black", linewidth=2.2))
    shown.set_data(values)
    ax.set_xticks(range(len(across)), [f"{one:g}" for one in across])
    ax.set_yticks(range(len(up)), [f"{one:g}" for one in up])
    ax.set(xlabel="ring diameter [mm]", ylabel="working distance [mm]")
    ax.set_title(title, fontsize=10)


def _area_over_error(ax: Axes, rows: Sequence[Row], several_views: bool) -> None:
    known = [row for row in rows if row["rms_error_mm"] is not None]
    best = sorted((row for row in known if row["undominated"]), key=lambda row: row["rms_error_mm"])
    even = [row for row in known if row["equidistant_rms_error_mm"] is not None]
    ax.plot(
        [row["equidistant_rms_error_mm"] for row in even], [row["equidistant_area_mm2"] for row in even], "o",
        color=GREY, mfc="white", ms=5, label="equidistant, best phase",
    )  # fmt: skip
    others = [row for row in known if not row["undominated"]]
    ax.plot(
        [row["rms_error_mm"] for row in others], [row["area_mm2"] for row in others], "s", color=BLUE, ms=5,
        alpha=0.55, label="proposed layout",
    )  # fmt: skip
    ax.plot(
        [row["rms_error_mm"] for row in best], [row["area_mm2"] for row in best], "s-", color=ORANGE, ms=7,
        label="proposed; no other ring has both\nmore area and less error",
    )  # fmt: skip
    for number, row in enumerate(best):
        view = f", {row['fov_width_mm']:g} x {row['fov_height_mm']:g}" if several_views else ""
        ax.annotate(
            f"{row['diameter_mm']:g} at {row['working_distance_mm']:g}{view}",
            (row["rms_error_mm"], row["area_mm2"]), xytext=(-8, 6 if number % 2 else -6), textcoords="offset points",
            fontsize=8, color=ORANGE, ha="right", va="center",
        )  # fmt: skip
    ax.margins(x=0.2, y=0.1)
    ax.set(xlabel="RMS of the predicted errors [mm]", ylabel="area reconstructed [mm²]")
    ax.set_title("area over error; written beside: diameter at working distance [mm]", fontsize=10)
    ax.grid(color="0.9")
    ax.spines[["top", "right"]].set_visible(False)
    ax.legend(loc="lower right", fontsize=8.5, frameon=True, framealpha=0.9, edgecolor="none")
