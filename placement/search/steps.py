"""The last tenths of a degree where the area has no derivative that is known: moves of one camera by fixed steps."""

import numpy as np

from placement.layouts.arcs import LayoutSpace
from placement.search.polish import WORTHWHILE
from placement.search.scoring import ExactScorer


def polish_by_steps(
    scorer: ExactScorer, space: LayoutSpace, angles, steps: tuple[float, ...], max_sweeps: int
) -> tuple[np.ndarray, int]:
    """Move one free camera at a time, by falling steps, as long as the exact fraction grows.

    Each move computes the view of the moved camera only.

    Parameters
    ----------
    scorer : ExactScorer
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
