"""Check a triangle mesh, mend what changes no area, and repair what can be repaired without guessing."""

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from meshes.condition.neighbours import neighbours
from meshes.condition.winding import both_sides, turn_outside_out, wind_alike
from meshes.distinct_rows import distinct_rows
from meshes.errors import MeshError
from meshes.file_faces import file_faces, number_faces

# A face flatter than this part of its distance from the origin has a normal of rounding noise in float64.
FLATNESS = 1e-12

# Larger coordinates [mm] are damage, not length: 1000 km. Their products would overflow.
LARGEST = 1e9


def check(
    mesh: trimesh.Trimesh,
    repair: bool = False,
    name: str = "mesh",
    *,
    two_sided: bool = False,
    seen_from: ArrayLike | None = None,
) -> trimesh.Trimesh:
    """Return a mesh on which areas mean something, or say why this one is not.

    Needed: at least one face with area; finite vertices; neighbouring faces wound the same way; no closed body
    inside-out, unless it is a hollow in another. Open meshes are fine. What changes no area is mended without being
    asked: faces without area and faces that repeat another go, and so do vertices that no face uses.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        Left as it is.
    repair : bool
        Wind neighbours the same way, turn closed bodies outside-out, and open ones to face `seen_from`.
    name : str
        What to call it in messages.
    two_sided : bool
        Let each face count from whichever side it is seen, by a second one that is wound the other way: for sheets
        and for surfaces whose winding means nothing. Closed bodies that are outside-out stay as they are.
    seen_from : (N, 3) array_like, optional
        Places from which the surface is looked at, such as those of cameras [mm]. Winding that is mixed where nothing
        is seen from them changes no area and is mended; a repair turns what looks away from them.

    Returns
    -------
    trimesh.Trimesh
        `mesh` itself, or a copy that is mended; in its metadata `watertight` (bool), and as lists of str `notes`, what
        was odd and what was mended, and `repairs`, what `repair` did. `meshes.file_faces` says which faces of `mesh`
        such a copy still has.

    Raises
    ------
    MeshError
        If a check fails, and with `repair` only if it cannot be put right.

    Examples
    --------
    >>> box = trimesh.creation.box((1, 1, 1))
    >>> _ = box.invert()
    >>> check(box)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    meshes.errors.MeshError: mesh: closed, but inside-out (its volume is -1), ...
    >>> check(box, repair=True).metadata["repairs"]
    ['turned 1 body outside-out']
    """
    if not isinstance(mesh, trimesh.Trimesh):
        raise MeshError(f"{name}: {type(mesh).__name__}, not a trimesh.Trimesh; load it with `meshes.load(path)`")
    vertices, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)
    _check_not_empty(name, vertices, faces)
    _check_finite(name, vertices, faces)
    notes, repairs = list(mesh.metadata.get("notes", ())), []
    number, n_in_file = file_faces(mesh)
    for step in (_flat_faces, _repeated_faces):
        kept = ~step(name, vertices, faces, notes)
        faces, number = faces[kept], number[kept]
    wound, places = faces, None if seen_from is None else np.atleast_2d(np.asarray(seen_from, dtype=np.float64))
    if two_sided:
        double = both_sides(vertices, faces)
        wound, number = np.concatenate([faces, faces[double, ::-1]]), np.concatenate([number, number[double]])
        first, _ = distinct_rows(_from_their_least_corner(wound))  # those that are there both ways already
        wound, number = wound[first], number[first]
        notes += [f"counted {_count(int(double.sum()), 'face')} from both sides"] * bool(double.any())
    else:
        for step in (wind_alike, turn_outside_out):
            wound = step(name, vertices, wound, number, notes, repairs, repair, places)
    if unused := int((np.bincount(np.ravel(mesh.faces), minlength=len(vertices)) == 0).sum()):
        notes.append(f"left out {_count(unused, 'vertex')} of no face")
    mended = wound is not faces or len(wound) != len(mesh.faces)
    if mended:
        metadata = mesh.metadata
        mesh = trimesh.Trimesh(vertices, wound, process=False)
        mesh.metadata.update(metadata)
        number_faces(mesh, number, n_in_file)
    if mended or unused:
        mesh = mesh if mended else mesh.copy()
        mesh.remove_unreferenced_vertices()
    mesh.metadata["watertight"] = 2 * len(neighbours(faces)[0]) == 3 * len(faces)
    mesh.metadata["notes"] = notes
    mesh.metadata["repairs"] = repairs
    return mesh


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
        notes.append(f"left out {_count(int(flat.sum()), 'face')} of zero area")
    return flat


def _repeated_faces(name, vertices, faces, notes):
    """(F,) bool: faces that were there before, wound the same way, which go: their areas would count twice."""
    first, kind = distinct_rows(_from_their_least_corner(faces))
    repeated = first[kind] != np.arange(len(faces))
    if repeated.any():
        notes.append(f"left out {_count(int(repeated.sum()), 'face')} that repeated another")
    return repeated


def _from_their_least_corner(faces: np.ndarray) -> np.ndarray:
    """Faces (F, 3), turned so that each begins with its least vertex; wound as before."""
    return np.take_along_axis(faces, (faces.argmin(axis=1)[:, None] + np.arange(3)) % 3, axis=1)


def _count(number: int, noun: str) -> str:
    many = "vertices" if noun == "vertex" else f"{noun}s"
    return f"{number} {noun if number == 1 else many}"
