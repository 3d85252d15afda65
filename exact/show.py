"""How results look: colours by number of views, a view from the cameras' side, a page for notebooks.

Matplotlib is imported when something is drawn.
"""

import base64
import io
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from exact.cameras import Camera
from exact.demand import Demand
from exact.drawing import NOT_COUNTED, regions_from

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from exact.results import Reconstruction

UNCOUNTED_COLOUR = "#e3e0da"
UNSEEN_COLOUR = "#4a4a4a"
# What enough cameras see, none of them far enough apart: stands for a number of views, and has a colour of its own.
TOO_NEAR, TOO_NEAR_COLOUR = -2, "#c99ac0"
# The display camera stands this many half widths of its picture above the top of the surface: near enough to show
# the walls of a channel, far enough not to distort what is at the rim.
NEARNESS = 1.7
# Direction of the light in the display camera's own axes, and the part of it that comes from everywhere.
LAMP, AMBIENT = np.array([-0.4, -0.5, -0.77]), 0.72


def colours(n_views: int, threshold: int) -> dict[int, np.ndarray]:
    """RGB of each number of views: dark for none, warm below the threshold, from light to deep blue above."""
    import matplotlib
    from matplotlib.colors import to_rgb

    table: dict[int, Any] = {TOO_NEAR: TOO_NEAR_COLOUR, NOT_COUNTED: UNCOUNTED_COLOUR, 0: UNSEEN_COLOUR}
    for count in range(1, n_views + 1):
        if count < threshold:
            table[count] = matplotlib.colormaps["YlOrBr"](0.55 - 0.3 * (count - 1) / max(threshold - 1, 1))
        else:
            table[count] = matplotlib.colormaps["GnBu"](0.4 + 0.6 * (count - threshold) / max(n_views - threshold, 1))
    return {count: np.array(to_rgb(colour)) for count, colour in table.items()}


def camera_above(corners: np.ndarray, focus, right: np.ndarray, up: np.ndarray, distance: float) -> Camera:
    """A camera that looks down on points, (N, 3), from close by, against the direction right x up.

    `distance` is that of the cameras that reconstruct from the `focus` [mm]; it stays below them.
    """
    axis, focus = np.cross(right, up), np.asarray(focus)
    away = corners - focus
    middle, half_width = [], 0.0
    for side in (right, up):
        low, high = (away @ side).min(), (away @ side).max()
        middle.append(0.5 * (low + high))
        half_width = max(half_width, 0.55 * (high - low))
    top = min(float((away @ axis).max()), 0.9 * distance)
    target = focus + middle[0] * right + middle[1] * up + top * axis
    return Camera.look_at(target + NEARNESS * half_width * axis, target, up, fov=(2 * half_width, 2 * half_width))


def shaded(fill: np.ndarray, normals: np.ndarray, camera: Camera) -> np.ndarray:
    """(N, 3) colours under a lamp beside the camera, so that slopes show, never so dark that colours get mixed up."""
    light = AMBIENT + (1 - AMBIENT) * np.clip(normals @ (camera.rotation.T @ LAMP), 0, 1)
    return np.clip(fill * light[:, None], 0, 1)


def add_polygons(ax: "Axes", polygons: np.ndarray, fill: np.ndarray, shift=(0.0, 0.0)) -> None:
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
    from matplotlib.collections import PathCollection
    from matplotlib.path import Path as Outline

    upright = shapely.transform(polygons, lambda xy: xy * [1.0, -1.0] + shift)
    part, of_region = shapely.get_parts(upright, return_index=True)
    ring, of_part = shapely.get_rings(part, return_index=True)
    corner, of_ring = shapely.get_coordinates(ring, return_index=True)
    begins, ends = np.diff(of_ring, prepend=-1) > 0, np.diff(of_ring, append=len(ring)) > 0
    code = np.select([begins, ends], [Outline.MOVETO, Outline.CLOSEPOLY], Outline.LINETO).astype(Outline.code_type)
    next_region = np.searchsorted(of_region[of_part][of_ring], np.arange(1, len(polygons)))
    pieces = list(zip(np.split(corner, next_region), np.split(code, next_region), strict=True))
    outlines = [Outline(*piece) for piece in pieces[: len(polygons)]]  # there is a piece even of nothing
    # The hairline of the same colour closes the seams that anti-aliasing leaves between neighbours.
    ax.add_collection(PathCollection(outlines, facecolors=fill, edgecolors=fill, linewidths=0.3, rasterized=True))


def add_surface(
    ax: "Axes", reconstruction: "Reconstruction", camera: Camera, palette: dict[int, np.ndarray], demand: Demand
) -> set[int]:
    """Draw a reconstruction as `camera` shows it, in these colours; the keys of `palette` that are in the picture.

    What as many cameras see as `demand` has it, and does not meet it all the same, is `TOO_NEAR`.
    """
    polygons, n_views, met, face = regions_from(reconstruction, camera, demand)
    key = np.where((n_views >= demand.threshold) & ~met, TOO_NEAR, n_views)
    base = np.stack([palette[int(one)] for one in key]) if len(key) else np.zeros((0, 3))
    add_polygons(ax, polygons, shaded(base, reconstruction.scene.everything.face_normals[face], camera))
    half = camera.fov[0] / 2
    ax.set(xlim=(-half, half), ylim=(-half, half), xticks=[], yticks=[], aspect="equal")
    return set(key.tolist())


