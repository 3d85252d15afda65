"""Check a triangle mesh, mend what changes no area, and repair what can be repaired without guessing."""

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from meshes.condition.mending import counted, from_their_least_corner, mended
from meshes.condition.neighbours import neighbours
from meshes.condition.winding import both_sides, turn_outside_out, wind_alike
from meshes.distinct_rows import distinct_rows
from meshes.file_faces import number_faces


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
    found = mended(mesh, name)
    vertices, faces, number, notes = found.vertices, found.faces, found.number, found.notes
    places = None if seen_from is None else np.atleast_2d(np.asarray(seen_from, dtype=np.float64))
    repairs: list[str] = []
    wound = faces
    if two_sided:
        double = both_sides(vertices, faces)
        wound, number = np.concatenate([faces, faces[double, ::-1]]), np.concatenate([number, number[double]])
        first, _ = distinct_rows(from_their_least_corner(wound))  # some may be there both ways already
        wound, number = wound[first], number[first]
        if double.any():
            notes.append(f"{counted(int(double.sum()), 'face')} count from both sides")
    else:
        for step in (wind_alike, turn_outside_out):
            wound = step(name, vertices, wound, number, notes, repairs, repair, places)
    if wound is not faces or len(wound) != len(mesh.faces):
        metadata = mesh.metadata
        mesh = trimesh.Trimesh(vertices, wound, process=False)
        mesh.metadata.update(metadata)
        number_faces(mesh, number, found.n_in_file)
    if not mesh.referenced_vertices.all():
        mesh = mesh.copy()
        mesh.remove_unreferenced_vertices()
    mesh.metadata["watertight"] = 2 * len(neighbours(faces)[0]) == 3 * len(faces)
    mesh.metadata["notes"] = notes
    mesh.metadata["repairs"] = repairs
    return mesh
