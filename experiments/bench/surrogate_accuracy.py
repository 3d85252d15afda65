"""How near soft and hard coverage of the samples come to the exact area: measured on random feasible layouts."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np

import exact
import meshes
from experiments.bench.surrogate_statistics import (
    error_sizes,
    gradient,
    gradient_error,
    least,
    rank_correlation,
    standard_error,
)
from placement.layouts.arcs import LayoutSpace
from placement.layouts.constraints import Constraints
from placement.samples.sampled_coverage import SampledCoverage
from placement.samples.sampled_site import SampledSite, sample_site
from placement.settings import Settings
from placement.surrogate.surrogate import Surrogate

DEMAND = exact.Demand()
MIN_SEPARATION = 5.0  # mm, the default of `placement.Constraints`
# Every so many layouts one is asked for its gradient, and one for rays to its samples: both take long.
GRADIENT_STRIDE, RAY_STRIDE = 8, 8
TIMING_REPEATS = 5


@dataclass(frozen=True, eq=False)
class Truth:
    """Random layouts on one site and what they really reconstruct.

    Attributes
    ----------
    site, depth_mm : str, float
        Name and depth of a built-in site; its ring has the field of view that the site is meant for.
    scene, ring
        The site without its top surface, and the ring.
    layouts : list of (M,) ndarray
        Ring angles [rad]; M differs.
    areas : (L,) ndarray
        Exact area of each [mm²].
    ring_area : float
        Ring maximum [mm²].
    """

    site: str
    depth_mm: float
    scene: exact.Scene
    ring: exact.Ring
    layouts: list[np.ndarray]
    areas: np.ndarray
    ring_area: float

    @property
    def counts(self) -> np.ndarray:
        """(L,) number of cameras of each layout."""
        return np.array([len(layout) for layout in self.layouts])


@dataclass(frozen=True)
class Accuracy:
    """One estimate of the area for a group of layouts; errors are parts of the ring maximum.

    `n_cameras` is "all" or one number of cameras; `temperature` 0 is hard coverage; `gradient_error` is the largest
    of a layout's |gradient - central difference| over its largest derivative, None where there is no gradient.
    """

    site: str
    depth_mm: float
    n_cameras: str
    n_layouts: int
    temperature_rad: float
    rank_correlation: float | None
    bias: float
    mean_error: float
    error_95: float
    greatest_error: float
    gradient_error: float | None


@dataclass(frozen=True)
class Sampling:
    """What one choice of samples, ring angles and bisections gives on one site; errors are parts of the ring maximum.

    `mean_error` and `greatest_error` are of hard coverage against exact areas. `predicted_error` is the standard
    error that the strata let expect. `profile_error` is the mean error of hard coverage against rays from the true
    camera positions to the same samples: what profiles alone get wrong. `ring_error` is that of the ring maximum.
    Times are processor times, which other programs disturb least.
    """

    site: str
    depth_mm: float
    n_samples: int
    n_angles: int
    bisections: int
    seed: int
    mean_error: float
    greatest_error: float
    predicted_error: float
    profile_error: float
    ring_error: float
    rank_correlation: float | None
    least_within: float | None
    tracing_s: float
    gradient_s: float


def true_areas(
    name: str, depth: float, counts: Sequence[int], each: int, ring_cameras: int, workers: int,
    report: Callable[[int], object] | None = None,
) -> Truth:  # fmt: skip
    """Exact areas of `each` random layouts of every number of cameras in `counts`; the same ones on every run."""
    mesh = meshes.site(name, depth=depth)
    ring, scene = exact.Ring(fov=meshes.SITES[name].fov), exact.Scene(mesh, exclude=meshes.top_surface(mesh))
    rng = np.random.default_rng(0)
    spaces = [LayoutSpace(ring, n, Constraints(min_separation=MIN_SEPARATION)) for n in counts]
    layouts = [space.random(rng) for space in spaces for _ in range(each)]
    cameras = [ring.cameras(layout) for layout in layouts]
    areas = exact.areas(scene, cameras, demand=DEMAND, workers=workers, report=report)
    everywhere = ring.cameras(ring.equidistant(ring_cameras))
    ring_area = exact.evaluate(scene, everywhere, demand=DEMAND, workers=workers).area
    return Truth(name, depth, scene, ring, layouts, areas, ring_area)


def accuracy(
    truth: Truth, settings: Settings, temperatures: Sequence[float], seed: int = 0
) -> tuple[list[Accuracy], dict[float, np.ndarray]]:
    """Soft coverage at each temperature [rad] and hard coverage against the exact areas.

    Returns
    -------
    list of Accuracy
        For all layouts and for each number of cameras; hard coverage last.
    dict
        From temperature, 0 for hard, to the (L,) estimated areas [mm²].
    """
    site = _sampled(truth, settings, seed)
    surrogate = Surrogate(site.profiles, DEMAND, truth.ring)
    estimates = {
        float(t): np.array([surrogate.at(layout, t) for layout in truth.layouts]) for t in sorted(temperatures)[::-1]
    }
    estimates[0.0] = hard_areas(truth, site)
    rows = []
    groups = {"all": np.ones(len(truth.layouts), dtype=bool)}
    groups |= {str(n): truth.counts == n for n in np.unique(truth.counts)}
    for temperature, estimate in estimates.items():
        errors = (estimate - truth.areas) / truth.ring_area
        steepest = gradient_error(surrogate, truth.layouts[::GRADIENT_STRIDE], temperature) if temperature else None
        for name, chosen in groups.items():
            rows.append(
                Accuracy(
                    truth.site, truth.depth_mm, name, int(chosen.sum()), temperature,
                    rank_correlation(estimate[chosen], truth.areas[chosen]), float(errors[chosen].mean()),
                    *error_sizes(errors[chosen]), steepest if name == "all" else None,
                )
            )  # fmt: skip
    return rows, estimates


def sampling(truth: Truth, settings: Settings, seed: int, rays: dict) -> Sampling:
    """Measure one choice of samples, ring angles and bisections.

    `rays` keeps what rays to each set of samples found, so that choices with the same samples share it.
    """
    start = time.process_time()
    site = _sampled(truth, settings, seed)
    tracing = time.process_time() - start
    hard, surrogate = hard_areas(truth, site), Surrogate(site.profiles, DEMAND, truth.ring)
    soft = np.array([surrogate.at(layout, settings.temperatures[-1]) for layout in truth.layouts])
    key = truth.site, truth.depth_mm, settings.n_samples, seed
    if key not in rays:
        covered = [
            site.visibility.from_angles(site.samples, truth.ring, layout).sum(axis=0) >= DEMAND.threshold
            for layout in truth.layouts[::RAY_STRIDE]
        ]
        rays[key] = (
            np.array([site.samples.weights @ points for points in covered]),
            np.sqrt(np.mean([standard_error(points, site.samples.weights) ** 2 for points in covered])),
        )
    cast, predicted = rays[key]
    mean, _, greatest = error_sizes((hard - truth.areas) / truth.ring_area)
    within = [rank_correlation(soft[truth.counts == n], truth.areas[truth.counts == n]) for n in set(truth.counts)]
    return Sampling(
        truth.site, truth.depth_mm, settings.n_samples, settings.n_angles, settings.bisections, seed, mean, greatest,
        float(predicted / truth.ring_area), float(np.abs(hard[::RAY_STRIDE] - cast).mean() / truth.ring_area),
        site.ring_area / truth.ring_area - 1, rank_correlation(soft, truth.areas), least(within), tracing,
        _gradient_seconds(surrogate, truth.layouts[-1], settings.temperatures[-1]),
    )  # fmt: skip


def hard_areas(truth: Truth, site: SampledSite) -> np.ndarray:
    """(L,) area [mm²] of the samples that each layout reconstructs."""
    coverage = SampledCoverage(site.profiles, DEMAND, truth.ring, n_grid=4)  # its grid of angles is not used here
    return np.array([coverage.fraction(layout) for layout in truth.layouts])


def _gradient_seconds(surrogate: Surrogate, layout: np.ndarray, temperature: float) -> float:
    """Median processor time of one gradient, once it is compiled [s]."""
    times = []
    for _ in range(1 + TIMING_REPEATS):
        start = time.process_time()
        gradient(
            jnp.asarray(layout), surrogate.points, jnp.asarray(temperature), surrogate.demand.threshold
        ).block_until_ready()
        times.append(time.process_time() - start)
    return float(np.median(times[1:]))


def _sampled(truth: Truth, settings: Settings, seed: int) -> SampledSite:
    return sample_site(truth.scene, truth.ring, DEMAND, settings, seed)
