"""A question about one site or several, with all that does not depend on the number of cameras worked out once."""

from collections.abc import Sequence
from typing import Any

import numpy as np

import exact
from exact.requests import checked_demand, demand_keywords, refuse_unknown, shows
from exact.workers import available_cores
from placement.errors import PlacementError, refusing
from placement.layouts.arcs import LayoutSpace
from placement.layouts.constraints import Constraints, checked_seed, demanded, on_ring
from placement.progress import Progress, nothing
from placement.proof.certificate import Certificate
from placement.recommend import Recommendation, recommend, refuse_target
from placement.results import Placement
from placement.samples.profiles import RingProfiles
from placement.samples.sampled_coverage import SampledCoverage
from placement.samples.sampled_site import SampledSite, sample_site
from placement.samples.viewed_samples import refuse_unmet
from placement.search.proposal import GIVE_UP, bound
from placement.search.ring_maximum import Memory, RingMaximum
from placement.search.rolled_proposal import propose_layout
from placement.search.scoring import ExactScorer
from placement.settings import Settings
from placement.sites import Objective, Sites, Surfaces, checked_sites, scene_keywords
from placement.surrogate.surrogate import Surrogate
from placement.trade_off import TradeOff, trade

ASKED = {**scene_keywords(), **demand_keywords(), "demand": None}


