"""camera_01.png, camera_02.png, ..: what each camera sees, with faces that it sees only in part in red."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import trimesh
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

import exact
from exact.show import add_polygons
from experiments.figures.text import figure_text
from experiments.files.whole import image_names, written_whole

WHOLE_COLOUR, CLIPPED_COLOUR, EDGE_COLOUR = (0.72, 0.78, 0.84), (0.85, 0.10, 0.10), "0.25"
# A face is seen whole if what is seen lacks no more than rounding.
WHOLE = 1.0 - 1e-12
# Beside and above the lens, so that slopes show.
LAMP = np.array([-0.4, -0.5, -0.77])


def write_camera_images(
    folder: Path,
    name: str,
    mesh: trimesh.Trimesh,
    cameras: Sequence[exact.Camera],
    places: Sequence[str],
    is_radial: bool,
    report: Callable[[int], object] = lambda steps: None,
) -> list[str]:
    """Draw the image of each camera of a layout.

    Parameters
    ----------
    folder : Path
        An existing one.
    name : str
        Of the mesh, for the titles.
    mesh : trimesh.Trimesh
    cameras : (M,) sequence of exact.Camera
    places : (M,) sequence of str
        Where each of them sits, in words.
    is_radial : bool
        Whether the width of every image lies along the ring.
    report : callable
        Called with 1 after each image.

    Returns
    -------
    list of str
        Names of the files.
    """
    names = image_names(len(cameras))
    for number, (file, place, camera) in enumerate(zip(names, places, cameras, strict=True), start=1):
        seen = exact.view(mesh, camera)
        title = f"{name}: camera {number} of {len(cameras)}, {place}"
        with written_whole(folder / file) as temporary:
            _drawn(seen, mesh, f"{title}\nsees {seen.area:.1f} mm²", is_radial).savefig(temporary)
        report(1)
    return names


def _drawn(seen: exact.View, mesh: trimesh.Trimesh, title: str, is_radial: bool) -> Figure:
    width, height = seen.camera.fov
    figure = Figure(figsize=(9.0, 1.9 + 8.0 * height / width), dpi=110, layout="constrained")
    ax = figure.subplots()
    visible = seen.face_areas > 0
    clipped = visible & (seen.face_areas < WHOLE * mesh.area_faces)
    light = 0.6 + 0.4 * np.clip(mesh.face_normals @ (seen.camera.rotation.T @ LAMP), 0, 1)
    for chosen, colour in ((visible & ~clipped, WHOLE_COLOUR), (clipped, CLIPPED_COLOUR)):
        add_polygons(ax, seen.polygons[chosen], np.multiply.outer(light[chosen], colour))
        ax.collections[-1].set(edgecolor=EDGE_COLOUR, linewidth=0.2)
    ax.add_patch(Rectangle((-width / 2, -height / 2), width, height, fill=False, edgecolor="black", linewidth=1.2))
    ax.set(xlim=(-0.52 * width, 0.52 * width), ylim=(-0.52 * height, 0.52 * height), aspect="equal")
    along, inwards = (", along the ring", ", inwards") if is_radial else ("", "")
    ax.set(xlabel=f"right of the optical axis{along} [mm]", ylabel=f"above the optical axis{inwards} [mm]")
    ax.set_title(figure_text(title), fontsize=12)
    legend = ((WHOLE_COLOUR, "face seen whole"), (CLIPPED_COLOUR, "face seen in part: what is seen of it"))
    handles = [Patch(facecolor=colour, edgecolor=EDGE_COLOUR, label=label) for colour, label in legend]
    handles.append(Patch(facecolor="none", edgecolor="black", label="field of view"))
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False, fontsize=11)
    return figure
