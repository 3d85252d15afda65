"""The sides of a surface that are worth looking at: of hollows those into which most is seen, else those with most."""

import numpy as np
from scipy.spatial.distance import cdist

from meshes.condition.winding import sphere_around
from meshes.errors import REPAIR_CALL, MeshError
from meshes.placing.poses import FLOOR, Pose, RingShape
from meshes.placing.sight import Sight, quantile

# Directions from which a side is looked for: some 14 degrees apart. A channel five times as deep as it is wide shows
# most of its walls from that far off its axis.
DIRECTIONS = 200
# Of the sides found the best so many are looked at more closely, so far apart [rad], and as good as this part of the
# best.
SIDES, APART, AS_GOOD = 3, 0.4, 0.7
# Windows the size of the field of view that are tried from each of them, if not all is in one.
WINDOWS = 40
# Of windows that hold as much the one nearest to the middle of all: worth this part of it, as far away as the size.
CENTRAL = 0.05
# A hollow matters if it holds this part of what is seen from the best side, and its walls face inwards, by so much in
# the mean of their normals, as those around a bump do not; and it is deep, so that its floor is what is looked at, if
# it is so deep for its width.
MATTERS, INWARDS, DEEP = 0.1, 0.05, 0.25


def sides(sight: Sight, ring: RingShape) -> list[Pose]:
    """Poses to start from: the sides of which most of a hollow is seen, or most of all if there is none."""
    places = sphere_around(sight.points, DIRECTIONS)
    directions = (places - sight.middle) / np.linalg.norm(places - sight.middle, axis=1, keepdims=True)
    seen = [sight.seen(one) for one in places]
    everything, hollows = (
        [window(sight, which * sight.worth_seeing(of_hollows, axis), of_hollows, axis, radius)
         for which, axis in zip(seen, directions, strict=True)]
        for of_hollows, radius in ((False, ring.outer), (True, ring.inner))
    )  # fmt: skip
    most, most_hollow = (max(range(DIRECTIONS), key=lambda one: found[one][0]) for found in (everything, hollows))
    if everything[most][0] == 0:
        raise MeshError(f"no front of the mesh is seen from any side; it may be inside-out: {REPAIR_CALL} turns it")
    held, middle = hollows[most_hollow]
    is_hollow = held >= MATTERS * everything[most][0] and (
        _inwards(sight, seen[most_hollow], middle, directions[most_hollow], ring.inner) > INWARDS
    )
    windows = hollows if is_hollow else everything
    worths = np.array([worth for worth, _ in windows])
    poses: list[Pose] = []
    for number in np.argsort(-worths, kind="stable"):
        if worths[number] < AS_GOOD * worths.max() or len(poses) == SIDES:
            break
        if any(np.arccos(np.clip(directions[number] @ one.axis, -1, 1)) < APART for one in poses):
            continue
        # From about the middle of where this is seen from.
        around = np.where(directions @ directions[number] > np.cos(APART), worths, 0.0) ** 4
        axis = around @ directions
        axis /= np.linalg.norm(axis)
        middle = windows[number][1]
        poses.append(
            Pose(middle, axis, is_hollow and _is_deep(sight, seen[number], middle, axis, ring.inner), is_hollow)
        )
    return poses


def _in_hollow(sight: Sight, seen: np.ndarray, centre: np.ndarray, axis: np.ndarray, radius: float) -> np.ndarray:
    """(N,) bool: points of a hollow, seen along an axis through its centre."""
    near = np.linalg.norm(measured(sight.points - centre, True, axis), axis=1) <= radius
    return seen & near & sight.in_hollow


def _inwards(sight: Sight, seen: np.ndarray, centre: np.ndarray, axis: np.ndarray, radius: float) -> float:
    """How much the normals in a hollow point to its middle, in the mean."""
    which = _in_hollow(sight, seen, centre, axis, radius)
    arm = measured(centre - sight.points[which], True, axis)
    length = np.maximum(np.linalg.norm(arm, axis=1), np.finfo(float).tiny)
    towards = np.einsum("nk,nk->n", sight.normals[which], arm) / length
    return float(sight.worth[which] @ towards / max(sight.worth[which].sum(), np.finfo(float).tiny))


def _is_deep(sight: Sight, seen: np.ndarray, centre: np.ndarray, axis: np.ndarray, radius: float) -> bool:
    """Whether a hollow is deep for its width: that of a disc of its area, seen along the axis."""
    which = _in_hollow(sight, seen, centre, axis, radius)
    if not which.any():
        return False
    worth, along = sight.worth[which], sight.points[which] @ axis
    wide = 2 * np.sqrt(worth @ np.abs(sight.normals[which] @ axis) / np.pi)
    return quantile(along, worth, 1 - FLOOR) - quantile(along, worth, FLOOR) > DEEP * wide


def measured(points: np.ndarray, of_hollows: bool, axis: np.ndarray) -> np.ndarray:
    """Points (N, 3) as distances between them count: in hollows only across the axis.

    Of a plane that goes on beyond the field of view the more would be in view, the more it is at a slant.
    """
    return points - np.outer(points @ axis, axis) if of_hollows else points


def window(
    sight: Sight, worth: np.ndarray, of_hollows: bool, axis: np.ndarray, radius: float
) -> tuple[float, np.ndarray]:
    """Where most lies within a radius, by the worth (N,) of points: how much it is, and its middle (3,) [mm]."""
    which = worth > 0
    if not which.any():
        return 0.0, sight.middle
    points, worth = sight.points[which], worth[which]
    flat = measured(points, of_hollows, axis)
    middle = worth @ flat / worth.sum()
    if np.linalg.norm(flat - middle, axis=1).max() <= radius:
        return float(worth.sum()), worth @ points / worth.sum()
    centres = np.vstack([flat[np.argmin(np.linalg.norm(flat - middle, axis=1))], flat[:: max(len(flat) // WINDOWS, 1)]])
    for again in range(2):  # the second time around the middles of what was in view
        inside = cdist(centres, flat) <= radius
        held = inside @ worth
        held *= 1 - CENTRAL * np.linalg.norm(centres - middle, axis=1) / sight.size
        if not again:
            centres = (inside * worth) @ flat / (inside @ worth)[:, None]
    best = int(np.argmax(held))
    return float(held[best]), (inside[best] * worth) @ points / (inside[best] @ worth)
