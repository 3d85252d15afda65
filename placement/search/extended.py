"""Known layouts of as many or fewer cameras, made up to as many as are wanted: more cameras are never worse."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from placement.errors import PlacementError
from placement.layouts.arcs import LayoutSpace

if TYPE_CHECKING:
    from placement.problem import Problem


def checked_starts(starts: Sequence, n_cameras: int) -> tuple[tuple[float, ...], ...]:
    """Layouts to start from, as they are kept.

    Raises
    ------
    PlacementError
        If one of them is no layout of 1 to `n_cameras` ring angles.
    """
    layouts = [np.asarray(start, dtype=np.float64) for start in starts]
    for number, layout in enumerate(layouts, start=1):
        if layout.ndim != 1 or not 1 <= layout.size <= n_cameras or not np.isfinite(layout).all():
            raise PlacementError(
                f"start {number} is {layout.tolist()}; a layout to start from has 1 to {n_cameras} finite ring "
                "angles [rad]"
            )
    return tuple(tuple(layout.tolist()) for layout in layouts)


def extended(problem: "Problem", space: LayoutSpace, starts: Sequence[Sequence[float]]) -> list[np.ndarray]:
    """Layouts of `space` from others with as many cameras or fewer, each camera more where most samples gain by it.

    Exact areas do not shrink by it. What leaves no room for as many, or breaks the constraints, is left out.
    """
    coverage, _ = problem.coverage(space.constraints)
    found = []
    for start in starts:
        theta = np.array(start, dtype=np.float64)
        while len(theta) < space.n_cameras:
            worths = np.where(space.allowed(coverage.grid, theta), coverage.worth_with_one_more(theta), -np.inf)
            if not np.isfinite(worths).any():
                break
            theta = np.append(theta, coverage.grid[int(worths.argmax())])
        if len(theta) == space.n_cameras and space.allows(theta):
            found.append(theta)
    return found
