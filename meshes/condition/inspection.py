"""All about a mesh that matters to an area on it: size, unit, bodies, winding, defects, which way it opens."""

from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from meshes.condition.bodies import inside_out
from meshes.condition.check import check
from meshes.condition.facing import facing
from meshes.condition.mending import mended
from meshes.condition.neighbours import bodies
from meshes.condition.opening import opening
from meshes.condition.overlapping import overlapping, words
from meshes.condition.winding import halves
from meshes.errors import MeshError


@dataclass(frozen=True)
class Inspection:
    """What there is to know of a mesh before cameras look at it.

    Attributes
    ----------
    n_faces, n_vertices : int
        Triangles and their vertices, those in one place counted once.
    n_file_faces : int
        Faces of the file; a polygon is one.
    bounds : ((float, float, float), (float, float, float))
        Least and greatest coordinates [mm].
    area : float
        [mm²]
    watertight : bool
        Whether each edge has two faces.
    n_bodies, n_closed : int
        Bodies that hang together by edges, and how many of them are closed.
    n_border_edges, n_crowded_edges : int
        Edges of one face, and of more than two.
    n_mixed : int
        Pairs of neighbours that are wound in opposite senses.
    one_sided : bool
        Whether a body cannot be wound alike.
    n_inside_out : int
        Closed bodies that are inside-out; 0 where winding is mixed.
    n_overlapping : int
        Faces that lie on top of others that look the same way, and have other corners.
    overlapping : str
        How many they are, one of them, where it is, and what that means; empty without any.
    opening : (float, float, float) or None
        Direction in which it opens: from where most of its hollows is seen, or, if it has none, most of its front; None
        for a convex body.
    back_share : float or None
        How much of what is seen from the cameras is its back; None without cameras.
    notes : tuple of str
        What was odd about the file, and what is mended without being asked.
    repairs : tuple of str
        What a repair does.
    refused : str
        Why the mesh is refused without a repair; empty if it is not.
    """

    n_faces: int
    n_vertices: int
    n_file_faces: int
    bounds: tuple[tuple[float, ...], tuple[float, ...]]
    area: float
    watertight: bool
    n_bodies: int
    n_closed: int
    n_border_edges: int
    n_crowded_edges: int
    n_mixed: int
    one_sided: bool
    n_inside_out: int
    n_overlapping: int
    overlapping: str
    opening: tuple[float, ...] | None
    back_share: float | None
    notes: tuple[str, ...]
    repairs: tuple[str, ...]
    refused: str

    @property
    def extents(self) -> tuple[float, ...]:
        """Its sides [mm]."""
        low, high = self.bounds
        return tuple(b - a for a, b in zip(low, high, strict=True))


def inspect(mesh: trimesh.Trimesh, name: str = "mesh", *, seen_from: ArrayLike | None = None) -> Inspection:
    """What there is to know of a mesh, whether it can be used or not.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        As `meshes.read` gives it; left as it is.
    name : str
        What to call it in messages.
    seen_from : (N, 3) array_like, optional
        Places of cameras [mm], as for `meshes.check`.

    Raises
    ------
    MeshError
        If it has no face with area, or coordinates that are no lengths.

    Examples
    --------
    >>> found = inspect(trimesh.creation.box((10, 20, 30)))
    >>> found.extents, found.watertight, found.n_bodies, found.opening, found.repairs
    ((10.0, 20.0, 30.0), True, 1, None, ())
    """
    repaired, repairs, refused = None, (), ""
    for repair in (False, True):
        try:
            repaired = check(mesh.copy(), repair, name, seen_from=seen_from)
            repairs = tuple(repaired.metadata["repairs"])
        except MeshError as error:
            if not repair:
                refused = str(error)
            elif refused:
                refused = f"{refused}; and a repair is refused too: {error}"
    found = mended(mesh, name)
    vertices, faces = found.vertices, found.faces
    pairs, alike, body, closed = bodies(faces)
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, count = np.unique(edges, axis=0, return_counts=True)
    used = vertices[np.unique(faces)]
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    on_top = overlapping(vertices, faces)
    usable = mesh if repaired is None else repaired
    return Inspection(
        n_faces=len(faces),
        n_vertices=len(used),
        n_file_faces=found.n_in_file,
        bounds=(tuple(used.min(axis=0).tolist()), tuple(used.max(axis=0).tolist())),
        area=float(0.5 * np.linalg.norm(normals, axis=1).sum()),
        watertight=bool((count == 2).all()),
        n_bodies=len(closed),
        n_closed=int(closed.sum()),
        n_border_edges=int((count == 1).sum()),
        n_crowded_edges=int((count > 2).sum()),
        n_mixed=int((~alike).sum()),
        one_sided=bool(halves(faces, pairs, alike)[2].any()),
        n_inside_out=int(inside_out(vertices, faces)[2].sum()) if alike.all() else 0,
        n_overlapping=len(on_top.pairs),
        overlapping=words(on_top, found.number) or "",
        opening=opening(np.asarray(usable.vertices), np.asarray(usable.faces)),
        back_share=None if seen_from is None else facing(vertices, faces, body, np.asarray(seen_from)).back_share,
        notes=tuple(found.notes),
        repairs=repairs,
        refused=refused,
    )
