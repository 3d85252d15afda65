"""coverage.png: the site from the cameras' side, coloured by the number of cameras that see each part, and the ring."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import shapely
import trimesh
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Patch
from matplotlib.path import Path as Outline

import exact
from experiments.files import written_whole

# From this number of views on, colours and counts are not told apart any more.
MOST_SHADES = 8
UNCOUNTED_COLOUR = "#e3e0da"
UNSEEN_COLOUR = "#4a4a4a"
# The display camera stands this many half widths of its picture above the top of the surface: near enough to show
# the walls of a channel, far enough not to distort what is at the rim.
NEARNESS = 1.7


@dataclass(frozen=True, eq=False)
class Panel:
    """One layout to show: what it is called, its ring angles [rad], a line about its area."""

    title: str
    angles: np.ndarray
    caption: str


def colours(n_views: int, threshold: int) -> dict[int, np.ndarray]:
    """RGB of each number of views: dark for none, warm below the threshold, from light to deep blue above."""
    table: dict[int, Any] = {exact.NOT_COUNTED: UNCOUNTED_COLOUR, 0: UNSEEN_COLOUR}
    for count in range(1, n_views + 1):
        if count < threshold:
            table[count] = matplotlib.colormaps["YlOrBr"](0.55 - 0.3 * (count - 1) / max(threshold - 1, 1))
        else:
            table[count] = matplotlib.colormaps["GnBu"](0.4 + 0.6 * (count - threshold) / max(n_views - threshold, 1))
    return {count: np.array(to_rgb(colour)) for count, colour in table.items()}


def display_camera(mesh: trimesh.Trimesh, ring: exact.Ring, faces: np.ndarray) -> exact.Camera:
    """A camera on the ring's axis that looks down on these faces, (F,) bool, from close by; ring angle 0 is right."""
    across = ring.positions([0.0, np.pi / 2]) - ring.positions([np.pi, -np.pi / 2])
    right, up = across / ring.diameter
    axis = np.cross(right, up)
    focus = np.array(ring.focus)
    away = mesh.triangles[faces].reshape(-1, 3) - focus
    middle, half_width = [], 0.0
    for side in (right, up):
        low, high = (away @ side).min(), (away @ side).max()
        middle.append(0.5 * (low + high))
        half_width = max(half_width, 0.55 * (high - low))
    top = min(float((away @ axis).max()), 0.9 * ring.working_distance)
    target = focus + middle[0] * right + middle[1] * up + top * axis
    return exact.Camera.look_at(target + NEARNESS * half_width * axis, target, up, fov=(2 * half_width, 2 * half_width))


def write_coverage(
    path: Path,
    name: str,
    mesh: trimesh.Trimesh,
    ring: exact.Ring,
    panels: Sequence[Panel],
    threshold: int,
    exclude: np.ndarray,
) -> None:
    """Draw the panels side by side with one legend, and the ring from above, to a PNG file."""
    figure = Figure(figsize=(5.0 * len(panels) + 5.2, 6.7), dpi=150, layout="constrained")
    axes = figure.subplots(1, len(panels) + 1, width_ratios=[5.0] * len(panels) + [4.6])
    shades = max(threshold, min(max(len(panel.angles) for panel in panels), MOST_SHADES))
    palette = colours(shades, threshold)
    reconstructions = []
    for panel in panels:
        cameras = ring.cameras(panel.angles)
        reconstructions.append(exact.evaluate(mesh, cameras, threshold=min(shades, len(cameras)), exclude=exclude))
    seen = np.any([result.level_face_areas[0] > 0 for result in reconstructions], axis=0)
    camera = display_camera(mesh, ring, seen if seen.any() else ~exclude)
    shown: set[int] = set()
    for panel, reconstruction, ax in zip(panels, reconstructions, axes[:-1], strict=True):
        polygons, n_views, face = exact.seen_from(reconstruction, camera)
        shown |= set(n_views.tolist())
        _fill(ax, polygons, n_views, mesh.face_normals[face], camera, palette)
        ax.set_title(f"{panel.title}\n{panel.caption}", fontsize=12)
    _ring_from_above(axes[-1], ring, panels)
    figure.suptitle(f"{name}: which parts do the cameras see?  (seen from the ring, looking down)", fontsize=14)
    figure.legend(
        handles=_legend(palette, shades, threshold, max(len(panel.angles) for panel in panels), shown),
        loc="outside lower center", ncols=min(6, len(shown)), fontsize=11, frameon=False,
        title=f"a point is reconstructable when at least {threshold} camera{'s see' if threshold > 1 else ' sees'} it",
        title_fontsize=11,
    )  # fmt: skip
    with written_whole(path) as temporary:
        figure.savefig(temporary)


