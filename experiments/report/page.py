"""report.html: a layout, what it was asked for and what is known of it, in one page that needs no network."""

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import exact
import placement
from experiments.files.errors import InputError
from experiments.files.whole import written_whole
from experiments.layouts.layout_file import LayoutFile, constraints_of
from experiments.report.drawings import count_drawing, histogram_drawing, ring_drawing, tradeoff_drawing
from experiments.report.rendered import rendered
from experiments.report.request_text import Made
from experiments.report.scene import DrawnSurface, drawn_surface
from experiments.report.simulated import simulated
from experiments.tables.layouts import SHARES
from experiments.tables.robustness import PAIRS_SHOWN_UNTIL, accurate_pairs_words, consensus_words
from experiments.terminal.console import note

# What must stand in a layout file to report on it.
NEEDED = (
    "angles_rad", "areas_mm2", "best_equidistant_phase_deg", "certificate", "constraints", "falloff_mm",
    "fractions_of_ring_maximum", "mesh", "meshes", "n_cameras", "objective", "poses", "seed", "settings", "versions",
)  # fmt: skip
# A table of numbers of cameras belongs to the layout if their equidistant fractions, both exact, differ by less.
SAME_FRACTION = 1e-9
ANGLE_SAMPLES = 20_000


def check(made: LayoutFile) -> None:
    """Refuse a layout file that says too little.

    Raises
    ------
    InputError
    """
    missing = [name for name in NEEDED if name not in made.content]
    if missing:
        raise InputError(
            f"{made.path} says nothing of {', '.join(missing)}, which a report tells; camring optimise and camring "
            "count write layouts that do"
        )


def write(path: Path, made: LayoutFile, shown: exact.Scene) -> None:
    """Write the report of a layout.

    Parameters
    ----------
    path : pathlib.Path
        The page; count.csv and tradeoff.csv beside it, if they are of the same request, and simulation.json, if of the
        same layout, are shown too.
    made : LayoutFile
    shown : exact.Scene
        The first of the meshes that the layout was made for, and what of it counts.

    Raises
    ------
    InputError
    """
    check(made)
    with written_whole(path) as temporary:
        temporary.write_text(page(made, shown, path.parent), encoding="utf-8")


def page(made: LayoutFile, shown: exact.Scene, folder: Path) -> str:
    """The report as HTML, with the tables found in a folder; whatever comes from files is shown as text."""
    content = made.content
    ring_area = content["meshes"][0]["areas_of_poses_mm2"][0]["ring_maximum"] if content["falloff_mm"] is None else None
    drawn = drawn_surface(shown, made.ring, made.angles, made.demand, ring_area, made.rolls)
    layouts, angles = _layouts(made, shown)
    limits = content["constraints"]
    return rendered(
        "report.html",
        Made(content, (made.ring,), made.demand),
        drawn,
        fraction=content["fractions_of_ring_maximum"]["optimised"],
        gain=content["fractions_of_ring_maximum"]["optimised"] - content["fractions_of_ring_maximum"]["equidistant"],
        layouts=layouts,
        ring=ring_drawing(made.ring, made.angles, limits["fixed"], limits["forbidden"], made.rolls),
        cameras=_cameras(made, drawn),
        is_rolled=made.rolls is not None or made.ring.roll != "radial",
        histogram=histogram_drawing(angles),
        robustness=_robustness(content),
        certificate=content["certificate"],
        count=_count(made, folder / "count.csv"),
        tradeoff=_tradeoff(made, folder / "tradeoff.csv"),
        simulated=simulated(made, folder),
        n_ring=content["settings"]["ring_cameras"],
        ring_area=content["areas_mm2"]["ring_maximum"],
    )


def _layouts(made: LayoutFile, shown: exact.Scene) -> tuple[list[dict[str, Any]], list]:
    """Rows of the table of layouts; for the histogram, names, best angles [degrees] and weights of two of them."""
    content, n = made.content, len(made.angles)
    phase, most = np.radians(content["best_equidistant_phase_deg"]), content.get("most_area")
    rolls = None if made.rolls is None else made.rolls.tolist()
    is_same = most is not None and (most["angles_rad"], most.get("rolls_rad")) == (made.angles.tolist(), rolls)
    other = None if is_same else most
    kinds = (
        ("equidistant", "equidistant", made.ring.equidistant(n), None),
        (
            "best_equidistant", f"equidistant, best phase ({np.degrees(phase):.1f}°)", made.ring.equidistant(n, phase),
            None,
        ),
        *([("most_area", "most area", np.array(other["angles_rad"]), other.get("rolls_rad"))] if other else []),
        ("optimised", "optimised", made.angles, made.rolls),
    )  # fmt: skip
    rows, spreads = [], []
    areas, fractions = content["areas_mm2"], content["fractions_of_ring_maximum"]
    if other:
        areas = areas | {"most_area": other["area_mm2"]}
        fractions = fractions | {"most_area": other["fraction_of_ring_maximum"]}
    limits, errors = constraints_of(content["constraints"]), content.get("rms_errors_mm", {})
    for kind, name, angles, rolls in kinds:
        spread = placement.triangulation(
            shown, made.ring, angles, rolls=rolls, demand=made.demand, n_samples=ANGLE_SAMPLES
        )
        rows.append(
            {
                "name": name,
                "area": areas[kind],
                "error": errors.get(kind),
                "fraction": fractions[kind],
                "gain": None if kind == "equidistant" else fractions[kind] - fractions["equidistant"],
                "breaks": next(iter(limits.violations(made.ring, angles)), None),
                "separation": spread.smallest_separation if n > 1 else None,
                "widest": float(np.degrees(spread.widest_angle)),
                "mean": float(np.degrees(spread.mean_best_angle)),
                "quantiles": tuple(np.degrees(spread.best_angle_quantiles(SHARES)).tolist()),
            }
        )
        if kind in ("equidistant", "optimised"):
            spreads.append((name, np.degrees(spread.best_angles), spread.weights))
    return rows, spreads


