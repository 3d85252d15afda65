"""transforms.json of nerfstudio: camera to world, the camera looks along its -z, y up; pixel centres at halves."""

import json
from collections.abc import Sequence
from pathlib import Path

from experiments.exports.cameras import PIXEL_RULE, NamedCamera
from experiments.files.whole import written_whole


def write(path: Path, cameras: Sequence[NamedCamera]) -> None:
    """Write the file; the pictures are expected in the folder images/ beside it."""
    frames = []
    for camera in cameras:
        (width, height), (fx, fy, cx, cy) = camera.size, camera.pinhole
        frames.append(
            {
                "file_path": f"images/{camera.image}",
                "w": width, "h": height, "fl_x": fx, "fl_y": fy, "cx": cx, "cy": cy,
                "k1": 0.0, "k2": 0.0, "p1": 0.0, "p2": 0.0,
                "transform_matrix": camera.to_world.tolist(),
            }
        )  # fmt: skip
    content = {
        "comment": f"camera to world [mm], the camera looks along its -z with y up; pixels: {PIXEL_RULE}",
        "camera_model": "OPENCV",
        "frames": frames,
    }
    with written_whole(path) as temporary:
        temporary.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n", encoding="utf-8")
