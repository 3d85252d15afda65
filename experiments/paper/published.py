"""The areas published in Wachter 2021, Tables A1 to A3."""

import csv
from pathlib import Path

CAMERA_COUNTS = (2, 4, 6, 8, 16, 32, 64, 128, 256, 360)
FIRST = CAMERA_COUNTS[0]  # number of cameras at which the amplitudes of a decay are counted
FILE = Path(__file__).parent / "published_areas.csv"


def published_areas() -> dict[tuple[str, int, str, bool, int], float]:
    """Area [mm²] by site, depth [mm], field of view, whether the top surface counts, and number of cameras.

    Examples
    --------
    >>> published_areas()["circ_artery", 50, "36x24", False, 4]
    3706.91
    """
    with FILE.open(newline="", encoding="utf-8") as file:
        return {
            (
                row["site"],
                int(row["depth_mm"]),
                row["fov_mm"],
                row["top_surface_included"] == "1",
                int(row["n_cameras"]),
            ): (float(row["area_mm2"]))
            for row in csv.DictReader(file)
        }
