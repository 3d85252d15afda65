"""What came out in figures: of the whole, and by views, incidence, density of pixels and predicted error."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from experiments.files.table import finite
from experiments.layouts.layout_content import rolls_content
from experiments.simulate.compare import TOLERANCE, TOLERANCES
from experiments.simulate.simulation import Simulated
from experiments.simulate.truth import FACING

# Borders of the classes: incidence of the second best view [degrees]; pixels to a square millimetre of the surface as
# the second best view has them, as parts of those of a surface at the focus that faces its camera; least disparity
# gradient of a pair; and predicted standard deviations along the normal at the measured noise [mm].
INCIDENCE_DEG = (0.0, 30.0, 45.0, 60.0, 70.0, 75.0, 80.0, 82.5, 85.0, 87.5, 90.0)
DENSITY_PARTS = (0.0, 0.02, 0.04, 0.06, 0.08, 0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 1.5)
GRADIENTS = (0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.85, 1.0, 1.2, 1.5, 2.0, 3.0, 10.0)
ERRORS_MM = (0.0, 0.002, 0.005, 0.01, 0.02, 0.03, 0.05, 0.1, 0.2, 0.5)


# Of the table that is printed.
HEADERS = (
    "layout", "predicted\n[mm²]", "seen by\nenough [mm²]", "measured to\n0.3 mm [mm²]", "of what\nis seen",
    "match noise\n[px]", "facing: σ_n\nmeasured [mm]", "σ_n predicted\n[mm]",
)  # fmt: skip


def classes(found: Simulated) -> Iterator[dict[str, Any]]:
    """One row for each class of what cameras enough see, without those of which there is nothing."""
    samples, seen = found.comparison.samples, found.seen
    for number in np.unique(samples.n_views[seen]).tolist():
        yield _row(found, "views", number, number, seen & (samples.n_views == number))
    camera = found.asked.cameras[0].camera
    most = float(np.prod(found.asked.demand.optics.focal(camera))) / camera.target_distance**2
    for by, values, borders in (
        ("incidence [degrees]", np.degrees(samples.second_incidence), INCIDENCE_DEG),
        ("density [px/mm²]", samples.second_density, [round(most * part, 6) for part in DENSITY_PARTS]),
        ("disparity gradient", found.gradient, GRADIENTS),
        ("predicted error [mm]", found.noise * samples.sigma, ERRORS_MM),
    ):
        for low, high in zip(borders[:-1], borders[1:], strict=True):
            chosen = seen & (values >= low) & (values < high)
            if chosen.any():
                yield _row(found, by, low, high, chosen)


def _row(found: Simulated, by: str, low: float, high: float, chosen: np.ndarray) -> dict[str, Any]:
    comparison = found.comparison
    shares = {f"within_{one:g}_mm": comparison.completeness(one, chosen) for one in TOLERANCES}
    return {
        "layout": found.asked.name,
        "by": by,
        "from": low,
        "to": high,
        "area_mm2": float(comparison.samples.areas[chosen].sum()),
        **shares,
        "normal_std_mm": finite(comparison.accuracy(chosen)),
        "predicted_normal_std_mm": finite(comparison.predicted(found.noise, chosen)),
    }


def summary(found: Simulated) -> dict[str, Any]:
    """The figures of one layout, as they stand in simulation.json."""
    comparison, asked, seen = found.comparison, found.asked, found.seen
    facing = seen & (comparison.samples.second_incidence < FACING)
    return {
        "layout": asked.name,
        "ring_angles_deg": np.degrees(asked.angles).tolist(),
        **rolls_content(None if asked.rolls is None else tuple(asked.rolls.tolist())),
        "pairs": [[i + 1, j + 1] for i, j in asked.matched],
        "predicted_area_mm2": found.predicted.area,
        "counts_when": asked.demand.clause(),
        "seen_area_mm2": float(comparison.samples.areas[seen].sum()),
        "measured_areas_mm2": {f"{one:g}": comparison.area(one) for one in TOLERANCES},
        "measured_shares_of_seen": {f"{one:g}": comparison.completeness(one, seen) for one in TOLERANCES},
        "measured_shares_of_points": {f"{one:g}": finite(comparison.precision(one)) for one in TOLERANCES},
        "match_noise_px": {"assumed": asked.demand.optics.match_noise, "measured": finite(found.noise)},
        "normal_std_mm": _both(found, seen),
        "normal_std_facing_mm": _both(found, facing),
        "points": found.n_points,
        "astray_share_of_points": comparison.astray,
    }


def _both(found: Simulated, chosen: np.ndarray) -> dict[str, float | None]:
    measured, predicted = found.comparison.accuracy(chosen), found.comparison.predicted(found.noise, chosen)
    return {"measured": finite(measured), "predicted": finite(predicted)}


def headline(found: Sequence[Simulated]) -> list[list[str]]:
    """One row a layout: what is predicted, what was measured."""
    rows = []
    for one in found:
        facts = summary(one)
        facing = facts["normal_std_facing_mm"]
        rows.append([
            one.asked.name, f"{facts['predicted_area_mm2']:.1f}", f"{facts['seen_area_mm2']:.1f}",
            f"{facts['measured_areas_mm2'][f'{TOLERANCE:g}']:.1f}",
            f"{100 * facts['measured_shares_of_seen'][f'{TOLERANCE:g}']:.1f} %",
            _shown(facts["match_noise_px"]["measured"], 3), _shown(facing["measured"], 4),
            _shown(facing["predicted"], 4),
        ])  # fmt: skip
    return rows


def _shown(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"
