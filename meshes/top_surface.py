"""The flat faces around the opening of a site."""

import numpy as np
import trimesh
from numpy.typing import ArrayLike

# Coordinates of an STL file are rounded to single precision, 6e-8 of their size.
ROUNDING = 1e-6
# A place is found to a few degrees; normals of the same flat part of an STL file differ by less than this [rad]; and of
# flat parts the largest so many are tried.
TILT, ALIKE, MOST_TRIED = np.radians(15.0), 1e-3, 20


def top_surface(mesh: trimesh.Trimesh, towards: ArrayLike | None = None) -> np.ndarray:
    """Which faces are the top surface: flat, facing +z, at the greatest z of the mesh.

    Drapes cover it in surgery, so most results leave it out (Wachter 2021, tables without top surface).

    Parameters
    ----------
    mesh : trimesh.Trimesh
        A site, opening towards +z.
    towards : (3,) array_like, optional
        About where it opens to, if that is not +z, such as the axis of a ring for which a place was found: the top
        surface is then the largest flat part that nothing rises above and that faces within 15 degrees of it.

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
    if towards is None:
        return _highest(mesh, np.array([0.0, 0.0, 1.0]))
    axis = np.asarray(towards, dtype=np.float64)
    areas, normals = np.asarray(mesh.area_faces), np.asarray(mesh.face_normals)
    near = (areas > 0) & (normals @ axis > np.cos(TILT) * np.linalg.norm(axis))
    best = np.zeros(len(areas), dtype=bool)
    tried = np.zeros(len(areas), dtype=bool)
    for _ in range(MOST_TRIED):
        left = np.where(near & ~tried, areas, 0.0)
        if left.max() == 0:
            break
        # The normals of small faces are rounded; the mean of all that are alike is not.
        alike = near & (normals @ normals[np.argmax(left)] > np.cos(ALIKE))
        tried |= alike
        direction = areas[alike] @ normals[alike]
        found = _highest(mesh, direction / np.linalg.norm(direction))
        best = found if areas[found].sum() > areas[best].sum() else best
    return best


def _highest(mesh: trimesh.Trimesh, direction: np.ndarray) -> np.ndarray:
    """(F,) bool: flat faces that face a direction, the unit vector (3,), at the greatest height along it."""
    has_area = np.asarray(mesh.area_faces) > 0  # others may reach anywhere
    if not has_area.any():
        return np.zeros(len(mesh.faces), dtype=bool)
    corners = np.asarray(mesh.vertices)[mesh.faces]
    tolerance = ROUNDING * np.abs(corners[has_area]).max()
    highest = corners @ direction
    level = highest.min(axis=1) >= highest[has_area].max() - tolerance
    return has_area & level & (np.asarray(mesh.face_normals) @ direction > 0)
