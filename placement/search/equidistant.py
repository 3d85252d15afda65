"""Equidistant rings to compare with: at every phase on the samples, the leading few exactly."""

from typing import TYPE_CHECKING

import numpy as np

from placement.layouts.arcs import LayoutSpace
from placement.layouts.constraints import Constraints

if TYPE_CHECKING:
    from placement.problem import Problem


def compared_phases(problem: "Problem", space: LayoutSpace) -> tuple[float, ...]:
    """Phase 0 and those that reconstruct most of the samples [rad], ascending; constraints do not matter here."""
    settings, (coverage, _) = problem.settings, problem.coverage(space.constraints)
    phases = 2 * np.pi / space.n_cameras * np.arange(settings.n_phases) / settings.n_phases
    worth = [coverage.worth(space.ring.equidistant(space.n_cameras, phase)) for phase in phases]
    leading = np.argsort(-np.array(worth), kind="stable")[: settings.exact_phases]
    return tuple(phases[sorted({0, *leading.tolist()})].tolist())


def best_equidistant_phase(problem: "Problem", n_cameras: int, constraints: Constraints | None = None) -> float:
    """Phase of the equidistant ring that reconstructs most, exactly.

    Parameters
    ----------
    problem : Problem
        `settings.n_phases` are looked at on the samples, the leading `settings.exact_phases` are scored exactly.
    n_cameras : int
        M.
    constraints : Constraints, optional
        Only their baseline matters here: equidistant rings are there to compare with, allowed or not.

    Returns
    -------
    float
        Phase [rad], from 0 to 2 pi / M.

    Examples
    --------
    >>> import exact, trimesh
    >>> from placement import Problem, Settings
    >>> quick = Settings(n_samples=200, n_angles=36, n_phases=4, ring_cameras=8)
    >>> problem = Problem(trimesh.creation.box((60, 10, 1)), exact.Ring(), settings=quick)
    >>> round(float(np.degrees(best_equidistant_phase(problem, 2))))  # fields of view are wide along the plate
    90
    """
    space = LayoutSpace(problem.ring, n_cameras, Constraints() if constraints is None else constraints)
    scorer, phases = problem.scorer(space.constraints), compared_phases(problem, space)
    layouts = [space.ring.equidistant(space.n_cameras, phase) for phase in phases]
    scorer.many(layouts)
    return phases[int(np.argmax([scorer.fraction(layout) for layout in layouts]))]
