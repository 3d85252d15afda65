"""How much each camera's mounting matters: what the exact area changes by for a degree, by its own derivative."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from rich.table import Table

import exact
from experiments.terminal.console import table


@dataclass(frozen=True, eq=False)
class Mounting:
    """Change of the reconstructable area with each of M cameras [mm²/°].

    Attributes
    ----------
    along_ring : (M,) float
        By its ring angle.
    roll : (M,) float
        By a turn about its optical axis, clockwise as the camera sees it.
    tilt : (M,) float
        By a turn of its optical axis, to the side to which the area grows fastest; as much is lost to the other.
    """

    along_ring: np.ndarray
    roll: np.ndarray
    tilt: np.ndarray


def mounting(
    scenes: Sequence[exact.Scene], ring: exact.Ring, angles, demand: exact.Demand, rolls=None
) -> Mounting | None:
    """Of the mean area over several scenes; None if the area has no derivative that is known (`exact.Demand`).

    Parameters
    ----------
    scenes : sequence of exact.Scene
    ring : exact.Ring
    angles : (M,) array_like
        Ring angles [rad].
    demand : exact.Demand
    rolls : (M,) array_like, optional
        Of cameras that have rolls of their own [rad].
    """
    if not demand.has_derivative:
        return None
    cameras = ring.cameras(angles, rolls)
    found = [exact.gradient(scene, cameras, demand=demand) for scene in scenes]
    around = [one.on_ring(ring) for one in found]
    look = np.array([camera.rotation[2] for camera in cameras])
    turn = np.mean([one.rotation for one in found], axis=0)
    turn = turn - (turn * look).sum(axis=1, keepdims=True) * look
    degree = np.radians(1.0)
    return Mounting(
        degree * np.mean([one.angle for one in around], axis=0),
        degree * np.mean([one.roll for one in around], axis=0),
        degree * np.linalg.norm(turn, axis=1),
    )


def mounting_table(found: Mounting, angles) -> Table:
    """For the terminal; `angles` are (M,) ring angles [rad]."""
    shown = table(
        "mounting of\ncamera", "ring angle\n[°]", "along the ring\n[mm² per degree]", "roll\n[mm² per degree]",
        "tilt\n[mm² per degree]",
    )  # fmt: skip
    for number, row in enumerate(mounting_content(found, angles), start=1):
        shown.add_row(
            str(number),
            f"{row['ring_angle_deg']:.3f}",
            f"{row['along_ring_mm2_per_deg']:+.2f}",
            f"{row['roll_mm2_per_deg']:+.2f}",
            f"{row['tilt_mm2_per_deg']:.2f}",
        )
    return shown


def mounting_content(found: Mounting, angles) -> list[dict[str, Any]]:
    """The same in full, as it stands in layout.json: one entry for each camera."""
    return [
        {
            "ring_angle_deg": float(np.degrees(angle)),
            "along_ring_mm2_per_deg": float(along),
            "roll_mm2_per_deg": float(roll),
            "tilt_mm2_per_deg": float(tilt),
        }
        for angle, along, roll, tilt in zip(angles, found.along_ring, found.roll, found.tilt, strict=True)
    ]
