"""What fixed cameras and forbidden arcs leave of the ring: for how many cameras, and how far apart."""

import numpy as np
from jaxtyping import Float, Int

import exact
from placement.layouts.constraints import GAP_MARGIN, OFFER_STEP, Constraints, offered

TURN = 2 * np.pi


def open_arcs(constraints: Constraints, gap: float) -> Float[np.ndarray, "A 2"]:
    """Arcs (A, 2) in which a free camera may be [rad], on the circle cut open at a fixed camera or forbidden arc.

    Examples
    --------
    >>> open_arcs(Constraints(fixed=(0.0,), forbidden=((1.0, 2.0),)), gap=0.25).round(3).tolist()
    [[0.25, 1.0], [2.0, 6.033]]
    """
    blocked = [(angle - gap, angle + gap) for angle in constraints.fixed]
    blocked += [(start, start + np.mod(end - start, TURN)) for start, end in constraints.forbidden]
    cut = constraints.fixed[0] if constraints.fixed else constraints.forbidden[0][0]
    pieces = []
    for start, end in blocked:
        begin = cut + np.mod(start - cut, TURN)
        pieces.append((begin, begin + (end - start)))
        pieces.append((begin - TURN, begin - TURN + (end - start)))
    position, arcs = cut, []
    for start, end in sorted(pieces):
        if start >= position:
            arcs.append((position, min(start, cut + TURN)))
        position = max(position, end)
    if position <= cut + TURN:
        arcs.append((position, cut + TURN))
    return np.array([(a, b) for a, b in arcs if a <= b and a < cut + TURN]).reshape(-1, 2)


def packed(constraints: Constraints, gap: float, enough: int) -> Int[np.ndarray, " A"]:
    """How many free cameras each open arc holds, at least `gap` [rad] apart, when as many fit as do, or `enough`.

    Packed from the beginning of each open arc, each camera as early as it may be: any layout can be pushed back to
    where one of its cameras is at the beginning of an arc.

    Examples
    --------
    >>> packed(Constraints(fixed=(0.0,), forbidden=((1.0, 2.0),)), gap=0.5, enough=8).tolist()
    [2, 6]
    """
    arcs = open_arcs(constraints, gap)
    best = np.zeros(len(arcs), dtype=np.int64)
    for first in range(len(arcs)):
        counts, position = np.zeros(len(arcs), dtype=np.int64), arcs[first, 0]
        last = position + TURN - gap
        for k, (start, end) in enumerate(np.concatenate([arcs[first:], arcs[:first] + TURN])):
            position = max(position, start)
            while position <= min(end, last) + GAP_MARGIN and counts.sum() < enough:
                counts[(first + k) % len(arcs)] += 1
                position += gap
        best = max(best, counts, key=np.sum)
    return best


def most_cameras(constraints: Constraints, gap: float, enough: int) -> int:
    """How many cameras fit at least `gap` [rad] apart, the fixed ones included; `enough` if that many do or more.

    Examples
    --------
    >>> most_cameras(Constraints(forbidden=((0.0, 4.0),)), gap=1.0, enough=8)  # at 4, 5 and 6 rad
    3
    """
    fixed = len(constraints.fixed)
    return min(fixed + int(packed(constraints, gap, max(enough - fixed, 0)).sum()), enough)


def greatest_separation(ring: exact.Ring, constraints: Constraints, n_cameras: int) -> float:
    """Greatest separation [mm], rounded down, at which `n_cameras` fit; 0 if there is no room for them at all."""
    least, most = 0.0, constraints.min_separation
    if most_cameras(constraints, 0.0, n_cameras) < n_cameras:
        return 0.0
    while most - least > OFFER_STEP / 10:
        middle = (least + most) / 2
        gap = float(2 * np.arcsin(middle / ring.diameter)) + GAP_MARGIN
        fits = most_cameras(constraints, gap, n_cameras) >= n_cameras
        least, most = (middle, most) if fits else (least, middle)
    return offered(least)


def widest_pair(constraints: Constraints, gap: float, n_cameras: int) -> float:
    """Greatest angle on the ring [rad] between two cameras, whatever room the others then have among fixed ones.

    Examples
    --------
    >>> float(np.degrees(widest_pair(Constraints(), gap=np.radians(100), n_cameras=3)).round(6))
    160.0
    >>> widest_pair(Constraints(forbidden=((0.0, 6.0),)), 0.0, 2) < 0.2832
    True
    """
    if not (constraints.fixed or constraints.forbidden):
        return min(np.pi, TURN - (n_cameras + 1) // 2 * gap)
    n_free = n_cameras - len(constraints.fixed)
    fixed = [(angle, angle) for angle in constraints.fixed]
    free = [(start, end) for start, end in open_arcs(constraints, gap).tolist()] if n_free else []
    pairs = [(a, b) for i, a in enumerate(fixed) for b in fixed[:i]] + [(a, b) for a in fixed for b in free]
    if n_free > 1:
        pairs += [(a, b) for i, a in enumerate(free) for b in free[: i + 1]]
    return max((_farthest(a, b) for a, b in pairs), default=0.0)


def _farthest(first: tuple[float, float], second: tuple[float, float]) -> float:
    """Greatest angle between a point of one arc and a point of another [rad], at most half a turn."""
    low, high = first[0] - second[1], first[1] - second[0]
    if np.floor((high - np.pi) / TURN) > np.floor((low - np.pi) / TURN):
        return np.pi  # opposite each other somewhere
    return float(max(2 * np.arcsin(min(abs(np.sin(end / 2)), 1.0)) for end in (low, high)))
