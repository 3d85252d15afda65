"""The flat faces around the opening of a site."""

import numpy as np
import trimesh

# Coordinates of an STL file are rounded to single precision, 6e-8 of their size.
ROUNDING = 1e-6


def top_surface(mesh: trimesh.Trimesh) -> np.ndarray:
    """Which faces are the top surface: flat, facing +z, at the greatest z of the mesh.

    Drapes cover it in surgery, so most results leave it out (Wachter 2021, tables without top surface).

    Parameters
    ----------
    mesh : trimesh.Trimesh
        A site, opening towards +z.

    Returns
    -------
    (F,) ndarray of bool
        True for faces of the top surface. A mesh whose highest point is a peak has none.

    Examples
    --------
    >>> box = trimesh.creation.box((10, 20, 30))
    >>> float(box.area_faces[top_surface(box)].sum())
    200.0
    >>> bool(top_surface(trimesh.creation.icosphere()).any())
    False
    """
    has_area = np.asarray(mesh.area_faces) > 0  # others may reach anywhere
    if not has_area.any():
        return np.zeros(len(mesh.faces), dtype=bool)
    corners = np.asarray(mesh.vertices)[mesh.faces]
    tolerance = ROUNDING * np.abs(corners[has_area]).max()
    highest = corners[:, :, 2]
    level = highest.min(axis=1) >= highest[has_area].max() - tolerance
    return has_area & level & (np.asarray(mesh.face_normals)[:, 2] > 0)
