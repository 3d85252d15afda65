"""Which faces one camera sees whole, which not at all, and along which segments it sees the rest in part.

Walking over a face, what hides it changes only where the image of a silhouette passes in front of it, where another
face cuts through it, or at the border of the field of view. So a face that none of these crosses is seen whole or not
at all, and so is a whole patch of such faces joined by their edges: one point decides. A face that is crossed is cut
along the segments, and each piece is asked for itself (`Sight.sees`), so a segment too many does no harm.

Unlike in Wachter 2021, section 2.3, which orders faces by their nearest vertices, depths are compared at the point
itself, which is right for long, slanted and intersecting faces too.
"""

from dataclasses import dataclass

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from exact.projection import Image

HIDDEN, WHOLE, CUT = 0, 1, 2

# Segments are followed this far beyond a face (in parts of the face), so that they surely reach its outline.
MARGIN = 1e-7
# Relative difference of depth below which two faces count as in the same place and neither hides the other.
SAME_DEPTH = 1e-10
# An image triangle thinner than this part of its longest side is a line: it hides nothing and is not seen.
THINNEST_IMAGE = 1e-14
# Slack with which a point on the common edge of two faces belongs to both (in parts of the face).
ON_EDGE = 1e-12
# How many faces of a patch are asked. They must agree; if rounding makes them differ, all are asked.
PROBES = 3


@dataclass(frozen=True, eq=False)
class Cuts:
    """Segments that cut faces: the face of each, and its ends in the face's own coordinates, (N,), (N, 2), (N, 2)."""

    face: np.ndarray
    start: np.ndarray
    end: np.ndarray

    @staticmethod
    def joined(parts: list["Cuts"]) -> "Cuts":
        """All segments of several sets."""
        empty = np.zeros((0, 2))
        return Cuts(
            np.concatenate([np.zeros(0, dtype=int), *(part.face for part in parts)]),
            np.concatenate([empty, *(part.start for part in parts)]),
            np.concatenate([empty, *(part.end for part in parts)]),
        )


@dataclass(frozen=True, eq=False)
class Sight:
    """What one camera sees of the faces it was asked about.

    Attributes
    ----------
    status : (F,) int8
        `HIDDEN`, `WHOLE`, or `CUT` for a face that has to be cut before it can be asked.
    cuts : Cuts
        The segments that cut the faces of status `CUT`.
    n_repairs : int
        Patches whose faces did not agree and were asked one by one.
    """

    image: Image
    status: np.ndarray
    cuts: Cuts
    n_repairs: int
    _tree: shapely.STRtree
    _tree_triangles: np.ndarray

    def sees(self, face: np.ndarray, inner: np.ndarray) -> np.ndarray:
        """Whether the camera sees the point with coordinates `inner` (N, 2) of each `face` (N,): (N,) bool."""
        return _sees(self.image, self._tree, self._tree_triangles, face, inner)


def look(image: Image, active: np.ndarray) -> Sight:
    """What the camera of `image` sees of the `active` faces, (F,) bool; all others count as hidden."""
    triangles = _triangles_in_view(image)
    tree = _box_tree(image, triangles)
    asked = active[image.parent[triangles]] & image.front[image.parent[triangles]]
    cuts = _crossings(image, tree, triangles, asked)
    status = np.zeros(len(image.front), dtype=np.int8)
    status[image.parent[triangles[asked]]] = WHOLE  # until something is found to cut or to hide it
    status[cuts.face] = CUT
    own = image.surface.intersections
    chosen = status[own.face] != HIDDEN
    cuts = Cuts.joined([cuts, Cuts(own.face[chosen], own.start[chosen], own.end[chosen])])
    status[cuts.face] = CUT
    uncut = np.flatnonzero(status == WHOLE)
    seen, n_repairs = _patches_seen(image, tree, triangles, uncut)
    status[uncut[~seen]] = HIDDEN
    return Sight(image, status, cuts, n_repairs, tree, triangles)


def _hides(image: Image) -> np.ndarray:
    """(F,) whether a face can hide another.

    From outside a closed surface every line of sight enters it through a front, so the fronts are enough. Backs hide
    if the surface is open or the camera may be inside.
    """
    low, high = image.surface.bounds
    position = image.camera.position
    if image.surface.closed and ((position < low) | (position > high)).any():
        return image.front
    return np.ones_like(image.front)


def _triangles_in_view(image: Image) -> np.ndarray:
    """Triangles whose box meets the field of view and that can hide something."""
    x, y = image.x[image.corners], image.y[image.corners]
    half_x, half_y = image.camera.half_extent
    inside = (x.min(axis=1) <= half_x) & (x.max(axis=1) >= -half_x)
    inside &= (y.min(axis=1) <= half_y) & (y.max(axis=1) >= -half_y)
    inside &= _hides(image)[image.parent]
    chosen = np.flatnonzero(inside)
    x, y = x[chosen], y[chosen]
    side_x, side_y = x[:, [1, 2, 0]] - x, y[:, [1, 2, 0]] - y
    twice_area = np.abs(side_x[:, 0] * side_y[:, 1] - side_y[:, 0] * side_x[:, 1])
    return chosen[twice_area > THINNEST_IMAGE * (side_x**2 + side_y**2).max(axis=1)]


