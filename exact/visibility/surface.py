"""A triangle mesh prepared for many cameras: merged vertices, edges with their faces, curves where faces intersect."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from exact.errors import ExactError
from exact.visibility.intersections import Intersections, Planes, intersecting_faces

if TYPE_CHECKING:
    import trimesh

# A face whose height is below this part of its longest edge has no normal that could be trusted: it counts as area 0.
THINNEST_FACE = 1e-12
# A closed mesh of less volume than this, in parts of that of its cones, has none: a sheet with both its sides.
NO_VOLUME = 1e-12
# Below this angle [rad] an edge counts as flat rather than concave; flat edges keep their silhouettes.
FLAT = 1e-9


@dataclass(frozen=True, eq=False)
class Surface:
    """Arrays of one mesh that no camera changes.

    Attributes
    ----------
    vertices : (V, 3) float
        Distinct corners of faces with area [mm]; vertices of the mesh in the very same place are one. What no such
        face uses may be anywhere, and must not enter a centre, a scale or bounds.
    faces : (F, 3) int
        In the order of the mesh; those without area are three times vertex 0.
    areas : (F,) float
        Area of each face [mm²], 0 for a face without a normal.
    normals : (F, 3) float
        Unit normals, 0 for a face without one.
    edges : (E, 2) int
        The two vertices of each edge between exactly two faces that run along it in opposite directions.
    edge_faces : (E, 2) int
        Its two faces.
    loose_edges : (L, 2) int
        Edges of one face, or of more than two: always silhouettes.
    edge_is_concave : (E,) bool
        Whether the two faces of each edge clearly look at each other.
    loose_edge_faces : (L,) int
        One of the faces of each loose edge.
    shell : (F,) int
        Number of the edge-connected shell each face belongs to.
    closed : bool
        Whether every edge is run along as often forwards as backwards.
    """

    vertices: np.ndarray
    faces: np.ndarray
    areas: np.ndarray
    normals: np.ndarray
    edges: np.ndarray
    edge_faces: np.ndarray
    edge_is_concave: np.ndarray
    loose_edges: np.ndarray
    loose_edge_faces: np.ndarray
    shell: np.ndarray
    closed: bool

    @cached_property
    def intersections(self) -> Intersections:
        """The segments in which faces cut each other, in both faces' own coordinates."""
        return intersecting_faces(self.planes, self.edge_faces)

    @cached_property
    def planes(self) -> Planes:
        """The plane of each face."""
        return Planes.of(self.vertices, self.faces, self.normals)

    @cached_property
    def solid(self) -> bool:
        """Whether the mesh is made of closed shells, each outside out and none cutting itself, but for touching points.

        Then a line of sight from outside passes a front before any back, which saves looking at backs at all.
        """
        own = self.intersections
        corner = self.vertices[self.faces] - self.vertices[0]
        cone = (np.cross(corner[:, 0], corner[:, 1]) * corner[:, 2]).sum(axis=1)
        return bool(
            self.closed
            and (np.bincount(self.shell, weights=cone) >= 0).all()
            and (own.is_point | (self.shell[own.face] != self.shell[own.other])).all()
        )

    @cached_property
    def bounds(self) -> np.ndarray:
        """(2, 3) least and greatest coordinates [mm]."""
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    def part(self, matters: np.ndarray) -> "Part":
        """What is left of it where only some faces matter, (F,) bool: these and their neighbours, with their edges.

        What only depends on the whole, as whether it is solid, is that of the whole.
        """
        inner, loose = matters[self.edge_faces].any(axis=1), matters[self.loose_edge_faces]
        kept = matters.copy()
        kept[self.edge_faces[inner]] = True
        face = np.flatnonzero(kept)
        vertex, faces = _of_used(self.faces[face], len(self.vertices))
        of_face, of_vertex = np.full(len(self.faces), -1), np.full(len(self.vertices), -1)
        of_face[face], of_vertex[vertex] = np.arange(len(face)), np.arange(len(vertex))
        surface = Surface(
            self.vertices[vertex], faces, self.areas[face], self.normals[face],
            of_vertex[self.edges[inner]], of_face[self.edge_faces[inner]], self.edge_is_concave[inner],
            of_vertex[self.loose_edges[loose]], of_face[self.loose_edge_faces[loose]], self.shell[face], self.closed,
        )  # fmt: skip
        own = self.intersections.of(of_face)
        vars(surface).update(
            planes=self.planes.of_faces(face, faces, vertex), intersections=own, solid=self.solid, bounds=self.bounds
        )
        return Part(surface, face, vertex, of_face)

    def points(self, face: np.ndarray, inner: np.ndarray) -> np.ndarray:
        """World points of face coordinates.

        Parameters
        ----------
        face : (N,) int
        inner : (N, 2) float
            Coordinates (b1, b2) in the face: corner0 + b1 (corner1 - corner0) + b2 (corner2 - corner0).

        Returns
        -------
        (N, 3) float [mm]
        """
        corner = self.vertices[self.faces[face]]
        along = inner[:, :1] * (corner[:, 1] - corner[:, 0]) + inner[:, 1:] * (corner[:, 2] - corner[:, 0])
        return corner[:, 0] + along


@dataclass(frozen=True, eq=False)
class Part:
    """A part of a surface, and which faces and vertices of the whole its own are.

    Attributes
    ----------
    surface : Surface
    face : (K,) int
        Ascending.
    vertex : (W,) int
    number : (F,) int
        Of each face of the whole that of the part's own, -1 for others.
    """

    surface: Surface
    face: np.ndarray
    vertex: np.ndarray
    number: np.ndarray


