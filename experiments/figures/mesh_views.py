"""check.png: a mesh from four sides, fronts and backs in their colours, the edges that matter in theirs."""

from pathlib import Path

import numpy as np
import trimesh
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch

import exact
from experiments.files.whole import written_whole

FRONT, BACK, BORDER, CROWDED = "#7f9ca8", "#e07b39", "#c1121f", "#6a0dad"
# More triangles than this make a picture no clearer, only slower: then each stands for several.
MOST_FACES = 40_000
LIGHT = np.array([0.4, 0.3, 0.87])


def write_views(path: Path, name: str, mesh: trimesh.Trimesh, ring: exact.Ring) -> None:
    """Draw a mesh from the ring's side, from above at a slant, and from two sides, to a PNG file."""
    figure = Figure(figsize=(11, 9), layout="constrained")
    figure.suptitle(name, parse_math=False)
    away, across, up = ring.frame[:, 2], ring.frame[:, 0], ring.frame[:, 1]
    slant = away + 0.8 * across - 0.8 * up
    views = (("from the cameras", away, up), ("at a slant", slant, away), ("from ring angle 0°", across, away),
             ("from ring angle 270°", -up, away))  # fmt: skip
    for axes, (title, towards, upwards) in zip(figure.subplots(2, 2).flat, views, strict=True):
        draw_mesh(axes, mesh, towards, upwards, ring)
        axes.set_title(title, fontsize=10)
    marks = [Patch(color=FRONT, label="front"), Patch(color=BACK, label="back"), Patch(color=BORDER, label="border"),
             Patch(color=CROWDED, label="edge of more than two faces")]  # fmt: skip
    figure.legend(handles=marks, loc="outside lower center", ncols=4, frameon=False)
    with written_whole(path) as temporary:
        figure.savefig(temporary, format="png", dpi=110)


def draw_mesh(
    axes: Axes, mesh: trimesh.Trimesh, towards: np.ndarray, upwards: np.ndarray, ring: exact.Ring
) -> np.ndarray:
    """Draw a mesh as it looks from a direction, and the focus of the ring; give the frame of the picture.

    Its columns, (3, 3), are unit vectors to the right, upwards, and towards who looks.
    """
    towards = towards / np.linalg.norm(towards)
    right = np.cross(upwards, towards)
    right /= np.linalg.norm(right)
    frame = np.column_stack([right, np.cross(towards, right), towards])
    corners = np.asarray(mesh.triangles)
    shown = corners[:: len(corners) // MOST_FACES + 1] @ frame
    normal = np.cross(shown[:, 1] - shown[:, 0], shown[:, 2] - shown[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    is_back = normal[:, 2] < 0
    shade = 0.35 + 0.65 * np.abs(normal @ LIGHT)
    colour = np.where(is_back[:, None], to_rgb(BACK), to_rgb(FRONT)) * shade[:, None]
    order = np.argsort(shown[:, :, 2].mean(axis=1))
    flat = list(shown[order, :, :2])
    axes.add_collection(PolyCollection(flat, facecolors=colour[order], edgecolors="face", linewidths=0.2))
    edges = np.sort(np.asarray(mesh.edges), axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    points = np.asarray(mesh.vertices) @ frame
    for which, stroke in ((count == 1, BORDER), (count > 2, CROWDED)):
        axes.add_collection(LineCollection(list(points[unique[which]][:, :, :2]), colors=stroke, linewidths=1.0))
    focus = np.array(ring.focus) @ frame
    axes.plot(*focus[:2], marker="+", color="black", markersize=10)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.tick_params(labelsize=8)
    return frame
