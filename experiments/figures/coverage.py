"""coverage.png: the site from the cameras' side, coloured by the number of cameras that see each part, and the ring."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import trimesh
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Patch

import exact
from exact.show import TOO_NEAR, UNCOUNTED_COLOUR, add_surface, camera_above, colours, too_near
from experiments.figures.text import figure_text
from experiments.files.whole import written_whole

# From this number of views on, colours and counts are not told apart any more.
MOST_SHADES = 8


@dataclass(frozen=True, eq=False)
class Panel:
    """One layout to show: what it is called, its ring angles [rad], a line about its area, rolls of its own [rad]."""

    title: str
    angles: np.ndarray
    caption: str
    rolls: np.ndarray | None = None


def display_camera(mesh: trimesh.Trimesh, ring: exact.Ring, faces: np.ndarray) -> exact.Camera:
    """A camera on the ring's axis that looks down on these faces, (F,) bool, from close by; ring angle 0 is right."""
    across = ring.positions([0.0, np.pi / 2]) - ring.positions([np.pi, -np.pi / 2])
    right, up = across / ring.diameter
    corners = mesh.triangles[faces].reshape(-1, 3)
    return camera_above(corners, ring.focus, right, up, ring.working_distance)


def write_coverage(
    path: Path, name: str, scene: exact.Scene, ring: exact.Ring, panels: Sequence[Panel], demand: exact.Demand
) -> None:
    """Draw the panels side by side with one legend, and the ring from above, to a PNG file."""
    figure = Figure(figsize=(5.0 * len(panels) + 5.2, 6.7), dpi=150, layout="constrained")
    axes = figure.subplots(1, len(panels) + 1, width_ratios=[5.0] * len(panels) + [4.6])
    titled = [(f"{panel.title}\n{panel.caption}", ring.cameras(panel.angles, panel.rolls)) for panel in panels]
    handles = add_surfaces(axes[:-1], scene, ring, titled, demand)
    _ring_from_above(axes[-1], ring, panels)
    heading = f"{name}: which parts do the cameras see?  (seen from the ring, looking down)"
    figure.suptitle(figure_text(heading), fontsize=14)
    add_legend(figure, handles, demand)
    with written_whole(path) as temporary:
        figure.savefig(temporary)


def add_surfaces(
    axes: Sequence[Axes],
    scene: exact.Scene,
    ring: exact.Ring,
    titled: Sequence[tuple[str, Sequence[exact.Camera]]],
    demand: exact.Demand,
) -> list[Patch]:
    """Draw what cameras see, with a title above, into each of the axes, from the axis of `ring`; what colours mean."""
    most = max(len(cameras) for _, cameras in titled)
    shades = max(demand.threshold, min(most, MOST_SHADES))
    palette = colours(shades, demand.threshold)
    # As many views as are told apart, not only as many as it takes.
    reconstructions = [
        exact.evaluate(scene, cameras, demand=replace(demand, threshold=min(shades, len(cameras))))
        for _, cameras in titled
    ]
    seen = np.any([result.level_face_areas[0] > 0 for result in reconstructions], axis=0)
    camera = display_camera(scene.mesh, ring, seen if seen.any() else scene.of_mesh(scene.counted))
    shown: set[int] = set()
    for (title, _), reconstruction, ax in zip(titled, reconstructions, axes, strict=True):
        shown |= add_surface(ax, reconstruction, camera, palette, demand)
        _add_bar(ax, camera.fov[0] / 2)
        ax.set_title(figure_text(title), fontsize=12)
    return _legend(palette, shades, demand, most, shown)


def add_legend(figure: Figure, handles: Sequence[Patch], demand: exact.Demand) -> None:
    """What the colours of `add_surfaces` mean, below a figure."""
    figure.legend(
        handles=handles, loc="outside lower center", ncols=min(6, len(handles)), fontsize=11, frameon=False,
        title=f"a point is reconstructable when {demand.clause()}",
        title_fontsize=11,
    )  # fmt: skip


def _add_bar(ax: Axes, half: float) -> None:
    """A scale for a picture that is `half` wide from its middle [mm]."""
    bar = 10.0 if half >= 8 else 10.0 ** np.floor(np.log10(half))
    left, low = -0.94 * half, -0.93 * half
    ax.plot([left, left + bar], [low, low], color="black", linewidth=3, solid_capstyle="butt")
    ax.text(left, low + 0.03 * half, f"{bar:g} mm at the top", fontsize=9, va="bottom")


def _legend(palette, shades: int, demand: exact.Demand, most: int, shown: set[int]) -> list[Patch]:
    handles = []
    for count in sorted(shown - {exact.NOT_COUNTED, TOO_NEAR}):
        if count == 0:
            label = "no camera"
        else:
            label = f"{count}{' or more' if count == shades < most else ''} camera{'s' if count > 1 else ''}"
            label += "" if count >= demand.threshold else " (too few)"
        handles.append(Patch(facecolor=palette[count], edgecolor="black", linewidth=0.5, label=label))
    if TOO_NEAR in shown:
        handles.append(Patch(facecolor=palette[TOO_NEAR], edgecolor="black", linewidth=0.5, label=too_near(demand)))
    if exact.NOT_COUNTED in shown:
        handles.append(Patch(facecolor=UNCOUNTED_COLOUR, edgecolor="black", linewidth=0.5, label="not counted"))
    return handles


def _add_sensors(ax: Axes, ring: exact.Ring, panel: Panel) -> None:
    """A line along the width of each image, unless they are all along the ring."""
    if panel.rolls is None and ring.roll == "radial":
        return
    for number, camera in enumerate(ring.cameras(panel.angles, panel.rolls)):
        x, y, _ = (camera.position - np.array(ring.focus)) @ ring.frame
        dx, dy, _ = 0.16 * ring.diameter / 2 * camera.rotation[0] @ ring.frame
        label = "_nolegend_" if number else "width of the image"
        ax.plot([x - dx, x + dx], [y - dy, y + dy], color="#1f5fa8", linewidth=2.2, label=label)


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
    _add_sensors(ax, ring, panels[-1])
    limit = 1.45 * radius
    ax.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
    ax.set_title(f"camera positions on the ring\n(diameter {ring.diameter:g} mm, from above)", fontsize=12)
    ax.legend(loc="center", frameon=False, fontsize=10)
    ax.spines[["top", "right"]].set_visible(False)
