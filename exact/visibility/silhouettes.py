"""Along which segments the silhouettes, the border of the field of view and the near plane cut the faces they cross."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from exact.visibility.grid import counting, greatest, least
from exact.visibility.projection import NEAR, Image
from exact.visibility.screen import PAIRS, Screen, barycentric, rims, seen_from_outside
from exact.visibility.seen_parts import Ends, seen_parts
from exact.visibility.sight_depth import SAME_DEPTH, blocks

# Segments are followed this far beyond a face (in parts of the face), so that they surely reach its outline.
MARGIN = 1e-7
# A segment from a corner that leaves the face at a smaller slope than this runs along the face's side.
ALONG_SIDE = 1e-9

# What moves a cut that no silhouette casts, in place of the points between which a silhouette runs: the sides of the
# field of view; nothing; limits on depth; the limit on incidence.
SIDES, FIXED, NEAREST, FARTHEST, STEEPEST = np.array([-1, -2, -3, -4]), -5, -6, -7, -8


@dataclass(frozen=True, eq=False)
class Cuts:
    """Segments that cut faces: the face of each, and its ends in the face's own coordinates, (N,), (N, 2), (N, 2).

    And, (N, 2) int, of what each is the shadow or the border: the points of the image between which a silhouette runs,
    or twice one of `SIDES`, `FIXED`, `NEAREST`, `FARTHEST` and `STEEPEST`.
    """

    face: np.ndarray
    start: np.ndarray
    end: np.ndarray
    source: np.ndarray

    @staticmethod
    def alike(face: np.ndarray, start: np.ndarray, end: np.ndarray, source: int = FIXED) -> "Cuts":
        """Segments that are all borders of the same."""
        return Cuts(face, start, end, np.full((len(face), 2), source))

    @staticmethod
    def none() -> "Cuts":
        """No segments."""
        return Cuts.alike(np.zeros(0, dtype=int), np.zeros((0, 2)), np.zeros((0, 2)))

    @staticmethod
    def joined(parts: list["Cuts"]) -> "Cuts":
        """All segments of several sets, by ascending face and then by their ends.

        So the order in which they were found makes no difference, not even in the last bit of an area.
        """
        face = np.concatenate([part.face for part in parts])
        start = np.concatenate([part.start for part in parts])
        end = np.concatenate([part.end for part in parts])
        source = np.concatenate([part.source for part in parts])
        order = np.lexsort((end[:, 1], end[:, 0], start[:, 1], start[:, 0], face))
        return Cuts(face[order], start[order], end[order], source[order])

    def of_faces(self, chosen: np.ndarray) -> "Cuts":
        """The segments of the `chosen` faces, (F,) bool."""
        keep = chosen[self.face]
        return Cuts(self.face[keep], self.start[keep], self.end[keep], self.source[keep])


def crossings(screen: Screen, asked: np.ndarray) -> Cuts:
    """Where something passes in front of the triangles of `screen` that are `asked` about, (N,) bool."""
    image = screen.image
    edges = _silhouettes(image) if screen.face_distance is None else _all_edges(screen)
    half_x, half_y = image.camera.half_extent
    border_x = half_x * np.array([-1.0, 1.0, 1.0, -1.0])
    border_y = half_y * np.array([-1.0, -1.0, 1.0, 1.0])
    # The border of the field of view cuts everything, as if it stood at the near plane.
    nearest = np.full(4, 1 / (NEAR * image.camera.target_distance))
    start, end = (
        Ends(
            np.append(edges[:, k], SIDES),
            np.append(image.x[edges[:, k]], np.roll(border_x, -k)),
            np.append(image.y[edges[:, k]], np.roll(border_y, -k)),
            np.append(image.inverse_depth[edges[:, k]], nearest),
        )
        for k in (0, 1)
    )
    parts = [_clip(screen, found, start.take(which), end.take(which)) for which, found in
             _pairs(screen, asked, start, end)]  # fmt: skip
    cuts = Cuts.joined(parts or [Cuts.none()])
    if image.frame is None:
        return cuts
    # A part of a face is cut off the rest along the near plane.
    part = screen.triangle[asked & image.is_part[screen.triangle]]
    frame, owner = image.frame[part], image.parent[part]
    return Cuts.joined([cuts, *(Cuts.alike(owner, frame[:, i], frame[:, j]) for i, j in ((0, 1), (1, 2), (2, 0)))])


def _pairs(screen: Screen, asked: np.ndarray, start: Ends, end: Ends) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Segments and triangles `asked` about that they may cut, in blocks: they meet in a cell where both can be seen."""
    nearest = np.maximum(start.inverse_depth, end.inverse_depth) * (1 + SAME_DEPTH)
    segment, cell = screen.grid.touched(
        np.stack([start.x, end.x], axis=1), np.stack([start.y, end.y], axis=1), screen.marks
    )
    if screen.face_distance is None:
        seen = screen.depths.near(nearest)[segment] >= screen.limit[cell]
        segment, cell = segment[seen], cell[seen]
    wanted = asked[screen.near]
    near, first = screen.near[wanted], np.append(0, np.cumsum(wanted))[screen.first]
    count = first[cell + 1] - first[cell]
    # A block ends with a segment, so that no pair is in two of them.
    begins = np.flatnonzero(np.diff(segment, prepend=-1))
    for low, high in blocks(np.add.reduceat(count, begins) if len(begins) else count, PAIRS):
        part = slice(begins[low], begins[high] if high < len(begins) else len(segment))
        found = near[np.repeat(first[cell[part]], count[part]) + counting(count[part])]
        which = np.repeat(segment[part], count[part])
        if screen.face_distance is None:
            keep = nearest[which] >= screen.farthest[found]
            which, found = which[keep], found[keep]
        keep = _line_meets(screen, found, start.take(which), end.take(which))
        pair = np.unique(which[keep] * len(asked) + found[keep])
        yield pair // len(asked), pair % len(asked)


