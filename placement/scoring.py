"""The one place that turns layouts into exact areas, and what follows from them: polish."""

import os
from collections.abc import Callable, Sequence

import numpy as np

import exact
from placement.arcs import LayoutSpace
from placement.ring_maximum import RingMaximum, evaluation
from placement.sites import Sites

# An improvement of the exact fraction smaller than this is rounding, not a better layout.
WORTHWHILE = 1e-7


class ExactScorer:
    """Exact areas of layouts on one ring over one site or several; each layout is evaluated once.

    Parameters
    ----------
    sites : Sites
        What is to be reconstructed.
    ring : exact.Ring
        The ring.
    threshold : int
        How many cameras must see a point.
    min_baseline : float
        Least chord between some two of the cameras that see a point [mm].
    ring_maximum : RingMaximum, optional
        Of these sites and this ring.
    workers : int
        Processes that share the work; the areas do not depend on it.

    Examples
    --------
    >>> import trimesh
    >>> from placement.sites import checked_sites
    >>> plate = checked_sites(trimesh.creation.box((10, 10, 1)))
    >>> scorer = ExactScorer(plate, exact.Ring(), 1, ring_maximum=RingMaximum(plate, exact.Ring(), 1, n_cameras=8))
    >>> bool(100.0 <= scorer.areas([0.0])[0] < 120.0), bool(0.5 < scorer.fraction([0.0]) < 1.0)
    (True, True)
    """

    def __init__(
        self,
        sites: Sites,
        ring: exact.Ring,
        threshold: int = 2,
        min_baseline: float = 0.0,
        ring_maximum: RingMaximum | None = None,
        workers: int = 1,
    ):
        self.sites, self.ring, self.threshold, self.min_baseline = sites, ring, threshold, min_baseline
        self._workers = workers
        self._areas: dict[bytes, tuple[float, ...]] = {}
        self._ring_maximum = ring_maximum or RingMaximum(sites, ring, threshold, workers=workers)

    @property
    def ring_areas(self) -> tuple[float, ...]:
        """(S,) exact area [mm²] of the ring maximum of each site."""
        return self._ring_maximum.areas

    def areas(self, angles) -> tuple[float, ...]:
        """Exact reconstructable area [mm²] of each site for a layout of (M,) ring angles [rad]."""
        return self.many([angles])[0]

    def many(self, layouts: Sequence, report: Callable[[int], object] | None = None) -> list[tuple[float, ...]]:
        """`areas` of several layouts; `report` is told 1 for each evaluation."""
        turned = [canonical(layout) for layout in layouts]
        new = list({theta.tobytes(): theta for theta in turned if theta.tobytes() not in self._areas}.values())
        if new:
            cameras = [self.ring.cameras(theta) for theta in new]
            requests = [evaluation(site, self.threshold, self.min_baseline) for site in self.sites.members]
            found = [
                exact.areas(**request, layouts=cameras, workers=self._workers, report=report) for request in requests
            ]
            for theta, of_sites in zip(new, np.stack(found, axis=1).tolist(), strict=True):
                self._areas[theta.tobytes()] = tuple(of_sites)
        return [self._areas[theta.tobytes()] for theta in turned]

    def fraction(self, angles) -> float:
        """Exact fraction of the ring maximum for a layout, over all sites as their objective says."""
        return self.combined(self.areas(angles))

    def combined(self, areas: Sequence[float]) -> float:
        """Fraction of the ring maximum, over all sites, from their (S,) areas [mm²]."""
        return self.sites.combined(np.array(areas) / np.array(self.ring_areas))

    def moving(self, angles, camera: int) -> Callable[[float], float]:
        """`fraction` of a layout as a function of the ring angle [rad] of one of its cameras, the others held."""
        others = self.ring.cameras(np.delete(angles, camera)) if len(angles) > 1 else ()
        layouts = [
            exact.OneMore(**evaluation(site, self.threshold, self.min_baseline), others=others)
            for site in self.sites.members
        ]
        return lambda angle: self.combined([one.area(self.ring.cameras([angle])[0]) for one in layouts])


def available_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def canonical(angles) -> np.ndarray:
    """(M,) the same layout with ring angles increasing in [0, 2 pi).

    Examples
    --------
    >>> canonical([7.0, -1.0, 2.0]).round(3).tolist()
    [0.717, 2.0, 5.283]
    """
    turned = np.mod(np.asarray(angles, dtype=np.float64), 2 * np.pi)
    turned[turned >= 2 * np.pi] = 0.0  # np.mod rounds tiny negative angles up to a full turn
    return np.sort(turned)


def distinct(layouts: list[np.ndarray], tolerance: float) -> list[int]:
    """Indices of the layouts that differ from every one before them, whatever the order of the cameras.

    Parameters
    ----------
    layouts : list of (M,) ndarray
        Ring angles [rad], best layout first.
    tolerance : float
        Two layouts are the same if no camera differs by more [rad].

    Examples
    --------
    >>> distinct([np.array([0.0, 1.0]), np.array([1.0, 6.28]), np.array([0.0, 2.0])], 0.01)
    [0, 2]
    """
    if not layouts:
        return []
    sorted_angles = np.stack([canonical(layout) for layout in layouts])
    first_is = (np.arange(sorted_angles.shape[1])[:, None] + np.arange(sorted_angles.shape[1])) % sorted_angles.shape[1]
    kept: list[int] = []
    for i, this in enumerate(sorted_angles):
        turns = this[first_is]  # (M, M): the same cameras, counted from each of them
        difference = np.abs(turns[:, None, :] - sorted_angles[kept])
        difference = np.minimum(difference, 2 * np.pi - difference).max(axis=2)
        if not (difference <= tolerance).any():
            kept.append(i)
    return kept


def polish(
    scorer: ExactScorer, space: LayoutSpace, angles, steps: tuple[float, ...], max_sweeps: int
) -> tuple[np.ndarray, int]:
    """Move one free camera at a time, by falling steps, as long as the exact fraction grows.

    Each move computes the view of the moved camera only.

    Parameters
    ----------
    scorer : ExactScorer
        Gives exact areas.
    space : LayoutSpace
        What is allowed; the layout stays in it.
    angles : (M,) array_like
        Ring angles [rad] to start from.
    steps : tuple of float
        Falling step lengths [rad].
    max_sweeps : int
        Times that each camera gets its turn at most.

    Returns
    -------
    (M,) ndarray
        Ring angles [rad] whose exact fraction is at least that of the start.
    int
        Number of moves tried.
    """
    theta, n_moves = np.array(angles, dtype=np.float64), 0
    best = scorer.fraction(theta)
    for _ in range(max_sweeps):
        before = best
        for camera in space.free_cameras(theta):
            fraction = scorer.moving(theta, int(camera))
            for step in steps:
                for direction in (step, -step):
                    while True:
                        moved = theta.copy()
                        moved[camera] += direction
                        if not space.allows(moved):
                            break
                        n_moves += 1
                        found = fraction(float(moved[camera]))
                        if found <= best + WORTHWHILE:
                            break
                        theta, best = moved, found
        if best <= before + WORTHWHILE:
            break
    return theta, n_moves
