"""Along which segments the silhouettes, the border of the field of view and the near plane cut the faces they cross."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from exact.visibility.grid import counting, greatest, least
from exact.visibility.projection import NEAR, Image
from exact.visibility.screen import PAIRS, Screen, barycentric, rims, seen_from_outside
from exact.visibility.sight_depth import SAME_DEPTH, THICK, blocks

# Segments are followed this far beyond a face (in parts of the face), so that they surely reach its outline.
MARGIN = 1e-7
# A segment from a corner that leaves the face at a smaller slope than this runs along the face's side.
ALONG_SIDE = 1e-9

# What moves a cut that no silhouette casts, in place of the points between which a silhouette runs: the sides of the
# field of view; nothing; limits on depth; the limit on incidence.
SIDES, FIXED, NEAREST, FARTHEST, STEEPEST = np.array([-1, -2, -3, -4]), -5, -6, -7, -8

# Nearer to each other than this (in parts of the field of view) two segments meet: far above rounding.
APART = 1e-9
# Segments from a common end at a smaller angle than this [rad] may run along each other.
TURNED = 1e-6
# What lies inside a triangle by more than this (in its barycentric coordinates) is clearly inside it.
CLEARLY = 1e-6
# Where they cross at a smaller angle than this [rad] is not clear enough to part one there; parts reach so much beyond
# where they begin and end, in parts of the way of the whole.
SLANTED, BEYOND = 1e-4, 1e-6


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


@dataclass(frozen=True, eq=False)
class _Ends:
    """One end of each segment in the image: point number (one of `SIDES` for none), x, y and 1/depth, all (N,)."""

    point: np.ndarray
    x: np.ndarray
    y: np.ndarray
    inverse_depth: np.ndarray

    def take(self, chosen: np.ndarray) -> "_Ends":
        return _Ends(self.point[chosen], self.x[chosen], self.y[chosen], self.inverse_depth[chosen])


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
        _Ends(
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


def _pairs(screen: Screen, asked: np.ndarray, start: _Ends, end: _Ends) -> Iterator[tuple[np.ndarray, np.ndarray]]:
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


def _line_meets(screen: Screen, found: np.ndarray, start: _Ends, end: _Ends) -> np.ndarray:
    """Whether the straight line through each segment meets the box-like neighbourhood of the triangle: a cheap sieve.

    The slack is far above rounding; whatever passes is looked at closely.
    """
    along_x, along_y = end.x - start.x, end.y - start.y
    side = [along_x * (screen.y[found, k] - start.y) - along_y * (screen.x[found, k] - start.x) for k in range(3)]
    low, high = np.minimum(np.minimum(*side[:2]), side[2]), np.maximum(np.maximum(*side[:2]), side[2])
    slack = 2 * MARGIN * (high - low)
    return (low <= slack) & (high >= -slack)


def _clip(screen: Screen, found: np.ndarray, start: _Ends, end: _Ends) -> Cuts:
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
            _Ends(
                start.point,
                start.x + at * (end.x - start.x),
                start.y + at * (end.y - start.y),
                ((at_start + at[:, None] * step) * inverse).sum(axis=1),
            )
            for at in within
        ]
        which, low, high = _seen_parts(screen, found, start, end, *places)
        found, inverse, step, source = found[which], inverse[which], step[which], source[which]
        at_start, at_end, enter, leave = at_start[which], at_end[which], enter[which], leave[which]
        first, last = (at[which] for at in within)
        enter, leave = (
            np.where(low > 0, first + low * (last - first), enter),
            np.where(high < 1, first + high * (last - first), leave),
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


def _seen_parts(screen: Screen, found: np.ndarray, start: _Ends, end: _Ends, enter: _Ends, leave: _Ends):
    """Parts of cuts of triangles `found`, from `enter` to `leave`, that can part what is seen from what is not.

    Others do not: there the triangle is hidden on both sides, by another sheet of faces than that of the silhouette
    from `start` to `end` itself. Whatever hides the middle of a part hides all of it, unless a sheet ends or folds back
    on the way, in front of the triangle, or a face cuts through the triangle. So a cut whose middle is hidden is parted
    where one does; others are left whole.

    Returns
    -------
    cut : (K,) int
    low, high : (K,) float
        Where each part begins and ends, in parts of the way.
    """
    surface = screen.image.surface
    cut_through = np.zeros(len(surface.faces), dtype=bool)
    cut_through[surface.intersections.face] = True
    asked = np.flatnonzero(~cut_through[screen.parent[found]])
    hidden, covered = _hidden_by_others(screen, *(ends.take(asked) for ends in (start, end, enter, leave)))
    cut, at = _crossed(screen, asked[hidden & ~covered], start, end, enter, leave)
    # Where it is not clear where a sheet ends, nothing is left out.
    unclear, parted = np.zeros((2, len(found)), dtype=bool)
    unclear[cut[np.isnan(at)]] = True
    cut, at = cut[~unclear[cut]], at[~unclear[cut]]
    parted[cut] = True
    whole = ~parted
    whole[asked[hidden]] = False
    whole = np.flatnonzero(whole | unclear)

    owner = np.concatenate([np.flatnonzero(parted), cut, np.flatnonzero(parted)])
    at = np.concatenate([np.zeros(parted.sum()), at, np.ones(parted.sum())])
    order = np.lexsort((at, owner))
    owner, at = owner[order], at[order]
    low = np.flatnonzero(owner[1:] == owner[:-1])
    owner, low, high = owner[low], at[low], at[low + 1]
    begin, finish = (_between(enter.take(owner), leave.take(owner), side) for side in (low, high))
    # Of a part of nearly no length rounding may have put the middle to this side or that of where a sheet ends.
    inside = np.where(high - low < 4 * BEYOND, CLEARLY, 0.0)
    seen = ~_hidden_by_others(screen, start.take(owner), end.take(owner), begin, finish, inside=inside)[0]
    # What follows upon each other is one part.
    goes_on = (owner[1:] == owner[:-1]) & seen[1:] & seen[:-1]
    first, last = np.flatnonzero(seen & ~np.append(False, goes_on)), np.flatnonzero(seen & ~np.append(goes_on, False))
    low, high = np.maximum(low[first] - BEYOND, 0.0), np.minimum(high[last] + BEYOND, 1.0)
    all_of = np.ones(len(whole))
    return np.append(whole, owner[first]), np.append(all_of - 1, low), np.append(all_of, high)


def _between(enter: _Ends, leave: _Ends, at: np.ndarray) -> _Ends:
    """Places on the way from one to the other."""
    values = [a + at * (b - a) for a, b in ((enter.x, leave.x), (enter.y, leave.y),
              (enter.inverse_depth, leave.inverse_depth))]  # fmt: skip
    return _Ends(enter.point, *values)


def _crossed(screen: Screen, asked: np.ndarray, start: _Ends, end: _Ends, enter: _Ends, leave: _Ends):
    """Where sheets end or fold back in front of cuts: (P,) which of the `asked`, and (P,) where, nan if not clear."""
    image = screen.image
    which, cell = screen.grid.touched(
        np.stack([enter.x[asked], leave.x[asked]], axis=1), np.stack([enter.y[asked], leave.y[asked]], axis=1),
        screen.marks,
    )  # fmt: skip
    which = asked[which]
    count = screen.first_rim[cell + 1] - screen.first_rim[cell]
    cuts, places = [np.zeros(0, dtype=int)], [np.zeros(0)]
    for low, high in blocks(count, PAIRS):
        part = slice(low, high)
        cut = np.repeat(which[part], count[part])
        rim = screen.rims[
            screen.near_rims[np.repeat(screen.first_rim[cell[part]], count[part]) + counting(count[part])]
        ]
        nearest = image.inverse_depth[rim].max(axis=1) * (1 + SAME_DEPTH)
        ahead = nearest >= np.minimum(enter.inverse_depth[cut], leave.inverse_depth[cut])
        cut, rim = cut[ahead], rim[ahead]
        meets = _meets(image, rim, start.take(cut), end.take(cut), enter.take(cut), leave.take(cut))
        cut, rim = cut[meets], rim[meets]
        along_x, along_y = leave.x[cut] - enter.x[cut], leave.y[cut] - enter.y[cut]
        x, y = image.x[rim], image.y[rim]
        rim_x, rim_y = x[:, 1] - x[:, 0], y[:, 1] - y[:, 0]
        turn = along_x * rim_y - along_y * rim_x
        clear = np.abs(turn) > SLANTED * np.hypot(along_x, along_y) * np.hypot(rim_x, rim_y)
        away = (x[:, 0] - enter.x[cut]) * rim_y - (y[:, 0] - enter.y[cut]) * rim_x
        at = np.divide(away, turn, out=np.full(len(cut), np.nan), where=clear)
        cuts.append(cut)
        places.append(np.clip(at, 0.0, 1.0))
    return np.concatenate(cuts), np.concatenate(places)


def _hidden_by_others(
    screen: Screen, start: _Ends, end: _Ends, enter: _Ends, leave: _Ends, *, inside: np.ndarray | float = 0.0
):
    """Whether a triangle surely hides the middle of each cut, and whether one hides each half of it: (N,), (N,).

    The middle must lie so far `inside` it, (N,), in barycentric coordinates. The triangles on either side of the
    silhouette itself are left out of account; in one about an end of it, the middle must lie clearly inside.
    """
    x, y = (enter.x + leave.x) / 2, (enter.y + leave.y) / 2
    inverse_depth = (enter.inverse_depth + leave.inverse_depth) / 2
    hidden, first_half, second_half = np.zeros((3, len(x)), dtype=bool)
    inside = np.broadcast_to(inside, x.shape)
    cell = screen.grid.cell(x, y)
    count = screen.first[cell + 1] - screen.first[cell]

    def how_far_inside(found, x, y, inverse_depth) -> np.ndarray:
        """Least barycentric coordinate; -inf where the triangle is not in front."""
        weight = barycentric(screen.x[found], screen.y[found], x, y)
        in_front = (weight * screen.inverse_depth[found]).sum(axis=1) > nearer * inverse_depth
        return np.where(in_front, least(weight), -np.inf)

    nearer = 1 + SAME_DEPTH
    for low, high in blocks(count, PAIRS):
        cut = low + np.repeat(np.arange(high - low), count[low:high])
        found = screen.near[np.repeat(screen.first[cell[low:high]], count[low:high]) + counting(count[low:high])]
        near_enough = (screen.nearest[found] > inverse_depth[cut]) & (screen.shape[found] > THICK)
        cut, found = cut[near_enough], found[near_enough]
        far = how_far_inside(found, x[cut], y[cut], inverse_depth[cut])
        here = far >= inside[cut]
        cut, found, far = cut[here], found[here], far[here]
        corner = screen.image.corners[screen.triangle[found]]
        common = ((corner == start.point[cut, None]) | (corner == end.point[cut, None])).sum(axis=1)
        others = (common == 0) | (common == 1) & (far >= CLEARLY)
        cut, found = cut[others], found[others]
        hidden[cut] = True
        for ends, half in ((enter, first_half), (leave, second_half)):
            half[cut[how_far_inside(found, ends.x[cut], ends.y[cut], ends.inverse_depth[cut]) >= 0]] = True
    return hidden, first_half & second_half


def _meets(image: Image, rim: np.ndarray, start: _Ends, end: _Ends, enter: _Ends, leave: _Ends) -> np.ndarray:
    """(N,) whether rims (N, 2) meet cuts, or nearly so, other than in a common end of rim and silhouette."""
    x, y = image.x[rim], image.y[rim]
    near = APART * float(image.camera.half_extent.max())

    def one_side(x0, y0, x1, y1, of_x, of_y) -> np.ndarray:
        """Whether both points (N, 2) lie clearly on one side of the line through two others."""
        along_x, along_y = x1 - x0, y1 - y0
        side = along_x[:, None] * (of_y - y0[:, None]) - along_y[:, None] * (of_x - x0[:, None])
        far = near * np.hypot(along_x, along_y)
        return (side > far[:, None]).all(axis=1) | (side < -far[:, None]).all(axis=1)

    cut_x, cut_y = np.stack([enter.x, leave.x], axis=1), np.stack([enter.y, leave.y], axis=1)
    apart = one_side(enter.x, enter.y, leave.x, leave.y, x, y)
    apart |= one_side(x[:, 0], y[:, 0], x[:, 1], y[:, 1], cut_x, cut_y)
    for of_rim, of_cut in ((x, cut_x), (y, cut_y)):
        apart |= (of_rim.min(axis=1) > of_cut.max(axis=1) + near) | (of_rim.max(axis=1) < of_cut.min(axis=1) - near)
    # The silhouette itself, and those that follow it and turn away from its line.
    along_x, along_y, rim_x, rim_y = end.x - start.x, end.y - start.y, x[:, 1] - x[:, 0], y[:, 1] - y[:, 0]
    length = np.hypot(along_x, along_y) * np.hypot(rim_x, rim_y)
    turned = np.abs(along_x * rim_y - along_y * rim_x) > TURNED * length
    for k, own in ((0, start.point), (1, end.point)):
        for j in (0, 1):
            onwards = (along_x * rim_x + along_y * rim_y) * (1 if k == j else -1) < 0
            apart |= (rim[:, j] == own) & (turned | onwards)
    same = (rim == start.point[:, None]).any(axis=1) & (rim == end.point[:, None]).any(axis=1)
    return ~(apart | same)


def _leads_away(step: np.ndarray, shared: np.ndarray) -> np.ndarray:
    """Whether a segment from a corner of a triangle goes out of it at once; along a side is not out."""
    clearly = ALONG_SIDE * np.abs(step).max(axis=1, keepdims=True)
    return ((step < -clearly) & ~shared).any(axis=1)
