"""The table of layouts that `optimise` and `compare` print and write."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

from experiments.files.table import finite, write_table
from experiments.terminal.console import table

if TYPE_CHECKING:  # at run time only their values are needed
    import placement

# Shares of the reconstructable area whose greatest best triangulation angle is told.
SHARES = (0.05, 0.5, 0.95)


@dataclass(frozen=True, eq=False)
class Row:
    """One layout and its figures.

    Attributes
    ----------
    name : str
    angles : (M,) ndarray
        Ring angles [rad].
    area, fraction : float
        Exact reconstructable area [mm²], and fraction of the ring maximum.
    gain : float or None
        Fraction more than the layout everything is compared with; None for that layout itself.
    smallest_separation : float
        Least chord between two cameras [mm]; infinite for one camera.
    widest_angle, mean_angle : float
        Widest and mean best triangulation angle over the reconstructable area [rad].
    angle_quantiles : tuple of float
        Best triangulation angles that `SHARES` of the reconstructable area do not exceed [rad].
    error : float
        Root mean square of the predicted errors over the reconstructable area [mm]; infinite where there is none.
    robustness : placement.Robustness or None
        What is left under faults, if that was worked out.
    breaks : tuple of str
        Which constraints of the request it does not meet, in words: it is there to compare with only.
    rolls : (M,) ndarray or None
        Of the cameras [rad], as `exact.Ring.cameras` takes them, where they are free.
    """

    name: str
    angles: np.ndarray
    area: float
    fraction: float
    gain: float | None
    smallest_separation: float
    widest_angle: float
    mean_angle: float
    angle_quantiles: tuple[float, ...]
    error: float
    robustness: "placement.Robustness | None" = None
    breaks: tuple[str, ...] = ()
    rolls: np.ndarray | None = None


def row(
    name: str,
    angles,
    area: float,
    fraction: float,
    gain: float | None,
    spread: "placement.Triangulation",
    error: float,
    robustness: "placement.Robustness | None" = None,
    breaks: Sequence[str] = (),
    rolls: np.ndarray | None = None,
) -> Row:
    """The row of a layout with this exact area [mm²] and fraction of the ring maximum."""
    return Row(
        name, np.asarray(angles), area, fraction, gain, spread.smallest_separation, spread.widest_angle,
        spread.mean_best_angle, spread.best_angle_quantiles(SHARES), error, robustness, tuple(breaks), rolls,
    )  # fmt: skip


def layout_table(rows: Sequence[Row], compared_with: str) -> Table:
    """For the terminal."""
    shown = table(
        "layout", "exact area\n[mm²]", "of the ring\nmaximum", f"gain over\n{compared_with}",
        "RMS error\n[mm]", "smallest sepa-\nration [mm]", "triangulation\nwidest, mean [°]",
    )  # fmt: skip
    for row in rows:
        shown.add_row(
            f"{row.name} (not allowed)" if row.breaks else row.name,
            f"{row.area:.2f}",
            f"{100 * row.fraction:.2f} %",
            "" if row.gain is None else f"{100 * row.gain:+.2f} %",
            f"{row.error:.4f}" if np.isfinite(row.error) else "",
            f"{row.smallest_separation:.3f}" if np.isfinite(row.smallest_separation) else "",
            f"{np.degrees(row.widest_angle):.2f}, {np.degrees(row.mean_angle):.2f}",
        )
    return shown


def figures(row: Row) -> dict[str, Any]:
    """Every figure of a row in full, angles in degrees; None where there is none."""
    found = row.robustness
    faults = {} if found is None else {
        "worst_failure_fraction": found.worst_failure,
        "mean_failure_fraction": found.mean_failure,
        "worst_mounting_fraction": found.worst_mounting,
    }  # fmt: skip
    quantiles = {
        f"triangulation_angle_{100 * share:.0f}_percent_deg": float(np.degrees(angle))
        for share, angle in zip(SHARES, row.angle_quantiles, strict=True)
    }
    return {
        "layout": row.name,
        "area_mm2": row.area,
        "fraction_of_ring_maximum": row.fraction,
        "gain_fraction": row.gain,
        "rms_error_mm": finite(row.error),
        "smallest_separation_mm": finite(row.smallest_separation),
        "widest_triangulation_angle_deg": float(np.degrees(row.widest_angle)),
        "mean_triangulation_angle_deg": float(np.degrees(row.mean_angle)),
        **quantiles,
        **faults,
        "breaks_constraints": "; ".join(row.breaks),
        "ring_angles_deg": np.degrees(row.angles).tolist(),
        **({} if row.rolls is None else {"rolls_deg": np.degrees(row.rolls).tolist()}),
    }


def write_csv(path: Path, rows: Sequence[Row]) -> None:
    """The figures of each row."""
    write_table(path, [figures(row) for row in rows])
