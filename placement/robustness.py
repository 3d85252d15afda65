"""Can it be built: what a layout keeps when a camera fails or sits askew, and which of its pairs do the work."""

from dataclasses import dataclass

import numpy as np

import exact
from exact.whole_numbers import is_whole
from placement.errors import PlacementError
from placement.layouts.constraints import Constraints
from placement.layouts.distinct import canonical
from placement.pairs import Pair, Pairs
from placement.problem import Problem
from placement.results import Candidate, Placement


@dataclass(frozen=True)
class Robustness:
    """What a layout of M cameras keeps.

    Attributes
    ----------
    angles : (M,) tuple of float
        Ring angles [rad], increasing in [0, 2 pi).
    fraction : float
        Exact fraction of the ring maximum with everything in place.
    failed_fractions : (M,) tuple of float
        The same if that one camera fails.
    mounting_error : float
        Each camera is off by this much to one side or the other [rad].
    mounting_fractions : tuple of float
        The same for layouts off in directions drawn at random.
    pairs : tuple of Pair
        First the pair that sees most of the reconstructable area, then whichever adds most, until hardly anything is
        missing.
    error_rms : float
        Root mean square of the predicted errors [mm] over all that all cameras reconstruct; infinite for one camera.
    accurate_pairs : tuple of Pair
        As few pairs as were found that keep 99 % of the area and, to within 10 %, that error: what to reconstruct from
        (Wachter 2021, section 4). In the order of the area that they add; empty where errors are not finite.
    """

    angles: tuple[float, ...]
    fraction: float
    failed_fractions: tuple[float, ...]
    mounting_error: float
    mounting_fractions: tuple[float, ...]
    pairs: tuple[Pair, ...]
    error_rms: float
    accurate_pairs: tuple[Pair, ...]

    @property
    def worst_failure(self) -> float:
        """Fraction left when the camera fails that is missed most."""
        return min(self.failed_fractions)

    @property
    def mean_failure(self) -> float:
        """Fraction left when any one camera fails, on average."""
        return float(np.mean(self.failed_fractions))

    @property
    def worst_mounting(self) -> float:
        """Least fraction of the layouts that are off."""
        return min(self.mounting_fractions)


@dataclass(frozen=True)
class Consensus:
    """How far the best layouts of a search agree.

    Attributes
    ----------
    fractions : (L,) tuple of float
        Exact fractions of the L best distinct layouts, best first.
    distances : (M,) tuple of float
        For each camera of the layout proposed the median, over the other layouts, of the angle to their camera next to
        it [rad]; 0 for no others. Small where all agree that a camera belongs.
    """

    fractions: tuple[float, ...]
    distances: tuple[float, ...]


def robustness(
    problem: Problem,
    angles,
    constraints: Constraints | None = None,
    mounting_error: float = float(np.radians(1.0)),
    n_mountings: int = 5,
    seed: int = 0,
) -> Robustness:
    """Work out, exactly, what a layout keeps under faults and which pairs of cameras do its work.

    Parameters
    ----------
    problem : Problem
    angles : (M,) array_like
        Ring angles [rad].
    constraints : Constraints, optional
        Only their baseline matters here.
    mounting_error : float
        How far each camera is off along the ring [rad].
    n_mountings : int
        Layouts that are off, each camera to a side drawn at random.
    seed : int
        Of those sides.

    Returns
    -------
    Robustness

    Examples
    --------
    >>> import trimesh
    >>> from placement.settings import Settings
    >>> quick = Settings(n_samples=200, n_angles=12, ring_cameras=8)
    >>> problem = Problem(trimesh.creation.box((10, 10, 1)), exact.Ring(), settings=quick)
    >>> found = robustness(problem, [0.0, 2.0, 4.0], n_mountings=2)
    >>> found.worst_failure <= found.mean_failure <= found.fraction, found.pairs[0].cameras
    (True, (1, 2))
    """
    constraints = Constraints() if constraints is None else constraints
    if not (is_whole(n_mountings) and n_mountings >= 1):
        raise PlacementError(f"n_mountings is {n_mountings!r}; it must be a whole number, at least 1")
    if not (isinstance(mounting_error, int | float | np.number) and 0 <= mounting_error < np.inf):
        raise PlacementError(f"mounting_error is {mounting_error!r}; it must be finite and at least 0 [rad]")
    theta, demand, scorer = canonical(angles), problem.demanded(constraints), problem.scorer(constraints)
    cameras = problem.ring.cameras(theta)
    sets = [
        exact.view_sets(site.scene, cameras, demand=demand, workers=problem.workers) for site in problem.sites.members
    ]
    without = ~np.eye(len(theta), dtype=bool)
    failed = [scorer.combined([of_site.area(demand=demand, cameras=kept) for of_site in sets]) for kept in without]
    sides = np.random.default_rng([seed, 2]).choice([-1.0, 1.0], size=(int(n_mountings), len(theta)))
    askew = scorer.many(list(theta + mounting_error * sides))
    far = demand.far(cameras)
    pairs = Pairs(sets, problem.coverage(constraints)[0], theta, without if far is None else far & without)
    return Robustness(
        tuple(theta.tolist()), scorer.fraction(theta), tuple(failed), mounting_error,
        tuple(scorer.combined(areas) for areas in askew), pairs.by_area(), pairs.error(None), pairs.accurate(),
    )  # fmt: skip


def consensus(result: Placement, n_layouts: int = 10) -> Consensus:
    """Compare the best distinct layouts that were scored exactly.

    Parameters
    ----------
    result : Placement
    n_layouts : int
        Layouts at most.

    Examples
    --------
    >>> import trimesh
    >>> from placement import Settings, optimise
    >>> quick = Settings(n_samples=200, n_angles=12, n_starts=2, ring_cameras=8, polish_steps=())
    >>> found = consensus(optimise(trimesh.creation.box((10, 10, 9)), exact.Ring(), 3, settings=quick, certify=False))
    >>> len(found.distances), found.fractions == tuple(sorted(found.fractions, reverse=True))
    (3, True)
    """
    if not (is_whole(n_layouts) and n_layouts >= 1):
        raise PlacementError(f"n_layouts is {n_layouts!r}; it must be a whole number, at least 1")
    best: tuple[Candidate, ...] = result.candidates[: int(n_layouts)]
    theta = np.array(result.angles)
    nearest = np.zeros((0, len(theta)))
    others = np.array([found.angles for found in best if found.angles != result.angles])
    if len(others):
        away = np.abs(np.angle(np.exp(1j * (theta[None, :, None] - others[:, None, :]))))
        nearest = away.min(axis=2)
    distances = np.median(nearest, axis=0) if len(nearest) else np.zeros(len(theta))
    return Consensus(tuple(found.fraction for found in best), tuple(distances.tolist()))
