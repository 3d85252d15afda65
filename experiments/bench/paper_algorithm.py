"""The algorithm of Wachter 2021, section 2.3, written plainly from the paper's text, to measure `exact` against.

One polygon operation for each pair of faces in the image, and for T = 2 the union over all pairs of cameras of what
both see. Faces are ordered by their nearest vertex. Nothing here is used for results.
"""

from collections.abc import Sequence
from itertools import combinations
from typing import Any

import numpy as np
import shapely
import trimesh

import exact


def t_view_area(scene: exact.Scene, cameras: Sequence[exact.Camera], demand: exact.Demand) -> float:
    """Area [mm²] that as many of the `cameras` see as the demand's threshold has it, by the paper's rules.

    Examples
    --------
    >>> ring, box = exact.Ring(), exact.Scene(trimesh.creation.box((10, 10, 10)))
    >>> cameras = ring.cameras(ring.equidistant(3))
    >>> difference = t_view_area(box, cameras, exact.Demand()) - exact.evaluate(box, cameras).area
    >>> abs(difference) < 1e-9
    True
    """
    views = [_visible_polygons(scene.mesh, camera) for camera in cameras]
    total = 0.0
    for face in np.flatnonzero(scene.counted).tolist():
        seen = [view[face] for view in views if face in view]
        common = []
        for some in combinations(seen, demand.threshold):
            polygon = some[0]
            for other in some[1:]:
                polygon = polygon.intersection(other)
            common.append(polygon)
        if common:
            total += shapely.union_all(common).area
    return total


def _visible_polygons(mesh: trimesh.Trimesh, camera: exact.Camera) -> dict[int, Any]:
    """What the camera sees of each face that it sees at all, in plane coordinates of the face [mm]."""
    triangles = np.asarray(mesh.triangles)
    facing = ((camera.position - triangles[:, 0]) * mesh.face_normals).sum(axis=1) > 0
    local = (triangles - camera.position) @ camera.rotation.T
    image = local[:, :, :2] / local[:, :, 2:] * camera.target_distance
    nearest = np.linalg.norm(local, axis=2).min(axis=1)
    window = shapely.box(*(-camera.fov / 2), *(camera.fov / 2))
    polygons = np.asarray(shapely.polygons(image))
    chosen = [face for face in np.flatnonzero(facing).tolist() if polygons[face].intersects(window)]
    seen = {}
    for face in chosen:
        visible = polygons[face].intersection(window)
        for other in chosen:
            if nearest[other] < nearest[face] and polygons[other].intersects(visible):
                visible = visible.difference(polygons[other])
        if visible.area > 0:
            seen[face] = shapely.transform(visible, lambda xy, face=face: _onto_face(xy, face, mesh, camera))
    return seen


def _onto_face(image: np.ndarray, face: int, mesh: trimesh.Trimesh, camera: exact.Camera) -> np.ndarray:
    """Image points [mm] back onto the plane of a face, in coordinates of that plane [mm]."""
    corner, normal = np.asarray(mesh.triangles[face]), mesh.face_normals[face]
    rays = np.concatenate([image, np.full((len(image), 1), camera.target_distance)], axis=1) @ camera.rotation
    depth = ((corner[0] - camera.position) @ normal) / (rays @ normal)
    points = camera.position + depth[:, None] * rays - corner[0]
    along = (corner[1] - corner[0]) / np.linalg.norm(corner[1] - corner[0])
    return np.stack([points @ along, points @ np.cross(normal, along)], axis=1)