def _box_tree(image: Image, triangles: np.ndarray) -> shapely.STRtree:
    x, y = image.x[image.corners[triangles]], image.y[image.corners[triangles]]
    return shapely.STRtree(shapely.box(x.min(axis=1), y.min(axis=1), x.max(axis=1), y.max(axis=1)))


def _silhouettes(image: Image) -> np.ndarray:
    """(S, 2) end points of the edges across which visibility can change.

    An edge inside the front (or the back) of the surface hides nothing that its two faces do not hide together.
    """
    surface = image.surface
    ahead = np.isfinite(image.x)
    state = np.where(image.whole >= 0, image.front, 2)
    between = state[surface.edge_faces[:, 0]] != state[surface.edge_faces[:, 1]]
    loose = _hides(image)[surface.loose_edge_faces]
    edges = np.concatenate([surface.edges[between], surface.loose_edges[loose]])
    edges = edges[ahead[edges].all(axis=1)]
    parts = image.corners[image.is_part]
    return np.concatenate([edges, parts[:, [0, 1]], parts[:, [1, 2]], parts[:, [2, 0]]])


def _crossings(image: Image, tree: shapely.STRtree, triangles: np.ndarray, asked: np.ndarray) -> Cuts:
    """Silhouettes and borders of the field of view, where they pass in front of the triangles that are asked about."""
    edges = _silhouettes(image)
    half_x, half_y = image.camera.half_extent
    border_x = half_x * np.array([-1.0, 1.0, 1.0, -1.0])
    border_y = half_y * np.array([-1.0, -1.0, 1.0, 1.0])
    nearest = 1 / (1e-6 * image.camera.target_distance)  # the border hides as if it stood right before the lens
    # Start and end of each segment: point number (-1 for the border), x, y, 1/depth.
    start, end = (
        (
            np.append(edges[:, k], np.full(4, -1)),
            np.append(image.x[edges[:, k]], np.roll(border_x, -k)),
            np.append(image.y[edges[:, k]], np.roll(border_y, -k)),
            np.append(image.inverse_depth[edges[:, k]], np.full(4, nearest)),
        )
        for k in (0, 1)
    )
    boxes = shapely.box(
        np.minimum(start[1], end[1]), np.minimum(start[2], end[2]),
        np.maximum(start[1], end[1]), np.maximum(start[2], end[2]),
    )  # fmt: skip
    segment, found = tree.query(boxes)
    keep = asked[found]
    segment, triangle = segment[keep], triangles[found[keep]]
    cuts = _clip_segments(image, triangle, *([part[segment] for part in ends] for ends in (start, end)))
    if image.frame is None:
        return cuts
    # A part of a face is cut off the rest along the near plane.
    part = triangles[asked & image.is_part[triangles]]
    frame, owner = image.frame[part], image.parent[part]
    sides = [Cuts(owner, frame[:, i], frame[:, j]) for i, j in ((0, 1), (1, 2), (2, 0))]
    return Cuts.joined([cuts, *sides])


def _clip_segments(image: Image, triangle: np.ndarray, start: list, end: list) -> Cuts:
    """The parts of segments over a triangle and not behind it, in the coordinates of the triangle's face.

    `start` and `end` hold point number, x, y and 1/depth of the (N,) ends of the segments in the image.
    """
    corner = image.corners[triangle]
    inverse = image.inverse_depth[corner]
    at_start = _barycentric(image.x[corner], image.y[corner], start[1], start[2])
    at_end = _barycentric(image.x[corner], image.y[corner], end[1], end[2])
    # Liang and Barsky: the segment's parameter runs from `enter` to `leave` over the (slightly enlarged) triangle.
    a, b = at_start + MARGIN, at_end + MARGIN
    with np.errstate(divide="ignore", invalid="ignore"):
        t = a / (a - b)
    enter = np.where(a < 0, t, 0.0).max(axis=1)
    leave = np.where(b < 0, t, 1.0).min(axis=1)
    over = (enter <= leave) & ~((a < 0) & (b < 0)).any(axis=1)

    start_shared, end_shared = corner == start[0][:, None], corner == end[0][:, None]
    has_start, has_end = start_shared.any(axis=1), end_shared.any(axis=1)
    step = at_end - at_start
    over &= ~(has_start & has_end)  # the triangle's own edge
    over &= ~(has_start & _leads_away(step, start_shared))
    over &= ~(has_end & _leads_away(-step, end_shared))

    def ahead(at, own):
        """How far the segment is in front of the triangle at a parameter, relative to its 1/depth."""
        where = at_start + at[:, None] * step
        plane = (where * inverse).sum(axis=1)
        return np.where(own, -np.inf, (start[3] + at * (end[3] - start[3]) - plane) / np.abs(plane))

    with np.errstate(invalid="ignore", divide="ignore"):  # misses are dropped with the rest, whatever they give
        over &= np.maximum(ahead(enter, has_start), ahead(leave, has_end)) > -SAME_DEPTH
    over &= image.parent[triangle] >= 0
    triangle, inverse, step = triangle[over], inverse[over], step[over]
    ends = []
    for at in (enter[over], leave[over]):
        where = np.where(at[:, None] == 1.0, at_end[over], at_start[over] + at[:, None] * step)
        weight = where * inverse  # perspective: 1/depth is affine in the image, position in the plane is not
        weight = weight / weight.sum(axis=1, keepdims=True)
        if image.frame is None:
            ends.append(weight[:, 1:])
        else:
            ends.append((weight[:, :, None] * image.frame[triangle]).sum(axis=1))
    return Cuts(image.parent[triangle], ends[0], ends[1])