def plot(reconstruction: "Reconstruction", ax: "Axes | None" = None) -> "Axes":
    """Draw a reconstruction from its cameras' side, coloured by the number of views.

    Parameters
    ----------
    reconstruction : Reconstruction
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a figure of their own by default, which `ax.figure` gives.

    Returns
    -------
    matplotlib.axes.Axes

    Examples
    --------
    >>> import trimesh
    >>> from exact import Ring, evaluate
    >>> ring, plate = Ring(), trimesh.creation.box((10, 10, 2))
    >>> plot(evaluate(plate, ring.cameras(ring.equidistant(2)))).get_title()
    '100.00 mm² seen by at least 2 cameras'
    """
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    if ax is None:
        ax = Figure(figsize=(5.0, 5.4), layout="constrained").subplots()
    demand, threshold = reconstruction.demand, reconstruction.threshold
    palette = colours(threshold, threshold)
    shown = add_surface(ax, reconstruction, _own_view(reconstruction), palette, demand)
    ax.set_title(f"{reconstruction.area:.2f} mm² {reconstruction.words}", wrap=True)
    labels = {TOO_NEAR: too_near(demand), NOT_COUNTED: "not counted"}
    labels |= {count: _words(count, threshold) for count in range(threshold + 1)}
    handles = [
        Patch(facecolor=tuple(palette[n]), edgecolor="black", linewidth=0.5, label=labels[n]) for n in sorted(shown)
    ]
    ax.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.01), ncols=2, fontsize=8, frameon=False)
    return ax


def _own_view(reconstruction: "Reconstruction") -> Camera:
    """From the middle of the cameras' side on what any of them sees, or on everything that counts."""
    cameras, mesh = reconstruction._cameras, reconstruction.scene.mesh
    position = np.mean([camera.position for camera in cameras], axis=0)
    ahead = [camera.position + camera.target_distance * camera.rotation[2] for camera in cameras]
    focus = np.mean(ahead, axis=0)
    distance = float(np.linalg.norm(position - focus))
    axis = (position - focus) / distance if distance > 0 else -cameras[0].rotation[2]
    # As near to the axes of the mesh as can be, so that x is to the right for cameras above.
    side = np.cross(np.eye(3)[1 if abs(axis[1]) < 0.9 else 0], axis)
    right = side / np.linalg.norm(side)
    seen = reconstruction.level_face_areas[0] > 0
    corners = mesh.triangles[seen if seen.any() else slice(None)].reshape(-1, 3)
    return camera_above(corners, focus, right, np.cross(axis, right), distance)


def too_near(demand: Demand) -> str:
    """What `TOO_NEAR` means, in words."""
    short = [] if demand.baseline == 0 else [f"no two {demand.baseline:g} mm apart"]
    steepest = demand.max_disparity_gradient
    short += [] if steepest is None else [f"no two with a disparity gradient of at most {steepest:g}"]
    short += [] if demand.max_error is None else [f"{demand.error} error above {demand.max_error:g} mm"]
    return f"enough cameras, {' or '.join(short)}"


def _words(count: int, threshold: int) -> str:
    cameras = f"{count or 'no'} camera{'' if count < 2 else 's'}"
    return f"seen by {'at least ' if count == threshold else ''}{cameras}"


def html(reconstruction: "Reconstruction") -> str:
    """A table of areas and a small picture, for notebooks."""
    rows = [(f"reconstructable: {reconstruction.words}", reconstruction.area)]
    for level, area in enumerate(reconstruction.level_areas, start=1):
        rows.append((f"seen by at least {level} camera{'' if level == 1 else 's'}", area))
    shown = [(words, f"{area:.4f} mm²") for words, area in rows]
    rms = reconstruction.error_rms
    if np.isfinite(rms):  # it is not where nothing is reconstructed, or single cameras count
        shown.append((f"RMS of the predicted error along {reconstruction.demand.error}", f"{rms:.4f} mm"))
    return page(rows_html(("reconstruction", ""), shown), plot(reconstruction))


def rows_html(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """A table; whatever its cells hold is shown as text."""
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


def page(table: str, ax: "Axes") -> str:
    """A table with the picture of `ax` below it, both in one piece."""
    from matplotlib.figure import Figure

    figure, picture = ax.figure, io.BytesIO()
    assert isinstance(figure, Figure)
    figure.savefig(picture, format="png", dpi=72)
    data = base64.b64encode(picture.getvalue()).decode("ascii")
    return f'<div>{table}<img alt="picture of the result" src="data:image/png;base64,{data}"></div>'
