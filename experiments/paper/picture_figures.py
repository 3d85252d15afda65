"""Figures 8, 9, 10 and 12: what each number of cameras adds, in the colours of the paper."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from PIL import Image
from scipy.spatial import KDTree

from exact.show import add_polygons
from experiments.files.whole import written_whole
from experiments.paper.cases import CIRCULAR, Case
from experiments.paper.pictures import Picture

COLOURS = {
    2: "gray", 4: "red", 6: "orange", 8: "yellow", 16: "lime", 32: "green", 64: "cyan", 128: "blue", 256: "purple",
    360: "magenta",
}  # fmt: skip
NEVER = "#fbf9f4"
# Little shade, for gray is a colour of the paper: what is never seen must stay lighter than that.
NEVER_SHADE = 0.35
INK = "#202020"
PLACES = (65536, 256, 1)  # of red, green and blue in the number of a colour
PNG_COLOURS = 256  # eleven colours and their shades need no more, and it is less than half as large


@dataclass(frozen=True)
class PictureFigure:
    """A figure of several panels, in rows; `close_up` is (left, right, low, high) of all of them [mm], or None."""

    number: str
    title: str
    rows: tuple[tuple[Case, ...], ...]
    close_up: tuple[float, float, float, float] | None = None

    @property
    def cases(self) -> list[Case]:
        """All panels."""
        return [case for row in self.rows for case in row]


FIGURES = (
    PictureFigure(
        "8", "Circular sites: what each number of equidistant cameras adds",
        tuple(tuple(Case(name, depth, "36x24") for name in CIRCULAR) for depth in (50, 100)),
    ),
    PictureFigure(
        "9", "Close-up of the artery: what each number of equidistant cameras adds",
        ((Case("circ_artery", 50, "36x24"),),), close_up=(-10.5, 10.5, -10.0, 3.0),
    ),
    PictureFigure(
        "10", "Elliptical sites, field of view 36 × 24 mm",
        (tuple(Case("elliptical", depth, "36x24") for depth in (50, 100)),),
    ),
    PictureFigure(
        "12", "Elliptical sites, field of view 60 × 60 mm",
        (tuple(Case("elliptical", depth, "60x60") for depth in (50, 100)),),
    ),
)  # fmt: skip


def write_picture_figure(folder: Path, spec: PictureFigure, pictures: dict[Case, Picture]) -> list[str]:
    """Draw the panels there are pictures of to figure_<number>.png and .pdf; the names of the files."""
    rows = [[case for case in row if case in pictures] for row in spec.rows]
    rows = [row for row in rows if row]
    if not rows:
        return []
    figure = _drawn(spec, rows, pictures)
    names = [f"figure_{spec.number}.png", f"figure_{spec.number}.pdf"]
    for name in names:
        with written_whole(folder / name) as temporary:
            figure.savefig(temporary, metadata={"CreationDate": None} if name.endswith("pdf") else {})
            if name.endswith("png"):
                _with_few_colours(temporary)
    return names


def _with_few_colours(path: Path) -> None:
    """Save a PNG file again with a palette: its most frequent colours, and the legend's however rare they are.

    Palettes made from averages, such as Pillow's, give up the slivers of blue and purple that the legend is for.
    """
    with Image.open(path) as image:
        pixels = np.asarray(image.convert("RGB"), dtype=np.int64)
    codes, where, counts = np.unique(pixels @ np.array(PLACES), return_inverse=True, return_counts=True)
    present = codes[:, None] // np.array(PLACES) % 256
    legend = np.array([np.round(255 * np.array(to_rgb(colour))) for colour in COLOURS.values()])
    frequent = present[np.argsort(-counts, kind="stable")[: PNG_COLOURS - len(legend)]]
    palette = np.concatenate([frequent, legend]).astype(np.uint8)
    nearest = np.asarray(KDTree(palette.astype(float)).query(present)[1]).astype(np.uint8)
    few = Image.fromarray(nearest[where].reshape(pixels.shape[:2]))
    few.putpalette(palette.tobytes())
    few.save(path, optimize=True)


def _drawn(spec: PictureFigure, rows: Sequence[Sequence[Case]], pictures: dict[Case, Picture]) -> Figure:
    n_columns = max(len(row) for row in rows)
    side = {1: 8.5, 2: 6.0}.get(n_columns, 4.2)
    left, right, low, high = spec.close_up or (0.0, 1.0, 0.0, 1.0)
    height = side * (high - low) / (right - left)
    figure = Figure(figsize=(side * n_columns + 0.6, height * len(rows) + 1.9), dpi=110, layout="constrained")
    figure.get_layout_engine().set(h_pad=0.1)  # pyright: ignore[reportOptionalMemberAccess, reportCallIssue]
    axes = figure.subplots(len(rows), n_columns, squeeze=False)
    for ax in axes.flat:
        ax.set_axis_off()
    for row, row_axes in zip(rows, axes, strict=True):
        for case, ax in zip(row, row_axes, strict=False):
            ax.set_axis_on()
            _panel(ax, pictures[case], spec.close_up)
            ax.set_title(f"{case.site}, {case.depth} mm deep", fontsize=13)
    counts = pictures[rows[0][0]].counts
    handles = [Patch(facecolor=COLOURS[n], edgecolor=INK, linewidth=0.5, label=str(n)) for n in counts]
    handles.append(Patch(facecolor=NEVER, edgecolor=INK, linewidth=0.5, label="none of these"))
    figure.legend(
        handles=handles, loc="outside lower center", ncols=len(handles) if n_columns > 2 else 6, fontsize=11,
        title="least number of cameras of which two see it", title_fontsize=11, frameon=False,
    )  # fmt: skip
    figure.suptitle(f"{spec.title}\n(from above, slightly tilted)", fontsize=14)
    return figure


def _panel(ax: Axes, picture: Picture, close_up: tuple[float, float, float, float] | None) -> None:
    # Regions of the same colour are drawn as one; they do not overlap, and the order of the levels stays.
    shade = np.round(255 * picture.shade).astype(int)
    key = (len(picture.counts) - picture.level) * 256 + shade
    _, first, group = np.unique(key, return_index=True, return_inverse=True)
    order = np.argsort(group, kind="stable")
    regions = np.asarray(shapely.multipolygons(picture.polygons[order], indices=group[order]))
    palette = np.array([to_rgb(COLOURS[n]) for n in picture.counts] + [to_rgb(NEVER)])
    never = picture.level[first] == len(picture.counts)
    light = 1 - (1 - picture.shade[first]) * np.where(never, NEVER_SHADE, 1.0)
    add_polygons(ax, regions, palette[picture.level[first]] * light[:, None])
    ax.collections[-1].set_rasterized(False)
    half = picture.half_width
    left, right, low, high = close_up or (-half, half, -half, half)
    ax.set(xlim=(left, right), ylim=(low, high), aspect="equal", xlabel="x at the top surface [mm]")
    ax.set_ylabel("y at the top surface [mm]")