def _fill(ax, polygons, n_views, normals, camera: exact.Camera, palette) -> None:
    # A lamp beside the display camera lets slopes show; the shade never goes so far that colours get mixed up.
    lamp = camera.rotation.T @ np.array([-0.4, -0.5, -0.77])
    light = 0.72 + 0.28 * np.clip(normals @ lamp, 0, 1)
    base = np.stack([palette[int(count)] for count in n_views]) if len(n_views) else np.zeros((0, 3))
    fill = np.clip(base * light[:, None], 0, 1)
    add_polygons(ax, polygons, fill)
    half = camera.fov[0] / 2
    bar = 10.0 if half >= 8 else 10.0 ** np.floor(np.log10(half))
    left, low = -0.94 * half, -0.93 * half
    ax.plot([left, left + bar], [low, low], color="black", linewidth=3, solid_capstyle="butt")
    ax.text(left, low + 0.03 * half, f"{bar:g} mm at the top", fontsize=9, va="bottom")
    ax.set(xlim=(-half, half), ylim=(-half, half), xticks=[], yticks=[], aspect="equal")


def add_polygons(ax: Axes, polygons: np.ndarray, fill: np.ndarray, shift=(0.0, 0.0)) -> None:
    """Draw regions of a camera's image, y down, in these colours, upright and moved by `shift`.

    Parameters
    ----------
    polygons : (N,) ndarray of object
        Polygons or MultiPolygons [mm].
    fill : (N, 3) ndarray
        RGB.
    shift : (2,) array_like
        To the right and up [mm].
    """
    upright = shapely.transform(polygons, lambda xy: xy * [1.0, -1.0] + shift)
    outlines = [
        Outline.make_compound_path(*(Outline(np.asarray(ring.coords), closed=True) for ring in _rings(region)))
        for region in upright
    ]
    # The hairline of the same colour closes the seams that anti-aliasing leaves between neighbours.
    ax.add_collection(PathCollection(outlines, facecolors=fill, edgecolors=fill, linewidths=0.3, rasterized=True))


def _rings(region: shapely.Polygon | shapely.MultiPolygon):
    return [ring for polygon in shapely.get_parts(region) for ring in (polygon.exterior, *polygon.interiors)]


def _legend(palette, shades: int, threshold: int, most: int, shown: set[int]) -> list[Patch]:
    handles = []
    for count in sorted(shown - {exact.NOT_COUNTED}):
        if count == 0:
            label = "no camera"
        else:
            label = f"{count}{' or more' if count == shades < most else ''} camera{'s' if count > 1 else ''}"
            label += "" if count >= threshold else " (too few)"
        handles.append(Patch(facecolor=palette[count], edgecolor="black", linewidth=0.5, label=label))
    if exact.NOT_COUNTED in shown:
        handles.append(Patch(facecolor=UNCOUNTED_COLOUR, edgecolor="black", linewidth=0.5, label="not counted"))
    return handles


def _ring_from_above(ax, ring: exact.Ring, panels: Sequence[Panel]) -> None:
    radius = ring.diameter / 2
    ax.add_patch(Circle((0, 0), radius, fill=False, color="0.6", linewidth=1.2))
    markers = [
        dict(marker="o", mfc="white", mec="0.35", ms=11, mew=1.5),
        dict(marker="s", mfc="#1f5fa8", mec="#1f5fa8", ms=9),
    ]
    for number, panel in enumerate(panels):
        x, y = radius * np.cos(panel.angles), radius * np.sin(panel.angles)
        ax.plot(x, y, linestyle="none", label=panel.title, **markers[min(number, len(markers) - 1)])
    if len(panels[-1].angles) <= 16:
        for angle in np.sort(np.mod(panels[-1].angles, 2 * np.pi)):
            ax.annotate(
                f"{np.degrees(angle):.1f}°", 1.22 * radius * np.array([np.cos(angle), np.sin(angle)]),
                ha="center", va="center", fontsize=10, color="#1f5fa8",
            )  # fmt: skip
    limit = 1.45 * radius
    ax.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
    ax.set_title(f"camera positions on the ring\n(diameter {ring.diameter:g} mm, from above)", fontsize=12)
    ax.legend(loc="center", frameon=False, fontsize=10)
    ax.spines[["top", "right"]].set_visible(False)