@shows(ASKED)
class Problem:
    """Sites, a ring, and what is asked of a point: ready for layouts of any number of cameras.

    Use it instead of `optimise` for several requests about the same sites: samples, ring profiles and the ring
    maximum are worked out once.

    Parameters
    ----------
    mesh : trimesh.Trimesh, exact.Scene, or sequence of them
        One site or several [mm].
    ring : exact.Ring
        Where cameras may be.
    settings : Settings, optional
        How layouts are searched for; with fewer exact areas where meshes are large (`Settings.for_faces`).
    seed : int
        Of samples and starts.
    site_weights : (S,) sequence of float, optional
        How much each site counts in the mean; equally by default.
    objective : {"mean", "worst"}
        Over several sites: maximise the mean of their fractions of the ring maximum, or the least of them.
    workers : int, optional
        Processes that share exact evaluations; by default one for each core. Results do not depend on it.
    progress : callable, optional
        Called with (what, done, total).
    memory : placement.search.ring_maximum.Memory, optional
        Where ring maxima evaluated before are found and new ones are kept, such as a dict that several problems share.
    ahead : bool
        Have other processes evaluate the ring maximum while samples are made, for who wants a layout at once.
    exclude, face_weights
        What of each mesh counts, and how much: `exclude` and `weights` of `exact.Scene`, for all meshes or one
        for each.
    threshold, min_baseline, demand
        What makes a point count: see `exact.Demand`.

    Raises
    ------
    PlacementError
        If something does not fit, or no cameras of the ring see a common point of a site that counts.

    Examples
    --------
    >>> import trimesh
    >>> from dataclasses import replace
    >>> quick = replace(Settings(), n_samples=500, n_angles=36, ring_cameras=16)
    >>> problem = Problem(trimesh.creation.box((30, 30, 1)), exact.Ring(), settings=quick)
    >>> 800 < problem.ring_maximum.areas[0] < 900
    True
    """

    def __init__(
        self,
        mesh: Surfaces,
        ring: exact.Ring,
        *,
        settings: Settings | None = None,
        seed: int = 0,
        site_weights: Sequence[float] | None = None,
        objective: Objective = "mean",
        workers: int | None = None,
        progress: Progress | None = None,
        memory: Memory | None = None,
        ahead: bool = False,
        **asked: Any,
    ):
        refuse_unknown(asked, {*scene_keywords(), *demand_keywords(), "demand"})
        seed = checked_seed(seed)
        report = progress or nothing
        with refusing():
            self.demand = on_ring(checked_demand(asked), ring)
        of_scenes = {name: asked.get(name) for name in scene_keywords()}
        self.sites: Sites = checked_sites(mesh, site_weights=site_weights, objective=objective, **of_scenes)
        self.ring, self.seed = ring, seed
        self.settings = (Settings() if settings is None else settings).for_faces(self.sites.n_faces)
        self.workers = available_cores() if workers is None else workers
        self.ring_maximum = RingMaximum(
            self.sites, ring, self.demand, n_cameras=self.settings.ring_cameras, workers=self.workers, memory=memory
        )
        self._grid_sets: dict[tuple, list[tuple[np.ndarray, np.ndarray]]] = {}
        self._scorers: dict[exact.Demand, ExactScorer] = {}
        self._coverages: dict[exact.Demand, tuple[SampledCoverage, Surrogate]] = {}
        if ahead:
            self.ring_maximum.begin()
        n_sites = len(self.sites.members)
        # Few samples of each of many sites do: what counts is their mean, or a worst site that stands out.
        few = min(self.settings.n_samples, max(self.settings.n_samples // n_sites, self.settings.least_samples))
        parts = []
        for number, site in enumerate(self.sites.members):
            report("tracing ring profiles", number, n_sites)
            parts.append(sample_site(site.scene, ring, self.demand, self.settings, seed, few))
        report("tracing ring profiles", n_sites, n_sites)
        self.sampled: tuple[SampledSite, ...] = tuple(parts)
        self.profiles: RingProfiles = _joined(parts, self.sites)

    def demanded(self, constraints: Constraints, n_cameras: int | None = None) -> exact.Demand:
        """What makes a point count under these constraints: with the baseline that they ask for."""
        return demanded(self.demand, constraints, self.ring, n_cameras)

    def grid_sets(
        self, demand: exact.Demand, n_grid: int, fixed: tuple[float, ...]
    ) -> list[tuple[np.ndarray, np.ndarray]]:
        """Of each site the (S, n_grid + F) sets of grid and fixed cameras that see something, and its area [mm²]."""
        key = (demand, n_grid, fixed)
        if key not in self._grid_sets:
            cameras = self.ring.cameras([*2 * np.pi / n_grid * np.arange(n_grid), *fixed])
            found = [exact.view_sets(site.scene, cameras, demand=demand) for site in self.sites.members]
            self._grid_sets = {key: [(sets.seen, sets.areas) for sets in found]}  # those of one request at a time
        return self._grid_sets[key]

    def scorer(self, constraints: Constraints) -> ExactScorer:
        """Exact areas under these constraints."""
        demand = self.demanded(constraints)
        if demand not in self._scorers:
            self._scorers[demand] = ExactScorer(self.sites, self.ring, demand, self.ring_maximum, self.workers)
        return self._scorers[demand]

    def coverage(self, constraints: Constraints) -> tuple[SampledCoverage, Surrogate]:
        """Hard and soft coverage of the samples under these constraints."""
        demand = self.demanded(constraints)
        if demand not in self._coverages:
            self._coverages[demand] = (
                SampledCoverage(self.profiles, demand, self.ring, self.settings.n_grid),
                Surrogate(self.profiles, demand, self.ring),
            )
        return self._coverages[demand]

    def optimise(
        self,
        n_cameras: int = 4,
        constraints: Constraints | None = None,
        *,
        certify: bool = True,
        give_up: float = GIVE_UP,
        starts: Sequence = (),
        progress: Progress | None = None,
    ) -> Placement:
        """Find where `n_cameras` cameras reconstruct the most; as `placement.optimise`.

        Examples
        --------
        >>> import trimesh
        >>> from dataclasses import replace
        >>> quick = replace(Settings(), n_samples=500, n_angles=36, n_starts=4, ring_cameras=16, exact_candidates=2)
        >>> problem = Problem(trimesh.creation.box((30, 30, 5)), exact.Ring(), settings=quick)
        >>> [len(problem.optimise(n, certify=False).angles) for n in (2, 3)]
        [2, 3]
        """
        return propose_layout(self, self._met(n_cameras, constraints), certify, progress, give_up, starts=starts)

    def tradeoff(
        self,
        n_cameras: int = 4,
        constraints: Constraints | None = None,
        *,
        certify: bool = True,
        progress: Progress | None = None,
    ) -> TradeOff:
        """Find what accuracy costs in area; as `placement.tradeoff`."""
        self._refuse_free_rolls("what accuracy costs")
        return trade(self, self._met(n_cameras, constraints), certify, progress)

    def certify(self, n_cameras: int = 4, constraints: Constraints | None = None, *, layout=None) -> Certificate:
        """Bound what any layout of `n_cameras` cameras can reconstruct; as `placement.certify`."""
        self._refuse_free_rolls("a bound")
        return bound(self, self._space(n_cameras, constraints), layout)

    def count(
        self,
        target: float = 0.99,
        constraints: Constraints | None = None,
        *,
        certify: bool = True,
        max_cameras: int = 16,
        progress: Progress | None = None,
    ) -> Recommendation:
        """Find the fewest cameras that reach `target`, optimised and equidistant; as `placement.recommend_count`."""
        constraints = Constraints() if constraints is None else constraints
        numbers = refuse_target(target, max_cameras, self.demanded(constraints), constraints)
        return recommend(self, target, constraints, numbers, certify, progress)

    def _met(self, n_cameras: int, constraints: Constraints | None) -> LayoutSpace:
        """The space of layouts, unless none of them meets a bound on the error anywhere."""
        space = self._space(n_cameras, constraints)
        refuse_unmet(self.profiles, self.demand, self.ring, space.n_cameras)
        return space

    def _refuse_free_rolls(self, what: str) -> None:
        if self.ring.roll == "free":
            raise PlacementError(
                f'{what} is known for given rolls only, and those of this ring are free; ask with roll="radial", '
                '"tangential" or a number'
            )

    def _space(self, n_cameras: int, constraints: Constraints | None) -> LayoutSpace:
        return LayoutSpace(self.ring, n_cameras, Constraints() if constraints is None else constraints)


def _joined(parts, sites: Sites) -> RingProfiles:
    """Profiles of all sites whose weights are shares of the ring maximum: of all, or of each in a sum of its own."""
    worst = sites.objective == "worst"
    shares = np.ones(len(parts)) if worst else sites.shares
    scaled = [part.profiles.scaled(share / part.ring_area) for share, part in zip(shares, parts, strict=True)]
    return RingProfiles(
        np.concatenate([profiles.behind for profiles in scaled], axis=1),
        np.concatenate([profiles.ahead for profiles in scaled], axis=1),
        np.concatenate([profiles.weights for profiles in scaled]),
        np.concatenate([np.full(len(profiles.weights), i * worst) for i, profiles in enumerate(scaled)]),
        np.concatenate([profiles.parts for profiles in scaled], axis=1),
        np.concatenate([profiles.noise for profiles in scaled]),
        np.concatenate([profiles.heights for profiles in scaled], axis=1),
    )
