"""COLMAP's text model: world to camera, x right, y down, z forward; no points yet.

COLMAP puts the centre of the upper left pixel at (0.5, 0.5), so its principal point is that of `exact.Camera`.
"""

from collections.abc import Sequence
from pathlib import Path

from scipy.spatial.transform import Rotation

from experiments.exports.cameras import PIXEL_RULE, NamedCamera
from experiments.files.whole import written_whole

FILES = ("cameras.txt", "images.txt", "points3D.txt")


def write(folder: Path, cameras: Sequence[NamedCamera]) -> None:
    """Write cameras.txt, images.txt and an empty points3D.txt into `folder`, which is there.

    Every image has a camera of its own: those of a real ring are calibrated one by one.
    """
    models = [f"# one PINHOLE camera per image; fx, fy, cx, cy [pixels]: {PIXEL_RULE}",
              "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]"]  # fmt: skip
    poses = ["# world to camera; lengths in millimetres; no observations, so every second line is empty",
             "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME"]  # fmt: skip
    for number, camera in enumerate(cameras, start=1):
        models.append(_line(number, "PINHOLE", *camera.size, *camera.pinhole))
        x, y, z, w = Rotation.from_matrix(camera.camera.rotation).as_quat().tolist()
        shift = camera.camera.extrinsic[:3, 3].tolist()
        poses += [_line(number, w, x, y, z, *shift, number, camera.image), ""]
    points = ["# no points: POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[]"]
    for name, lines in zip(FILES, (models, poses, points), strict=True):
        with written_whole(folder / name) as temporary:
            temporary.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _line(*values: object) -> str:
    return " ".join(str(value) for value in values)  # str of a float gives back the same float
