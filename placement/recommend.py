"""How many cameras: the fewest whose best layout, and whose equidistant ring, reach a target."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import trimesh

import exact
from placement.constraints import Constraints
from placement.errors import PlacementError
from placement.optimise import place
from placement.problem import Problem, Progress
from placement.results import Placement
from placement.settings import Settings
from placement.sites import Objective


@dataclass(frozen=True)
class CountResult:
    """What cameras of one number reconstruct.

    Attributes
    ----------
    n_cameras : int
    equidistant_fraction : float
        Exact fraction of the ring maximum with the equidistant ring at phase 0.
    best_equidistant_fraction : float
        The same at the best phase tried.
    placement : Placement or None
        The optimised layout; None if cameras of this number do not meet the constraints.
    """

    n_cameras: int
    equidistant_fraction: float
    best_equidistant_fraction: float
    placement: Placement | None

    @property
    def fraction(self) -> float | None:
        """Exact fraction of the ring maximum of the optimised layout."""
        return None if self.placement is None else self.placement.fraction


@dataclass(frozen=True)
class Recommendation:
    """The fewest cameras that reach a target.

    Attributes
    ----------
    target : float
        Fraction of the ring maximum.
    n_cameras : int or None
        Fewest cameras whose optimised layout reaches it; None if none of those tried does.
    n_equidistant : int or None
        Fewest cameras whose equidistant ring at phase 0 reaches it; None if none of those tried does.
    counts : tuple of CountResult
        All numbers tried, increasing.
    """

    target: float
    n_cameras: int | None
    n_equidistant: int | None
    counts: tuple[CountResult, ...]

    @property
    def placement(self) -> Placement | None:
        """The optimised layout with `n_cameras` cameras."""
        return next((found.placement for found in self.counts if found.n_cameras == self.n_cameras), None)

    @property
    def saved(self) -> int | None:
        """Cameras saved against an equidistant ring, where both reach the target."""
        return None if self.n_cameras is None or self.n_equidistant is None else self.n_equidistant - self.n_cameras


def recommend_count(
    mesh: trimesh.Trimesh | Sequence[trimesh.Trimesh],
    ring: exact.Ring,
    target: float = 0.99,
    threshold: int = 2,
    exclude: np.ndarray | Sequence[np.ndarray | None] | None = None,
    constraints: Constraints | None = None,
    settings: Settings | None = None,
    seed: int = 0,
    progress: Progress | None = None,
    certify: bool = True,
    max_cameras: int = 16,
    face_weights: np.ndarray | Sequence[np.ndarray | None] | None = None,
    site_weights: Sequence[float] | None = None,
    objective: Objective = "mean",
    workers: int | None = None,
) -> Recommendation:
    """Find the fewest cameras that reach `target`, optimised and equidistant.

    Numbers are tried one after another until both have reached it, or `max_cameras`.

    Parameters
    ----------
    mesh, ring, threshold, exclude, constraints, settings, seed, progress, certify, face_weights, site_weights, \
objective, workers
        As for `optimise`.
    target : float
        Fraction of the ring maximum, above 0 and at most 1.
    max_cameras : int
        Most cameras to try.

    Returns
    -------
    Recommendation
        With a certificate for each number, unless `certify` is False.

    Raises
    ------
    PlacementError
        If the request makes no sense, or not even the fewest cameras can meet the constraints.

    Examples
    --------
    >>> quick = Settings(n_samples=500, n_angles=36, n_starts=2, ring_cameras=16, polish_steps=(), exact_candidates=1)
    >>> step = trimesh.util.concatenate([trimesh.creation.box((30, 30, 1)), trimesh.creation.box((1, 8, 30))])
    >>> found = recommend_count(step, exact.Ring(), target=0.9, settings=quick, max_cameras=4, certify=False)
    >>> found.n_cameras, found.placement.fraction >= 0.9
    (4, True)
    """
    constraints = Constraints() if constraints is None else constraints
    if not (isinstance(target, int | float | np.number) and 0 < target <= 1):
        raise PlacementError(f"target is {target!r}; it must be a fraction of the ring maximum, above 0 and at most 1")
    needs_two = constraints.baseline(ring) > 0
    fewest = max(threshold, len(constraints.fixed), 2 if needs_two else 1)
    if not isinstance(max_cameras, int | np.integer) or max_cameras < fewest:
        raise PlacementError(f"max_cameras is {max_cameras!r}; it must be a whole number, at least {fewest} here")
    problem = Problem(
        mesh, ring, threshold, exclude, settings, seed, face_weights, site_weights, objective, workers, progress
    )
    return recommend(problem, target, constraints, range(fewest, max_cameras + 1), certify, progress)


def recommend(
    problem: Problem,
    target: float,
    constraints: Constraints,
    numbers: Sequence[int],
    certify: bool = True,
    progress: Progress | None = None,
    on_count: Callable[[CountResult], object] | None = None,
) -> Recommendation:
    """`recommend_count` for a `Problem`, with these numbers of cameras, increasing.

    `on_count` is told each result as soon as it is there.
    """
    counts: list[CountResult] = []
    n_cameras = n_equidistant = None
    refusal = None
    for n in numbers:
        found = None
        if refusal is None:
            try:
                found = place(problem, n, constraints, certify, _numbered(progress, n))
            except PlacementError as error:  # as many do not fit, nor do more
                refusal = error
                if not counts:
                    raise
        counts.append(_counted(problem, n, constraints, found))
        if on_count is not None:
            on_count(counts[-1])
        if n_cameras is None and found is not None and found.fraction >= target:
            n_cameras = n
        if n_equidistant is None and counts[-1].equidistant_fraction >= target:
            n_equidistant = n
        if n_equidistant is not None and (n_cameras is not None or refusal is not None):
            break
    return Recommendation(float(target), n_cameras, n_equidistant, tuple(counts))


def _counted(problem: Problem, n: int, constraints: Constraints, found: Placement | None) -> CountResult:
    if found is not None:
        return CountResult(n, found.equidistant_fraction, found.best_equidistant_fraction, found)
    even = problem.scorer(constraints).fraction(problem.ring.equidistant(n))
    return CountResult(n, even, even, None)


def _numbered(progress: Progress | None, n: int) -> Progress | None:
    if progress is None:
        return None
    return lambda what, done, total: progress(f"{n} cameras: {what}", done, total)
