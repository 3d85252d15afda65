"""What can hide something inside one camera's field of view, in a form that is fast to search."""

from dataclasses import dataclass

import numpy as np

from exact.visibility.grid import Grid, counting, greatest, in_window, least
from exact.visibility.projection import Image
from exact.visibility.sight_depth import SAME_DEPTH, Depths, blocks, cell_centres_in, sight_depth

# An image triangle thinner than this part of its longest side is a line: it hides nothing and is not seen.
THINNEST_IMAGE = 1e-14
# Images smaller than this are points.
SMALLEST_IMAGE = 1e-150
# Slack with which a point on the common edge of two faces belongs to both (in parts of the face).
ON_EDGE = 1e-12
# Pairs of a point and a triangle near it that are looked at in one go: few enough for caches, many enough for numpy.
PAIRS = 250_000
# Where fewer than one in so many are asked about, it is worth finding out which cells these really touch.
FEW_ASKED = 4


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
    shape : (N,) float
        Twice the area of each over the square of its longest side: how thick it is.
    marks : (n, n) bool
        Cells of the grid in which something is asked about.
    first, near : (n * n + 1,) int, (P,) int
        Triangles that touch each of those cells and can be seen there: near[first[cell] : first[cell + 1]].
    limit : (n * n,) int
        What is farther away than this in a cell is hidden there; see `sight_depth`.
    depths : Depths
        How depths are counted in `limit`.
    rims : (S, 2) int
        End points of the edges where a sheet of what can hide ends or folds back in the image.
    first_rim, near_rims : (n * n + 1,) int, (Q,) int
        Those that touch each cell and can be seen there.
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
    shape: np.ndarray
    marks: np.ndarray
    first: np.ndarray
    near: np.ndarray
    limit: np.ndarray
    depths: Depths
    rims: np.ndarray
    first_rim: np.ndarray
    near_rims: np.ndarray
    grid: Grid
    face_distance: np.ndarray | None

    @classmethod
    def of(cls, image: Image, active: np.ndarray, depth_order: str) -> "Screen":
        """The screen of an image, as far as it is needed to look at the `active` faces, (F,) bool."""
        candidate = np.flatnonzero(hides(image)[image.parent])
        corner = image.corners[candidate]
        x, y = image.x[corner], image.y[corner]
        box = np.stack([least(x), least(y), greatest(x), greatest(y)])
        twice_area = np.abs(twice_areas(x, y))
        asked = (active & image.front)[image.parent[candidate]] & in_window(box, -image.camera.half_extent)
        grid = Grid.over(box[:, asked], image.camera.half_extent, box, twice_area / 2)
        near = np.flatnonzero(in_window(box, grid.low, grid.high))
        cells = grid.boxes(box[:, near])
        # Late in a long row of cameras few faces are active, and most of what could hide has nothing left to hide.
        marks = grid.marked(cells[:, asked[near]])
        if FEW_ASKED * asked.sum() < len(asked):
            _, cell = grid.touched(x[asked], y[asked], marks)
            marks = np.zeros_like(marks)
            marks.reshape(-1)[cell] = True
        near = near[grid.meets(marks, cells)]
        candidate, corner, x, y, box, twice_area = (
            candidate[near], corner[near], x[near], y[near], box[:, near], twice_area[near],
        )  # fmt: skip
        inverse_depth = image.inverse_depth[corner]
        shape = twice_area / np.maximum(np.maximum(box[2] - box[0], box[3] - box[1]), SMALLEST_IMAGE) ** 2
        nearest, farthest = greatest(inverse_depth), least(inverse_depth)
        owner, cell = grid.touched(x, y, marks)
        face_distance, depths = None, Depths.between(farthest, nearest)
        if depth_order == "vertex":
            surface = image.surface
            distance = np.linalg.norm(surface.vertices - image.camera.position, axis=1)
            face_distance = distance[surface.faces].min(axis=1)
            limit = np.zeros(grid.n_cells, dtype=np.int64)
            ends, rim, rim_cell = np.zeros((0, 2), dtype=int), np.zeros(0, dtype=int), np.zeros(0, dtype=int)
        else:
            ends = rims(image)
            rim, rim_cell = grid.touched(image.x[ends], image.y[ends], marks)
            rim_depth = image.inverse_depth[ends]
            rim_steps = depths.near(greatest(rim_depth))
            steps = depths.near(nearest)
            limit = sight_depth(
                grid.n_cells,
                (cell, steps[owner], depths.far(farthest)[owner]),
                cell_centres_in(grid, owner, cell, x, y, shape),
                (rim_cell, rim_steps[rim], depths.far(least(rim_depth))[rim]),
            )
            seen = steps[owner] >= limit[cell]
            owner, cell = owner[seen], cell[seen]
            seen = rim_steps[rim] >= limit[rim_cell]
            rim, rim_cell = rim[seen], rim_cell[seen]
        thick = shape > THINNEST_IMAGE
        kept = np.zeros(len(candidate), dtype=bool)
        kept[owner] = True
        kept &= thick
        listed = kept[owner]
        owner, cell = (np.cumsum(kept) - 1)[owner[listed]], cell[listed]
        triangle = candidate[kept]
        return cls(
            image, triangle, image.parent[triangle], x[kept], y[kept], inverse_depth[kept], nearest[kept],
            farthest[kept], shape[kept], marks, *grid.listed(owner, cell), limit, depths, ends,
            *grid.listed(rim, rim_cell), grid, face_distance,
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
        cell = self.grid.cell(x[asked], y[asked])
        order = np.argsort(cell, kind="stable")
        asked, cell = asked[order], cell[order]
        count = self.first[cell + 1] - self.first[cell]
        for low, high in blocks(count, PAIRS):
            point = np.repeat(asked[low:high], count[low:high])
            found = self.near[np.repeat(self.first[cell[low:high]], count[low:high]) + counting(count[low:high])]
            seen[self._hidden(point, found, face, x, y, inverse_depth)] = False
        return seen

    def _hidden(self, point, found, face, x, y, inverse_depth) -> np.ndarray:
        """Those of the points that a triangle hides that stands with them in `point`, `found`: (P,) int."""
        if self.face_distance is not None:
            nearer = self.face_distance[self.parent[found]] < self.face_distance[face[point]]
            point, found = point[nearer], found[nearer]
            return point[least(self._weights(found, x[point], y[point])) >= -ON_EDGE]
        near_enough = (self.nearest[found] > inverse_depth[point]) & (self.parent[found] != face[point])
        point, found = point[near_enough], found[near_enough]
        weight = self._weights(found, x[point], y[point])
        lead = (weight * self.inverse_depth[found]).sum(axis=1) / inverse_depth[point] - 1
        hidden = (least(weight) >= -ON_EDGE) & (lead > 0)
        # Faces in one plane do not hide each other, whichever way rounding goes.
        close = np.flatnonzero(hidden & (lead < SAME_DEPTH))
        hidden[close] = ~self.image.surface.planes.coincide(self.parent[found[close]], face[point[close]])
        return point[hidden]

    def _weights(self, found: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return barycentric(self.x[found], self.y[found], x, y)


def seen_from_outside(image: Image) -> bool:
    """Whether the camera looks at solids from outside, so that each line of sight enters them through a front."""
    low, high = image.surface.bounds
    position = image.camera.position
    return bool(((position < low) | (position > high)).any()) and image.surface.solid


def hides(image: Image) -> np.ndarray:
    """(F,) whether a face can hide another: of solids seen from outside the fronts, else all faces."""
    return image.front if seen_from_outside(image) else np.ones_like(image.front)


def rims(image: Image, concave: bool = True) -> np.ndarray:
    """(S, 2) end points of the edges where the image of a sheet of what can hide ends, or folds back.

    With or without those between a front and a back that clearly look at each other.
    """
    surface = image.surface
    ahead = np.isfinite(image.x)
    state = np.where(image.whole >= 0, image.front, 2).astype(np.int8)
    between = state[surface.edge_faces[:, 0]] != state[surface.edge_faces[:, 1]]
    if not concave:
        between &= ~surface.edge_is_concave
    loose = hides(image)[surface.loose_edge_faces]
    edges = np.concatenate([surface.edges[between], surface.loose_edges[loose]])
    edges = edges[ahead[edges].all(axis=1)]
    parts = image.corners[image.is_part]
    return np.concatenate([edges, parts[:, [0, 1]], parts[:, [1, 2]], parts[:, [2, 0]]])


def twice_areas(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(N,) twice the signed areas of triangles with corners x, y (N, 3)."""
    return (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (y[:, 1] - y[:, 0]) * (x[:, 2] - x[:, 0])


def barycentric(x: np.ndarray, y: np.ndarray, at_x: np.ndarray, at_y: np.ndarray) -> np.ndarray:
    """(N, 3) barycentric coordinates of image points in triangles with corners x, y (N, 3); exact at the corners."""
    x0, x1, x2 = x[:, 0] - at_x, x[:, 1] - at_x, x[:, 2] - at_x
    y0, y1, y2 = y[:, 0] - at_y, y[:, 1] - at_y, y[:, 2] - at_y
    twice_area = twice_areas(x, y)
    weight = np.empty((len(x), 3))
    weight[:, 0] = (x1 * y2 - y1 * x2) / twice_area
    weight[:, 1] = (x2 * y0 - y2 * x0) / twice_area
    weight[:, 2] = (x0 * y1 - y0 * x1) / twice_area
    return weight
