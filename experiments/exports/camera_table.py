"""cameras.csv: one row per camera, for spreadsheets and scripts."""

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from experiments.exports.cameras import NamedCamera
from experiments.files.whole import written_whole

COLUMNS = (
    "camera", "image", "ring_angle_deg",
    *(f"{axis}_mm" for axis in "xyz"),
    *(f"{direction}_{axis}" for direction in ("right", "down", "look") for axis in "xyz"),
    "width_px", "height_px", "fx_px", "fy_px", "cx_px", "cy_px",
)  # fmt: skip


def write(path: Path, cameras: Sequence[NamedCamera]) -> None:
    """Write position, axes in world coordinates and intrinsic numbers; pixels count from the upper left corner."""
    with written_whole(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(COLUMNS)
        for camera in cameras:
            place, axes = camera.camera.position.tolist(), camera.camera.rotation.ravel().tolist()
            angle = float(np.degrees(camera.angle))
            rows.writerow([camera.name, camera.image, angle, *place, *axes, *camera.size, *camera.pinhole])
