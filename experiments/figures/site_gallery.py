"""sites.png: a contact sheet of the built-in reference sites, cut open along a vertical plane through the axis."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely
import trimesh
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from PIL import Image

import exact
import meshes
from exact.show import add_polygons
from experiments.files.whole import written_whole
from experiments.terminal.progress import progress_bar
from meshes.anatomy import air, arteries
from meshes.sites import PAPER_DEPTHS

CUT_COLOUR = "#d98f7a"
LINING_COLOUR = "#f4dcc6"
TUBE_COLOUR = "#b3282d"
OUTSIDE_COLOUR = "#a9b7ba"
# Seen from this far above the horizon and beside the normal of the cut: the floor shows, and so does the profile.
ELEVATION, ASIDE = np.radians(30.0), np.radians(14.0)
DISTANCE = 1000.0  # of the display camera [mm]: many times a site's size, so that lengths hardly change with depth
# The half that stays lies towards +y, so that the cut shows the x axis, unless the other way shows more.
KEPT = {"circ_overhang": (1.0, 0.0, 0.0), "cerebellopontine": (1.0, 0.0, 0.0)}
# The cut misses the axis by this [mm]: corners of a channel lie in the plane itself, where a cut leaves open edges.
BESIDE_AXIS = 1e-3
# A tube's skin this far above the bed [mm] has the full colour of a tube: the width of the fillet between them.
TUBE_RISE = 0.7
GAP, HEADING = 12.0, 24.0  # between sites, and above each for its text [mm on the sheet]
MM_PER_INCH = 28.0  # of the sheet: a site 60 mm wide is about 300 pixels wide
NARROWEST = 210.0  # sheet that has room for its own legend, in two columns [mm]
BORDER = 3.0  # from the block's left side to the line that shows the depth [mm]
COLOURS = 256  # of the file: four hues and their shades need no more, and it is less than half as large
INK = "#202020"


@dataclass(frozen=True, eq=False)
class CutSite:
    """A site, cut open and seen from the cut: what to fill with which colour, and where things are.

    Attributes
    ----------
    name, depth : str, float
    block : (3,) ndarray
        Extents of the block of tissue [mm].
    n_faces : int
        Of the whole site, before the cut.
    polygons : (N,) ndarray of object
        Visible parts of its faces in the plane through `camera`'s target, y down [mm].
    fill : (N, 3) ndarray
        Their colours.
    camera : exact.Camera
    right : (3,) ndarray
        Horizontal direction within the cut, to the right of the picture.
    """

    name: str
    depth: float
    block: np.ndarray
    n_faces: int
    polygons: np.ndarray
    fill: np.ndarray
    camera: exact.Camera
    right: np.ndarray

    def on_cut(self, across, height) -> np.ndarray:
        """(N, 2) place in the picture, y up, of points of the cut `across` from the axis at a `height` [mm]."""
        points = np.multiply.outer(np.asarray(across, dtype=float), self.right)
        points[..., 2] = height
        return _in_picture(self.camera, points)


def gallery_rows() -> list[list[tuple[str, float]]]:
    """Name and depth of the sites to show: those of Wachter 2021 at each depth, then the others at their first.

    Examples
    --------
    >>> [len(row) for row in gallery_rows()]
    [5, 5, 4]
    """
    paper = [site.name for site in meshes.SITES.values() if site.depths == PAPER_DEPTHS]
    others = [(site.name, site.depths[0]) for site in meshes.SITES.values() if site.name not in paper]
    return [*([(name, depth) for name in paper] for depth in PAPER_DEPTHS), others]


def write_gallery(path: Path, rows: Sequence[Sequence[tuple[str, float]]], detail: str = "middle") -> None:
    """Draw rows of sites, each a name and a depth [mm], all at one scale, to a PNG file.

    Raises
    ------
    meshes.MeshError
        If there is no such site, depth or detail.
    """
    with progress_bar("cutting sites open", sum(len(row) for row in rows)) as advance:
        cut = []
        for row in rows:
            cut.append([])
            for name, depth in row:
                cut[-1].append(cut_open(name, depth, detail))
                advance(1)
    figure = _sheet(cut)
    with written_whole(path) as temporary:
        figure.savefig(temporary)
        with Image.open(temporary) as picture:
            few_colours = picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
        few_colours.save(temporary, optimize=True)


def cut_open(name: str, depth: float, detail: str = "middle") -> CutSite:
    """Half of a site, and what of it a camera sees that looks at the cut obliquely from above."""
    mesh = meshes.site(name, depth, detail)
    kept, up = np.array(KEPT.get(name, (0.0, 1.0, 0.0))), np.array([0.0, 0.0, 1.0])
    half = mesh.slice_plane(BESIDE_AXIS * kept, kept, cap=True)
    right = np.cross(kept, up)
    towards = np.cos(ELEVATION) * (np.sin(ASIDE) * right - np.cos(ASIDE) * kept) + np.sin(ELEVATION) * up
    target = 0.5 * (depth + mesh.bounds[0, 2]) * up
    size = 3 * float(mesh.extents.max())
    camera = exact.Camera.look_at(target + DISTANCE * towards, target, up, fov=(size, size))
    seen = exact.view(half, camera)
    shown = np.flatnonzero(seen.face_areas > 0)
    # The lamp stands to the upper left of the camera, so that the profile of the channel throws light and shade.
    lamp = towards - 0.7 * right + 0.35 * up
    cosine = np.clip(half.face_normals[shown] @ (lamp / np.linalg.norm(lamp)), 0, 1)
    light = 0.5 + 0.55 * cosine
    fill = np.clip(_colours(name, depth, half, kept)[shown] * light[:, None], 0, 1)
    return CutSite(name, depth, mesh.extents, len(mesh.faces), seen.polygons[shown], fill, camera, right)


def _colours(name: str, depth: float, half: trimesh.Trimesh, kept: np.ndarray) -> np.ndarray:
    """(F, 3) colour of each face: cut tissue, lining of the channel, vessels and nerves, outside of the block."""
    site = meshes.SITES[name]
    opening = site.openings[site.depths.index(depth)]
    # How far the surface stands out of what would be there without tubes: of the bed below the anatomy's top, of
    # the plain wall above it.
    vertices, centre = np.asarray(half.vertices), half.triangles_center
    bed = air(replace(site.anatomy, vessels=(), arteries=()), opening, vertices)[half.faces].mean(axis=1)
    # The plain wall's faces are long, with corners where an artery ends: it counts where their middle is.
    artery = np.where(np.abs(arteries(site.anatomy, centre)) < TUBE_RISE, TUBE_RISE, 0.0)
    rise = np.where(centre[:, 2] < site.anatomy.top, bed, artery)
    share = np.clip(rise / TUBE_RISE, 0, 1)[:, None]
    colours = (1 - share) * to_rgb(LINING_COLOUR) + share * to_rgb(TUBE_COLOUR)
    outside = np.abs(centre[:, :2]).max(axis=1) > 0.5 * site.block - 1e-6
    outside |= (half.face_normals[:, 2] > 0.999) & (centre[:, 2] > depth - 1e-6)
    colours[outside] = to_rgb(OUTSIDE_COLOUR)
    colours[np.abs(centre @ kept - BESIDE_AXIS) < 1e-6] = to_rgb(CUT_COLOUR)
    return colours


def _sheet(rows: Sequence[Sequence[CutSite]]) -> Figure:
    boxes = [[_box(cut) for cut in row] for row in rows]
    width = max(sum(box[1, 0] - box[0, 0] + GAP for box in row) for row in boxes) + GAP
    width = max(float(width), NARROWEST)
    heights = [max(box[1, 1] - box[0, 1] for box in row) + HEADING + GAP for row in boxes]
    head, foot = 22.0, 16.0
    total = head + sum(heights) + foot
    figure = Figure(figsize=(width / MM_PER_INCH, total / MM_PER_INCH), dpi=140)
    ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    ax.set(xlim=(0, width), ylim=(0, total), aspect="equal")
    ax.axis("off")
    ax.text(0.5 * width, total - 9.0, "Reference sites, cut open", fontsize=18, ha="center", va="center", color=INK)
    ax.text(
        0.5 * width, total - 17.0, "along the axis of the channel; all at one scale, lengths in mm",
        fontsize=13, ha="center", va="center", color=INK,
    )  # fmt: skip
    low = total - head
    for row, row_boxes, height in zip(rows, boxes, heights, strict=True):
        low -= height
        taken = sum(box[1, 0] - box[0, 0] for box in row_boxes)
        space = (width - taken) / (len(row) + 1)
        left = space
        for cut, box in zip(row, row_boxes, strict=True):
            _draw(ax, cut, box, np.array([left, low + 0.5 * GAP]) - box[0])
            left += box[1, 0] - box[0, 0] + space
    labels = {
        CUT_COLOUR: "cut tissue", LINING_COLOUR: "wall and floor of the channel",
        TUBE_COLOUR: "vessels and nerves", OUTSIDE_COLOUR: "top surface and sides of the block",
    }  # fmt: skip
    handles = [Patch(facecolor=c, edgecolor=INK, linewidth=0.5, label=label) for c, label in labels.items()]
    ax.legend(handles=handles, loc="lower center", ncols=2 if width < 2 * NARROWEST else 4, fontsize=13, frameon=False)
    return figure


def _draw(ax: Axes, cut: CutSite, box: np.ndarray, shift: np.ndarray) -> None:
    """One site at its place on the sheet, with its dimensions."""
    site = meshes.SITES[cut.name]
    opening = site.openings[site.depths.index(cut.depth)]
    add_polygons(ax, cut.polygons, cut.fill, shift)
    half_width = float(np.abs(np.array(opening.half_axes) @ cut.right[:2]))
    beside = BORDER - 0.5 * site.block
    floor = cut.on_cut([beside, 0.0], 0.0) + shift
    ax.plot(*floor.T, color=INK, linewidth=0.8, linestyle=(0, (3, 3)))
    _dimension(ax, cut.on_cut([beside, beside], [0.0, cut.depth]) + shift, f"{cut.depth:g}", upright=True)
    _dimension(ax, cut.on_cut([-half_width, half_width], cut.depth) + shift, f"{2 * half_width:g}")
    bar = cut.on_cut([-5.0, 5.0], -5.0) + shift
    ax.plot(*bar.T, color=INK, linewidth=3.5, solid_capstyle="butt")
    x, y = bar.mean(axis=0)
    ax.text(x, y - 1.2, "10 mm", fontsize=10.5, ha="center", va="top", color=INK)
    across, along = (2 * half_axis for half_axis in opening.half_axes)
    channel = f"⌀ {across:g}" if across == along else f"{across:g} × {along:g}"
    middle, top = 0.5 * (box[0, 0] + box[1, 0]) + shift[0], box[1, 1] + shift[1]
    ax.text(middle, top + 18.0, f"{cut.name}, {cut.depth:g} mm", fontsize=14, weight="bold", ha="center", color=INK)
    n_faces = f"{cut.n_faces:,}".replace(",", "\u2009")
    block = f"block {' × '.join(f'{side:g}' for side in cut.block.round(1))} mm"
    ax.text(
        middle, top + 16.5, f"channel {channel} mm\n{block}\n{n_faces} faces",
        fontsize=10.5, ha="center", va="top", color=INK, linespacing=1.25,
    )  # fmt: skip


def _dimension(ax: Axes, ends: np.ndarray, label: str, upright: bool = False) -> None:
    """A line with an arrow at both ends and its length [mm] beside it."""
    ax.annotate(
        "", ends[0], ends[1], arrowprops=dict(arrowstyle="<|-|>", color=INK, linewidth=1.2, shrinkA=0, shrinkB=0)
    )
    x, y = ends.mean(axis=0) + ([1.0, 0.0] if upright else [0.0, 1.0])
    text = ax.text(
        x, y, label, fontsize=11.5, rotation=90 if upright else 0, color=INK,
        ha="left" if upright else "center", va="center" if upright else "bottom",
    )  # fmt: skip
    text.set_path_effects([withStroke(linewidth=3, foreground="white")])


def _box(cut: CutSite) -> np.ndarray:
    """(2, 2) lowest and highest x and y of the picture of a site, y up [mm]."""
    bounds = shapely.bounds(cut.polygons)
    return np.array([[bounds[:, 0].min(), -bounds[:, 3].max()], [bounds[:, 2].max(), -bounds[:, 1].min()]])


def _in_picture(camera: exact.Camera, points: np.ndarray) -> np.ndarray:
    """(N, 2) image of points in the plane through the camera's target, y up [mm]."""
    local = (points - camera.position) @ camera.rotation.T
    return local[..., :2] / local[..., 2:] * camera.target_distance * [1.0, -1.0]
