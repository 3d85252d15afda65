"""The report of a layout on several rings: what each ring does alone, and what all of them do together."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import exact
from experiments.files.whole import written_whole
from experiments.report.drawings import rings_drawing
from experiments.report.rendered import rendered
from experiments.report.request_text import Made
from experiments.report.scene import ShownLayout, compared_surface
from experiments.tables.several_rings import LayoutOnRings


def write(
    path: Path,
    made: Made,
    shown: exact.Scene,
    rows: Sequence[dict[str, Any]],
    alone: LayoutOnRings | None,
    found: LayoutOnRings,
) -> None:
    """Write the report of a layout on several rings.

    Parameters
    ----------
    path : pathlib.Path
    made : Made
    shown : exact.Scene
        The first of the meshes that the layout was made for, and what of it counts.
    rows : sequence of dict
        The table of layouts compared, as several_rings.csv has it.
    alone : LayoutOnRings or None
        The best layout on one of the rings, to compare with; None if none of them takes all cameras.
    found : LayoutOnRings
        The layout proposed.
    """
    content, rings = made.content, made.rings
    cameras, degrees = found.cameras(rings), np.degrees(found.angles)
    compared = None if alone is None else ShownLayout(alone.name, f"that of {alone.name}", alone.cameras(rings))
    proposed = ShownLayout(found.name, f"the layout on {found.name}", cameras)
    places = [f"on ring {k + 1} at {angle:.1f}°" for k, angle in zip(found.ring_of, degrees, strict=True)]
    weighs_all_alike = content["falloff_mm"] is None
    maximum = content["meshes"][0]["areas_of_poses_mm2"][0]["all_rings"]
    drawn = compared_surface(
        shown, compared, proposed, places, rings[0].frame[:, 2], made.demand,
        (maximum, "what all rings see") if weighs_all_alike else None,
    )  # fmt: skip
    text = rendered(
        "several_rings.html",
        made,
        drawn,
        fraction=found.fraction,
        gain=None if alone is None else found.fraction - alone.fraction,
        layouts=rows,
        drawing=rings_drawing(rings, found.ring_of, found.angles),
        cameras=[
            {
                "number": number,
                "ring": found.ring_of[number - 1] + 1,
                "degrees": float(degrees[number - 1]),
                "position": tuple(cameras[number - 1].position.tolist()),
                "area": float(drawn.camera_areas[number - 1]),
                "nearest": _nearest(cameras, number - 1),
            }
            for number in range(1, len(cameras) + 1)
        ],
        certificate=content["certificate"],
        n_ring=content["settings"]["ring_cameras"],
        maximum=content["all_rings_area_mm2"],
    )
    with written_whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _nearest(cameras: Sequence[exact.Camera], one: int) -> float | None:
    """Distance to the nearest other camera centre [mm]; None if there is no other."""
    others = [np.linalg.norm(camera.position - cameras[one].position) for k, camera in enumerate(cameras) if k != one]
    return float(min(others)) if others else None
