"""How far the gradient search alone gets from random starts, for several sequences of temperatures."""

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from experiments.bench.surrogate_accuracy import DEMAND, MIN_SEPARATION, Truth
from placement.layouts.arcs import LayoutSpace
from placement.layouts.constraints import Constraints
from placement.samples.sampled_coverage import SampledCoverage
from placement.samples.sampled_site import sample_site
from placement.settings import Settings
from placement.surrogate.descent import descend
from placement.surrogate.surrogate import Surrogate


@dataclass(frozen=True)
class Stages:
    """Where random starts end on one site: hard coverage as a part of the samples' ring maximum, processor time."""

    site: str
    depth_mm: float
    n_cameras: int
    n_starts: int
    temperatures_rad: str
    mean_end: float
    best_end: float
    flat_or_failed: int
    seconds: float


def stages(
    truth: Truth, settings: Settings, sequences: Sequence[tuple[float, ...]], n_cameras: int, n_starts: int
) -> list[Stages]:
    """Search from the same random starts with each sequence of temperatures [rad]; times are without compiling."""
    site = sample_site(truth.scene, truth.ring, DEMAND, settings)
    # Shares of the ring maximum, as in a search: its tolerances are absolute.
    profiles = site.profiles.scaled(1 / site.ring_area)
    surrogate, coverage = (
        Surrogate(profiles, DEMAND, truth.ring),
        SampledCoverage(profiles, DEMAND, truth.ring, n_grid=4),
    )
    space = LayoutSpace(truth.ring, n_cameras, Constraints(min_separation=MIN_SEPARATION))
    rng = np.random.default_rng(0)
    starts = np.stack([space.parameters(space.random(rng))[0] for _ in range(n_starts)])
    rows = []
    for temperatures in sequences:
        for _ in range(2):  # the first time compiles
            start = time.process_time()
            end = descend(
                starts, None, surrogate,
                minimum_gap=space.minimum_gap, temperatures=temperatures, max_steps=settings.max_steps,
            )  # fmt: skip
            seconds = time.process_time() - start
        reached = [coverage.fraction(angles) for angles in end.angles]
        rows.append(
            Stages(
                truth.site, truth.depth_mm, n_cameras, n_starts, " ".join(f"{t:g}" for t in temperatures),
                float(np.mean(reached)), max(reached), int((end.flat | end.failed).sum()), seconds,
            )
        )  # fmt: skip
    return rows