def _silhouettes(image: Image) -> np.ndarray:
    """(S, 2) end points of the edges across which visibility can change.

    An edge inside the front (or the back) of the surface hides nothing that its two faces do not hide together. A
    concave edge of a solid seen from outside is itself hidden: the line of sight reaches it through the solid, which
    hides what is behind on either side of it.
    """
    return rims(image, concave=not seen_from_outside(image))


def _all_edges(screen: Screen) -> np.ndarray:
    """(S, 2) end points of all edges of the triangles of a screen."""
    corner = screen.image.corners[screen.triangle]
    return np.unique(np.sort(np.concatenate([corner[:, [0, 1]], corner[:, [1, 2]], corner[:, [2, 0]]]), axis=1), axis=0)


def _line_meets(screen: Screen, found: np.ndarray, start: Ends, end: Ends) -> np.ndarray:
    """Whether the straight line through each segment meets the box-like neighbourhood of the triangle: a cheap sieve.

    The slack is far above rounding; whatever passes is looked at closely.
    """
    along_x, along_y = end.x - start.x, end.y - start.y
    side = [along_x * (screen.y[found, k] - start.y) - along_y * (screen.x[found, k] - start.x) for k in range(3)]
    low, high = np.minimum(np.minimum(*side[:2]), side[2]), np.maximum(np.maximum(*side[:2]), side[2])
    slack = 2 * MARGIN * (high - low)
    return (low <= slack) & (high >= -slack)


def _clip(screen: Screen, found: np.ndarray, start: Ends, end: Ends) -> Cuts:
    """The parts of segments over the triangles `found` and not behind them, in the coordinates of their faces."""
    image = screen.image
    at_start = barycentric(screen.x[found], screen.y[found], start.x, start.y)
    at_end = barycentric(screen.x[found], screen.y[found], end.x, end.y)
    # Liang and Barsky: the segment's parameter runs from `enter` to `leave` over the (slightly enlarged) triangle.
    a, b = at_start + MARGIN, at_end + MARGIN
    t = np.divide(a, a - b, out=np.zeros_like(a), where=(a < 0) != (b < 0))
    enter = greatest(np.where(a < 0, t, 0.0))
    leave = least(np.where(b < 0, t, 1.0))
    over = np.flatnonzero((enter <= leave) & ~((a < 0) & (b < 0)).any(axis=1))
    found, at_start, at_end, enter, leave = found[over], at_start[over], at_end[over], enter[over], leave[over]
    start, end = start.take(over), end.take(over)

    corner = image.corners[screen.triangle[found]]
    start_shared, end_shared = corner == start.point[:, None], corner == end.point[:, None]
    has_start, has_end = start_shared.any(axis=1), end_shared.any(axis=1)
    step = at_end - at_start
    keep = ~(has_start & has_end)  # else it is the triangle's own edge
    keep &= ~(has_start & _leads_away(step, start_shared))
    keep &= ~(has_end & _leads_away(-step, end_shared))
    inverse = screen.inverse_depth[found]

    def lead(at: np.ndarray) -> np.ndarray:
        """How far the segment is in front of the triangle, relative to the triangle's 1/depth."""
        plane = ((at_start + at[:, None] * step) * inverse).sum(axis=1)
        return (start.inverse_depth + at * (end.inverse_depth - start.inverse_depth) - plane) / plane

    # At a common corner neither is in front: the other end tells. By vertices, where a segment is decides nothing.
    first, last = np.where(has_start, -np.inf, lead(enter)), np.where(has_end, -np.inf, lead(leave))
    if screen.face_distance is None:
        keep &= np.maximum(first, last) > -SAME_DEPTH
    found, inverse, step = found[keep], inverse[keep], step[keep]
    start, end = start.take(keep), end.take(keep)
    source, ends = np.stack([start.point, end.point], axis=1), []
    enter, leave, at_start, at_end = enter[keep], leave[keep], at_start[keep], at_end[keep]
    if screen.face_distance is None and image.frame is None:
        within = screen.grid.part_within(start, end, enter, leave)  # beyond it, not all that hides is known
        places = [
            Ends(
                start.point,
                start.x + at * (end.x - start.x),
                start.y + at * (end.y - start.y),
                ((at_start + at[:, None] * step) * inverse).sum(axis=1),
            )
            for at in within
        ]
        which, low, high = seen_parts(screen, found, start, end, *places)
        found, inverse, step, source = found[which], inverse[which], step[which], source[which]
        at_start, at_end, enter, leave = at_start[which], at_end[which], enter[which], leave[which]
        first, last = (at[which] for at in within)
        enter, leave = (
            np.where(at == 0, enter, np.where(at == 1, leave, first + at * (last - first))) for at in (low, high)
        )
    for at in (enter, leave):
        where = np.where(at[:, None] == 1.0, at_end, at_start + at[:, None] * step)
        weight = where * inverse  # perspective: 1/depth is affine in the image, the place in the plane is not
        weight = weight / weight.sum(axis=1, keepdims=True)
        if image.frame is None:
            ends.append(weight[:, 1:])
        else:
            ends.append((weight[:, :, None] * image.frame[screen.triangle[found]]).sum(axis=1))
    return Cuts(screen.parent[found], ends[0], ends[1], source)


def _leads_away(step: np.ndarray, shared: np.ndarray) -> np.ndarray:
    """Whether a segment from a corner of a triangle goes out of it at once; along a side is not out."""
    clearly = ALONG_SIDE * np.abs(step).max(axis=1, keepdims=True)
    return ((step < -clearly) & ~shared).any(axis=1)
