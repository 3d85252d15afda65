"""What can hide something inside one camera's field of view, in a form that is fast to search."""

from dataclasses import dataclass

import numpy as np

from exact.visibility.projection import Image

# Two faces that differ less in depth (relatively) may be in the same plane, which is then looked into.
SAME_DEPTH = 1e-7
# An image triangle thinner than this part of its longest side is a line: it hides nothing and is not seen.
THINNEST_IMAGE = 1e-14
# Slack with which a point on the common edge of two faces belongs to both (in parts of the face).
ON_EDGE = 1e-12
# Cells along either side of the grid that finds what is near the active faces.
CELLS = 128
# A window narrower than this (in image coordinates of order 1) is one cell wide.
NARROWEST_WINDOW = 1e-15


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
    cells : (4, N) int
        Left, low, right and high cell of `grid` that the box of each triangle reaches.
    grid : Grid
        Over the part of the field of view where something is asked about.
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
    cells: np.ndarray
    grid: "Grid"
    face_distance: np.ndarray | None

    @classmethod
    def of(cls, image: Image, active: np.ndarray, depth_order: str) -> "Screen":
        """The screen of an image, as far as it is needed to look at the `active` faces, (F,) bool."""
        candidate = np.flatnonzero(hides(image)[image.parent])
        corner = image.corners[candidate]
        x, y = image.x[corner], image.y[corner]
        box = np.stack([least(x), least(y), greatest(x), greatest(y)])
        asked = (active & image.front)[image.parent[candidate]] & in_window(box, -image.camera.half_extent)
        grid = Grid.over(box[:, asked], image.camera.half_extent)
        near = np.flatnonzero(in_window(box, grid.low, grid.high))
        cells = grid.cells_of(box[:, near])
        # Late in a long row of cameras few faces are active, and most of what could hide has nothing left to hide.
        met = grid.meets(grid.marked(cells[:, asked[near]]), cells)
        near, cells = near[met], cells[:, met]
        candidate, corner, x, y, box = candidate[near], corner[near], x[near], y[near], box[:, near]
        side_x, side_y = x[:, 1:] - x[:, :1], y[:, 1:] - y[:, :1]
        twice_area = np.abs(side_x[:, 0] * side_y[:, 1] - side_y[:, 0] * side_x[:, 1])
        longest = np.maximum(box[2] - box[0], box[3] - box[1])
        kept = twice_area > THINNEST_IMAGE * longest**2
        triangle, inverse_depth = candidate[kept], image.inverse_depth[corner[kept]]
        face_distance = None
        if depth_order == "vertex":
            surface = image.surface
            distance = np.linalg.norm(surface.vertices - image.camera.position, axis=1)
            face_distance = distance[surface.faces].min(axis=1)
        return cls(
            image, triangle, image.parent[triangle], x[kept], y[kept], inverse_depth,
            greatest(inverse_depth), least(inverse_depth), cells[:, kept], grid, face_distance,
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
        point, found = self._boxes_around(x[asked], y[asked])
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

    def _boxes_around(self, x: np.ndarray, y: np.ndarray):
        """Pairs of a point and a triangle whose box may contain it."""
        column, row = self.grid.cell(x, 0), self.grid.cell(y, 1)
        key = column * CELLS + row
        order = np.argsort(key, kind="stable")
        key = key[order]
        marks = np.zeros((CELLS, CELLS), dtype=bool)
        marks[column, row] = True
        triangle = np.flatnonzero(self.grid.meets(marks, self.cells))
        left, low, right, high = self.cells[:, triangle]
        # The points in one column of a triangle's cells follow each other.
        width = right - left + 1
        which = np.repeat(np.arange(len(triangle)), width)
        column = left[which] + counting(width)
        first = np.searchsorted(key, column * CELLS + low[which], "left")
        count = np.searchsorted(key, column * CELLS + high[which], "right") - first
        return order[np.repeat(first, count) + counting(count)], triangle[np.repeat(which, count)]

    def _weights(self, found: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return barycentric(self.x[found], self.y[found], x, y)


@dataclass(frozen=True, eq=False)
class Grid:
    """`CELLS` x `CELLS` cells over a window of the image, to find boxes and points that are near each other.

    Attributes
    ----------
    low, high : (2,) float
        Corners of the window.
    """

    low: np.ndarray
    high: np.ndarray

    @classmethod
    def over(cls, box: np.ndarray, half_extent: np.ndarray) -> "Grid":
        """The grid over all boxes (left, low, right, high; (4, N)), as far as they lie in the field of view."""
        if box.shape[1] == 0:
            return cls(np.zeros(2), np.zeros(2))
        return cls(np.maximum(box[:2].min(axis=1), -half_extent), np.minimum(box[2:].max(axis=1), half_extent))

    def cell(self, coordinate: np.ndarray, axis: int) -> np.ndarray:
        """Column (axis 0) or row (axis 1) of the cell that holds each coordinate; the outer cells reach outwards."""
        size = self.high[axis] - self.low[axis]
        scale = CELLS / size if size > NARROWEST_WINDOW else 0.0
        return np.clip((coordinate - self.low[axis]) * scale, 0, CELLS - 1).astype(np.int64)

    def cells_of(self, box: np.ndarray) -> np.ndarray:
        """(4, N) cells that boxes (4, N) reach: left, low, right, high."""
        return np.stack([self.cell(side, k % 2) for k, side in enumerate(box)])

    def marked(self, cells: np.ndarray) -> np.ndarray:
        """(CELLS, CELLS) bool: the cells that some box reaches."""
        left, low, right, high = cells
        # Marks at the corners of each box, summed up along both axes, are the number of boxes over each cell.
        corners = np.zeros((CELLS + 1, CELLS + 1), dtype=np.int32)
        np.add.at(corners, (left, low), 1)
        np.add.at(corners, (right + 1, low), -1)
        np.add.at(corners, (left, high + 1), -1)
        np.add.at(corners, (right + 1, high + 1), 1)
        return corners.cumsum(axis=0).cumsum(axis=1)[:CELLS, :CELLS] > 0

    def meets(self, marks: np.ndarray, cells: np.ndarray) -> np.ndarray:
        """(N,) whether boxes that reach these `cells` (4, N) reach one of the marked ones."""
        left, low, right, high = cells
        total = np.zeros((CELLS + 1, CELLS + 1), dtype=np.int32)
        total[1:, 1:] = marks.cumsum(axis=0, dtype=np.int32).cumsum(axis=1)
        return total[right + 1, high + 1] - total[left, high + 1] - total[right + 1, low] + total[left, low] > 0


def counting(count: np.ndarray) -> np.ndarray:
    """0, 1, .. count[0] - 1, 0, 1, .. count[1] - 1, and so on."""
    return np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)


def in_window(box: np.ndarray, low: np.ndarray, high: np.ndarray | None = None) -> np.ndarray:
    """(N,) whether boxes (left, low, right, high; (4, N)) meet a window, by default symmetric about the origin."""
    high = -low if high is None else high
    return (box[0] <= high[0]) & (box[1] <= high[1]) & (box[2] >= low[0]) & (box[3] >= low[1])


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
