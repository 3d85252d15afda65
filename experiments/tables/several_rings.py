"""The table of several rings: each alone, equidistant and optimised, and all of them together."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from rich.table import Table

import exact
import placement
from experiments.files.table import finite
from experiments.terminal.console import table
from placement.rings.ring_places import Places, cameras_of


class LayoutOnRings(NamedTuple):
    """One of the layouts compared."""

    name: str
    ring_of: Sequence[int]
    """Which ring each camera sits on, from 0."""
    angles: Sequence[float]
    """Ring angles [rad]."""
    fraction: float
    """Exact area over what all rings see."""

    def cameras(self, rings: Sequence[exact.Ring]) -> tuple[exact.Camera, ...]:
        """(M,) its cameras."""
        return cameras_of(rings, Places(np.array(self.ring_of), np.array(self.angles)))


def best_alone(found: "placement.RingsPlacement") -> LayoutOnRings | None:
    """The best layout of one ring; None if none of them takes all cameras."""
    alone = [
        (one.fraction, k, one.placement.angles) for k, one in enumerate(found.alone)
        if one.placement is not None and one.fraction is not None
    ]  # fmt: skip
    if not alone:
        return None
    fraction, k, angles = max(alone)
    return LayoutOnRings(f"ring {k + 1} alone", [k] * len(angles), angles, fraction)


def all_rings(found: "placement.RingsPlacement") -> LayoutOnRings:
    """The layout proposed."""
    return LayoutOnRings("all rings", found.ring_of, found.angles, found.fraction)


def rings_rows(found: "placement.RingsPlacement", n_poses: int) -> list[dict[str, Any]]:
    """Figures of every layout compared; areas are means over the poses of each mesh.

    Parameters
    ----------
    found : placement.RingsPlacement
    n_poses : int
        Poses of each mesh.
    """
    rows = []
    for number, (ring, one) in enumerate(zip(found.rings, found.alone, strict=True)):
        alone, size = one.placement, f"{ring.diameter:g} x {ring.working_distance:g}"
        if alone is None:
            rows.append(_row(f"ring {number + 1} ({size})", None, None, np.inf, np.inf, ()) | {"refused": one.refused})
            continue
        even = ring.equidistant(alone.n_cameras, alone.best_equidistant_phase)
        compared = (
            ("equidistant", alone.equidistant_area, one.equidistant_fraction, alone.equidistant_error_rms,
             ring.equidistant(alone.n_cameras)),
            ("equidistant, best phase", alone.best_equidistant_area, one.best_equidistant_fraction,
             alone.best_equidistant_error_rms, even),
            ("optimised", alone.area, one.fraction, alone.error_rms, alone.angles),
        )  # fmt: skip
        for kind, area, fraction, error, angles in compared:
            apart = ring.separations(angles)
            least = float(np.min(apart[~np.eye(len(apart), dtype=bool)], initial=np.inf))
            on_ring = [(number, float(angle)) for angle in angles]
            rows.append(_row(f"ring {number + 1} ({size}), {kind}", area / n_poses, fraction, error, least, on_ring))
    places = list(zip(found.ring_of, found.angles, strict=True))
    area, error, apart = found.area / n_poses, found.error_rms, found.smallest_separation
    rows.append(_row("all rings", area, found.fraction, error, apart, places))
    return rows


def _row(
    name: str,
    area: float | None,
    fraction: float | None,
    error: float,
    least: float,
    places: Sequence[tuple[int, float]],
) -> dict[str, Any]:
    return {
        "layout": name,
        "area_mm2": area,
        "fraction_of_all_rings": fraction,
        "rms_error_mm": finite(error),
        "smallest_separation_mm": finite(least),
        "rings": [ring + 1 for ring, _ in places],
        "ring_angles_deg": [float(np.degrees(angle)) for _, angle in places],
        "refused": "",
    }


def rings_table(rows: Sequence[dict[str, Any]]) -> Table:
    """For the terminal."""
    shown = table(
        "layout", "exact area\n[mm²]", "of what all\nrings see", "RMS error\n[mm]", "smallest sepa-\nration [mm]"
    )
    for row in rows:
        if row["refused"]:
            shown.add_row(row["layout"], "none")
            continue
        error, apart = row["rms_error_mm"], row["smallest_separation_mm"]
        shown.add_row(
            row["layout"],
            f"{row['area_mm2']:.2f}",
            f"{100 * row['fraction_of_all_rings']:.2f} %",
            "" if error is None else f"{error:.4f}",
            "" if apart is None else f"{apart:.2f}",
        )
    return shown


def places_words(found: "placement.RingsPlacement") -> str:
    """Which camera sits on which ring, in words."""
    parts = []
    for number, ring in enumerate(found.rings):
        own = np.degrees(np.array(found.angles)[np.array(found.ring_of) == number])
        at = f"at {', '.join(f'{angle:.3f}' for angle in own)} degrees" if len(own) else "no camera"
        parts.append(f"ring {number + 1} ({ring.diameter:g} x {ring.working_distance:g} mm): {at}")
    return "; ".join(parts)
