"""Exact areas and errors of layouts on several rings, each layout once, and the last tenths of a degree."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

import exact
from placement.rings.ring_places import Places, RingsSpace, cameras_of
from placement.search.polish import WINDOW, Move, combined, into_sight, moved_in_turn, polish, turned
from placement.search.ring_maximum import RingMaximum
from placement.search.scoring import squared_errors
from placement.search.steps import polish_by_steps
from placement.settings import Settings
from placement.sites import Sites


class RingsScorer:
    """Exact areas of layouts on several rings over one site or several.

    Parameters
    ----------
    sites : Sites
    space : RingsSpace
    demand : exact.Demand
        What makes a point count.
    maximum : RingMaximum
        Of all rings together.
    workers : int
        Processes that share the work; the areas do not depend on it.
    """

    def __init__(self, sites: Sites, space: RingsSpace, demand: exact.Demand, maximum: RingMaximum, workers: int = 1):
        self.sites, self.space, self.demand = sites, space, demand
        self._maximum, self.workers = maximum, workers
        self._areas: dict[bytes, tuple[float, ...]] = {}

    @property
    def n_scored(self) -> int:
        """How many layouts were evaluated."""
        return len(self._areas)

    @property
    def maximum(self) -> tuple[float, ...]:
        """(S,) exact area of each site that all rings together reconstruct [mm²]."""
        return self._maximum.areas

    def many(self, layouts: Sequence[Places]) -> list[tuple[float, ...]]:
        """(S,) exact areas of the sites [mm²] for each layout."""
        new = {layout.key: layout.canonical() for layout in layouts if layout.key not in self._areas}
        if new:
            cameras = [cameras_of(self.space.rings, layout) for layout in new.values()]
            found = [
                exact.areas(site.scene, cameras, demand=self.demand, workers=self.workers)
                for site in self.sites.members
            ]
            for key, of_sites in zip(new, np.stack(found, axis=1).tolist(), strict=True):
                self._areas[key] = tuple(of_sites)
        return [self._areas[layout.key] for layout in layouts]

    def combined(self, areas: Sequence[float]) -> float:
        """Fraction of the maximum of all rings, over all sites as their objective says, from (S,) areas [mm²]."""
        return self.sites.combined(np.array(areas) / np.array(self.maximum))

    def fraction(self, places: Places) -> float:
        """The same of a layout."""
        return self.combined(self.many([places])[0])

    def error(self, places: Places) -> float:
        """Root mean square of the predicted errors [mm] over all that a layout reconstructs; infinite for nothing."""
        cameras = cameras_of(self.space.rings, places.canonical())
        found = [squared_errors(site.scene, cameras, self.demand) for site in self.sites.members]
        squares, total = (float(sum(values)) for values in zip(*found, strict=True))
        return float(np.sqrt(squares / total)) if total > 0 else np.inf

    def polished(self, places: Places, settings: Settings, thorough: bool) -> tuple[Places, int]:
        """Move cameras along their rings to a local optimum of the exact area, and tell how many places were tried."""
        on_rings = _OnRings(self, places.ring)
        if not self.demand.has_derivative:
            steps = settings.polish_steps
            angles, n = polish_by_steps(on_rings, on_rings, places.angles, steps, settings.polish_sweeps)
        else:
            angles, n = polish(on_rings, on_rings, places.angles, settings.polish_sweeps, thorough)
        return Places(places.ring, angles), n


@dataclass(frozen=True, eq=False)
class _OnRings:
    """Layouts whose cameras stay on their rings, by their angles alone: as `polish` and `polish_by_steps` ask."""

    scorer: RingsScorer
    ring: np.ndarray

    def free_cameras(self, angles) -> np.ndarray:
        return self.scorer.space.free(self._places(angles))

    def allows(self, angles) -> bool:
        return not self.scorer.space.violations(self._places(angles))

    def fraction(self, angles) -> float:
        return self.scorer.fraction(self._places(angles))

    def moving(self, angles, camera: int) -> Callable[[float], float]:
        layouts = self._with_one_more(angles, camera)
        return lambda angle: self.scorer.combined([one.area(self._camera(camera, angle)) for one in layouts])

    def of_all(self, angles: np.ndarray) -> tuple[float, np.ndarray]:
        cameras = cameras_of(self.scorer.space.rings, self._places(angles))
        found = [exact.gradient(site.scene, cameras, demand=self.scorer.demand) for site in self.scorer.sites.members]
        slopes = [np.array([self._slope(one.of_camera(i), i) for i in range(len(cameras))]) for one in found]
        return self._combined([one.area for one in found], slopes)

    def in_turn(self, angles: np.ndarray, cameras: Sequence[int], move: Move) -> np.ndarray:
        scenes = [site.scene for site in self.scorer.sites.members]
        rings = [self.scorer.space.rings[k] for k in self.ring]
        return moved_in_turn(scenes, rings, angles, self.scorer.demand, cameras, move, self._combined)

    def jumps(self, angles: np.ndarray, camera: int, faces: bool) -> np.ndarray:
        ring, angle = self.scorer.space.rings[self.ring[camera]], angles[camera]
        found = [np.zeros(0)]
        if self.scorer.demand.baseline > 0:
            others = self._places(angles).take(np.delete(np.arange(len(angles)), camera))
            positions = self.scorer.space.positions(others)
            found += [turned(_at_distance(ring, one, self.scorer.demand.baseline) - angle) for one in positions]
        if faces:
            found += [into_sight(site.scene, ring, angle) for site in self.scorer.sites.members]
        offset = np.concatenate(found)
        return offset[np.abs(offset) <= WINDOW]

    def _places(self, angles) -> Places:
        return Places(self.ring, np.asarray(angles, dtype=np.float64))

    def _camera(self, camera: int, angle: float) -> exact.Camera:
        (one,) = self.scorer.space.rings[self.ring[camera]].cameras([angle])
        return one

    def _slope(self, derivative: exact.Derivative, camera: int) -> float:
        return float(derivative.on_ring(self.scorer.space.rings[self.ring[camera]]).angle[0])

    def _with_one_more(self, angles, camera: int) -> list[exact.OneMore]:
        others = self._places(angles).take(np.delete(np.arange(len(angles)), camera))
        cameras = cameras_of(self.scorer.space.rings, others)
        return [exact.OneMore(site.scene, cameras, demand=self.scorer.demand) for site in self.scorer.sites.members]

    def _combined(self, areas: list[float], slopes: list[np.ndarray]) -> tuple[float, np.ndarray]:
        sites = self.scorer.sites
        return combined(areas, slopes, self.scorer.maximum, sites.shares, sites.objective)


def _at_distance(ring: exact.Ring, point: np.ndarray, distance: float) -> np.ndarray:
    """(0 or 2,) ring angles [rad] at which a camera is so far from a point (3,) [mm].

    In the frame of the ring |C - P|² = r² + |P|² - 2 r ρ cos(θ - φ), where P lies ρ off the axis, in direction φ, and
    |P| is measured from the centre of the ring.

    Examples
    --------
    >>> ring = exact.Ring()
    >>> np.degrees(_at_distance(ring, ring.positions([0.0])[0], 15.0)).round(9).tolist()
    [-60.0, 60.0]
    """
    x, y, z = (point - np.array(ring.focus)) @ ring.frame - [0.0, 0.0, ring.working_distance]
    radius, across = ring.diameter / 2, np.hypot(x, y)
    cosine = (radius**2 + x * x + y * y + z * z - distance**2) / max(2 * radius * across, np.finfo(float).tiny)
    if abs(cosine) > 1:
        return np.zeros(0)
    away = np.arccos(cosine)
    return np.arctan2(y, x) + np.array([-away, away])
