"""The derivative by what may change of a ring: the angles of its cameras, radius and height, and rolls."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exact.cameras import Camera
from exact.errors import ExactError
from exact.ring import Ring

# A camera is on a ring if it is nearer to it, and looks closer to the focus, than this part of its distance.
ON_RING = 1e-9


@dataclass(frozen=True, eq=False)
class RingDerivative:
    """How an area changes with each of M cameras of a ring.

    They go on looking at the focus, where their field of view stays as large, and keep their rolls; of a ring whose
    rolls are one direction in space, that direction. Of radius and height of the whole ring, it is the sum over the
    cameras.

    Attributes
    ----------
    angle : (M,) float
        By the ring angle [mm²/rad].
    radius : (M,) float
        By the distance from the ring's axis, half the diameter [mm²/mm].
    height : (M,) float
        By the working distance [mm²/mm].
    roll : (M,) float
        By a turn about the optical axis, clockwise as the camera sees it [mm²/rad].
    """

    angle: np.ndarray
    radius: np.ndarray
    height: np.ndarray
    roll: np.ndarray


def on_ring(
    ring: Ring, cameras: Sequence[Camera], position: np.ndarray, rotation: np.ndarray, half_extent: np.ndarray,
    target_distance: np.ndarray,
) -> RingDerivative:  # fmt: skip
    """From derivatives by position, rotation (M, 3), extent (M, 2) and distance of the target (M,) of cameras.

    Raises
    ------
    ExactError
        If a camera is none of this ring.
    """
    away = np.array([camera.position for camera in cameras]) - np.array(ring.focus)
    look = np.array([camera.rotation[2] for camera in cameras])
    extent = np.array([camera.half_extent for camera in cameras])
    axis, radius, height = ring.frame[:, 2], ring.diameter / 2, ring.working_distance
    distance = float(np.hypot(radius, height))
    across = away - (away @ axis)[:, None] * axis
    off = np.abs(np.linalg.norm(across, axis=1) - radius) + np.abs(away @ axis - height)
    off = np.maximum(off, np.linalg.norm(away + distance * look, axis=1)) / distance
    off = np.maximum(off, np.abs(extent * 2 * distance / np.array(ring.fov) - 1).max(axis=1))
    if off.max() > ON_RING:
        raise ExactError(
            f"camera {int(off.argmax()) + 1} of {len(cameras)} is none of this ring; give the ring whose `cameras` "
            "they are"
        )
    outwards = across / np.linalg.norm(across, axis=1)[:, None]
    tangent = np.cross(axis, outwards)

    def along(moved: np.ndarray, turned: np.ndarray, farther: float) -> np.ndarray:
        """By a motion (M, 3) [mm] and a turn (M, 3) [rad], while the focus gets so much farther away [mm]."""
        if not isinstance(ring.roll, str):
            turned = _keeping(ring, ring.roll, look, -(moved + farther * look) / distance)
        narrower = half_extent * extent * (farther / distance)
        return (position * moved + rotation * turned).sum(axis=1) - narrower.sum(axis=1) + target_distance * farther

    turns = tangent / distance**2
    upwards = np.broadcast_to(axis, outwards.shape)
    return RingDerivative(
        along(radius * tangent, upwards, 0.0),
        along(outwards, height * turns, radius / distance),
        along(upwards, -radius * turns, height / distance),
        (rotation * look).sum(axis=1),
    )


def _keeping(ring: Ring, roll: float, look: np.ndarray, swung: np.ndarray) -> np.ndarray:
    """(M, 3) turns that swing looks (M, 3) by `swung`, across them, while images stay along the direction `roll`.

    Right is the part p of that direction d across the look l, of unit length. It changes by -(l·d) dl + .. l, of which
    the part along down, l x p / |p|, is a turn about the look.
    """
    along = ring.frame[:, :2] @ [np.cos(roll), np.sin(roll)]
    sideways = np.cross(look, along)
    about = -(look @ along) * (sideways * swung).sum(axis=1) / (sideways**2).sum(axis=1)
    return np.cross(look, swung) + about[:, None] * look
