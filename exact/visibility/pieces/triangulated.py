"""Whole faces and pieces of faces as meshes and polygons in space."""

from typing import TYPE_CHECKING

import numpy as np
import shapely

if TYPE_CHECKING:
    import trimesh


def triangulated(
    mesh: "trimesh.Trimesh", whole: np.ndarray, piece_face: np.ndarray, piece: np.ndarray
) -> "tuple[trimesh.Trimesh, np.ndarray]":
    """The faces `whole` and the pieces, given in the coordinates of their faces, as one mesh.

    Also, for each of the triangles that follow the whole faces, which piece it is from.
    """
    import trimesh

    piece_of, inner = triangles_in(piece)
    parent = piece_face[piece_of]
    turned = np.cross(_as_3d(inner[:, 1] - inner[:, 0]), _as_3d(inner[:, 2] - inner[:, 0]))[:, 2] < 0
    inner[turned] = inner[turned, ::-1]
    corner = np.asarray(mesh.triangles)[parent]
    one, two = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    points = corner[:, None, 0] + inner[:, :, :1] * one[:, None] + inner[:, :, 1:] * two[:, None]
    used, faces = np.unique(mesh.faces[whole], return_inverse=True)
    vertices = np.concatenate([np.asarray(mesh.vertices)[used], points.reshape(-1, 3)])
    faces = np.concatenate([faces.reshape(-1, 3), len(used) + np.arange(3 * len(points)).reshape(-1, 3)])
    result = trimesh.Trimesh(vertices, faces, process=False)
    result.face_attributes["parent"] = np.concatenate([whole, parent])
    return result, piece_of


def triangles_in(polygon: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles of polygons and multipolygons (P,): which each is from, (N,), and its corners, (N, 3, 2)."""
    parts, owner = shapely.get_parts(polygon, return_index=True)
    collections = shapely.constrained_delaunay_triangles(parts) if len(parts) else parts
    corner, part = shapely.get_coordinates(collections, return_index=True)
    return owner[part[::4]], corner.reshape(-1, 4, 2)[:, :3]


def in_space(mesh, face: np.ndarray, polygon: np.ndarray) -> np.ndarray:
    """Polygons in the coordinates of their faces as polygons with x, y and z."""
    inner, index = shapely.get_coordinates(polygon, return_index=True)
    corner = np.asarray(mesh.triangles)[face[index]]
    points = corner[:, 0] + inner[:, :1] * (corner[:, 1] - corner[:, 0]) + inner[:, 1:] * (corner[:, 2] - corner[:, 0])
    return np.asarray(shapely.set_coordinates(np.array(shapely.force_3d(polygon), dtype=object), points))


def _as_3d(flat: np.ndarray) -> np.ndarray:
    return np.concatenate([flat, np.zeros((*flat.shape[:-1], 1))], axis=-1)
