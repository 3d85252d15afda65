"""From a candidate to a local optimum of the exact area, by its own derivative."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

import exact
from exact.one_more import in_turn
from exact.workers import processes
from placement.layouts.arcs import LayoutSpace
from placement.sites import Sites

# An improvement of the exact fraction smaller than this is rounding, not a better layout.
WORTHWHILE = 1e-7
# A camera that gains less than this, in parts of the ring maximum, is where it should be, at first and in the end. What
# is left is a few times as much, since others may gain once more when one has moved.
NEARLY_SETTLED, SETTLED = 1e-5, 1e-6
# A better place for a camera is looked for within this of where it is [rad], from a few places on while there is far to
# go, and from enough in the end.
WINDOW = float(np.radians(1.0))
FARTHEST = 16 * WINDOW
FEW_PLACES = WINDOW * np.array([-1.0, -0.3, 0.0, 0.3, 1.0])
MANY_PLACES = WINDOW * np.array([-1.0, -0.75, -0.5, -0.3, -0.15, -0.05, 0.0, 0.05, 0.15, 0.3, 0.5, 0.75, 1.0])
# Further places where slopes promise more, at most; none nearer to an end of its interval than this part of it.
MOST_PLACES, APART = 12, 0.02
# Planes of faces that are looked at in the end, at most, and how far beyond them [rad].
MOST_JUMPS, BEYOND = 6, 1e-7
# Steps of all cameras together along the gradient, of the one that moves most [rad].
JOINT_STEPS = np.radians([0.5, 0.1, 0.02])
# Halvings that find how far a camera may go, to 1e-12 of the window, and how far it stays off that [rad]: angles are
# rounded when they are written.
HALVINGS, CLEARANCE = 40, 1e-9

# Fraction and derivative by the ring angle of one camera, the others held.
Along = Callable[[float], tuple[float, float]]
# Takes (M,) ring angles, the camera whose turn it is, and the fraction along its own; gives its new one [rad], or None.
Move = Callable[[np.ndarray, int, Along], float | None]


@runtime_checkable
class Sloping(Protocol):
    """What has an exact fraction and its derivative by the angles of cameras; methods as those of `Slopes`."""

    def of_all(self, angles: np.ndarray) -> tuple[float, np.ndarray]:
        """The fraction of a layout, and its derivative by all of its (M,) ring angles [1/rad]."""
        ...

    def jumps(self, angles: np.ndarray, camera: int, faces: bool) -> np.ndarray:
        """How far a camera would have to go [rad] to where the area jumps up, within the window."""
        ...

    def in_turn(self, angles: np.ndarray, cameras: Sequence[int], move: Move) -> np.ndarray:
        """Let one camera after another move; (M,) the ring angles [rad] of all of them then."""
        ...


@runtime_checkable
class Room(Protocol):
    """What says where cameras may go; methods as those of `LayoutSpace`."""

    def free_cameras(self, angles) -> np.ndarray:
        """Tell the indices of the cameras that are not fixed."""
        ...

    def allows(self, angles) -> bool:
        """Whether a layout meets every constraint."""
        ...


@dataclass(frozen=True)
class Slopes:
    """Exact fraction of the ring maximum and its derivative, over one site or several.

    Parameters
    ----------
    scenes : (S,) tuple of exact.Scene
    shares : (S,) ndarray of float
        Part of each site in the mean.
    objective : "mean" or "worst"
    ring : exact.Ring
    demand : exact.Demand
        Without a bound on the error, with which there is no derivative.
    ring_areas : (S,) tuple of float
        Ring maximum of each site [mm²].
    """

    scenes: tuple[exact.Scene, ...]
    shares: np.ndarray
    objective: str
    ring: exact.Ring
    demand: exact.Demand
    ring_areas: tuple[float, ...]

    @classmethod
    def of(cls, sites: Sites, ring: exact.Ring, demand: exact.Demand, ring_areas: Sequence[float]) -> "Slopes":
        """For these sites; light enough for another process."""
        scenes = tuple(site.scene.without_mesh() for site in sites.members)
        return cls(scenes, sites.shares, sites.objective, ring, demand, tuple(ring_areas))

    def _combined(self, areas: list[float], slopes: list[np.ndarray]) -> tuple[float, np.ndarray]:
        return combined(areas, slopes, self.ring_areas, self.shares, self.objective)

    def of_all(self, angles: np.ndarray) -> tuple[float, np.ndarray]:
        """The fraction of a layout, and its derivative by all of its (M,) ring angles [1/rad]."""
        cameras = self.ring.cameras(angles)
        found = [exact.gradient(scene, cameras, demand=self.demand) for scene in self.scenes]
        return self._combined([one.area for one in found], [one.on_ring(self.ring).angle for one in found])

    def jumps(self, angles: np.ndarray, camera: int, faces: bool) -> np.ndarray:
        """How far a camera would have to go [rad] to where the area jumps up, within the window.

        It does where the camera is just the baseline away from another, and, looked at if `faces`, where it comes to
        the front of large faces.
        """
        found = [np.zeros(0)]
        if 0 < self.demand.baseline <= self.ring.diameter:
            apart = 2 * np.arcsin(self.demand.baseline / self.ring.diameter)
            others = np.delete(angles, camera)
            found.append(turned(np.concatenate([others - apart, others + apart]) - angles[camera]))
        if faces:
            found += [into_sight(scene, self.ring, angles[camera]) for scene in self.scenes]
        offset = np.concatenate(found)
        return offset[np.abs(offset) <= WINDOW]

    def in_turn(self, angles: np.ndarray, cameras: Sequence[int], move: Move) -> np.ndarray:
        """Let one camera after another move; (M,) the ring angles [rad] of all of them then."""
        return moved_in_turn(self.scenes, [self.ring] * len(angles), angles, self.demand, cameras, move, self._combined)


def moved_in_turn(
    scenes: Sequence[exact.Scene], rings: Sequence[exact.Ring], angles: np.ndarray, demand: exact.Demand,
    which: Sequence[int], move: Move, combine: Callable[[list[float], list[np.ndarray]], tuple[float, np.ndarray]],
) -> np.ndarray:  # fmt: skip
    """(M,) ring angles [rad] after each camera `which`, on its ring of (M,) `rings`, had its turn to `move`."""
    theta = np.array(angles, dtype=np.float64)

    def camera(k: int, angle: float) -> exact.Camera:
        (one,) = rings[k].cameras([angle])
        return one

    def turn(k: int, layouts: list[exact.OneMore]) -> exact.Camera | None:
        def along(angle: float) -> tuple[float, float]:
            found = [layout.gradient(camera(k, angle)) for layout in layouts]
            slopes = [derivative.on_ring(rings[k]).angle for _, derivative in found]
            fraction, slope = combine([area for area, _ in found], slopes)
            return fraction, float(slope[0])

        angle = move(theta, k, along)
        if angle is None:
            return None
        theta[k] = angle
        return camera(k, angle)

    in_turn(scenes, [camera(k, angle) for k, angle in enumerate(theta.tolist())], demand, which, turn)
    return theta


def combined(
    areas: Sequence[float], slopes: Sequence[np.ndarray], ring_areas: Sequence[float], shares: np.ndarray,
    objective: str,
) -> tuple[float, np.ndarray]:  # fmt: skip
    """Fraction of the ring maxima and its derivative, from areas of (S,) sites [mm²] and (M,) derivatives of each."""
    fractions = np.array(areas) / np.array(ring_areas)
    of_sites = np.stack(slopes) / np.array(ring_areas)[:, None]
    if objective == "worst":
        worst = int(fractions.argmin())
        return float(fractions[worst]), of_sites[worst]
    return float(shares @ fractions), shares @ of_sites


def turned(angle: np.ndarray) -> np.ndarray:
    """The same angles from -pi to pi."""
    return np.angle(np.exp(1j * angle))


def into_sight(scene: exact.Scene, ring: exact.Ring, angle: float) -> np.ndarray:
    """(K,) how far a camera would have to go to see the fronts of the largest faces in whose plane it then was."""
    planes, counts = scene.surface.planes, scene.counted & (scene.surface.areas > 0)
    normal = planes.normal[counts] @ ring.frame
    towards = np.arctan2(normal[:, 1], normal[:, 0])
    across = np.hypot(normal[:, 0], normal[:, 1]) * ring.diameter / 2
    level = planes.normal[counts] @ (np.array(ring.focus) - planes.centre) - planes.offset[counts]
    level = level + normal[:, 2] * ring.working_distance
    crosses = np.abs(level) < across
    away = np.arccos(-level[crosses] / across[crosses])
    # A face is seen from an arc about where its normal points.
    area = np.tile(scene.surface.areas[counts][crosses], 2)
    offset = np.concatenate([towards[crosses] - away + BEYOND, towards[crosses] + away - BEYOND]) - angle
    offset = turned(offset)
    near = np.abs(offset) <= WINDOW
    # Faces in one plane come into sight together.
    offset, area = offset[near], area[near]
    place, group = np.unique(np.round(offset, 6), return_inverse=True)
    largest = np.argsort(-np.bincount(group, area, minlength=len(place)), kind="stable")[:MOST_JUMPS]
    return np.array([offset[group == one].mean() for one in largest])


def polish(slopes: Sloping, space: Room, angles, max_sweeps: int, thorough: bool = False) -> tuple[np.ndarray, int]:
    """Move one camera after another to its best place within a degree, until none has a better one.

    Where the area goes on rising, a camera goes on. Slopes tell where between two places there may be a better one,
    also at a kink, which is where many optima are. When no camera gains anything by itself, all of them together take a
    step along the gradient, if that gains.

    Parameters
    ----------
    slopes : Sloping
        Gives exact fractions and their derivatives.
    space : Room
        What is allowed; the layout stays in it.
    angles : (M,) array_like
        Ring angles [rad] to start from.
    max_sweeps : int
        Times that each camera gets its turn, in the mean, at most.
    thorough : bool
        Look at so many places within the degree that hardly a better one is missed.

    Returns
    -------
    (M,) ndarray
        Ring angles [rad] whose exact fraction is at least that of the start.
    int
        Number of places tried.
    """
    theta, n_tried = np.array(angles, dtype=np.float64), 0
    places, settled = (MANY_PLACES, SETTLED) if thorough else (FEW_PLACES, NEARLY_SETTLED)
    free = [int(camera) for camera in space.free_cameras(theta)]
    waiting, turns = list(free), max_sweeps * len(free)

    def move(angles: np.ndarray, camera: int, along: Along) -> float | None:
        nonlocal n_tried, turns, waiting
        waiting.remove(camera)
        if turns == 0:
            return None
        turns -= 1
        looked_at = np.concatenate([places, slopes.jumps(angles, camera, thorough)])
        at, gain, tried = _best_place(along, angles, camera, space, looked_at, settled, thorough)
        n_tried += tried
        if gain > settled:
            waiting += [other for other in free if other not in waiting]
        return at if gain > WORTHWHILE else None

    while waiting and turns > 0:
        theta = slopes.in_turn(theta, list(waiting), move)
        if not waiting:
            theta, gain, tried = _joint_step(slopes, theta, free, space, settled)
            n_tried += tried
            waiting = list(free) if gain > settled else []
    return theta, n_tried


def polish_several(
    slopes: Slopes, space: LayoutSpace, layouts: Sequence, max_sweeps: int, workers: int
) -> list[tuple[np.ndarray, int]]:
    """`polish` of several layouts, shared among processes; the results do not depend on how many."""
    if workers <= 1 or len(layouts) <= 1:
        return [polish(slopes, space, angles, max_sweeps) for angles in layouts]
    with processes(min(workers, len(layouts))) as executor:
        futures = [executor.submit(polish, slopes, space, angles, max_sweeps) for angles in layouts]
        return [future.result() for future in futures]


def _best_place(
    along: Along, theta: np.ndarray, camera: int, space: Room, places: np.ndarray, settled: float, thorough: bool
) -> tuple[float, float, int]:
    """The best angle of a camera near its own, what is gained by it, and how many were tried.

    If `thorough`, none within the window about the best is better either.
    """
    here = theta[camera]
    low, high = (_reach(theta, camera, space, sign) for sign in (-1.0, 1.0))
    offsets = np.unique(np.clip(places, max(low, -WINDOW), min(high, WINDOW)))
    found = {float(offset): along(here + offset) for offset in offsets}
    start = found[0.0][0]
    for sign, end in ((-1.0, low), (1.0, high)):
        at = float(sign * np.max(sign * offsets))
        # As long as it rises, farther and farther: a degree at a time would take long.
        while found[at] == max(found.values()) and sign * found[at][1] > 0 and at != end:
            at = float(sign * min(2 * abs(at), abs(end)))
            found[at] = along(here + at)
    while True:
        for _ in range(MOST_PLACES):
            at, promise = _most_promising(found)
            if promise <= max(value for value, _ in found.values()) + settled / 2:
                break
            found[at] = along(here + at)
        best = max(found, key=lambda offset: (found[offset][0], -abs(offset)))
        ends = {float(np.clip(best + by, low, high)) for by in (-WINDOW, WINDOW)} if thorough else set()
        beyond = [end for end in ends if not min(found) <= end <= max(found)]
        if not beyond:
            return here + best, found[best][0] - start, len(found)
        found |= {end: along(here + end) for end in beyond}


def _most_promising(found: dict[float, tuple[float, float]]) -> tuple[float, float]:
    """Where tangents at neighbouring places meet highest, and how high: what is concave between them stays below."""
    offset = np.array(sorted(found))
    value, slope = np.array([found[at] for at in offset]).T
    left, right = slice(None, -1), slice(1, None)
    width = offset[right] - offset[left]
    rises = (slope[left] > 0) & (slope[right] < 0)
    bend = np.where(rises, slope[left] - slope[right], 1.0)
    step = (value[right] - value[left] - slope[right] * width) / bend
    # Where it is not concave they may meet beyond the interval; its middle is as good as any place.
    inside = rises & (step > 0) & (step < width)
    step = np.where(inside, step, width / 2)
    height = np.where(rises, np.minimum(value[left] + slope[left] * step, value[right] - slope[right] * (width - step)),
                      -np.inf)  # fmt: skip
    if not len(height) or not np.isfinite(height).any():
        return 0.0, -np.inf
    i = int(height.argmax())
    return float(offset[i] + np.clip(step[i], APART * width[i], (1 - APART) * width[i])), float(height[i])


def _reach(theta: np.ndarray, camera: int, space: Room, sign: float) -> float:
    """How far a camera may go one way without passing what it may not, at most `FARTHEST` [rad]."""

    def allowed(by: float) -> bool:
        moved = theta.copy()
        moved[camera] += sign * by
        return space.allows(moved)

    low, high = 0.0, WINDOW
    while allowed(high):
        if high >= FARTHEST:
            return sign * high
        low, high = high, 2 * high
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if allowed(middle) else (low, middle)
    return sign * max(low - CLEARANCE, 0.0)


def _joint_step(
    slopes: Sloping, theta: np.ndarray, free: list[int], space: Room, settled: float
) -> tuple[np.ndarray, float, int]:
    """The layout after the first step of all cameras along the gradient that gains, what it gains, and steps tried."""
    start, slope = slopes.of_all(theta)
    towards = np.zeros_like(theta)
    towards[free] = slope[free]
    if not towards.any():
        return theta, 0.0, 1
    towards /= np.abs(towards).max()
    for tried, step in enumerate(JOINT_STEPS, start=2):
        moved = theta + step * towards
        if space.allows(moved):
            gain = slopes.of_all(moved)[0] - start
            if gain > settled:
                return moved, gain, tried
    return theta, 0.0, 1 + len(JOINT_STEPS)
