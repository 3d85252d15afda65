"""The cameras of a layout as they are exported: named, and with an image size in pixels."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

import exact
from experiments.files.errors import InputError

# Pixels along the longer side of the image unless another size is asked for.
LONGER_SIDE = 3600
PIXEL_RULE = (
    "x to the right, y down, the upper left corner of the image at (0, 0), the centre of its first pixel at (0.5, 0.5)"
)


@dataclass(frozen=True, eq=False)
class NamedCamera:
    """One camera of a layout.

    Attributes
    ----------
    name : str
        camera_01, camera_02, … in the order of the layout.
    angle : float
        Ring angle [rad].
    camera : exact.Camera
        Its `resolution` is the image size [pixels].
    """

    name: str
    angle: float
    camera: exact.Camera

    @property
    def image(self) -> str:
        """Name of the picture that this camera takes."""
        return f"{self.name}.png"

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the image [pixels]."""
        width, height = self.camera.resolution
        return int(width), int(height)

    @property
    def pinhole(self) -> tuple[float, float, float, float]:
        """fx, fy, cx, cy [pixels], with the image's upper left corner at (0, 0)."""
        matrix = self.camera.intrinsic
        return float(matrix[0, 0]), float(matrix[1, 1]), float(matrix[0, 2]), float(matrix[1, 2])

    @property
    def to_world(self) -> np.ndarray:
        """(4, 4) camera to world [mm], for a camera that looks along its -z with y up, as OpenGL has it."""
        right, down, look = self.camera.rotation
        matrix = np.eye(4)
        matrix[:3] = np.stack([right, -down, -look, self.camera.position], axis=1) + 0.0  # + 0.0 turns -0.0 into 0.0
        return matrix


def named_cameras(
    ring: exact.Ring,
    angles: np.ndarray,
    resolution: tuple[int, int] | None = None,
    rolls: np.ndarray | None = None,
) -> tuple[NamedCamera, ...]:
    """Name the cameras at these (M,) ring angles [rad] and give them an image size.

    Parameters
    ----------
    resolution : (int, int), optional
        Width and height [pixels]; without it the longer side has 3600 and pixels are square, to rounding.
    rolls : (M,) ndarray, optional
        Of the cameras [rad], as `exact.Ring.cameras` takes them.

    Examples
    --------
    >>> ring = exact.Ring(fov=(60.0, 40.0))
    >>> cameras = named_cameras(ring, ring.equidistant(2))
    >>> [(camera.name, camera.image, camera.size) for camera in cameras]
    [('camera_01', 'camera_01.png', (3600, 2400)), ('camera_02', 'camera_02.png', (3600, 2400))]
    """
    if resolution is None:
        width, height = (max(1, round(LONGER_SIDE * side / max(ring.fov))) for side in ring.fov)
        resolution = width, height
    pixels = np.array(resolution, dtype=np.float64)
    digits = max(2, len(str(len(angles))))
    return tuple(
        NamedCamera(f"camera_{number:0{digits}d}", float(angle), replace(camera, resolution=pixels))
        for number, (angle, camera) in enumerate(zip(angles, ring.cameras(angles, rolls), strict=True), start=1)
    )


def named_on_rings(
    rings: Sequence[exact.Ring], ring_of, angles, resolution: tuple[int, int] | None = None
) -> tuple[NamedCamera, ...]:
    """The same for cameras on several rings: which of the rings (M,) each sits on, from 0, and its ring angle [rad].

    Names tell the ring, counted from 1; the cameras of each ring follow each other.

    Examples
    --------
    >>> rings = exact.Ring(), exact.Ring(fov=(30.0, 30.0))
    >>> [(camera.name, camera.size) for camera in named_on_rings(rings, [0, 1], [0.5, 2.0])]
    [('ring_1_camera_01', (3600, 2400)), ('ring_2_camera_01', (3600, 3600))]
    """
    found = []
    for k in np.unique(ring_of).tolist():
        own = named_cameras(rings[k], np.asarray(angles)[np.asarray(ring_of) == k], resolution)
        found += [replace(camera, name=f"ring_{k + 1}_{camera.name}") for camera in own]
    return tuple(found)


def parse_resolution(text: str) -> tuple[int, int]:
    """Width x height in pixels.

    Raises
    ------
    InputError
        If it is not two whole positive numbers.

    Examples
    --------
    >>> parse_resolution("1920x1080")
    (1920, 1080)
    """
    match = re.fullmatch(r"\s*([0-9]{1,6})\s*[x×]\s*([0-9]{1,6})\s*", text)
    width, height = (int(part) for part in match.groups()) if match else (0, 0)
    if width < 1 or height < 1:
        raise InputError(f"--resolution is {text!r}; it must be width x height in whole pixels, as in 3600x2400")
    return width, height
