"""The last tenths of a degree: cameras moved one at a time on the exact area."""

import numpy as np

from placement.layouts.arcs import LayoutSpace
from placement.search.scoring import ExactScorer

# An improvement of the exact fraction smaller than this is rounding, not a better layout.
WORTHWHILE = 1e-7


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