def _barycentric(x: np.ndarray, y: np.ndarray, at_x: np.ndarray, at_y: np.ndarray) -> np.ndarray:
    """(N, 3) barycentric coordinates of image points in triangles with corners x, y (N, 3); exact at the corners."""
    dx, dy = x - at_x[:, None], y - at_y[:, None]
    side_x, side_y = x[:, 1:] - x[:, :1], y[:, 1:] - y[:, :1]
    twice_area = side_x[:, 0] * side_y[:, 1] - side_y[:, 0] * side_x[:, 1]
    opposite = np.stack(
        [
            dx[:, 1] * dy[:, 2] - dy[:, 1] * dx[:, 2],
            dx[:, 2] * dy[:, 0] - dy[:, 2] * dx[:, 0],
            dx[:, 0] * dy[:, 1] - dy[:, 0] * dx[:, 1],
        ],
        axis=1,
    )
    return opposite / twice_area[:, None]


def _leads_away(step: np.ndarray, shared: np.ndarray) -> np.ndarray:
    """Whether a segment from a corner of a triangle goes out of it at once; along a side is not out."""
    clearly = 1e-9 * np.abs(step).max(axis=1, keepdims=True)
    return ((step < -clearly) & ~shared).any(axis=1)


def _sees(image: Image, tree: shapely.STRtree, triangles: np.ndarray, face: np.ndarray, inner: np.ndarray):
    x, y, inverse, ahead = image.locate(face, inner)
    half_x, half_y = image.camera.half_extent
    seen = ahead & image.front[face] & (np.abs(x) <= half_x) & (np.abs(y) <= half_y)
    asked = np.flatnonzero(seen)
    point, found = tree.query(shapely.points(x[asked], y[asked]))
    point, triangle = asked[point], triangles[found]
    other = image.parent[triangle] != face[point]
    point, triangle = point[other], triangle[other]
    corner = image.corners[triangle]
    weight = _barycentric(image.x[corner], image.y[corner], x[point], y[point])
    inside = (weight >= -ON_EDGE).all(axis=1)
    plane = (weight * image.inverse_depth[corner]).sum(axis=1)
    hidden = inside & (plane > inverse[point] * (1 + SAME_DEPTH))
    seen[point[hidden]] = False
    return seen


def _patches_seen(image: Image, tree: shapely.STRtree, triangles: np.ndarray, uncut: np.ndarray):
    """Whether each of the faces `uncut`, which nothing cuts, is seen; and how many patches did not agree."""
    surface = image.surface
    number = np.full(len(surface.faces), -1)
    number[uncut] = np.arange(len(uncut))
    pair = number[surface.edge_faces]
    pair = pair[(pair >= 0).all(axis=1)]
    graph = coo_array((np.ones(len(pair), dtype=np.int8), (pair[:, 0], pair[:, 1])), shape=(len(uncut),) * 2)
    n_patches, patch = connected_components(graph, directed=False)
    # The faces with the largest images speak for their patch.
    corner = image.corners[image.whole[uncut]]
    x, y = image.x[corner], image.y[corner]
    size = np.abs((x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (y[:, 1] - y[:, 0]) * (x[:, 2] - x[:, 0]))
    order = np.lexsort((-size, patch))
    count = np.bincount(patch, minlength=n_patches)
    rank = np.empty(len(uncut), dtype=int)
    rank[order] = np.arange(len(uncut)) - np.repeat(np.cumsum(count) - count, count)
    probe = np.flatnonzero(rank < PROBES)

    def centre_seen(which):
        return _sees(image, tree, triangles, uncut[which], np.full((len(which), 2), 1 / 3))

    answer = centre_seen(probe)
    votes = np.bincount(patch[probe], weights=answer, minlength=n_patches)
    seen = (votes > 0)[patch]
    split = (votes > 0) & (votes < np.minimum(count, PROBES))
    if split.any():
        doubtful = np.flatnonzero(split[patch])
        seen[doubtful] = centre_seen(doubtful)
    return seen, int(split.sum())
