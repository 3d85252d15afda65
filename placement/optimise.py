"""What one calls about a mesh: where cameras should sit, how far that is from the best possible, how many it takes."""

from collections.abc import Sequence
from typing import Any

import exact
from exact.requests import checked_demand, shows
from placement.errors import refusing
from placement.layouts.arcs import LayoutSpace
from placement.layouts.constraints import Constraints, demanded
from placement.problem import ASKED, Problem
from placement.progress import Progress
from placement.proof.certificate import Certificate
from placement.recommend import Recommendation, refuse_target
from placement.results import Placement
from placement.search.proposal import GIVE_UP
from placement.sites import Surfaces
from placement.trade_off import TradeOff

# What a `Problem` takes beside meshes and ring, with its defaults.
ABOUT = {"settings": None, "seed": 0, "site_weights": None, "objective": "mean", **ASKED}


@shows({**ABOUT, "workers": None})
def optimise(
    mesh: Surfaces,
    ring: exact.Ring,
    n_cameras: int = 4,
    *,
    constraints: Constraints | None = None,
    certify: bool = True,
    give_up: float = GIVE_UP,
    starts: Sequence = (),
    progress: Progress | None = None,
    **about: Any,
) -> Placement:
    """Find where `n_cameras` cameras on `ring` reconstruct the most of one site or several.

    Parameters
    ----------
    mesh, ring, progress
        See `Problem`.
    n_cameras : int
        Number of cameras M.
    constraints : Constraints, optional
        What every layout must meet; by default cameras at least 5 mm apart.
    certify : bool
        Also bound what any layout could reconstruct (`Placement.certificate`), within
        `settings.certificate_seconds`; a better layout found on the way is taken.
    give_up : float
        Coverage that may be given up for accuracy, as a fraction of the ring maximum: of layouts within so much of the
        greatest exact area found, and with no less than equidistant ones, the one with the least error is proposed. 0
        proposes the one with the greatest area.
    starts : sequence of (K,) array_like
        Known layouts [rad] of at most M cameras to start from too, as those found for M - 1: what is missing is added,
        so that `most_area` reconstructs at least as much as each of them that leaves room for it.
    settings, seed, site_weights, objective, workers, exclude, face_weights, threshold, min_baseline, demand
        See `Problem`. The same request with the same seed gives the same layout, bit for bit, unless the certificate
        runs out of time: which layouts it knows then depends on how fast the machine is.

    Returns
    -------
    Placement
        Neither `most_area` nor the layout proposed ever has less area than the best equidistant layout tried that meets
        the constraints.

    Raises
    ------
    PlacementError
        If the request cannot be met; the message says why and what would be feasible.

    Examples
    --------
    >>> import trimesh
    >>> from dataclasses import replace
    >>> from placement import Settings
    >>> step = trimesh.util.concatenate([trimesh.creation.box((30, 30, 1)), trimesh.creation.box((1, 8, 30))])
    >>> quick = replace(Settings(), n_samples=500, n_angles=36, n_starts=4, n_start_phases=2, ring_cameras=16)
    >>> result = optimise(step, exact.Ring(), n_cameras=3, settings=replace(quick, polish_steps=()))
    >>> bool(result.area >= result.best_equidistant_area), bool(result.smallest_separation >= 5.0)
    (True, True)
    """
    _refuse_beforehand(ring, n_cameras, constraints, about)
    return Problem(mesh, ring, progress=progress, ahead=True, **about).optimise(
        n_cameras, constraints, certify=certify, give_up=give_up, starts=starts, progress=progress
    )


@shows(ABOUT)
def certify(
    mesh: Surfaces,
    ring: exact.Ring,
    n_cameras: int = 4,
    *,
    constraints: Constraints | None = None,
    layout=None,
    **about: Any,
) -> Certificate:
    """Bound what any layout of a request can reconstruct.

    Parameters
    ----------
    mesh, ring, n_cameras, constraints, settings, seed, site_weights, objective, exclude, face_weights, threshold, \
min_baseline, demand
        The request, as for `optimise`; `settings.certificate_step` and `settings.certificate_seconds` say how.
    layout : (M,) array_like, optional
        Ring angles [rad] whose gap to the bounds is wanted; as many as `n_cameras`, and within the constraints.

    Raises
    ------
    PlacementError
        If the request cannot be met, or `layout` is none that it bounds.

    Examples
    --------
    >>> import numpy as np, trimesh
    >>> from dataclasses import replace
    >>> from placement import Settings
    >>> step = trimesh.util.concatenate([trimesh.creation.box((30, 30, 1)), trimesh.creation.box((1, 8, 30))])
    >>> quick = replace(Settings(), n_samples=500, n_angles=36, certificate_step=float(np.radians(10)))
    >>> found = certify(step, exact.Ring(), n_cameras=2, settings=quick)
    >>> found.proven, bool(found.grid_fraction <= found.grid_bound_fraction <= found.bound_fraction <= 1)
    (True, True)
    """
    _refuse_beforehand(ring, n_cameras, constraints, about)
    return Problem(mesh, ring, **about).certify(n_cameras, constraints, layout=layout)


