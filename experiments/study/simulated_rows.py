"""What the simulated study found: one row a layout, one a limit, and what follows from them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import spearmanr

from experiments.simulate.compare import TOLERANCE
from experiments.study.simulated_tasks import DENSITIES, GRADIENTS, INCIDENCES_DEG, MAX_ERROR
from experiments.sweeps.task import Outcome

# Ways to predict what comes out, in the order of the columns that hold their areas.
PREDICTIONS = (
    "no limits", "error", "incidence", "density", "incidence and error", "density and error", "gradient",
    "gradient and error",
)  # fmt: skip


@dataclass(frozen=True)
class SimulatedRow:
    """One layout: areas predicted and measured [mm²], noise of matches [pixels], accuracy on facing surfaces [mm].

    `tested` are those that the limits were not chosen on. Predicted areas are exact; None where a task failed.
    """

    site: str
    depth_mm: int
    n_cameras: int
    kind: str
    width_px: int
    tested: bool
    angles_deg: tuple[float, ...] = ()
    no_limits_mm2: float | None = None
    error_mm2: float | None = None
    incidence_mm2: float | None = None
    density_mm2: float | None = None
    incidence_and_error_mm2: float | None = None
    density_and_error_mm2: float | None = None
    gradient_mm2: float | None = None
    gradient_and_error_mm2: float | None = None
    seen_mm2: float | None = None
    within_01_mm2: float | None = None
    within_02_mm2: float | None = None
    within_03_mm2: float | None = None
    within_05_mm2: float | None = None
    match_noise_px: float | None = None
    facing_measured_mm: float | None = None
    facing_predicted_mm: float | None = None
    failure: str = ""

    def predicted(self, way: str) -> float | None:
        """The area that one of `PREDICTIONS` gives."""
        return getattr(self, f"{way.replace(' ', '_')}_mm2")


@dataclass(frozen=True)
class LimitRow:
    """One limit over all layouts of a resolution that it may be chosen on: areas sampled [mm²].

    `met_mm2` meets it, and of that `both_mm2` was reconstructed. `kind` is "incidence" [degrees], "density" [px/mm²] or
    "gradient", perhaps "and error".
    """

    width_px: int
    kind: str
    limit: float
    met_mm2: float
    both_mm2: float
    reconstructed_mm2: float
    seen_mm2: float

    @property
    def disagree(self) -> float:
        """Share of what is seen of which the limit says the wrong thing."""
        return (self.met_mm2 + self.reconstructed_mm2 - 2 * self.both_mm2) / self.seen_mm2


def limit_rows(found: Sequence[tuple[dict[str, Any], Outcome]]) -> list[LimitRow]:
    """Every limit, summed over the layouts of each resolution, without those that it is tested on."""
    rows = []
    for width in dict.fromkeys(about["width_px"] for about, _ in found):
        results = [
            one.result
            for about, one in found
            if about["width_px"] == width and not about["tested"] and one.result is not None
        ]
        if not results:
            continue
        made = sum(one["limits"]["reconstructed"] for one in results)
        seen = sum(one["summary"]["seen_area_mm2"] for one in results)
        for kind, values in (("incidence", INCIDENCES_DEG), ("density", DENSITIES), ("gradient", GRADIENTS)):
            for ending in ("", " and error"):
                met, both = (
                    np.sum([one["limits"][kind + ending][name] for one in results], axis=0) for name in ("met", "both")
                )
                for value, one, two in zip(values, met.tolist(), both.tolist(), strict=True):
                    rows.append(LimitRow(width, kind + ending, value, one, two, made, seen))
    return rows


def best_limit(rows: Sequence[LimitRow], kind: str, width: int) -> float:
    """The limit that disagrees least with what was reconstructed.

    Examples
    --------
    >>> rows = [LimitRow(720, "incidence", limit, met, both, 10.0, 100.0) for limit, met, both in
    ...         ((80.0, 6.0, 6.0), (85.0, 11.0, 9.0), (90.0, 100.0, 10.0))]
    >>> best_limit(rows, "incidence", 720)
    85.0
    """
    of = [row for row in rows if row.kind == kind and row.width_px == width]
    return min(of, key=lambda row: row.disagree).limit


def limits_of(rows: Sequence[LimitRow], width: int) -> dict[str, dict[str, float | None]]:
    """What each of `PREDICTIONS` asks for, as inputs of `simulated_tasks.predicted`."""
    incidence, density, gradient = (best_limit(rows, kind, width) for kind in ("incidence", "density", "gradient"))
    none: dict[str, float | None] = {
        "max_incidence_deg": None, "min_pixel_density": None, "max_disparity_gradient": None, "max_error": None
    }  # fmt: skip
    return {
        "no limits": none,
        "error": none | {"max_error": MAX_ERROR},
        "incidence": none | {"max_incidence_deg": incidence},
        "density": none | {"min_pixel_density": density},
        "incidence and error": none | {"max_incidence_deg": incidence, "max_error": MAX_ERROR},
        "density and error": none | {"min_pixel_density": density, "max_error": MAX_ERROR},
        "gradient": none | {"max_disparity_gradient": gradient},
        "gradient and error": none | {"max_disparity_gradient": gradient, "max_error": MAX_ERROR},
    }


def simulated_row(about: dict[str, Any], outcome: Outcome, areas: Sequence[Outcome]) -> SimulatedRow:
    """The row of a layout, with the areas in the order of `PREDICTIONS`."""
    failure = next((one.failure for one in (outcome, *areas) if one.failure), "")
    if outcome.result is None or any(one.result is None for one in areas):
        return SimulatedRow(**about, failure=failure)
    facts = outcome.result["summary"]
    measured, facing = facts["measured_areas_mm2"], facts["normal_std_facing_mm"]
    exactly = [one.result["area_mm2"] for one in areas if one.result is not None]
    predicted = {f"{way.replace(' ', '_')}_mm2": area for way, area in zip(PREDICTIONS, exactly, strict=True)}
    within = {f"within_{one.replace('.', '')}_mm2": area for one, area in measured.items()}
    return SimulatedRow(
        **about, **predicted, **within, angles_deg=tuple(facts["ring_angles_deg"]), seen_mm2=facts["seen_area_mm2"],
        match_noise_px=facts["match_noise_px"]["measured"], facing_measured_mm=facing["measured"],
        facing_predicted_mm=facing["predicted"],
    )  # fmt: skip


def rank_correlation(rows: Sequence[SimulatedRow], way: str) -> float:
    """Spearman's, between what one of `PREDICTIONS` gives and the area reconstructed within 0.3 mm.

    Examples
    --------
    >>> rows = [SimulatedRow("a", 50, 2, "proposed", 720, False, no_limits_mm2=area, within_03_mm2=area**2)
    ...         for area in (1.0, 3.0, 2.0)]
    >>> rank_correlation(rows, "no limits")
    1.0
    """
    both = np.array(
        [(row.predicted(way), row.within_03_mm2) for row in rows if row.within_03_mm2 is not None], dtype=np.float64
    )
    return float(np.asarray(spearmanr(both[:, 0], both[:, 1]))[0]) if len(both) > 1 else float("nan")


TOLERANCE_WORDS = f"within {TOLERANCE:g} mm"
