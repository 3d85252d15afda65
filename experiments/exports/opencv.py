"""K, R and t for OpenCV, as JSON: world to camera, x right, y down, z forward.

OpenCV puts the centre of the upper left pixel at (0, 0), half a pixel from its corner, where `exact.Camera` counts
from: its principal point is smaller by (0.5, 0.5).
"""

import json
from collections.abc import Sequence
from pathlib import Path

from experiments.exports.cameras import NamedCamera
from experiments.files.whole import written_whole

CONVENTIONS = {
    "pose": "x_camera = R x_world + t",
    "axes": "x right, y down, z forward",
    "unit": "mm",
    "pixels": "x to the right, y down, the centre of the upper left pixel at (0, 0)",
}


def write(path: Path, cameras: Sequence[NamedCamera]) -> None:
    """Write the file: for each camera K (3, 3), R (3, 3), t (3,) [mm], and no distortion (5,)."""
    listed = []
    for camera in cameras:
        (width, height), (fx, fy, cx, cy) = camera.size, camera.pinhole
        listed.append(
            {
                "name": camera.name,
                "image": camera.image,
                "width": width,
                "height": height,
                "K": [[fx, 0.0, cx - 0.5], [0.0, fy, cy - 0.5], [0.0, 0.0, 1.0]],
                "R": camera.camera.rotation.tolist(),
                "t": camera.camera.extrinsic[:3, 3].tolist(),
                "distortion": [0.0] * 5,
            }
        )
    with written_whole(path) as temporary:
        content = {"conventions": CONVENTIONS, "cameras": listed}
        temporary.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n", encoding="utf-8")
