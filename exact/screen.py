"""What can hide something inside one camera's field of view, in a form that is fast to search."""

from dataclasses import dataclass

import numpy as np
import shapely

from exact.projection import Image

# Two faces that differ less in depth (relatively) may be in the same plane, which is then looked into.
SAME_DEPTH = 1e-7
# An image triangle thinner than this part of its longest side is a line: it hides nothing and is not seen.
THINNEST_IMAGE = 1e-14
# Slack with which a point on the common edge of two faces belongs to both (in parts of the face).
ON_EDGE = 1e-12
# Cells along either side of the grid that finds what is near the active faces.
CELLS = 256


@dataclass(frozen=True, eq=False)
class Screen:
    """The triangles of an image that can hide something and whose boxes meet the field of view.

    Attributes
    ----------
    image : Image
    triangle : (N,) int
        Which triangles of the image.
    parent : (N,) int
        Their faces.
    x, y, inverse_depth : (N, 3) float
        Their corners.
    nearest, farthest : (N,) float
        Greatest and least 1/depth of each.
    tree : shapely.STRtree
        Of their boxes.
    face_distance : (F,) float or None
        Distance of each face's nearest vertex from the camera [mm], if the nearer face by this distance is to hide
        the other wherever they overlap; None to compare depths at the point itself.
    """

    image: Image
    triangle: np.ndarray
    parent: np.ndarray
    x: np.ndarray
    y: np.ndarray
    inverse_depth: np.ndarray
    nearest: np.ndarray
    farthest: np.ndarray
    tree: shapely.STRtree
    face_distance: np.ndarray | None

    @classmethod
    def of(cls, image: Image, active: np.ndarray, depth_order: str) -> "Screen":
        """The screen of an image, as far as it is needed to look at the `active` faces, (F,) bool."""
        candidate = np.flatnonzero(hides(image)[image.parent])
        corner = image.corners[candidate]
        x, y = image.x[corner], image.y[corner]
        box = least(x), least(y), greatest(x), greatest(y)
        inside = _near(box, (active & image.front)[image.parent[candidate]], image.camera.half_extent)
        candidate, corner, x, y = candidate[inside], corner[inside], x[inside], y[inside]
        box = tuple(side[inside] for side in box)
        side_x, side_y = x[:, 1:] - x[:, :1], y[:, 1:] - y[:, :1]
        twice_area = np.abs(side_x[:, 0] * side_y[:, 1] - side_y[:, 0] * side_x[:, 1])
        longest = np.maximum(box[2] - box[0], box[3] - box[1])
        solid = twice_area > THINNEST_IMAGE * longest**2
        triangle = candidate[solid]
        inverse_depth = image.inverse_depth[corner[solid]]
        # A diagonal has the box's envelope, which is all the tree looks at, and is made in less time than the box.
        left, low, right, high = (side[solid] for side in box)
        diagonals = shapely.linestrings(np.stack([left, right], axis=1), np.stack([low, high], axis=1))
        tree = shapely.STRtree(np.asarray(diagonals))
        face_distance = None
        if depth_order == "vertex":
            surface = image.surface
            distance = np.linalg.norm(surface.vertices - image.camera.position, axis=1)
            face_distance = distance[surface.faces].min(axis=1)
        return cls(
            image, triangle, image.parent[triangle], x[solid], y[solid], inverse_depth,
            greatest(inverse_depth), least(inverse_depth), tree, face_distance,
        )  # fmt: skip

    def sees(self, face: np.ndarray, inner: np.ndarray) -> np.ndarray:
        """(N,) whether the camera sees the point with coordinates `inner` (N, 2) of each `face` (N,).

        Seen means: the face turns its front to the camera, the point is ahead of the near plane, inside the field of
        view, and no triangle is in front of it.
        """
        image = self.image
        x, y, inverse_depth, ahead = image.locate(face, inner)
        half_x, half_y = image.camera.half_extent
        seen = ahead & image.front[face] & (np.abs(x) <= half_x) & (np.abs(y) <= half_y)
        asked = np.flatnonzero(seen)
        point, found = self.tree.query(shapely.points(x[asked], y[asked]))
        point = asked[point]
        if self.face_distance is not None:
            nearer = self.face_distance[self.parent[found]] < self.face_distance[face[point]]
            point, found = point[nearer], found[nearer]
            hidden = least(self._weights(found, x[point], y[point])) >= -ON_EDGE
        else:
            near_enough = (self.nearest[found] > inverse_depth[point]) & (self.parent[found] != face[point])
            point, found = point[near_enough], found[near_enough]
            weight = self._weights(found, x[point], y[point])
            lead = (weight * self.inverse_depth[found]).sum(axis=1) / inverse_depth[point] - 1
            hidden = (least(weight) >= -ON_EDGE) & (lead > 0)
            # Faces in one plane do not hide each other, whichever way rounding goes.
            close = np.flatnonzero(hidden & (lead < SAME_DEPTH))
            hidden[close] = ~image.surface.planes.coincide(self.parent[found[close]], face[point[close]])
        seen[point[hidden]] = False
        return seen

    def _weights(self, found: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return barycentric(self.x[found], self.y[found], x, y)


def _near(box: tuple, active: np.ndarray, half_extent: np.ndarray) -> np.ndarray:
    """Which boxes (left, low, right, high, each (N,)) meet the field of view and a cell that an active one meets.

    The cells are those of a coarse grid over the field of view. Late in a long row of cameras few faces are active,
    and most of what could hide something has nothing left to hide.
    """
    cell = [
        np.floor((side + half_extent[k % 2]) / (2 * half_extent[k % 2]) * CELLS).clip(-1, CELLS).astype(int)
        for k, side in enumerate(box)
    ]
    inside = (cell[2] >= 0) & (cell[3] >= 0) & (cell[0] <= CELLS) & (cell[1] <= CELLS)
    inside &= (box[0] <= half_extent[0]) & (box[1] <= half_extent[1])
    left, low, right, high = (side.clip(0, CELLS - 1) for side in cell)
    asked = active & inside
    # Mark all cells of each active box by its corners, sum up to have the marks, sum again to count them in any box.
    marks = np.zeros((CELLS + 1, CELLS + 1), dtype=int)
    np.add.at(marks, (left[asked], low[asked]), 1)
    np.add.at(marks, (right[asked] + 1, low[asked]), -1)
    np.add.at(marks, (left[asked], high[asked] + 1), -1)
    np.add.at(marks, (right[asked] + 1, high[asked] + 1), 1)
    marked = marks.cumsum(axis=0).cumsum(axis=1)[:CELLS, :CELLS] > 0
    count = np.zeros((CELLS + 1, CELLS + 1), dtype=int)
    count[1:, 1:] = marked.cumsum(axis=0).cumsum(axis=1)
    met = count[right + 1, high + 1] - count[left, high + 1] - count[right + 1, low] + count[left, low]
    return inside & (met > 0)


def seen_from_outside(image: Image) -> bool:
    """Whether the camera looks at solids from outside, so that each line of sight enters them through a front."""
    low, high = image.surface.bounds
    position = image.camera.position
    return bool(((position < low) | (position > high)).any()) and image.surface.solid


def hides(image: Image) -> np.ndarray:
    """(F,) whether a face can hide another: of solids seen from outside the fronts, else all faces."""
    return image.front if seen_from_outside(image) else np.ones_like(image.front)


def least(columns: np.ndarray) -> np.ndarray:
    """(N,) least of the three numbers in each row of (N, 3); numpy's own is slow along so short an axis."""
    return np.minimum(np.minimum(columns[:, 0], columns[:, 1]), columns[:, 2])


def greatest(columns: np.ndarray) -> np.ndarray:
    """(N,) greatest of the three numbers in each row of (N, 3)."""
    return np.maximum(np.maximum(columns[:, 0], columns[:, 1]), columns[:, 2])


def barycentric(x: np.ndarray, y: np.ndarray, at_x: np.ndarray, at_y: np.ndarray) -> np.ndarray:
    """(N, 3) barycentric coordinates of image points in triangles with corners x, y (N, 3); exact at the corners."""
    x0, x1, x2 = x[:, 0] - at_x, x[:, 1] - at_x, x[:, 2] - at_x
    y0, y1, y2 = y[:, 0] - at_y, y[:, 1] - at_y, y[:, 2] - at_y
    twice_area = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (y[:, 1] - y[:, 0]) * (x[:, 2] - x[:, 0])
    weight = np.empty((len(x), 3))
    weight[:, 0] = (x1 * y2 - y1 * x2) / twice_area
    weight[:, 1] = (x2 * y0 - y2 * x0) / twice_area
    weight[:, 2] = (x0 * y1 - y0 * x1) / twice_area
    return weight
