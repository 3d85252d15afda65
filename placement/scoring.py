"""The one place that turns layouts into exact areas, and what follows from them: polish."""

import os
from collections.abc import Callable

import numpy as np
import trimesh

import exact
from placement.arcs import LayoutSpace

# An improvement of the exact area smaller than this fraction is rounding, not a better layout.
WORTHWHILE = 1e-7
# From this many cameras on, an evaluation is shared among processes: below, starting them takes longer.
MANY_CAMERAS = 64


class ExactScorer:
    """Exact areas of layouts on one ring over one site; each layout is evaluated once.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        The site [mm].
    ring : exact.Ring
        The ring.
    threshold : int
        How many cameras must see a point.
    exclude : (F,) ndarray of bool or None
        Faces that do not count.
    min_baseline : float
        Least chord between some two of the cameras that see a point [mm].
    on_evaluation : callable, optional
        Called with nothing before each evaluation.

    Examples
    --------
    >>> scorer = ExactScorer(trimesh.creation.box((10, 10, 1)), exact.Ring(), threshold=1)
    >>> bool(100.0 <= scorer.area([0.0]) < 120.0), scorer.n_evaluations
    (True, 1)
    """

    def __init__(
        self,
        mesh: trimesh.Trimesh,
        ring: exact.Ring,
        threshold: int = 2,
        exclude: np.ndarray | None = None,
        min_baseline: float = 0.0,
        on_evaluation: Callable[[], object] | None = None,
    ):
        self._mesh, self._ring, self._exclude = mesh, ring, exclude
        self._threshold, self._min_baseline = threshold, min_baseline
        self._on_evaluation = on_evaluation
        self._areas: dict[bytes, float] = {}

    @property
    def n_evaluations(self) -> int:
        """Number of exact evaluations so far."""
        return len(self._areas)

    def area(self, angles) -> float:
        """Exact reconstructable area [mm²] of a layout of (M,) ring angles [rad]."""
        theta = canonical(angles)
        key = theta.tobytes()
        if key not in self._areas:
            if self._on_evaluation is not None:
                self._on_evaluation()
            found = exact.evaluate(
                self._mesh,
                self._ring.cameras(theta),
                threshold=self._threshold,
                exclude=self._exclude,
                min_baseline=self._min_baseline,
                workers=1 if len(theta) < MANY_CAMERAS else min(2, os.cpu_count() or 1),
            )
            self._areas[key] = float(found.area)
        return self._areas[key]


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
    scorer: ExactScorer, space: LayoutSpace, angles, steps: tuple[float, ...], max_evaluations: int
) -> np.ndarray:
    """Move one free camera at a time, by falling steps, as long as the exact area grows.

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
    max_evaluations : int
        New exact evaluations at most.

    Returns
    -------
    (M,) ndarray
        Ring angles [rad] whose exact area is at least that of the start.
    """
    theta = np.array(angles, dtype=np.float64)
    best = scorer.area(theta)
    allowance = scorer.n_evaluations + max_evaluations
    for step in steps:
        improved = True
        while improved:
            improved = False
            for camera in space.free_cameras(theta):
                for move in (step, -step):
                    if scorer.n_evaluations >= allowance:
                        return theta
                    moved = theta.copy()
                    moved[camera] += move
                    if not space.allows(moved):
                        continue
                    area = scorer.area(moved)
                    if area > best * (1 + WORTHWHILE):
                        theta, best, improved = moved, area, True
                        break
    return theta
