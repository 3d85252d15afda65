"""The last tenths of a degree where the area has no derivative that is known: moves of one camera by fixed steps."""

from collections.abc import Callable
from typing import Protocol, runtime_checkable

import numpy as np

from placement.search.polish import WORTHWHILE, Room


@runtime_checkable
class Scored(Protocol):
    """What gives exact fractions; methods as those of `ExactScorer`."""

    def fraction(self, angles) -> float:
        """Exact fraction of the ring maximum for a layout."""
        ...

    def moving(self, angles, camera: int) -> Callable[[float], float]:
        """`fraction` as a function of the ring angle [rad] of one of the cameras, the others held."""
        ...


def polish_by_steps(
    scorer: Scored, space: Room, angles, steps: tuple[float, ...], max_sweeps: int
) -> tuple[np.ndarray, int]:
    """Move one free camera at a time, by falling steps, as long as the exact fraction grows.

    Each move computes the view of the moved camera only.

    Parameters
    ----------
    scorer : Scored
        Gives exact areas.
    steps : tuple of float
        Falling step lengths [rad].
    space, angles, max_sweeps
        As for `polish`.

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
