"""A question about one site or several, with all that does not depend on the number of cameras worked out once."""

from collections.abc import Callable, Sequence

import numpy as np
import trimesh

import exact
from placement.constraints import Constraints, checked_seed
from placement.exchange import SampledCoverage
from placement.profiles import RingProfiles
from placement.ring_maximum import Memory, RingMaximum
from placement.sampled_site import sample_site
from placement.scoring import ExactScorer, available_cores
from placement.settings import Settings
from placement.sites import Objective, Sites, checked_sites
from placement.surrogate import Surrogate

Progress = Callable[[str, int, int], object]
"""Called with what is being done, how many steps of it are done, and how many there are."""


class Problem:
    """Sites, a ring, and what is asked of a point: ready for layouts of any number of cameras.

    Use it instead of `optimise` for several requests about the same sites: samples, ring profiles and the ring
    maximum are worked out once.

    Parameters
    ----------
    mesh : trimesh.Trimesh or sequence of them
        One site or several [mm].
    ring : exact.Ring
        Where cameras may be.
    threshold : int
        How many cameras must see a point.
    exclude : (F,) ndarray of bool, or one for each site, optional
        Faces that do not count, such as `meshes.top_surface(mesh)`; they still hide what is behind them.
    settings : Settings, optional
        How layouts are searched for.
    seed : int
        Of samples and starts.
    face_weights : (F,) ndarray, or one for each site, optional
        Factor by which the area of each face counts, such as `falloff(mesh, ring, distance)`.
    site_weights : (S,) sequence of float, optional
        How much each site counts in the mean; equally by default.
    objective : {"mean", "worst"}
        Over several sites: maximise the mean of their fractions of the ring maximum, or the least of them.
    workers : int, optional
        Processes that share exact evaluations; by default one for each core. Results do not depend on it.
    progress : callable, optional
        Called with (what, done, total).
    memory : placement.ring_maximum.Memory, optional
        Where ring maxima evaluated before are found and new ones are kept, such as a dict that several problems share.

    Raises
    ------
    PlacementError
        If something does not fit, or no `threshold` cameras of the ring see a common point of a site.

    Examples
    --------
    >>> from dataclasses import replace
    >>> quick = replace(Settings(), n_samples=500, n_angles=36, ring_cameras=16)
    >>> problem = Problem(trimesh.creation.box((30, 30, 1)), exact.Ring(), settings=quick)
    >>> 800 < problem.ring_maximum.areas[0] < 900
    True
    """

    def __init__(
        self,
        mesh: trimesh.Trimesh | Sequence[trimesh.Trimesh],
        ring: exact.Ring,
        threshold: int = 2,
        exclude: np.ndarray | Sequence[np.ndarray | None] | None = None,
        settings: Settings | None = None,
        seed: int = 0,
        face_weights: np.ndarray | Sequence[np.ndarray | None] | None = None,
        site_weights: Sequence[float] | None = None,
        objective: Objective = "mean",
        workers: int | None = None,
        progress: Progress | None = None,
        memory: Memory | None = None,
    ):
        seed = checked_seed(seed)
        report = progress or (lambda what, done, total: None)
        self.sites: Sites = checked_sites(mesh, exclude, face_weights, site_weights, objective)
        self.ring, self.threshold, self.seed = ring, threshold, seed
        self.settings = Settings() if settings is None else settings
        self.workers = available_cores() if workers is None else workers
        self.ring_maximum = RingMaximum(self.sites, ring, threshold, self.settings.ring_cameras, self.workers, memory)
        self._scorers: dict[float, ExactScorer] = {}
        self._coverages: dict[float, tuple[SampledCoverage, Surrogate]] = {}
        # Other processes are at it while this one samples and searches.
        self.ring_maximum.begin()
        n_sites = len(self.sites.members)
        # Few samples of each of many sites do: what counts is their mean, or a worst site that stands out.
        few = min(self.settings.n_samples, max(self.settings.n_samples // n_sites, self.settings.least_samples))
        parts = []
        for number, site in enumerate(self.sites.members):
            report("tracing ring profiles", number, n_sites)
            parts.append(
                sample_site(site.mesh, ring, threshold, site.excluded, self.settings, seed, site.face_weights, few)
            )
        report("tracing ring profiles", n_sites, n_sites)
        self.profiles: RingProfiles = _joined(parts, self.sites)

    def scorer(self, constraints: Constraints) -> ExactScorer:
        """Exact areas, with the baseline that the constraints ask for."""
        baseline = constraints.baseline(self.ring)
        if baseline not in self._scorers:
            self._scorers[baseline] = ExactScorer(
                self.sites, self.ring, self.threshold, baseline, self.ring_maximum, self.workers
            )
        return self._scorers[baseline]

    def coverage(self, constraints: Constraints) -> tuple[SampledCoverage, Surrogate]:
        """Hard and soft coverage of the samples, with the baseline that the constraints ask for."""
        baseline = constraints.baseline(self.ring)
        if baseline not in self._coverages:
            profiles, diameter = self.profiles, self.ring.diameter
            self._coverages[baseline] = (
                SampledCoverage(profiles, self.threshold, diameter, baseline, self.settings.n_grid),
                Surrogate(profiles, self.threshold, diameter, baseline),
            )
        return self._coverages[baseline]


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
    )
