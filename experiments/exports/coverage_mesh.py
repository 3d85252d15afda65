"""Results as meshes: the reconstructable part, the surface coloured by the number of views, and by predicted error.

The colours are those of `coverage_figure`. PLY has one per face and the number of views beside it; in glTF each number
of views is an object of its own, which can be shown and hidden.
"""

from pathlib import Path

import numpy as np
import trimesh
from matplotlib import colormaps
from matplotlib.ticker import MaxNLocator
from trimesh.visual import ColorVisuals

import exact
from exact.show import colours
from experiments.exports import gltf
from experiments.files.whole import written_whole

RECONSTRUCTABLE = ("reconstructable.stl", "reconstructable.ply")
FILES = (*RECONSTRUCTABLE, "coverage.ply", "coverage.glb")
ERRORS = ("errors.ply", "errors.glb")
# Classes of errors that are told apart.
N_CLASSES = 8


def coverage_parts(result: exact.Reconstruction) -> dict[int, trimesh.Trimesh]:
    """The surface by number of views: `exact.NOT_COUNTED`, 0, 1, .. up to the threshold, which stands for that or more.

    Returns
    -------
    dict of int to trimesh.Trimesh
        Meshes without a common point but their borders, some perhaps without faces; together they are `mesh`.

    Examples
    --------
    >>> ring, plate = exact.Ring(), trimesh.creation.box((10, 10, 2))
    >>> parts = coverage_parts(exact.evaluate(plate, ring.cameras(ring.equidistant(2))))
    >>> {n_views: round(float(part.area), 6) for n_views, part in parts.items()}  # each sees a side, both the top
    {-1: 0.0, 0: 140.0, 1: 40.0, 2: 100.0}
    """
    mesh, counted = result.scene.everything, result.scene.counted
    left_out = trimesh.Trimesh(mesh.vertices, mesh.faces[~counted], process=False)
    left_out.remove_unreferenced_vertices()
    by_views = {n_views: result.to_mesh(n_views) for n_views in range(result.threshold + 1)}
    return {exact.NOT_COUNTED: left_out, **by_views}


def write(folder: Path, result: exact.Reconstruction) -> tuple[str, ...]:
    """Write `FILES` into `folder`; if nothing is reconstructable, without the two that would be empty.

    Parameters
    ----------
    folder : pathlib.Path
        Prepared by `output_folder`: what is there may be replaced.
    result : exact.Reconstruction

    Returns
    -------
    tuple of str
        Names of the files written.
    """
    part = _in_four_bytes(result.to_mesh())
    names = FILES if len(part.faces) else FILES[len(RECONSTRUCTABLE) :]
    for name in RECONSTRUCTABLE:
        if name not in names:
            (folder / name).unlink(missing_ok=True)  # of an earlier result, it would pass for this one's
            continue
        with written_whole(folder / name) as temporary:
            part.export(temporary)
    parts = coverage_parts(result)
    palette = colours(result.threshold, result.threshold)
    with written_whole(folder / "coverage.ply") as temporary:
        _coloured(parts, palette).export(temporary)
    objects = [gltf.Part(_title(n, result.threshold), parts[n], palette[n].tolist()) for n in parts]
    gltf.write(folder / "coverage.glb", objects)
    return names


def write_errors(folder: Path, result: exact.Reconstruction | None) -> tuple[str, ...]:
    """Write `ERRORS` into `folder`, the reconstructable part coloured by its predicted error; without one, none.

    In PLY each triangle has the errors at its centre beside its colour, `depth_error` and `normal_error` [mm]; in glTF
    each class of errors is an object of its own.
    """
    for name in ERRORS:
        (folder / name).unlink(missing_ok=True)  # of an earlier result, it would pass for this one's
    if result is None:
        return ()
    mesh = result.to_mesh(errors=True)
    error = np.asarray(mesh.face_attributes[f"{result.demand.error}_error"])
    # The few that are much worse than all others would leave the rest in one class.
    edges = MaxNLocator(N_CLASSES, min_n_ticks=2).tick_values(0.0, float(np.quantile(error, 0.98)))[1:]
    which = np.minimum(np.searchsorted(edges, error), len(edges) - 1)
    palette = colormaps["viridis"](np.linspace(0.95, 0.0, len(edges)))[:, :3]
    mesh.visual = ColorVisuals(mesh, face_colors=np.round(255 * palette[which]).astype(np.uint8))
    with written_whole(folder / ERRORS[0]) as temporary:
        _in_four_bytes(mesh).export(temporary)
    titles = [f"to {edge:.3g} mm" for edge in edges[:-1]] + [f"above {edges[-2] if len(edges) > 1 else 0.0:.3g} mm"]
    classes = [(int(k), trimesh.Trimesh(mesh.vertices, mesh.faces[which == k])) for k in np.unique(which)]
    gltf.write(folder / ERRORS[1], [gltf.Part(titles[k], part, palette[k].tolist()) for k, part in classes])
    return ERRORS


def _in_four_bytes(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """The mesh with whole numbers that PLY has a type for."""
    for name, values in mesh.face_attributes.items():
        if values.dtype == np.int64:
            mesh.face_attributes[name] = values.astype(np.int32)
    return mesh


def _coloured(parts: dict[int, trimesh.Trimesh], palette: dict[int, np.ndarray]) -> trimesh.Trimesh:
    """All parts as one mesh with a colour per face and its number of views as `face_attributes["n_views"]`."""
    first = np.cumsum([0] + [len(part.vertices) for part in parts.values()])
    n_views = np.repeat(list(parts), [len(part.faces) for part in parts.values()])
    mesh = trimesh.Trimesh(
        np.concatenate([part.vertices for part in parts.values()]),
        np.concatenate([part.faces + start for part, start in zip(parts.values(), first[:-1], strict=True)]),
        face_colors=np.round(255 * np.stack([palette[n] for n in n_views.tolist()])).astype(np.uint8),
        process=False,
    )
    mesh.face_attributes["n_views"] = n_views.astype(np.int32)
    return mesh


def _title(n_views: int, threshold: int) -> str:
    if n_views == exact.NOT_COUNTED:
        return "not counted"
    cameras = f"{n_views or 'no'} camera{'' if n_views < 2 else 's'}"
    return f"seen by {cameras}{' or more' if n_views == threshold else ''}"
