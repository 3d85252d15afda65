"""The colours that a mesh's file gives its surface."""

import numpy as np
import trimesh
from trimesh.visual import ColorVisuals

import meshes
from experiments.files.errors import InputError

# What has no colour in a scene, such as an obstacle: light grey.
PLAIN = 0.6


def own_colours(path: str, mesh: trimesh.Trimesh, n_faces: int) -> np.ndarray:
    """(n_faces, 3) reflectances from 0 to 1 of the faces of a mesh, and plain ones of those after them.

    Parameters
    ----------
    path : str
        Of the file that the mesh was loaded from.
    mesh : trimesh.Trimesh
    n_faces : int
        With those of obstacles.

    Raises
    ------
    InputError
        If the file gives no colours, or none of triangles.
    """
    read = trimesh.load_mesh(path, process=False)
    number, n_in_file = meshes.file_faces(mesh)
    shown = read.visual
    if not (isinstance(shown, ColorVisuals) and shown.defined and shown.kind in ("face", "vertex")):
        raise InputError(f"{path} gives its surface no colours; leave --texture out, for those of tissue")
    if len(read.faces) != n_in_file:
        raise InputError(
            f"{path} has faces that are no triangles, whose colours are not read; save it with triangles alone, or "
            "leave --texture out"
        )
    colours = np.full((n_faces, 3), PLAIN)
    # Files give colours as screens show them, with a bend that light does not have.
    colours[: len(number)] = (shown.face_colors[number, :3] / 255.0) ** 2.2
    return colours
