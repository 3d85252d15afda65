"""Which parts of the cuts along silhouettes can part what is seen from what is not: few where much lies in shadow."""

from dataclasses import dataclass

import numpy as np

from exact.visibility.grid import counting, least
from exact.visibility.projection import Image
from exact.visibility.screen import PAIRS, Screen, barycentric
from exact.visibility.sight_depth import SAME_DEPTH, THICK, blocks

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
class Ends:
    """One end of each segment in the image: point number (negative for none), x, y and 1/depth, all (N,)."""

    point: np.ndarray
    x: np.ndarray
    y: np.ndarray
    inverse_depth: np.ndarray

    def take(self, chosen: np.ndarray) -> "Ends":
        """The chosen ones, by mask or index."""
        return Ends(self.point[chosen], self.x[chosen], self.y[chosen], self.inverse_depth[chosen])


def seen_parts(screen: Screen, found: np.ndarray, start: Ends, end: Ends, enter: Ends, leave: Ends):
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
    seen = ~_hidden_by_others(screen, start.take(owner), end.take(owner), begin, finish)[0]
    # What follows upon each other is one part.
    goes_on = (owner[1:] == owner[:-1]) & seen[1:] & seen[:-1]
    first, last = np.flatnonzero(seen & ~np.append(False, goes_on)), np.flatnonzero(seen & ~np.append(goes_on, False))
    low, high = np.maximum(low[first] - BEYOND, 0.0), np.minimum(high[last] + BEYOND, 1.0)
    all_of = np.ones(len(whole))
    cut, low, high = np.append(whole, owner[first]), np.append(all_of - 1, low), np.append(all_of, high)
    return _with_stubs(found, start.point, end.point, cut, low, high)


def _with_stubs(found, start: np.ndarray, end: np.ndarray, cut: np.ndarray, low: np.ndarray, high: np.ndarray):
    """Parts of cuts, and stubs of those left out that meet a part in an end of theirs, on the same triangle.

    What is seen changes there since something else passes exactly through that point, or along the part. Rounding must
    not keep it from meeting what else begins there.
    """
    n_points = int(max(start.max(initial=0), end.max(initial=0))) + 1
    ends = []
    for k, (point, kept) in enumerate(((start, cut[low == 0.0]), (end, cut[high == 1.0]))):
        number = np.where(point >= 0, point, n_points + (k - 1 - point) % 4)  # else a corner of the field of view
        lost = np.ones(len(found), dtype=bool)
        lost[kept] = False
        ends.append((found * (n_points + 4) + number, kept, np.flatnonzero(lost)))
    there = np.concatenate([place[kept] for place, kept, _ in ends])
    first, last = (lost[np.isin(place[lost], there)] for place, _, lost in ends)
    return (
        np.concatenate([cut, first, last]),
        np.concatenate([low, np.zeros(len(first)), np.full(len(last), 1.0 - BEYOND)]),
        np.concatenate([high, np.full(len(first), BEYOND), np.ones(len(last))]),
    )


def _between(enter: Ends, leave: Ends, at: np.ndarray) -> Ends:
    """Places on the way from one to the other."""
    values = [a + at * (b - a) for a, b in ((enter.x, leave.x), (enter.y, leave.y),
              (enter.inverse_depth, leave.inverse_depth))]  # fmt: skip
    return Ends(enter.point, *values)


def _crossed(screen: Screen, asked: np.ndarray, start: Ends, end: Ends, enter: Ends, leave: Ends):
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


def _hidden_by_others(screen: Screen, start: Ends, end: Ends, enter: Ends, leave: Ends):
    """Whether a triangle surely hides the middle of each cut, and whether one hides each half of it: (N,), (N,).

    The middle must lie clearly inside it: where it lies on a side, the sheet may fold back there, as at a face in line
    with the camera. The triangles on either side of the silhouette itself are left out of account.
    """
    x, y = (enter.x + leave.x) / 2, (enter.y + leave.y) / 2
    inverse_depth = (enter.inverse_depth + leave.inverse_depth) / 2
    hidden, first_half, second_half = np.zeros((3, len(x)), dtype=bool)
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
        here = how_far_inside(found, x[cut], y[cut], inverse_depth[cut]) >= CLEARLY
        cut, found = cut[here], found[here]
        corner = screen.image.corners[screen.triangle[found]]
        others = ((corner == start.point[cut, None]) | (corner == end.point[cut, None])).sum(axis=1) < 2
        cut, found = cut[others], found[others]
        hidden[cut] = True
        for ends, half in ((enter, first_half), (leave, second_half)):
            half[cut[how_far_inside(found, ends.x[cut], ends.y[cut], ends.inverse_depth[cut]) >= 0]] = True
    return hidden, first_half & second_half


def _meets(image: Image, rim: np.ndarray, start: Ends, end: Ends, enter: Ends, leave: Ends) -> np.ndarray:
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
