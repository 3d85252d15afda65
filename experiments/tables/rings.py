"""The table of rings: what the layout proposed on each reconstructs, how accurately, and how near its cameras sit."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.table import Table

from experiments.terminal.console import table

# Which of the layouts of a layout file is meant.
PROPOSED, EVEN = "optimised", "best_equidistant"


def ring_row(ring: dict[str, Any], result: dict[str, Any], counted: Sequence[float], shares) -> dict[str, Any]:
    """Figures of one ring.

    Parameters
    ----------
    ring : dict
        As it stands in a layout file.
    result : dict
        "layout", as it stands in the file; or "refused", why there is none.
    counted : (S,) sequence of float
        Area of all that counts of each mesh and pose [mm²].
    shares : (S,) array_like or None
        Part of each in the mean; None for the worst.

    Examples
    --------
    >>> ring = {"diameter_mm": 3.0, "working_distance_mm": 9.0, "fov_mm": [4.0, 3.0]}
    >>> ring_row(ring, {"refused": "too narrow"}, [1.0], None)["refused"]
    'too narrow'
    """
    width, height = ring["fov_mm"]
    row: dict[str, Any] = {
        "diameter_mm": ring["diameter_mm"], "working_distance_mm": ring["working_distance_mm"],
        "fov_width_mm": width, "fov_height_mm": height,
    }  # fmt: skip
    made = result.get("layout")
    areas, errors, of_maximum = (
        {} if made is None else made[name] for name in ("areas_mm2", "rms_errors_mm", "fractions_of_ring_maximum")
    )
    for name, kind in (("", PROPOSED), ("equidistant_", EVEN)):
        row[f"{name}area_mm2"] = areas.get(kind)
        row[f"{name}fraction_of_ring_maximum"] = of_maximum.get(kind)
        row[f"{name}fraction_of_counted_area"] = None if made is None else _of_counted(made, kind, counted, shares)
        row[f"{name}rms_error_mm"] = errors.get(kind)
    row["ring_maximum_mm2"] = areas.get("ring_maximum")
    smallest = None if made is None else made["smallest_separation_mm"]
    row["smallest_separation_mm"] = smallest
    least = 0.0 if made is None else made["constraints"]["min_separation"]
    row["separation_left_mm"] = None if smallest is None else smallest - least
    row["undominated"] = False
    row["ring_angles_deg"] = [] if made is None else made["angles_deg"]
    row["rolls_deg"] = [] if made is None else made.get("rolls_deg", [])
    row["equidistant_phase_deg"] = None if made is None else made["best_equidistant_phase_deg"]
    row["refused"] = result.get("refused", "")
    return row


def _of_counted(made: dict[str, Any], kind: str, counted: Sequence[float], shares) -> float:
    areas = [pose[kind] for mesh in made["meshes"] for pose in mesh["areas_of_poses_mm2"]]
    fractions = np.array(areas) / np.array(counted)
    return float(fractions.min() if shares is None else np.asarray(shares) @ fractions)


def mark_undominated(rows: Sequence[dict[str, Any]]) -> None:
    """Mark the rings of which none has both more area and less error; where errors are not known, the greatest area.

    Examples
    --------
    >>> rows = [{"area_mm2": area, "rms_error_mm": error} for area, error in ((3.0, 0.2), (2.0, 0.3), (2.5, 0.1))]
    >>> mark_undominated(rows)
    >>> [row["undominated"] for row in rows]
    [True, False, True]
    """
    known = [row for row in rows if row["area_mm2"] is not None]
    value = np.array([(row["area_mm2"], -_error(row)) for row in known]).reshape(-1, 2)
    for row, one in zip(known, value, strict=True):
        better = (value >= one).all(axis=1) & (value > one).any(axis=1)
        row["undominated"] = not better.any()


def _error(row: dict[str, Any]) -> float:
    return 0.0 if row["rms_error_mm"] is None else row["rms_error_mm"]


def ring_table(rows: Sequence[dict[str, Any]]) -> Table:
    """For the terminal; undominated rings have a star."""
    several = len({(row["fov_width_mm"], row["fov_height_mm"]) for row in rows}) > 1
    shown = table(
        "diameter x\ndistance [mm]", *["field of\nview [mm]"] * several, "exact area\n[mm²]", "of the ring's\nmaximum",
        "of the\ncounted area", "equidistant,\nbest phase", "RMS error\n[mm]", "smallest sepa-\nration, left [mm]",
    )  # fmt: skip
    for row in rows:
        name = f"{row['diameter_mm']:g} x {row['working_distance_mm']:g}{' *' if row['undominated'] else ''}"
        view = [f"{row['fov_width_mm']:g}x{row['fov_height_mm']:g}"] * several
        if row["area_mm2"] is None:
            shown.add_row(name, *view, "none")
            continue
        separation = row["smallest_separation_mm"]
        shown.add_row(
            name, *view, f"{row['area_mm2']:.2f}", f"{100 * row['fraction_of_ring_maximum']:.2f} %",
            f"{100 * row['fraction_of_counted_area']:.2f} %",
            f"{row['equidistant_area_mm2']:.2f}, {100 * row['equidistant_fraction_of_ring_maximum']:.2f} %",
            "" if row["rms_error_mm"] is None else f"{row['rms_error_mm']:.4f}",
            "" if separation is None else f"{separation:.2f}, {row['separation_left_mm']:.2f}",
        )  # fmt: skip
    return shown


def refined_row(start: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Figures of a ring moved from where another was: `start` is the layout of that one, as of a layout file."""
    made, rings = result["layout"], (start["ring"], result["layout"]["ring"])
    (d0, h0), (d1, h1) = ((ring["diameter_mm"], ring["working_distance_mm"]) for ring in rings)
    return {
        "start_diameter_mm": d0,
        "start_working_distance_mm": h0,
        "diameter_mm": d1,
        "working_distance_mm": h1,
        "fov_width_mm": rings[1]["fov_mm"][0],
        "fov_height_mm": rings[1]["fov_mm"][1],
        "area_mm2": made["areas_mm2"][PROPOSED],
        "start_area_mm2": start["areas_mm2"][PROPOSED],
        "fraction_of_counted_area": result["fraction_of_counted_area"],
        "rms_error_mm": made["rms_errors_mm"][PROPOSED],
        "start_rms_error_mm": start["rms_errors_mm"][PROPOSED],
        "smallest_separation_mm": made["smallest_separation_mm"],
        "ring_angles_deg": made["angles_deg"],
        "rolls_deg": made.get("rolls_deg", []),
    }


def refined_table(rows: Sequence[dict[str, Any]]) -> Table:
    """For the terminal."""
    shown = table(
        "from [mm]", "to diameter x\ndistance [mm]", "exact area\n[mm²]", "more than\nthere", "RMS error,\nthere [mm]",
        "smallest sepa-\nration [mm]",
    )  # fmt: skip
    for row in rows:
        errors = [row[name] for name in ("rms_error_mm", "start_rms_error_mm")]
        separation = row["smallest_separation_mm"]
        shown.add_row(
            f"{row['start_diameter_mm']:g} x {row['start_working_distance_mm']:g}",
            f"{row['diameter_mm']:.2f} x {row['working_distance_mm']:.2f}",
            f"{row['area_mm2']:.2f}",
            f"{row['area_mm2'] - row['start_area_mm2']:+.2f}",
            "" if None in errors else "{:.4f}, {:.4f}".format(*errors),
            "" if separation is None else f"{separation:.2f}",
        )
    return shown