def prepare(mesh: "trimesh.Trimesh") -> Surface:
    """Arrays of `mesh` for the evaluator.

    Raises
    ------
    ExactError
        If `mesh` has a vertex that is not finite or no face with area, has two neighbouring faces of opposite winding,
        or is closed and inside out.
    """
    return _build(np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64))


def _build(points: np.ndarray, faces: np.ndarray) -> Surface:
    if len(faces) == 0:
        raise ExactError("the mesh has no faces; at least one face with area is needed")
    if not np.isfinite(points[faces]).all():
        bad = int(np.flatnonzero(~np.isfinite(points[faces]).all(axis=(1, 2)))[0])
        raise ExactError(f"face {bad} has a vertex that is not finite; remove or mend it first")
    used, faces = _of_used(faces, len(points))
    vertices, first = np.unique(points[used] + 0.0, axis=0, return_inverse=True)
    faces = first.reshape(-1)[faces]
    corner = vertices[faces]
    sides = corner[:, [1, 2, 0]] - corner
    longest_squared = (sides**2).sum(axis=2).max(axis=1)
    normals = np.cross(sides[:, 0], sides[:, 1])
    twice_areas = np.linalg.norm(normals, axis=1)
    has_area = twice_areas > THINNEST_FACE * longest_squared
    areas = np.where(has_area, 0.5 * twice_areas, 0.0)
    normals = np.divide(normals, twice_areas[:, None], out=np.zeros_like(normals), where=has_area[:, None])
    if not areas.any():
        raise ExactError(f"none of the {len(faces)} faces has an area; at least one is needed")
    closed = _is_closed(faces, len(vertices))
    kept, corners = _of_used(faces[areas > 0], len(vertices))
    vertices, faces = vertices[kept], np.zeros_like(faces)
    faces[areas > 0] = corners
    edges, edge_faces, loose, loose_faces = _edges(faces, areas > 0, len(vertices))
    graph = coo_array(
        (np.ones(len(edges), dtype=np.int8), (edge_faces[:, 0], edge_faces[:, 1])), shape=(len(faces),) * 2
    )
    shell = connected_components(graph, directed=False)[1]
    # Relative to the first vertex: the volume of a closed mesh is the same from any point, the rounding is not.
    arm = vertices[faces] - vertices[0]
    cones = (np.cross(arm[:, 0], arm[:, 1]) * arm[:, 2]).sum(axis=1)
    if closed and cones.sum() < -NO_VOLUME * np.abs(cones).sum():
        raise ExactError("the mesh is closed and inside out: all its normals point inwards; meshes.load(path, "
                         "repair=True) turns it, or call mesh.invert()")  # fmt: skip
    concave = _is_concave(vertices, faces, normals, edges, edge_faces)
    return Surface(vertices, faces, areas, normals, edges, edge_faces, concave, loose, loose_faces, shell, closed)


def _of_used(faces: np.ndarray, n_vertices: int) -> tuple[np.ndarray, np.ndarray]:
    """The vertices that faces use, ascending, and the faces by their numbers among these."""
    is_used = np.zeros(n_vertices, dtype=bool)
    is_used[faces] = True
    return np.flatnonzero(is_used), (np.cumsum(is_used) - 1)[faces]


def _is_concave(vertices, faces, normals, edges, edge_faces) -> np.ndarray:
    """(E,) whether the second face of each edge rises clearly above the plane of the first."""
    away = vertices[faces[edge_faces[:, 1]]].mean(axis=1) - vertices[edges[:, 0]]
    rise = (normals[edge_faces[:, 0]] * away).sum(axis=1)
    return rise > FLAT * np.sqrt((away * away).sum(axis=1))


def _half_edges(faces: np.ndarray, n_vertices: int):
    """Start and end vertex of the (3F,) half edges and the key of their undirected edge."""
    start, end = faces.reshape(-1), faces[:, [1, 2, 0]].reshape(-1)
    return start, end, np.minimum(start, end) * n_vertices + np.maximum(start, end)


def _is_closed(faces: np.ndarray, n_vertices: int) -> bool:
    start, end, key = _half_edges(faces, n_vertices)
    _, edge = np.unique(key, return_inverse=True)
    balance = np.bincount(edge, weights=np.sign(end - start))
    return not balance.any()


def _edges(faces: np.ndarray, has_area: np.ndarray, n_vertices: int):
    """Edges between exactly two faces with these faces, and all other edges with one face each."""
    kept = np.flatnonzero(has_area)
    start, end, key = _half_edges(faces[kept], n_vertices)
    face = np.repeat(kept, 3)
    order = np.argsort(key, kind="stable")
    start, end, key, face = start[order], end[order], key[order], face[order]
    first = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]]))
    count = np.diff(np.append(first, len(key)))
    pair = first[count == 2]
    same_way = start[pair] == start[pair + 1]
    corners = np.sort(faces, axis=1)
    duplicate = (corners[face[pair]] == corners[face[pair + 1]]).all(axis=1)
    if (same_way & ~duplicate).any():
        bad = pair[np.flatnonzero(same_way & ~duplicate)[0]]
        raise ExactError(
            f"faces {face[bad]} and {face[bad + 1]} run along their common edge in the same direction: the mesh has "
            "mixed winding, so front and back cannot be told; meshes.load(path, repair=True) mends it"
        )
    is_edge = count == 2
    is_edge[is_edge] = ~same_way
    pair = pair[~same_way]
    is_loose = np.repeat(~is_edge, count)
    edges = np.stack([start[pair], end[pair]], axis=1)
    loose = np.stack([start[is_loose], end[is_loose]], axis=1)
    return edges, np.stack([face[pair], face[pair + 1]], axis=1), loose, face[is_loose]
