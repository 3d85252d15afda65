"""Where a ring stands over a surface, what is seen from there, and how to stand a little better."""

from dataclasses import dataclass, replace

import numpy as np

from meshes.placing.sight import Sight, across, quantile

# Places on the ring from which is looked.
PLACES = 16
# How good a place is: the area that so many of the places on the ring see, each with its weight. Two are what many
# cameras reconstruct, half of them what four do.
LEVELS = {2: 0.6, 4: 0.25, 8: 0.15}
# The floor of a hollow: all but this part of what is seen lies above it.
FLOOR = 0.01
# Steps by which a place is made better: the first and the last tilt [rad], and shifts, in parts of the field of view,
# that go with them; and how many of them are taken at most.
FIRST_TILT, LAST_TILT, SHIFT, MOST_STEPS = np.radians(8.0), np.radians(0.25), 0.25, 60
# Of two places that see as much the one that has what it sees in its middle: worth this part of what is seen. And less
# of it than this is not worth a step.
CENTRED, GAIN = 0.05, 0.0005


@dataclass(frozen=True)
class RingShape:
    """Diameter, working distance and field of view of a ring [mm]."""

    diameter: float
    working_distance: float
    fov: tuple[float, float]

    @property
    def inner(self) -> float:
        """Radius that is in view of most cameras [mm]."""
        return 0.25 * sum(self.fov)

    @property
    def outer(self) -> float:
        """Radius beyond which nothing is in view of any [mm]."""
        return 0.5 * float(np.hypot(*self.fov))


@dataclass(frozen=True, eq=False)
class Pose:
    """Where a ring stands; `worth` is how good that is [mm²], `deep` whether its focus is on the floor of a hollow."""

    focus: np.ndarray
    axis: np.ndarray
    deep: bool
    hollow: bool
    worth: float = 0.0


def views(sight: Sight, ring: RingShape, focus: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """(PLACES, N) bool: points that are seen, within the field of view, from places around the ring."""
    flat = np.column_stack(across(axis))
    found = []
    for angle in 2 * np.pi * np.arange(PLACES) / PLACES:
        outwards = flat @ [np.cos(angle), np.sin(angle)]
        camera = focus + ring.working_distance * axis + 0.5 * ring.diameter * outwards
        ahead = focus - camera
        length = np.linalg.norm(ahead)
        ahead /= length
        along = np.cross(axis, outwards)
        arm = sight.points - camera
        depth = arm @ ahead
        width, height = np.array(ring.fov) / 2 / length
        inside = (depth > 0) & (np.abs(arm @ along) <= width * depth)
        inside &= np.abs(arm @ np.cross(ahead, along)) <= height * depth
        found.append(sight.seen(camera, inside))
    return np.array(found)


def scored(sight: Sight, ring: RingShape, pose: Pose) -> tuple[Pose, np.ndarray]:
    """The pose with its worth, and which points at least two places see."""
    count = views(sight, ring, pose.focus, pose.axis).sum(axis=0)
    worth = sight.worth_seeing(pose.hollow, pose.axis)
    if not pose.hollow:
        worth *= np.linalg.norm(sight.points - pose.focus, axis=1) <= ring.outer
    area = sum(weight * float(worth @ (count >= level)) for level, weight in LEVELS.items())
    if area > 0:
        arm = (worth * count) @ sight.points / (worth @ count) - pose.focus
        off = np.linalg.norm(arm - (arm @ pose.axis) * pose.axis) / ring.inner
        area *= 1 - CENTRED * min(off, 1.0)
    return replace(pose, worth=area), count >= 2


def levelled(sight: Sight, ring: RingShape, pose: Pose) -> Pose:
    """The same with its focus at the depth where it belongs."""
    _, seen = scored(sight, ring, pose)
    seen &= sight.in_hollow if pose.deep else True
    if seen.any():
        along, worth = (sight.points[seen] - pose.focus) @ pose.axis, sight.worth[seen]
        depth = quantile(along, worth, FLOOR) if pose.deep else float(along @ worth / worth.sum())
        pose = replace(pose, focus=pose.focus + depth * pose.axis)
    return scored(sight, ring, pose)[0]


def better(sight: Sight, ring: RingShape, pose: Pose) -> Pose:
    """The best pose near this one, by tilts and shifts that get smaller."""
    pose = levelled(sight, ring, levelled(sight, ring, pose))
    tilt, shift = FIRST_TILT, SHIFT * min(ring.fov)
    for _ in range(MOST_STEPS):
        if tilt < LAST_TILT:
            break
        first, second = across(pose.axis)
        turns = [np.cos(tilt) * pose.axis + np.sin(tilt) * side for side in (first, -first, second, -second)]
        height = _height(sight, ring, pose)
        tried = [replace(pose, focus=pose.focus + height * (pose.axis - axis), axis=axis) for axis in turns]
        tried += [replace(pose, focus=pose.focus + shift * side) for side in (first, -first, second, -second)]
        best = max((scored(sight, ring, one)[0] for one in tried), key=lambda one: one.worth)
        if best.worth > (1 + GAIN) * pose.worth:
            pose = levelled(sight, ring, best)
        else:
            tilt, shift = tilt / 2, shift / 2
    return pose


def _height(sight: Sight, ring: RingShape, pose: Pose) -> float:
    """How far above the focus the middle of what is seen lies [mm]: turned about it, the ring keeps that in view."""
    _, seen = scored(sight, ring, pose)
    return float(np.mean((sight.points[seen] - pose.focus) @ pose.axis)) if seen.any() else 0.0
