"""How many cameras: the fewest whose best layout, and whose equidistant ring, reach a target."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

import exact
from exact.whole_numbers import is_whole
from placement.errors import PlacementError
from placement.layouts.arcs import LayoutSpace
from placement.layouts.constraints import Constraints
from placement.progress import Progress, numbered
from placement.proof.certificate import at_most
from placement.results import Placement
from placement.search.rolled_proposal import propose_layout

if TYPE_CHECKING:
    from placement.problem import Problem


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
        The optimised layout; None if cameras of this number do not meet the constraints. Where the target is reached,
        it is the most accurate of those that reach it and give up no more than usual, else the one with most area.
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


def fewest_cameras(demand: exact.Demand, constraints: Constraints) -> int:
    """Cameras without which nothing could meet the request; the demand has the baseline of the constraints.

    Examples
    --------
    >>> fewest_cameras(exact.Demand(1), Constraints()), fewest_cameras(exact.Demand(1, min_baseline=5.0), Constraints())
    (1, 2)
    """
    return max(demand.threshold, len(constraints.fixed), 2 if demand.baseline > 0 else 1)


def refuse_target(target: float, max_cameras: int, demand: exact.Demand, constraints: Constraints) -> range:
    """Numbers of cameras to try.

    Raises
    ------
    PlacementError
        If the target is no fraction, or fewer cameras are allowed than any layout needs.
    """
    if not (isinstance(target, int | float | np.number) and 0 < target <= 1):
        raise PlacementError(f"target is {target!r}; it must be a fraction of the ring maximum, above 0 and at most 1")
    fewest = fewest_cameras(demand, constraints)
    if not is_whole(max_cameras) or max_cameras < fewest:
        raise PlacementError(f"max_cameras is {max_cameras!r}; it must be a whole number, at least {fewest} here")
    return range(fewest, int(max_cameras) + 1)


def recommend(
    problem: "Problem",
    target: float,
    constraints: Constraints,
    numbers: Sequence[int],
    certify: bool = True,
    progress: Progress | None = None,
    on_count: Callable[[CountResult], object] | None = None,
) -> Recommendation:
    """The fewest of these numbers of cameras, increasing, that reach `target`.

    Each search starts from the layouts found for one camera less too, so that the greatest area found never shrinks.
    What bounds one camera more bounds as many as leave room for it; `on_count` is told each result before that is
    known.
    """
    counts: list[CountResult] = []
    n_cameras = n_equidistant = None
    refusal, starts = None, ()
    for n in numbers:
        found = None
        if refusal is None:
            try:
                space = LayoutSpace(problem.ring, n, constraints)
                found = propose_layout(problem, space, certify, numbered(progress, n), target=target, starts=starts)
                starts = tuple(dict.fromkeys((found.most_area.angles, found.angles)))
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
    bounded = bounded_by_more([found.placement for found in counts])
    counts = [replace(found, placement=placed) for found, placed in zip(counts, bounded, strict=True)]
    return Recommendation(float(target), n_cameras, n_equidistant, tuple(counts))


def bounded_by_more(placements: Sequence[Placement | None]) -> list[Placement | None]:
    """Layouts of one camera more each, the bound of each no looser than that of the next, where there is room for it.

    What is asked of them is the same but for the number of cameras.
    """
    bounded = list(placements)
    for i in range(len(bounded) - 2, -1, -1):
        here, more = bounded[i], bounded[i + 1]
        if here is None or more is None or here.certificate is None or more.certificate is None:
            continue
        if LayoutSpace(here.ring, here.n_cameras, here.constraints).leaves_room:
            bounded[i] = replace(here, certificate=at_most(here.certificate, more.certificate))
    return bounded


def _counted(problem: "Problem", n: int, constraints: Constraints, found: Placement | None) -> CountResult:
    if found is not None:
        return CountResult(n, found.equidistant_fraction, found.best_equidistant_fraction, found)
    even = problem.scorer(constraints).fraction(problem.ring.equidistant(n))
    return CountResult(n, even, even, None)
