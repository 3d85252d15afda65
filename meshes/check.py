"""Check a triangle mesh, and repair what can be repaired without guessing."""

import numpy as np
import trimesh
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from meshes.errors import MeshError

# A face flatter than this part of its distance from the origin has a normal of rounding noise in float64.
FLATNESS = 1e-12

# Larger coordinates [mm] are damage, not length: 1000 km. Their products would overflow.
LARGEST = 1e9


def check(mesh: trimesh.Trimesh, repair: bool = False, name: str = "mesh") -> trimesh.Trimesh:
    """Return a mesh on which areas mean something, or say why this one is not.

    Needed: at least one face; finite vertices; no face without area; no face twice; neighbouring faces wound the
    same way; a closed mesh not inside-out. Open meshes are fine.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        Left as it is.
    repair : bool
        Remove faces without area and repeated ones, wind neighbours the same way, turn a closed mesh outside-out.
    name : str
        What to call it in messages.

    Returns
    -------
    trimesh.Trimesh
        `mesh` itself, or a repaired copy; in its metadata `watertight` (bool) and `repairs` (list of str).

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
    repairs: list[str] = []
    for step in (_drop_flat_faces, _drop_repeated_faces, _wind_alike, _turn_outside_out):
        faces = step(name, vertices, faces, repairs, repair)
    if repairs:
        mesh = trimesh.Trimesh(vertices, faces, process=False)
        mesh.remove_unreferenced_vertices()
    mesh.metadata["watertight"] = bool(mesh.is_watertight)
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


def _drop_flat_faces(name, vertices, faces, repairs, repair):
    distance = np.abs(vertices[faces]).max(axis=(1, 2))
    flat = _altitudes(vertices, faces) <= FLATNESS * distance
    if flat.all():
        raise MeshError(
            f"{name}: all {len(faces)} faces have zero area; needed is at least one face with area. "
            "Were the coordinates exported with too few digits?"
        )
    if not flat.any():
        return faces
    first = int(np.flatnonzero(flat)[0])
    if not repair:
        raise MeshError(
            f"{name}: face {first} has zero area (vertices {', '.join(map(str, faces[first]))}), and so have "
            f"{int(flat.sum()) - 1} more; `meshes.load(path, repair=True)` removes such faces"
        )
    repairs.append(f"removed {_count(int(flat.sum()), 'face')} of zero area")
    return faces[~flat]


def _drop_repeated_faces(name, vertices, faces, repairs, repair):
    """Drop a face that occurs twice, wound the same way: its area would count twice."""
    start = faces.argmin(axis=1)
    turned = np.take_along_axis(faces, (start[:, None] + np.arange(3)) % 3, axis=1)
    _, first, inverse = np.unique(turned, axis=0, return_index=True, return_inverse=True)
    original = first[inverse.ravel()]
    again = np.flatnonzero(original != np.arange(len(faces)))
    if len(again) == 0:
        return faces
    if not repair:
        raise MeshError(
            f"{name}: face {again[0]} repeats face {original[again[0]]}, and {len(again) - 1} more faces repeat "
            "another; each area would count twice. `meshes.load(path, repair=True)` removes repeated faces"
        )
    repairs.append(f"removed {_count(len(again), 'repeated face')}")
    return np.delete(faces, again, axis=0)


def _neighbours(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of faces that share an edge which no third face has.

    Returns
    -------
    (N, 2) and (N,) ndarray
        The two faces, and whether they are wound alike (run along the edge in opposite directions).
    """
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    forward = edges[:, 0] < edges[:, 1]
    low, high = np.sort(edges, axis=1).T
    order = np.lexsort((high, low))
    new_edge = np.r_[True, (np.diff(low[order]) != 0) | (np.diff(high[order]) != 0), True]
    starts = np.flatnonzero(new_edge)
    pairs = starts[:-1][np.diff(starts) == 2]
    first, second = order[pairs], order[pairs + 1]
    return np.stack([first // 3, second // 3], axis=1), forward[first] != forward[second]


def _wind_alike(name, vertices, faces, repairs, repair):
    pairs, alike = _neighbours(faces)
    if alike.all():
        return faces
    first = pairs[~alike][0]
    if not repair:
        raise MeshError(
            f"{name}: neighbouring faces {first[0]} and {first[1]} are wound in opposite senses, and so are "
            f"{int((~alike).sum()) - 1} more pairs; `meshes.load(path, repair=True)` winds them alike"
        )
    # Two copies of every face, as it is and turned round; neighbours link the copies that agree. A surface that can
    # be wound alike falls apart into two mirrored halves; on a Moebius strip both copies of a face hang together.
    n = len(faces)
    a, b = pairs.T
    rows, columns = np.r_[a, a + n], np.r_[np.where(alike, b, b + n), np.where(alike, b + n, b)]
    links = coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(2 * n, 2 * n))
    label = connected_components(links, directed=False)[1]
    if (label[:n] == label[n:]).any():
        face = int(np.flatnonzero(label[:n] == label[n:])[0])
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


def _turn_outside_out(name, vertices, faces, repairs, repair):
    """Turn closed bodies of negative volume, unless they lie inside another: then they are a hollow in it."""
    pairs, _ = _neighbours(faces)
    links = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(faces), len(faces)))
    n_bodies, body = connected_components(links, directed=False)
    closed = np.bincount(pairs.ravel(), minlength=len(faces)) == 3
    is_closed = np.bincount(body, weights=closed, minlength=n_bodies) == np.bincount(body, minlength=n_bodies)
    corners = vertices[faces]
    # About the middle of the mesh: far from the origin the terms would cancel badly.
    local = corners - 0.5 * (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1)))
    volumes = np.einsum("ij,ij->i", local[:, 0], np.cross(local[:, 1], local[:, 2])) / 6
    volume = np.bincount(body, weights=volumes, minlength=n_bodies)
    inverted = np.zeros(n_bodies, dtype=bool)
    suspects = np.flatnonzero(is_closed & (volume < 0))
    if len(suspects):
        low, high = np.full((n_bodies, 3), np.inf), np.full((n_bodies, 3), -np.inf)
        np.minimum.at(low, body, corners.min(axis=1))
        np.maximum.at(high, body, corners.max(axis=1))
        solid = np.flatnonzero(~is_closed | (volume > 0))
        for suspect in suspects:
            inside = (low[solid] < low[suspect]).all(axis=1) & (high[solid] > high[suspect]).all(axis=1)
            inverted[suspect] = not inside.any()
    if not inverted.any():
        return faces
    worst = int(np.argmin(np.where(inverted, volume, np.inf)))
    if not repair:
        raise MeshError(
            f"{name}: closed, but inside-out (its volume is {volume[worst]:.6g}), so that every face is seen from "
            "behind; `meshes.load(path, repair=True)` turns it outside-out"
        )
    count = int(inverted.sum())
    repairs.append(f"turned {count} {'body' if count == 1 else 'bodies'} outside-out")
    return np.where(inverted[body][:, None], faces[:, ::-1], faces)


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"