def _cameras(made: LayoutFile, drawn: DrawnSurface) -> list[dict[str, Any]]:
    """Rows of the table of cameras."""
    found = made.content.get("robustness")
    left = found["layouts"][-1]["fractions_without_camera"] if found else [None] * len(made.angles)
    agreed = found["distances_in_best_layouts_deg"] if found else left
    positions = made.ring.positions(made.angles)
    mounted = made.content.get("mounting") or [None] * len(made.angles)
    rolls = made.ring.rolls(made.angles) if made.rolls is None else made.rolls
    return [
        {
            "number": number,
            "degrees": float(np.degrees(made.angles[number - 1])),
            "roll": float(np.degrees(rolls[number - 1])),
            "position": tuple(positions[number - 1].tolist()),
            "area": float(drawn.camera_areas[number - 1]),
            "without": left[number - 1],
            "away": agreed[number - 1],
            "mounting": mounted[number - 1],
        }
        for number in range(1, len(made.angles) + 1)
    ]


def _robustness(content: dict[str, Any]) -> dict[str, Any] | None:
    found = content.get("robustness")
    if found is None:
        return None
    # Layouts of earlier versions have no accurate pairs.
    accurate = found.get("accurate_pairs", [])
    enough = [pair["share_with_pairs_before"] >= PAIRS_SHOWN_UNTIL for pair in found["pairs"]]
    n_cameras = len(found["layouts"][-1]["ring_angles_deg"])
    agreed = placement.Consensus(
        tuple(found["best_layouts_fractions"]), tuple(np.radians(found["distances_in_best_layouts_deg"]).tolist())
    )
    return {
        "mounting_error": found["mounting_error_deg"],
        "n_mountings": len(found["layouts"][0]["fractions_mounted_off"]),
        "layouts": [
            {
                "name": layout["layout"],
                "worst_failure": min(layout["fractions_without_camera"]),
                "mean_failure": float(np.mean(layout["fractions_without_camera"])),
                "worst_mounting": min(layout["fractions_mounted_off"]),
            }
            for layout in found["layouts"]
        ],
        "consensus": consensus_words(agreed, np.radians(found["layouts"][-1]["ring_angles_deg"]).tolist()),
        "pairs": accurate or found["pairs"][: enough.index(True) + 1 if True in enough else None],
        "accurate": accurate_pairs_words(len(accurate), n_cameras, found["rms_error_mm"]) if accurate else None,
    }


def _count(made: LayoutFile, path: Path) -> dict[str, Any] | None:
    """What count.csv says, if it is there and of the same request."""
    if not path.exists():
        return None
    names = ("n_cameras", "equidistant_fraction", "best_equidistant_fraction", "optimised_fraction", "bound_fraction")
    table, rows = _table(path, names, "count")
    of_as_many = [row for row in rows if row["n_cameras"] == made.content["n_cameras"]]
    if not _is_of(made, path, [row["equidistant_fraction"] for row in of_as_many]):
        return None
    words = {"True": "yes", "False": "time ran out"}
    proven = [words.get(row.get("proven", ""), "") for row in table]
    return {
        "rows": [row | {"proven": word} for row, word in zip(rows, proven, strict=True)],
        "chart": count_drawing(rows),
    }


def _tradeoff(made: LayoutFile, path: Path) -> dict[str, Any] | None:
    """What tradeoff.csv says, if it is there and of the same request."""
    if not path.exists():
        return None
    names = ("area_mm2", "fraction_of_ring_maximum", "rms_error_mm")
    table, rows = _table(path, names, "tradeoff")
    rows = [
        numbers
        | {"layout": row.get("layout", ""), **{name: row.get(name) == "True" for name in ("undominated", "knee")}}
        for row, numbers in zip(table, rows, strict=True)
    ]
    if not _is_of(made, path, [row["fraction_of_ring_maximum"] for row in rows if row["layout"] == "equidistant"]):
        return None
    rows = [row for row in rows if None not in row.values()]
    return {"rows": [row for row in rows if row["undominated"]], "chart": tradeoff_drawing(rows)}


def _is_of(made: LayoutFile, path: Path, fractions: Sequence[float | None]) -> bool:
    """Whether one of the equidistant fractions of a table is that of the layout; if not, it says so."""
    own = made.content["fractions_of_ring_maximum"]["equidistant"]
    if any(fraction is not None and abs(fraction - own) < SAME_FRACTION for fraction in fractions):
        return True
    note(f"note: {path} is of another request, and is left out of the report")
    return False


def _table(
    path: Path, names: Sequence[str], command: str
) -> tuple[list[dict[str, str]], list[dict[str, float | None]]]:
    """Rows of a table that a command wrote, as they stand, and their numbers; None where there is none.

    Raises
    ------
    InputError
    """
    try:
        with path.open(newline="", encoding="utf-8") as file:
            table = list(csv.DictReader(file))
        return table, [{name: float(row[name]) if row[name] else None for name in names} for row in table]
    except (OSError, ValueError, KeyError) as error:
        raise InputError(
            f"{path} is no table of camring {command} ({error!r}); repeat camring {command}, or remove it"
        ) from error