@shows({**ABOUT, "workers": None})
def recommend_count(
    mesh: Surfaces,
    ring: exact.Ring,
    target: float = 0.99,
    *,
    constraints: Constraints | None = None,
    certify: bool = True,
    max_cameras: int = 16,
    progress: Progress | None = None,
    **about: Any,
) -> Recommendation:
    """Find the fewest cameras that reach `target`, optimised and equidistant.

    Numbers are tried one after another until both have reached it, or `max_cameras`.

    Parameters
    ----------
    mesh, ring, constraints, certify, progress, settings, seed, site_weights, objective, workers, exclude, \
face_weights, threshold, min_baseline, demand
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
    >>> import trimesh
    >>> from placement import Settings
    >>> quick = Settings(n_samples=500, n_angles=36, n_starts=2, ring_cameras=16, polish_steps=())
    >>> step = trimesh.util.concatenate([trimesh.creation.box((30, 30, 1)), trimesh.creation.box((1, 8, 30))])
    >>> found = recommend_count(step, exact.Ring(), target=0.9, settings=quick, max_cameras=4, certify=False)
    >>> found.n_cameras, found.placement.fraction >= 0.9
    (4, True)
    """
    limits = Constraints() if constraints is None else constraints
    with refusing():
        demand = checked_demand(about)
    refuse_target(target, max_cameras, demanded(demand, limits, ring), limits)
    return Problem(mesh, ring, progress=progress, ahead=True, **about).count(
        target, limits, certify=certify, max_cameras=max_cameras, progress=progress
    )


@shows({**ABOUT, "workers": None})
def tradeoff(
    mesh: Surfaces,
    ring: exact.Ring,
    n_cameras: int = 4,
    *,
    constraints: Constraints | None = None,
    certify: bool = True,
    progress: Progress | None = None,
    **about: Any,
) -> TradeOff:
    """Find what accuracy costs in area: layouts of which none has both more area and less error.

    Parameters
    ----------
    mesh, ring, n_cameras, constraints, certify, progress, settings, seed, site_weights, objective, workers, exclude, \
face_weights, threshold, min_baseline, demand
        As for `optimise`.

    Returns
    -------
    TradeOff
        Each layout with its exact area and the root mean square of its predicted errors.

    Raises
    ------
    PlacementError
        If the request cannot be met, or single cameras count, which triangulate nothing.

    Examples
    --------
    >>> import trimesh
    >>> from placement import Settings
    >>> quick = Settings(n_samples=500, n_angles=36, n_starts=4, ring_cameras=16, exact_candidates=2)
    >>> step = trimesh.util.concatenate([trimesh.creation.box((30, 30, 1)), trimesh.creation.box((1, 8, 30))])
    >>> found = tradeoff(step, exact.Ring(), n_cameras=3, settings=quick, certify=False)
    >>> errors = [layout.error_rms for layout in found.layouts]
    >>> errors == sorted(errors, reverse=True), found.knee in found.layouts
    (True, True)
    """
    _refuse_beforehand(ring, n_cameras, constraints, about)
    return Problem(mesh, ring, progress=progress, ahead=True, **about).tradeoff(
        n_cameras, constraints, certify=certify, progress=progress
    )


def place(
    problem: Problem,
    n_cameras: int = 4,
    constraints: Constraints | None = None,
    certify: bool = True,
    progress: Progress | None = None,
) -> Placement:
    """Find the best layout of a `Problem`: the same as `Problem.optimise`.

    Examples
    --------
    >>> import trimesh
    >>> from placement import Settings
    >>> quick = Settings(n_samples=200, n_angles=12, n_starts=2, ring_cameras=8, polish_steps=())
    >>> problem = Problem(trimesh.creation.box((30, 30, 5)), exact.Ring(), settings=quick)
    >>> len(place(problem, 2, certify=False).angles)
    2
    """
    return problem.optimise(n_cameras, constraints, certify=certify, progress=progress)


def _refuse_beforehand(
    ring: exact.Ring, n_cameras: int, constraints: Constraints | None, about: dict[str, Any]
) -> None:
    """Refuse what can never be met, before anything is computed."""
    space = LayoutSpace(ring, n_cameras, Constraints() if constraints is None else constraints)
    with refusing():
        demand = checked_demand(about)
    demanded(demand, space.constraints, ring, space.n_cameras)
