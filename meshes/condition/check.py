"""Check a triangle mesh, mend what changes no area, and repair what can be repaired without guessing."""

import numpy as np
import trimesh
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from meshes.condition.bodies import inside_out
from meshes.condition.neighbours import neighbours
from meshes.distinct_rows import distinct_rows
from meshes.errors import REPAIR_CALL, MeshError
from meshes.file_faces import file_faces, number_faces

# A face flatter than this part of its distance from the origin has a normal of rounding noise in float64.
FLATNESS = 1e-12

# Larger coordinates [mm] are damage, not length: 1000 km. Their products would overflow.
LARGEST = 1e9


def check(mesh: trimesh.Trimesh, repair: bool = False, name: str = "mesh") -> trimesh.Trimesh:
    """Return a mesh on which areas mean something, or say why this one is not.

    Needed: at least one face with area; finite vertices; neighbouring faces wound the same way; no closed body
    inside-out, unless it is a hollow in another. Open meshes are fine. What changes no area is mended without being
    asked: faces without area and faces that repeat another go, and so do vertices that no face uses.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        Left as it is.
    repair : bool
        Wind neighbours the same way, turn closed bodies outside-out.
    name : str
        What to call it in messages.

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
    wound = faces
    for step in (_wind_alike, _turn_outside_out):
        wound = step(name, vertices, wound, number, repairs, repair)
    if unused := int((np.bincount(np.ravel(mesh.faces), minlength=len(vertices)) == 0).sum()):
        notes.append(f"left out {_count(unused, 'vertex')} of no face")
    mended = repairs or len(wound) < len(mesh.faces)
    if mended:
        metadata = mesh.metadata
        mesh = trimesh.Trimesh(vertices, wound, process=False)
        mesh.metadata.update(metadata)
        number_faces(mesh, number, n_in_file)
    if mended or unused:
        mesh = mesh if mended else mesh.copy()
        mesh.remove_unreferenced_vertices()
    mesh.metadata["watertight"] = 2 * len(neighbours(wound)[0]) == 3 * len(wound)
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
    start = faces.argmin(axis=1)
    turned = np.take_along_axis(faces, (start[:, None] + np.arange(3)) % 3, axis=1)
    first, kind = distinct_rows(turned)
    repeated = first[kind] != np.arange(len(faces))
    if repeated.any():
        notes.append(f"left out {_count(int(repeated.sum()), 'face')} that repeated another")
    return repeated


def _wind_alike(name, vertices, faces, number, repairs, repair):
    pairs, alike = neighbours(faces)
    if alike.all():
        return faces
    first = number[pairs[~alike][0]]
    if not repair:
        raise MeshError(
            f"{name}: neighbouring faces {first[0]} and {first[1]} are wound in opposite senses, and so are "
            f"{int((~alike).sum()) - 1} more pairs; {REPAIR_CALL} winds them alike"
        )
    # Two copies of every face, as it is and turned round; neighbours link the copies that agree. A surface that can
    # be wound alike falls apart into two mirrored halves; on a Moebius strip both copies of a face hang together.
    n = len(faces)
    a, b = pairs.T
    rows, columns = np.r_[a, a + n], np.r_[np.where(alike, b, b + n), np.where(alike, b + n, b)]
    links = coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(2 * n, 2 * n))
    label = connected_components(links, directed=False)[1]
    if (label[:n] == label[n:]).any():
        face = int(number[label[:n] == label[n:]][0])
        raise MeshError(
            f"{name}: the surface through face {face} is one-sided, like a Moebius strip, and has no outside; "
            "cut it into two-sided parts"
        )
    # Of the two halves of each patch keep the one that turns fewer faces round.
    patch = np.minimum(label[:n], label[n:])
    turned = label[:n] != patch
    size = np.bincount(patch, minlength=2 * n)
    many = np.bincount(patch, weights=turned, minlength=2 * n) > size / 2
    turned ^= many[patch]
    repairs.append(f"turned {_count(int(turned.sum()), 'face')} round to wind all alike")
    return np.where(turned[:, None], faces[:, ::-1], faces)


def _turn_outside_out(name, vertices, faces, number, repairs, repair):
    body, volume, inverted = inside_out(vertices, faces)
    if not inverted.any():
        return faces
    worst = int(np.argmin(np.where(inverted, volume, np.inf)))
    if not repair:
        raise MeshError(
            f"{name}: closed, but inside-out (its volume is {volume[worst]:.6g}), so that every face is seen from "
            f"behind; {REPAIR_CALL} turns it outside-out"
        )
    count = int(inverted.sum())
    repairs.append(f"turned {count} {'body' if count == 1 else 'bodies'} outside-out")
    return np.where(inverted[body][:, None], faces[:, ::-1], faces)


def _count(number: int, noun: str) -> str:
    many = "vertices" if noun == "vertex" else f"{noun}s"
    return f"{number} {noun if number == 1 else many}"
