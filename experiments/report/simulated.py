"""What `camring simulate` found of a layout, for its report."""

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np

from experiments.files.errors import InputError
from experiments.layouts.layout_file import LayoutFile
from experiments.simulate import ERRORS, FIGURES, PREDICTION
from experiments.terminal.console import note

# Ring angles and rolls are the same if they differ by less [degrees].
SAME = 1e-9
PICTURES = {
    PREDICTION: "what came out, by incidence, density of pixels, disparity gradient, views and predicted error",
    ERRORS: "what is predicted to count, and how far off it came out",
}


def simulated(made: LayoutFile, folder: Path) -> dict[str, Any] | None:
    """What simulation.json of a folder says, with its pictures, if it is there and of the same layout and mesh.

    Raises
    ------
    InputError
    """
    path = folder / FIGURES
    if not path.exists():
        return None
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        is_own = content["mesh_sha256"] in made.made_for and any(_is_of(made, one) for one in content["layouts"])
        resolution, rows = content["demand"]["optics"]["resolution"], [_row(one) for one in content["layouts"]]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"{path} is no result of camring simulate ({error!r}); repeat camring simulate, or remove it"
        ) from error
    if not is_own:
        note(f"note: {path} is of another layout or mesh, and is left out of the report")
        return None
    there = {name: words for name, words in PICTURES.items() if (folder / name).exists()}
    return {
        "rows": rows,
        "pixels": f"{int(resolution[0])} × {int(resolution[1])}",
        "pictures": [
            {"words": words, "data": base64.b64encode((folder / name).read_bytes()).decode("ascii")}
            for name, words in there.items()
        ],
    }


def _is_of(made: LayoutFile, one: dict[str, Any]) -> bool:
    own = {"ring_angles_deg": np.degrees(made.angles)}
    if made.rolls is not None:
        own["rolls_deg"] = np.degrees(made.rolls)
    return all(
        len(one.get(name, ())) == len(values) and np.allclose(one[name], values, rtol=0, atol=SAME)
        for name, values in own.items()
    )


def _row(one: dict[str, Any]) -> dict[str, Any]:
    facing, noise = one["normal_std_facing_mm"], one["match_noise_px"]["measured"]
    return {
        "name": "optimised" if one["layout"] == "layout" else str(one["layout"]),
        "predicted": float(one["predicted_area_mm2"]),
        "within": [(float(most), float(area)) for most, area in one["measured_areas_mm2"].items()],
        "noise": None if noise is None else float(noise),
        "facing": [None if facing[which] is None else float(facing[which]) for which in ("measured", "predicted")],
    }
