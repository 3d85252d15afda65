"""A bound on the surface itself: what layouts on the grid can reconstruct, from exact areas instead of samples.

All grid cameras together divide the surface into parts, each seen by one set of them. With the exact areas of these
sets as weights the grid program has no sampling error.
"""

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

import exact
from exact.demand import SAME_LENGTH
from placement.layouts.arcs import TURN, LayoutSpace
from placement.proof.certificate import (
    PROOF_TOLERANCE,
    Certificate,
    arc_of,
    certify_samples,
    grid_places,
    grid_rules,
    known_on_grid,
    measure,
)
from placement.proof.grid_program import GridProgram
from placement.proof.solver import solve
from placement.proof.surface_bound import SurfaceBound
from placement.sites import Sites

if TYPE_CHECKING:
    from placement.problem import Problem

# Sets of cameras of so little area together, in parts of the ring maximum, count as covered by any layout.
SMALL = 1e-4
# Faces times grid cameras up to which it is done unless something else was asked for: some tens of seconds.
USUAL_WORK = 500_000


def certified(
    problem: "Problem", space: LayoutSpace, demand: exact.Demand, layouts: Sequence[np.ndarray] = ()
) -> Certificate:
    """Bounds for any layout of `space`, on the samples, and on the surface itself as the settings say.

    Good `layouts` of (M,) ring angles [rad] spare the programs the search for one.
    """
    of = problem.sites.of
    certificate = certify_samples(problem.profiles, space, demand, problem.settings, of, layouts)
    if not _is_wanted(problem, space):
        return certificate
    return replace(certificate, surface=certify_surface(problem, space, demand, layouts))


def measured(
    problem: "Problem", certificate: Certificate, space: LayoutSpace, layout, demand: exact.Demand
) -> Certificate:
    """The certificate with the gaps of `layout`, (M,) ring angles [rad], to its bounds."""
    found = measure(certificate, problem.profiles, layout, demand, problem.ring)
    if found.surface is None:
        return found
    fraction = problem.scorer(space.constraints).fraction(layout)
    gap = found.surface.bound_fraction - fraction
    return replace(found, surface=replace(found.surface, layout_fraction=fraction, gap=gap))


def certify_surface(
    problem: "Problem", space: LayoutSpace, demand: exact.Demand, layouts: Sequence[np.ndarray] = ()
) -> SurfaceBound:
    """Bound what any layout of `space` with its free cameras on the grid reconstructs of the surface itself."""
    begun = time.perf_counter()
    n_grid, settings = grid_places(problem.settings), problem.settings
    program, small = surface_program(problem, space, demand, n_grid)
    known = known_on_grid(problem.profiles, space, demand, n_grid, layouts)
    found = solve(program, settings.certificate_seconds, PROOF_TOLERANCE, known)
    angles = fraction = None
    if found.places is not None:
        angles = (*(TURN * np.array(found.places, dtype=float) / n_grid).tolist(), *space.constraints.fixed)
        fraction = problem.scorer(space.constraints).fraction(angles)
    # A layout on the grid is a layout; what one reconstructs may be summed in another order.
    bound = max(found.bound + small, fraction or 0.0)
    return SurfaceBound(
        bound_fraction=bound,
        fraction=fraction,
        angles=angles,
        proven=bound - (fraction or 0.0) <= 1.01 * PROOF_TOLERANCE,
        small_fraction=small,
        n_sets=len(program.weights),
        method=found.method,
        seconds=time.perf_counter() - begun,
        ignores_error=demand.max_error is not None,
    )


def surface_program(
    problem: "Problem", space: LayoutSpace, demand: exact.Demand, n_grid: int
) -> tuple[GridProgram, float]:
    """The choice of grid places by the exact areas of what they see, and the share of what counts as covered anyhow.

    Of a bound on the error it takes nothing but the baseline that goes with it, so that it bounds what is reconstructed
    with any error.
    """
    parts = problem.grid_sets(demand, n_grid, space.constraints.fixed)
    sets, small = weighted_sets(parts, problem.sites, problem.scorer(space.constraints).ring_areas, demand)
    views = sets.seen
    chord = np.full(views.shape[1], demand.baseline * (1 - SAME_LENGTH))
    rules = grid_rules(space, n_grid, arc_of(chord, space.ring))
    return GridProgram(
        views[:n_grid].copy(), sets.weights, space.n_free, demand.threshold, rules.window, rules.allowed, sets.site,
        rules.apart, views[n_grid:].copy(), rules.fixed_at, sets.n_sites,
    ), small  # fmt: skip


class WeightedSets(NamedTuple):
    """Sets of cameras and what they are worth: fields as those of `GridProgram`."""

    seen: Bool[np.ndarray, "K P"]
    weights: Float[np.ndarray, " P"]
    site: Int[np.ndarray, " P"]
    n_sites: int


def weighted_sets(
    parts: Sequence[tuple[np.ndarray, np.ndarray]], sites: Sites, ring_areas: Sequence[float], demand: exact.Demand
) -> tuple[WeightedSets, float]:
    """Sets of K cameras of (S,) sites, shares of their ring maxima, and the share of small ones, which are left out.

    `parts` are of each site the (P, K) sets of cameras that see something, and its area [mm²].
    """
    worst = sites.objective == "worst"
    shares = np.ones(len(parts)) if worst else sites.shares
    seen, weights, numbers = [], [], []
    small = 0.0
    for number, ((of_sets, areas), share, ring_area) in enumerate(zip(parts, shares, ring_areas, strict=True)):
        enough = of_sets.sum(axis=1) >= demand.threshold
        of_sets, weight = of_sets[enough], share * areas[enough] / ring_area
        order = np.argsort(weight, kind="stable")
        left_out = int(np.searchsorted(np.cumsum(weight[order]), SMALL * share, side="right"))
        of_site, kept = float(weight[order[:left_out]].sum()), order[left_out:]
        small = max(small, of_site) if worst else small + of_site
        seen.append(of_sets[kept])
        weights.append(weight[kept])
        numbers.append(np.full(len(kept), number * worst))
    views = np.concatenate(seen).T
    return WeightedSets(views, np.concatenate(weights), np.concatenate(numbers), len(parts) if worst else 1), small


def _is_wanted(problem: "Problem", space: LayoutSpace) -> bool:
    """Whether the settings ask for it, or leave it open and it is usually done in less than half a minute."""
    cameras = grid_places(problem.settings) + len(space.constraints.fixed)
    return problem.settings.certify_on == "surface" or (
        problem.settings.certify_on == "auto" and is_usual(problem.sites, cameras)
    )


def is_usual(sites: Sites, n_cameras: int) -> bool:
    """Whether sets of so many cameras are usually found in less than half a minute."""
    return sum(int(site.scene.counted.sum()) for site in sites.members) * n_cameras <= USUAL_WORK
