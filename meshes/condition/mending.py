"""What no area depends on, mended without being asked: faces without area and faces that repeat another go."""

from dataclasses import dataclass

import numpy as np
import trimesh

from meshes.distinct_rows import distinct_rows
from meshes.errors import MeshError
from meshes.file_faces import file_faces

# A face flatter than this part of its distance from the origin has a normal of rounding noise in float64.
FLATNESS = 1e-12

# Larger coordinates [mm] are damage, not length: 1000 km. Their products would overflow.
LARGEST = 1e9


@dataclass(frozen=True, eq=False)
class Mended:
    """Faces that have area, each once.

    Attributes
    ----------
    vertices : (V, 3) float
        All vertices of the mesh [mm], used or not.
    faces : (F, 3) int
    number : (F,) int
        Number in the file of each face.
    n_in_file : int
        How many faces the file has.
    notes : list of str
        What was odd when it was read, and what was mended.
    """

    vertices: np.ndarray
    faces: np.ndarray
    number: np.ndarray
    n_in_file: int
    notes: list[str]


def mended(mesh: trimesh.Trimesh, name: str) -> Mended:
    """The faces of a mesh that count; the mesh is left as it is.

    Raises
    ------
    MeshError
        If it is no mesh, has no face with area, or coordinates that are no lengths.
    """
    if not isinstance(mesh, trimesh.Trimesh):
        raise MeshError(f"{name}: {type(mesh).__name__}, not a trimesh.Trimesh; load it with `meshes.load(path)`")
    vertices, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)
    _check_not_empty(name, vertices, faces)
    _check_finite(name, vertices, faces)
    notes = list(mesh.metadata.get("notes", ()))
    if unused := int((np.bincount(faces.ravel(), minlength=len(vertices)) == 0).sum()):
        notes.append(f"left out {counted(unused, 'vertex')} of no face")
    number, n_in_file = file_faces(mesh)
    for step in (_flat_faces, _repeated_faces):
        kept = ~step(name, vertices, faces, notes)
        if not kept.all():
            faces, number = faces[kept], number[kept]
    return Mended(vertices, faces, number, n_in_file, notes)


def _check_not_empty(name: str, vertices: np.ndarray, faces: np.ndarray) -> None:
    if len(faces) == 0:
        raise MeshError(f"{name}: {len(vertices)} vertices and no faces; needed is at least one triangle")


def _check_finite(name: str, vertices: np.ndarray, faces: np.ndarray) -> None:
    bad = np.flatnonzero(~(np.abs(vertices) <= LARGEST).all(axis=1))  # written so that nan is bad
    bad = bad[np.isin(bad, faces)]  # a vertex no face uses does no harm
    if len(bad):
        position = ", ".join(f"{coordinate:g}" for coordinate in vertices[bad[0]])
        raise MeshError(
            f"{name}: vertex {bad[0]} is ({position}), and {len(bad) - 1} more are like it; needed are finite "
            f"coordinates up to {LARGEST:g} mm. The file is damaged, or these vertices must be removed"
        )


def _altitudes(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(F,) smallest altitude of each face [mm]: twice its area over its longest edge; 0 for a point."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    twice_area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    longest = np.max([np.linalg.norm(edge, axis=1) for edge in (b - a, c - b, a - c)], axis=0)
    return np.divide(twice_area, longest, out=np.zeros(len(faces)), where=longest > 0)


def _flat_faces(name, vertices, faces, notes):
    """(F,) bool: faces without area, which go."""
    distance = np.abs(vertices[faces]).max(axis=(1, 2))
    flat = _altitudes(vertices, faces) <= FLATNESS * distance
    if flat.all():
        raise MeshError(
            f"{name}: all {len(faces)} faces have zero area; needed is at least one face with area. "
            "Were the coordinates exported with too few digits?"
        )
    if flat.any():
        notes.append(f"left out {counted(int(flat.sum()), 'face')} of zero area")
    return flat


def _repeated_faces(name, vertices, faces, notes):
    """(F,) bool: faces that were there before, wound the same way, which go: their areas would count twice."""
    first, kind = distinct_rows(from_their_least_corner(faces))
    repeated = first[kind] != np.arange(len(faces))
    if repeated.any():
        notes.append(f"left out {counted(int(repeated.sum()), 'face')} that repeated another")
    return repeated


def from_their_least_corner(faces: np.ndarray) -> np.ndarray:
    """Faces (F, 3), turned so that each begins with its least vertex; wound as before."""
    return np.take_along_axis(faces, (faces.argmin(axis=1)[:, None] + np.arange(3)) % 3, axis=1)


def counted(number: int, noun: str) -> str:
    """A number of things in words.

    Examples
    --------
    >>> counted(1, "face"), counted(2, "vertex")
    ('1 face', '2 vertices')
    """
    many = "vertices" if noun == "vertex" else f"{noun}s"
    return f"{number} {noun if number == 1 else many}"
