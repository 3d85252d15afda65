"""What layouts on a grid of places of several rings can reconstruct at most, proven on the surface itself."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

import exact
from placement.layouts.constraints import LENGTH_TOLERANCE
from placement.proof.certificate import PROOF_TOLERANCE, grid_places
from placement.proof.surface import weighted_sets
from placement.rings.ring_places import Places, RingsSpace, cameras_of
from placement.rings.rings_program import RingsProgram, solve
from placement.rings.rings_scoring import RingsScorer
from placement.settings import Settings


@dataclass(frozen=True)
class RingsBound:
    """An upper bound for layouts on the grid, from exact areas: fractions of the maximum of all rings together.

    Attributes
    ----------
    bound_fraction : float
        No layout with its free cameras at multiples of `step` on any of the rings reconstructs more of the surface.
    fraction : float or None
        What the best layout found there reconstructs, exactly; None if there is none, or none was found in time.
    ring_of, angles : tuple or None
        That layout: which ring each camera sits on, and its ring angle [rad].
    proven : bool
        Whether the two differ by 0.2 % at most.
    gap : float or None
        `bound_fraction` less the fraction of the layout proposed; below 0 if that, off the grid, beats every layout on
        it.
    step : float
        Of the grid [rad].
    n_places, n_sets : int
        Places on the rings, and sets of cameras whose areas decide.
    small_fraction : float
        What small sets add to the bound, which count as covered by any layout.
    method : str
        "enumeration" or "mixed-integer program".
    seconds : float
        Time taken [s].
    ignores_error : bool
        Whether a bound on the predicted error was asked for, which this bound leaves out.
    ignores_disparity : bool
        The same of a bound on the disparity gradient.
    """

    bound_fraction: float
    fraction: float | None
    ring_of: tuple[int, ...] | None
    angles: tuple[float, ...] | None
    proven: bool
    gap: float | None
    step: float
    n_places: int
    n_sets: int
    small_fraction: float
    method: str
    seconds: float = field(compare=False)
    ignores_error: bool
    ignores_disparity: bool = False

    @property
    def statement(self) -> str:
        """What is proven, in words."""
        words = (
            f"On the surface itself no layout with cameras at multiples of {np.degrees(self.step):g} degrees on these "
            f"rings reconstructs more than {self.bound_fraction:.2%} of the maximum of all rings together "
            f"({self.method} over the exact areas of {self.n_sets} sets of cameras)"
        )
        if self.fraction is not None:
            words += f"; the best one found there reconstructs {self.fraction:.2%}"
        if not self.proven:
            words += ", and time ran out before more was known" if self.method != "enumeration" else ""
        left_out = ["the error"] * self.ignores_error + ["the disparity gradient"] * self.ignores_disparity
        return words + "." + (f" Bounds on {' and '.join(left_out)} are left out; it may be loose." if left_out else "")


def bounded(scorer: RingsScorer, settings: Settings) -> tuple[RingsBound, Places | None]:
    """Bound layouts on the grid, and give the best one found there."""
    begun, space, demand = time.perf_counter(), scorer.space, scorer.demand
    n_grid = grid_places(settings)
    grid, fixed = Places.grid(len(space.rings), n_grid), space.fixed
    program, small = _program(scorer, grid, fixed)
    found = solve(program, settings.certificate_seconds, PROOF_TOLERANCE)
    places = fraction = None
    if found.places is not None:
        chosen = np.flatnonzero(_possible(space, grid))[list(found.places)]
        places = Places.joined([grid.take(chosen), fixed]).canonical()
        fraction = scorer.fraction(places)
    # A layout on the grid is a layout; what one reconstructs may be summed in another order.
    bound = max(found.bound + small, fraction or 0.0)
    made = RingsBound(
        bound_fraction=bound,
        fraction=fraction,
        ring_of=None if places is None else tuple(places.ring.tolist()),
        angles=None if places is None else tuple(places.angles.tolist()),
        proven=bound - (fraction or 0.0) <= 1.01 * PROOF_TOLERANCE,
        gap=None,
        step=2 * np.pi / n_grid,
        n_places=len(grid.ring),
        n_sets=len(program.weights),
        small_fraction=small,
        method=found.method,
        seconds=time.perf_counter() - begun,
        ignores_error=demand.max_error is not None,
        ignores_disparity=demand.max_disparity_gradient is not None,
    )
    return made, places


def measured(bound: RingsBound, fraction: float) -> RingsBound:
    """The same with the gap of a layout that reconstructs this fraction."""
    return replace(bound, gap=bound.bound_fraction - fraction)


def _possible(space: RingsSpace, grid: Places) -> np.ndarray:
    """Places of the grid that go with the fixed cameras, but for rounding."""
    return space.allowed(grid, space.fixed, LENGTH_TOLERANCE)


def _program(scorer: RingsScorer, grid: Places, fixed: Places) -> tuple[RingsProgram, float]:
    space, demand = scorer.space, scorer.demand
    places = grid.take(_possible(space, grid))
    n_places, every = len(places.ring), Places.joined([places, fixed])
    sets = weighted_sets(_sets(scorer, every), scorer.sites, scorer.maximum, demand)
    (seen, weights, site, n_sites), small = sets
    compatible = space.far_enough(places, places, LENGTH_TOLERANCE)
    n_fixed = np.bincount(fixed.ring, minlength=len(space.rings))
    return RingsProgram(
        seen[:n_places].copy(), weights, site, n_sites, space.n_cameras - len(fixed.ring), demand.threshold,
        places.ring, space.most - n_fixed, compatible, seen[n_places:].copy(),
        demand.far(cameras_of(space.rings, every)),
    ), small  # fmt: skip


def _sets(scorer: RingsScorer, places: Places) -> Sequence[tuple[np.ndarray, np.ndarray]]:
    cameras = cameras_of(scorer.space.rings, places)
    found = [
        exact.view_sets(site.scene, cameras, demand=scorer.demand, workers=scorer.workers)
        for site in scorer.sites.members
    ]
    return [(sets.seen, sets.areas) for sets in found]
