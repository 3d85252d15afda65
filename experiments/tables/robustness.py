"""Can it be built: tables and words about faults, agreement among the best layouts, and pairs of cameras."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.table import Table

import placement
from experiments.files.table import finite
from experiments.tables.layouts import Row
from experiments.terminal.console import table

# Pairs are shown until the rest of them would add less than this part of the reconstructable area.
PAIRS_SHOWN_UNTIL = 0.99


def faults_table(rows: Sequence[Row]) -> Table:
    """Fractions left under faults, and triangulation angles, of each layout."""
    off, n_mountings = _mounting(rows)
    shown = table(
        "can it be built: layout", "one camera fails:\nworst, mean", f"mounted off by {off}:\nworst of {n_mountings}",
        "triangulation angle [°]\n5 %, 50 %, 95 % of the area",
    )  # fmt: skip
    for row in rows:
        found = row.robustness
        if found is not None:
            shown.add_row(
                row.name,
                f"{100 * found.worst_failure:.2f} %, {100 * found.mean_failure:.2f} %",
                f"{100 * found.worst_mounting:.2f} %",
                ", ".join(f"{angle:.2f}" for angle in np.degrees(row.angle_quantiles)),
            )
    return shown


def faults_caption(rows: Sequence[Row], of: str) -> str:
    """What the figures of `faults_table` are; `of` says what a fraction is a fraction of."""
    off, n_mountings = _mounting(rows)
    return (
        f"Exact fractions of {of}: with any one camera dead, and with every camera off by {off} along the ring, each "
        f"to a side drawn at random ({n_mountings} draws). Angles on samples: so much of the reconstructable area has "
        "a best triangulation angle of at most that."
    )


def _mounting(rows: Sequence[Row]) -> tuple[str, int]:
    found = next(row.robustness for row in rows if row.robustness is not None)
    return f"{np.degrees(found.mounting_error):g}°", len(found.mounting_fractions)


def consensus_words(agreed: placement.Consensus, angles: Sequence[float]) -> str:
    """How far the best layouts agree with the one proposed, whose ring angles [rad] are given.

    Examples
    --------
    >>> print(consensus_words(placement.Consensus((0.97, 0.96, 0.96), (0.0, 0.5)), (0.1, 2.0)))
    Consensus: the 3 best distinct layouts reconstruct 97.00 % to 96.00 %. From each camera of the one proposed it is \
this far to the nearest one of the others, in the median: 1 (5.7°) 0.0°, 2 (114.6°) 28.6°. Where it is little, all \
agree on the place; where it is much, other places serve as well.
    """
    if len(agreed.fractions) == 1:
        return "Consensus: no other distinct layout was scored, so there is none to compare with."
    away = ", ".join(
        f"{number} ({np.degrees(angle):.1f}°) {np.degrees(distance):.1f}°"
        for number, (angle, distance) in enumerate(zip(angles, agreed.distances, strict=True), start=1)
    )
    best, least = (f"{100 * fraction:.2f} %" for fraction in (agreed.fractions[0], agreed.fractions[-1]))
    return (
        f"Consensus: the {len(agreed.fractions)} best distinct layouts reconstruct {best} to {least}. From each camera "
        f"of the one proposed it is this far to the nearest one of the others, in the median: {away}. Where it is "
        "little, all agree on the place; where it is much, other places serve as well."
    )


def pairs_table(found: placement.Robustness, area: float) -> Table:
    """The pairs of cameras to reconstruct from; `area` is what the layout reconstructs [mm²], summed over the sites."""
    columns = ["cameras", "ring angles [°]", "see of the area", "with those above"]
    shown = table(*columns, *(["RMS error with those above [mm]"] if found.accurate_pairs else []))
    for pair in _shown_pairs(found, area):
        first, second = pair.cameras
        shown.add_row(
            f"{first + 1} and {second + 1}",
            f"{np.degrees(found.angles[first]):.1f} and {np.degrees(found.angles[second]):.1f}",
            f"{100 * pair.area / area:.1f} %",
            f"{100 * pair.together / area:.1f} %",
            *([f"{pair.error:.4f}"] if found.accurate_pairs else []),
        )
    return shown


def pairs_words(found: placement.Robustness, area: float) -> str:
    """What `pairs_table` shows."""
    if found.accurate_pairs:
        return accurate_pairs_words(len(found.accurate_pairs), len(found.angles), found.error_rms)
    return (
        "Pairs of the optimised layout to reconstruct from: the one that sees most of its reconstructable area, then "
        "whichever adds most."
    )


def accurate_pairs_words(n_pairs: int, n_cameras: int, error_rms: float) -> str:
    """How few pairs will do.

    Examples
    --------
    >>> print(accurate_pairs_words(4, 4, 0.0803))
    Pairs of the optimised layout to reconstruct from: 4 of its 6 keep 99 % of its area and, to within 10 %, the RMS \
error of all cameras together, 0.0803 mm.
    """
    return (
        f"Pairs of the optimised layout to reconstruct from: {n_pairs} of its {n_cameras * (n_cameras - 1) // 2} keep "
        f"99 % of its area and, to within 10 %, the RMS error of all cameras together, {error_rms:.4f} mm."
    )


def _shown_pairs(found: placement.Robustness, area: float) -> Sequence[placement.Pair]:
    if found.accurate_pairs:
        return found.accurate_pairs
    pairs = found.pairs
    enough = next((i for i, pair in enumerate(pairs) if pair.together >= PAIRS_SHOWN_UNTIL * area), len(pairs))
    return pairs[: enough + 1]


def robustness_content(rows: Sequence[Row], agreed: placement.Consensus, area: float) -> dict[str, Any]:
    """All of it as it stands in layout.json, cameras numbered from 1 as in its list of ring angles.

    Parameters
    ----------
    rows : sequence of Row
        The layouts, the one proposed last.
    agreed : placement.Consensus
    area : float
        What the layout proposed reconstructs [mm²], summed over the sites.
    """
    layouts = [(row.name, row.robustness) for row in rows if row.robustness is not None]
    best = layouts[-1][1]
    return {
        "mounting_error_deg": float(np.degrees(best.mounting_error)),
        "layouts": [
            {
                "layout": name,
                "ring_angles_deg": np.degrees(found.angles).tolist(),
                "fraction": found.fraction,
                "fractions_without_camera": list(found.failed_fractions),
                "fractions_mounted_off": list(found.mounting_fractions),
            }
            for name, found in layouts
        ],
        "best_layouts_fractions": list(agreed.fractions),
        "distances_in_best_layouts_deg": np.degrees(agreed.distances).tolist(),
        "pairs": [_pair_content(pair, area) for pair in best.pairs],
        "rms_error_mm": finite(best.error_rms),
        "accurate_pairs": [_pair_content(pair, area) for pair in best.accurate_pairs],
    }


def _pair_content(pair: placement.Pair, area: float) -> dict[str, Any]:
    return {
        "cameras": [pair.cameras[0] + 1, pair.cameras[1] + 1],
        "share_of_area": pair.area / area,
        "share_with_pairs_before": pair.together / area,
        "rms_error_with_pairs_before_mm": finite(pair.error),
    }
