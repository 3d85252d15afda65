"""Which layouts there may be on several rings: how many cameras each takes, and how far apart they must be."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

import exact
from exact.ring import MOST_CAMERAS
from exact.whole_numbers import is_whole
from placement.errors import PlacementError
from placement.layouts.arcs import TURN, LayoutSpace
from placement.layouts.constraints import LENGTH_TOLERANCE, Constraints
from placement.layouts.distinct import canonical, distinct

# Layouts drawn at random until one keeps cameras of different rings apart, too.
MOST_TRIES = 200


class Places(NamedTuple):
    """Cameras on several rings."""

    ring: Int[np.ndarray, " M"]
    """Which ring each sits on, from 0."""
    angles: Float[np.ndarray, " M"]
    """Ring angles [rad]."""

    def take(self, chosen) -> "Places":
        """Some of them, by mask or index."""
        return Places(self.ring[chosen], self.angles[chosen])

    def with_angle(self, camera: int, angle: float) -> "Places":
        """One of them at another angle of its ring [rad]."""
        angles = self.angles.copy()
        angles[camera] = angle
        return Places(self.ring, angles)

    @staticmethod
    def joined(parts: Sequence["Places"]) -> "Places":
        """Those of all parts, in order."""
        return Places(np.concatenate([one.ring for one in parts]), np.concatenate([one.angles for one in parts]))

    @staticmethod
    def on(ring: int, angles) -> "Places":
        """Cameras that all sit on one ring, at these ring angles [rad]."""
        theta = np.atleast_1d(np.asarray(angles, dtype=np.float64))
        return Places(np.full(len(theta), ring), theta)

    @staticmethod
    def grid(n_rings: int, n_angles: int) -> "Places":
        """Every ring at multiples of 2 pi / n_angles, ring after ring."""
        return Places.joined([Places.on(k, TURN * np.arange(n_angles) / n_angles) for k in range(n_rings)])

    def canonical(self) -> "Places":
        """The same layout by ring, and on each by ring angles that increase in [0, 2 pi)."""
        return Places.joined(
            [Places.on(k, canonical(self.angles[self.ring == k])) for k in np.unique(self.ring).tolist()]
        )

    @property
    def key(self) -> bytes:
        """Equal for the same layout."""
        same = self.canonical()
        return same.ring.astype(np.int64).tobytes() + same.angles.tobytes()


def cameras_of(rings: Sequence[exact.Ring], places: Places) -> tuple[exact.Camera, ...]:
    """(M,) the cameras, in the order of the places.

    Examples
    --------
    >>> rings = exact.Ring(), exact.Ring(diameter=10.0)
    >>> [camera.position.tolist() for camera in cameras_of(rings, Places(np.array([1, 0]), np.zeros(2)))]
    [[5.0, 0.0, 400.0], [15.0, 0.0, 400.0]]
    """
    found: dict[int, exact.Camera] = {}
    for k in np.unique(places.ring):
        here = np.flatnonzero(places.ring == k)
        found |= dict(zip(here.tolist(), rings[k].cameras(places.angles[here]), strict=True))
    return tuple(found[i] for i in range(len(places.ring)))


def distinct_places(layouts: list[Places], tolerance: float) -> list[int]:
    """Indices of the layouts that differ from every one before them by more than `tolerance` [rad] in some camera."""
    kept: list[int] = []
    for i, one in enumerate(layouts):
        if not any(_same(layouts[j], one, tolerance) for j in kept):
            kept.append(i)
    return kept


def _same(one: Places, other: Places, tolerance: float) -> bool:
    if not np.array_equal(np.sort(one.ring), np.sort(other.ring)):
        return False
    pairs = [[layout.angles[layout.ring == k] for layout in (one, other)] for k in np.unique(one.ring)]
    return all(distinct(pair, tolerance) == [0] for pair in pairs)


class RingsSpace:
    """The layouts of M cameras on several rings that meet the constraints.

    Parameters
    ----------
    rings : (K,) tuple of exact.Ring
    n_cameras : int
        Number of cameras M on all of them together, fixed ones included.
    most : (K,) sequence of int or None
        The most cameras that each ring takes; None for as many as there is room for.
    constraints : (K,) tuple of Constraints
        Of each ring. Two cameras are as far apart as the stricter of their rings asks for.

    Raises
    ------
    PlacementError
        If no layout meets them, as far as each ring for itself tells.

    Examples
    --------
    >>> rings = exact.Ring(), exact.Ring(diameter=16.0)
    >>> space = RingsSpace(rings, 3, (None, 1), (Constraints(), Constraints()))
    >>> space.violations(Places(np.array([0, 0, 1]), np.array([0.0, 3.0, 1.0])))
    []
    >>> space.violations(Places(np.array([0, 1, 1]), np.array([0.0, 3.0, 1.0])))
    ['ring 2 holds 2 cameras and takes 1']
    """

    def __init__(
        self,
        rings: tuple[exact.Ring, ...],
        n_cameras: int,
        most: Sequence[int | None],
        constraints: tuple[Constraints, ...],
    ):
        if not (is_whole(n_cameras) and n_cameras >= 1) or isinstance(n_cameras, bool):
            raise PlacementError(f"number of cameras is {n_cameras!r}; it must be a whole number, at least 1")
        if n_cameras > MOST_CAMERAS:
            raise PlacementError(f"number of cameras is {n_cameras}; it must be at most {MOST_CAMERAS}")
        self.rings, self.n_cameras, self.constraints = rings, int(n_cameras), constraints
        asked = [self.n_cameras if one is None else one for one in most]
        if not all(is_whole(one) and one >= 0 and not isinstance(one, bool) for one in asked):
            raise PlacementError(f"most is {tuple(most)!r}; it must give a whole number, or None, for each ring")
        self.most = np.minimum(asked, self.n_cameras).astype(int)
        least = np.array([one.min_separation for one in constraints])
        self.separation = np.maximum(least[:, None], least[None, :])
        # Of baselines it is told by the demand.
        self._own = [replace(one, min_baseline=0.0, min_angle=0.0) for one in constraints]
        self._spaces: dict[tuple[int, int], LayoutSpace | None] = {}
        self.takes = np.array([self._takes(k) for k in range(len(rings))])
        self.fixed = Places.joined([Places.on(k, np.array(one.fixed)) for k, one in enumerate(constraints)])
        self._refuse_impossible()

    def _refuse_impossible(self) -> None:
        for k, own in enumerate(self._own):
            n_fixed = len(own.fixed)
            if n_fixed > self.most[k]:
                raise PlacementError(
                    f"ring {k + 1} takes {self.most[k]} cameras, and {n_fixed} are fixed there; let it take more"
                )
            if n_fixed:
                LayoutSpace(self.rings[k], n_fixed, own)  # which says what contradicts what
        if len(self.fixed.ring) > self.n_cameras:
            raise PlacementError(
                f"{len(self.fixed.ring)} cameras are fixed but the layout has {self.n_cameras}; ask for at least "
                f"{len(self.fixed.ring)}"
            )
        if self.takes.sum() < self.n_cameras:
            each = ", ".join(f"ring {k + 1} {takes}" for k, takes in enumerate(self.takes))
            raise PlacementError(
                f"{self.n_cameras} cameras do not fit on these rings: {each}; ask for fewer cameras, let rings take "
                "more, or ask for less separation"
            )
        if reasons := self._too_near(self.fixed):
            raise PlacementError(f"the fixed cameras contradict the constraints: {reasons[0]}; move a camera")

    def _takes(self, k: int) -> int:
        """How many cameras ring k takes: as many as it may and has room for."""
        return next((n for n in range(self.most[k], 0, -1) if self._space(k, n) is not None), 0)

    def _space(self, k: int, n_cameras: int) -> LayoutSpace | None:
        """Layouts of so many cameras on ring k alone; None if there are none."""
        key = (k, n_cameras)
        if key not in self._spaces:
            try:
                self._spaces[key] = LayoutSpace(self.rings[k], n_cameras, self._own[k])
            except PlacementError:
                self._spaces[key] = None
        return self._spaces[key]

    def positions(self, places: Places) -> Float[np.ndarray, "M 3"]:
        """(M, 3) camera centres [mm]."""
        found = np.zeros((len(places.ring), 3))
        for k in np.unique(places.ring):
            found[places.ring == k] = self.rings[k].positions(places.angles[places.ring == k])
        return found

    def distances(self, places: Places, others: Places) -> Float[np.ndarray, "M O"]:
        """(M, O) distances between camera centres [mm]."""
        return np.linalg.norm(self.positions(places)[:, None] - self.positions(others)[None, :], axis=2)

    def far_enough(self, places: Places, others: Places, slack: float = 0.0) -> Bool[np.ndarray, "M O"]:
        """(M, O) whether cameras are as far apart as they must be, to `slack` [mm]."""
        return self.distances(places, others) >= self.separation[np.ix_(places.ring, others.ring)] - slack

    def allowed(self, candidates: Places, others: Places, slack: float = 0.0) -> Bool[np.ndarray, " C"]:
        """(C,) bool: may one more camera be at each of the (C,) candidates beside the others, to `slack` [mm]."""
        n_there = np.bincount(others.ring, minlength=len(self.rings))
        allowed = (n_there < self.most)[candidates.ring]
        allowed &= self.far_enough(candidates, others, slack).all(axis=1)
        for k, own in enumerate(self._own):
            for start, end in own.forbidden:
                inside, width = np.mod(candidates.angles - start, TURN), np.mod(end - start, TURN)
                margin = slack / self.rings[k].diameter
                allowed &= (candidates.ring != k) | (inside <= margin) | (inside >= width - margin)
        return allowed

    def free(self, places: Places) -> Int[np.ndarray, " m"]:
        """Indices of the cameras of a layout that are not fixed."""
        free = np.ones(len(places.ring), dtype=bool)
        for ring, angle in zip(*self.fixed, strict=True):
            away = np.where(free & (places.ring == ring), np.abs(np.sin((places.angles - angle) / 2)), np.inf)
            free[away.argmin()] = False
        return np.flatnonzero(free)

    def violations(self, places: Places) -> list[str]:
        """Say in words what a layout breaks; empty for one that meets everything."""
        found = [f"the layout has {len(places.ring)} cameras, not {self.n_cameras}"] * (
            len(places.ring) != self.n_cameras
        )
        for k, own in enumerate(self._own):
            here = places.angles[places.ring == k]
            if len(here) > self.most[k]:
                found.append(f"ring {k + 1} holds {len(here)} cameras and takes {self.most[k]}")
            if len(here):
                alone = replace(own, min_separation=0.0)
                found += [f"on ring {k + 1}: {words}" for words in alone.violations(self.rings[k], here)]
            elif own.fixed:
                found.append(f"on ring {k + 1}: no camera at the fixed angle of {np.degrees(own.fixed[0]):.1f} degrees")
        return found + self._too_near(places)

    def _too_near(self, places: Places) -> list[str]:
        near = ~self.far_enough(places, places, LENGTH_TOLERANCE) & ~np.eye(len(places.ring), dtype=bool)
        if not near.any():
            return []
        one, other = np.argwhere(near)[0]
        least = self.separation[places.ring[one], places.ring[other]]
        return [f"two cameras are {self.distances(places, places)[one, other]:.6g} mm apart, less than {least:g} mm"]

    def random(self, rng: np.random.Generator) -> Places | None:
        """A random feasible layout, or None if none was found: which ring takes how many is drawn first."""
        n_fixed = np.bincount(self.fixed.ring, minlength=len(self.rings))
        for _ in range(MOST_TRIES):
            numbers = n_fixed.copy()
            for _ in range(self.n_cameras - numbers.sum()):
                numbers[rng.choice(np.flatnonzero(numbers < self.takes))] += 1
            spaces = [self._space(k, int(n)) for k, n in enumerate(numbers) if n]
            parts = [Places.on(int(k), one.random(rng)) for k, one in zip(np.flatnonzero(numbers), spaces, strict=True)
                     if one is not None]  # fmt: skip
            drawn = Places.joined(parts)
            if len(drawn.ring) == self.n_cameras and not self._too_near(drawn):
                return drawn
        return None
