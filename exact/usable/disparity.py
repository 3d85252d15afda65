r"""How unlike two images of a face are: the disparity gradient of a pair of cameras.

Rectified, the two images of a plane with normal n differ by a disparity that is linear in the image. Its gradient, by
how many pixels a match shifts from one pixel to the next, is the same all over the plane::

    g = b |n - (n·a) a| / h

with the baseline b, the unit vector a of their common viewing direction across the baseline, and the height h over the
plane of the middle between the two: b tan β / z at incidence β and depth z. A window of an image is squeezed or slanted
by as much in the other, and past some gradient no matcher takes them for the same (Burt and Julesz, A disparity
gradient limit for binocular fusion, Science 208, 1980).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exact.cameras import Camera
from exact.visibility.surface import Surface

# Numbers at once.
AT_ONCE = 4_000_000


@dataclass(frozen=True, eq=False)
class DisparityLimit:
    """The greatest disparity gradient with which a pair of given cameras is matched on the faces of a surface.

    Attributes
    ----------
    surface : Surface
    cameras : (M,) tuple of Camera
    largest : float
        Greatest gradient.
    """

    surface: Surface
    cameras: tuple[Camera, ...]
    largest: float

    def matched(self, face: np.ndarray, seen: np.ndarray, far: np.ndarray | None) -> np.ndarray:
        """(N,) bool: whether some two of the cameras that see a part of each face (N,), by `seen` (N, M), match it.

        `far`, (M, M) bool, are pairs that count at all; None: any.
        """
        n_cameras = len(self.cameras)
        step = max(1, AT_ONCE // n_cameras)
        parts = [slice(first, first + step) for first in range(0, len(face), step)]
        found = [self._matched(face[part], seen[part, :n_cameras], far) for part in parts]
        return np.concatenate(found) if found else np.zeros(0, dtype=bool)

    def _matched(self, face: np.ndarray, seen: np.ndarray, far: np.ndarray | None) -> np.ndarray:
        found = np.zeros(len(face), dtype=bool)
        for i in range(1, len(self.cameras)):
            left = np.flatnonzero(seen[:, i] & ~found)
            partner = seen[left, :i] if far is None else seen[left, :i] & far[i, :i]
            some = partner.any(axis=1)
            left, partner = left[some], partner[some]
            if not len(left):
                continue
            which, back = np.unique(face[left], return_inverse=True)
            matches = gradients(self.surface, self.cameras[:i], self.cameras[i], which) <= self.largest
            found[left] = (partner & matches[back.reshape(-1)]).any(axis=1)
        return found


def gradients(surface: Surface, cameras: Sequence[Camera], other: Camera, face: np.ndarray) -> np.ndarray:
    """(F, M) disparity gradients of `cameras` (M,), each with the `other`, on faces given by index (F,)."""
    return plane_gradients(surface.normals[face], surface.vertices[surface.faces[face, 0]], cameras, other)


def plane_gradients(normals: np.ndarray, points: np.ndarray, cameras: Sequence[Camera], other: Camera) -> np.ndarray:
    """(F, M) the same on planes with unit normals (F, 3) through points (F, 3) [mm].

    Infinite where the middle between the two is not above a plane, and for cameras that look at each other.
    """
    positions, looks = (np.array([getattr(one, name) for one in cameras]) for name in ("position", "rotation"))
    between = positions - other.position
    baseline = np.linalg.norm(between, axis=1)
    along = between / np.where(baseline > 0, baseline, 1.0)[:, None]
    view = looks[:, 2] + other.rotation[2]
    view -= np.einsum("mi,mi->m", view, along)[:, None] * along
    length = np.linalg.norm(view, axis=1)
    towards = normals @ (view / np.where(length > 0, length, 1.0)[:, None]).T
    height = normals @ ((positions + other.position) / 2).T - np.einsum("fi,fi->f", normals, points)[:, None]
    slope = np.sqrt(np.maximum(1.0 - towards**2, 0.0))
    steep = np.divide(baseline * slope, height, out=np.full(height.shape, np.inf), where=height > 0)
    return np.where(length > 0, steep, np.inf)
