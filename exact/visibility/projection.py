"""The image of a surface in one camera: where its vertices fall, how far away they are, which faces look at it.

Image coordinates are right/depth and down/depth, so the plane through the camera at unit depth; pixels never matter.
On a plane 1/depth is affine in them, which is what decides who is in front of whom.
"""

from dataclasses import dataclass

import numpy as np
import shapely

from exact.cameras import Camera
from exact.visibility.surface import Surface

# Parts of a face nearer than this part of the target distance are cut away: they are in the camera's own housing.
NEAR = 1e-6
# A face seen at a smaller angle than this [rad] is edge-on. Its image has no area and it counts as turned away.
EDGE_ON = 1e-12


@dataclass(frozen=True, eq=False)
class Image:
    """A surface as one camera sees it, before anything hides anything.

    Triangles are the faces that lie in front of the camera, followed by what the near plane leaves of the faces
    that cross it.

    Attributes
    ----------
    x, y, inverse_depth : (P,) float
        Image coordinates and 1/depth [1/mm] of the points; nan for points not in front of the near plane.
    corners : (N, 3) int
        Points of each triangle.
    parent : (N,) int
        The face each triangle is, or is part of.
    is_part : (N,) bool
        Whether the near plane has cut it.
    frame : (N, 3, 2) float or None
        Corners in the face's own coordinates; None if no triangle is a part.
    front : (F,) bool
        Whether each face turns its front towards the camera.
    whole : (F,) int
        Index of the triangle that is this face, -1 if there is none.
    """

    surface: Surface
    camera: Camera
    x: np.ndarray
    y: np.ndarray
    inverse_depth: np.ndarray
    corners: np.ndarray
    parent: np.ndarray
    is_part: np.ndarray
    frame: np.ndarray | None
    front: np.ndarray
    whole: np.ndarray

    def locate(self, face: np.ndarray, inner: np.ndarray):
        """Image coordinates, 1/depth and whether in front of the near plane, of points of faces: four (N,) arrays."""
        local = (self.surface.points(face, inner) - self.camera.position) @ self.camera.rotation.T
        ahead = local[:, 2] > NEAR * self.camera.target_distance
        inverse = np.divide(1.0, local[:, 2], out=np.ones(len(local)), where=ahead)
        return local[:, 0] * inverse, local[:, 1] * inverse, inverse, ahead


def project(surface: Surface, camera: Camera) -> Image:
    """The image of `surface` in `camera`; see `Image`."""
    local = (surface.vertices - camera.position) @ camera.rotation.T
    near = NEAR * camera.target_distance
    ahead = local[:, 2] > near
    faces = surface.faces
    front = _front(surface, camera)
    proper = surface.areas > 0
    if ahead.all():
        in_front, cut = proper, np.zeros(0, dtype=int)
    else:
        n_ahead = ahead[faces].sum(axis=1)
        in_front, cut = proper & (n_ahead == 3), np.flatnonzero(proper & (n_ahead > 0) & (n_ahead < 3))
    parent = np.flatnonzero(in_front)
    whole = np.full(len(faces), -1)
    whole[parent] = np.arange(len(parent))
    corners, is_part, frame = faces[parent], np.zeros(len(parent), dtype=bool), None
    if len(cut):
        points, part_corners, part_parent, part_frame = _clip_near(local, faces, cut, ahead, near)
        corners = np.concatenate([corners, part_corners + len(local)])
        local, ahead = np.concatenate([local, points]), np.concatenate([ahead, np.ones(len(points), dtype=bool)])
        frame = np.concatenate([np.broadcast_to(UNIT_FRAME, (len(parent), 3, 2)), part_frame])
        is_part = np.concatenate([is_part, np.ones(len(part_parent), dtype=bool)])
        parent = np.concatenate([parent, part_parent])
    inverse_depth = np.divide(1.0, local[:, 2], out=np.full(len(local), np.nan), where=ahead)
    return Image(
        surface, camera, local[:, 0] * inverse_depth, local[:, 1] * inverse_depth, inverse_depth,
        corners, parent, is_part, frame, front, whole,
    )  # fmt: skip


def image_polygons(surface: Surface, camera: Camera, face: np.ndarray, polygon: np.ndarray) -> np.ndarray:
    """Polygons given in the coordinates of faces, as they appear in the plane through the target [mm right, mm down].

    They must lie in front of the camera. An image may be degenerate where a face is seen nearly edge-on.
    """
    inner, index = shapely.get_coordinates(polygon, return_index=True)
    local = (surface.points(face[index], inner) - camera.position) @ camera.rotation.T
    image = local[:, :2] / local[:, 2:] * camera.target_distance
    return np.asarray(shapely.set_coordinates(np.array(polygon, dtype=object), image))


UNIT_FRAME = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])


def _front(surface: Surface, camera: Camera) -> np.ndarray:
    """(F,) whether the camera is on the outer side of each face's plane."""
    planes = surface.planes
    away = camera.position - planes.centre
    height = planes.normal @ away - planes.offset
    return height > EDGE_ON * (np.linalg.norm(away) + planes.scale)


def _clip_near(local: np.ndarray, faces: np.ndarray, cut: np.ndarray, ahead: np.ndarray, near: float):
    """Triangles of what lies in front of the near plane of the faces `cut`, which cross it.

    Returns
    -------
    points : (P, 3) float, corners : (N, 3) int into them, parent : (N,) int, frame : (N, 3, 2) float
    """
    points, parents, frames = [], [], []
    for n_ahead in (1, 2):
        chosen = cut[ahead[faces[cut]].sum(axis=1) == n_ahead]
        if not len(chosen):
            continue
        turn, _ = lone_corner_first(ahead[faces[chosen]])
        corner = local[np.take_along_axis(faces[chosen], turn, axis=1)]
        frame = UNIT_FRAME[turn]
        depth = corner[:, :, 2]
        t = ((near - depth[:, :1]) / (depth[:, 1:] - depth[:, :1]))[:, :, None]
        new = corner[:, :1] + t * (corner[:, 1:] - corner[:, :1])
        new_frame = frame[:, :1] + t * (frame[:, 1:] - frame[:, :1])
        if n_ahead == 1:
            pieces = [([corner[:, 0], new[:, 0], new[:, 1]], [frame[:, 0], new_frame[:, 0], new_frame[:, 1]])]
        else:
            pieces = [
                ([new[:, 0], corner[:, 1], corner[:, 2]], [new_frame[:, 0], frame[:, 1], frame[:, 2]]),
                ([new[:, 0], corner[:, 2], new[:, 1]], [new_frame[:, 0], frame[:, 2], new_frame[:, 1]]),
            ]
        for piece, piece_frame in pieces:
            points.append(np.stack(piece, axis=1))
            frames.append(np.stack(piece_frame, axis=1))
            parents.append(chosen)
    points, frame, parent = np.concatenate(points), np.concatenate(frames), np.concatenate(parents)
    return points.reshape(-1, 3), np.arange(3 * len(points)).reshape(-1, 3), parent, frame


def lone_corner_first(side: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Turns of triangles of which one corner is on one side and two are on the other, by which side, (N, 3) bool.

    (N, 3) the corners in order, beginning with the lone one, and (N,) whether that one's side is the true one.
    """
    is_true = side.sum(axis=1) == 1
    lone = np.argmax(side == is_true[:, None], axis=1)
    return (lone[:, None] + np.arange(3)) % 3, is_true
