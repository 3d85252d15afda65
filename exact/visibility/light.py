"""What of a surface is lit: what at least one of several point lights sees, as pinholes that look all around."""

from collections.abc import Sequence

import numpy as np

from exact.cameras import Camera
from exact.demand import Criterion
from exact.visibility.coverage import Tally, tally
from exact.visibility.surface import Surface

# A light whose whole surface lies within this tangent of one direction looks there; any other looks six ways.
WIDEST = 3.0
# What the image of a light reaches beyond what it has to show.
ROOM = 1.01
SIX_WAYS = [(axis, sign) for axis in range(3) for sign in (1.0, -1.0)]


def lit(surface: Surface, lights: Sequence[Sequence[float]], counted: np.ndarray) -> Tally:
    """Which part of which of the `counted` faces, (F,) bool, some of the lights (3,) [mm] sees."""
    looks = [look for light in lights for look in _looks(surface, np.array(light))]
    return tally(surface, looks, Criterion(1), counted, workers=1)


def _looks(surface: Surface, light: np.ndarray) -> list[Camera]:
    """Pinholes at a light that together look at all of the surface."""
    low, high = surface.bounds
    centre, size = (low + high) / 2, float(np.linalg.norm(high - low))
    away = centre - light
    distance = float(np.linalg.norm(away))
    if distance > 0:
        one = _pinhole(light, away / distance, distance, 2 * distance)
        local = (surface.vertices - light) @ one.rotation.T
        if (np.abs(local[:, :2]) <= WIDEST * local[:, 2:]).all() and (local[:, 2] > 0).all():
            tangent = float((np.abs(local[:, :2]) / local[:, 2:]).max())
            return [_pinhole(light, away / distance, distance, 2 * ROOM * tangent * distance)]
    # A quarter turn to each side, and a hair more.
    return [_pinhole(light, sign * np.eye(3)[axis], size, 2 * size * ROOM) for axis, sign in SIX_WAYS]


def _pinhole(light: np.ndarray, look: np.ndarray, distance: float, side: float) -> Camera:
    up = np.eye(3)[int(np.argmin(np.abs(look)))]
    return Camera.look_at(light, light + distance * look, up, fov=(side, side))
