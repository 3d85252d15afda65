"""place.png: a mesh, the ring over it and what is in its field of view, before anything is computed."""

from pathlib import Path

import numpy as np
import trimesh
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

import exact
from experiments.figures.mesh_views import BACK, FRONT, draw_mesh
from experiments.figures.text import figure_text
from experiments.files.whole import written_whole

RING, VIEW, ZERO = "#1f5fa8", "#b5179e", "#2a9d3f"
# Points of a circle.
ROUND = 96


def write_place(path: Path, name: str, mesh: trimesh.Trimesh, ring: exact.Ring) -> None:
    """Draw them from the ring, and from its side from near and from afar, to a PNG file."""
    figure = Figure(figsize=(16, 6.4), layout="constrained")
    focus = ", ".join(f"{one:.4g}" for one in ring.focus)
    figure.suptitle(
        figure_text(f"{name}: the ring, {ring.diameter:g} mm wide, stands {ring.working_distance:g} mm from {focus}"),
        fontsize=13,
    )
    zero, quarter, axis = ring.frame.T
    views = (
        ("from the cameras", axis, quarter),
        ("from ring angle 270°", -quarter, axis),
        ("the same from afar", -quarter, axis),
    )
    panels = figure.subplots(1, 3, width_ratios=(1, 1, 0.55))
    for axes, (title, towards, upwards) in zip(panels, views, strict=True):
        frame = draw_mesh(axes, mesh, towards, upwards, ring)
        axes.set_title(title, fontsize=10)
        limits = axes.get_xlim(), axes.get_ylim()
        _draw_ring(axes, frame, ring)
        if towards is axis or "afar" in title:
            axes.autoscale_view()
        else:
            axes.set(xlim=limits[0], ylim=limits[1])
    marks = [
        Patch(color=FRONT, label="front"), Patch(color=BACK, label="back"),
        Line2D([], [], color=RING, label="ring"), Line2D([], [], color=ZERO, label="ring angle 0"),
        Line2D([], [], color=VIEW, label="field of view of the camera there, at the focus, and its borders"),
        Line2D([], [], color="black", marker="+", linestyle="none", label="focus"),
    ]  # fmt: skip
    figure.legend(handles=marks, loc="outside lower center", ncols=6, frameon=False)
    with written_whole(path) as temporary:
        figure.savefig(temporary, format="png", dpi=110)


def field_of_view(ring: exact.Ring) -> np.ndarray:
    """(4, 3) corners of the field of view of the camera at ring angle 0, in the plane through the focus [mm]."""
    width, height = np.array(ring.fov) / 2
    (camera,) = ring.cameras([0.0])
    across, down, _ = camera.rotation
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [width, height]
    return np.array(ring.focus) + corners @ np.stack([across, down])


def _draw_ring(axes: Axes, frame: np.ndarray, ring: exact.Ring) -> None:
    """The ring, its axis and ring angle 0, and the view of the camera there; `frame` is that of the picture."""
    circle = ring.positions(np.linspace(0, 2 * np.pi, ROUND))
    centre = np.array(ring.focus) + ring.working_distance * ring.frame[:, 2]
    camera, corners = circle[0], field_of_view(ring)
    # Beyond the focus by as much again as the field of view is wide.
    further = 1 + max(ring.fov) / ring.working_distance
    lines = (
        ([circle], RING, "-"),
        ([[centre, camera]], ZERO, "-"),
        ([np.vstack([corners, corners[:1]])], VIEW, "-"),
        ([[camera, corner] for corner in camera + further * (corners - camera)], VIEW, ":"),
        ([[ring.focus, centre]], "black", "--"),
    )
    for points, colour, style in lines:
        flat = [np.asarray(line) @ frame[:, :2] for line in points]
        axes.add_collection(LineCollection(flat, colors=colour, linestyles=style, linewidths=1.0))
