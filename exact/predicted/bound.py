"""Where on a surface given cameras reconstruct points to a given error."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exact.cameras import Camera
from exact.usable.information import information, spread, variance
from exact.usable.optics import Optics
from exact.visibility.surface import Surface

# Within a distance r of a point at depth z an error changes by less than this times r / z of the greatest error of any
# direction: depth and the angles between rays change by r / z, and the directions of the rays by as many radians.
CHANGE = 10.0
# Beyond this r / z that is not relied on.
SMALL = 0.02


@dataclass(frozen=True, eq=False)
class Predictor:
    """Predicted errors on a surface, by which cameras see a point.

    Attributes
    ----------
    surface : Surface
    cameras : tuple of Camera
    optics : Optics
    axis : (3,) float
        Unit vector along which depth is measured.
    """

    surface: Surface
    cameras: tuple[Camera, ...]
    optics: Optics
    axis: np.ndarray

    def directions(self, error: str, face: np.ndarray) -> np.ndarray:
        """(N, 3) unit vectors along which errors on the faces (N,) are measured: "depth" or "normal"."""
        return self.surface.normals[face] if error == "normal" else np.broadcast_to(self.axis, (len(face), 3))

    def totals(self, points: np.ndarray, seen: np.ndarray) -> np.ndarray:
        """(N, 6) information [1/mm²] about points (N, 3) [mm] from the cameras that see them, (N, M) bool."""
        total = np.zeros((len(points), 6))
        for i, camera in enumerate(self.cameras):
            chosen = np.flatnonzero(seen[:, i])
            total[chosen] += information(points[chosen], [camera], self.optics)[:, 0]
        return total

    def errors(self, error: str, face: np.ndarray, inner: np.ndarray, seen: np.ndarray) -> np.ndarray:
        """(N,) standard deviation [mm] at points given by face and face coordinates (N, 2), seen by `seen` (N, M)."""
        total = self.totals(self.surface.points(face, inner), seen)
        return np.sqrt(np.maximum(variance(total, self.directions(error, face)), 0.0))


@dataclass(frozen=True, eq=False)
class ErrorBound:
    """The error that a point may have to count.

    Attributes
    ----------
    predictor : Predictor
    largest : float
        Greatest error [mm].
    error : {"depth", "normal"}
        Along what it is measured.
    """

    predictor: Predictor
    largest: float
    error: str

    def excess(self, face: np.ndarray, inner: np.ndarray, seen: np.ndarray) -> np.ndarray:
        """(N,) by how much an error is greater than the greatest allowed, relatively; at most 1e6."""
        found = self.predictor.errors(self.error, face, inner, seen)
        return np.minimum(found / self.largest - 1, 1e6)

    def holds_all_over(self, face: np.ndarray, seen: np.ndarray) -> np.ndarray:
        """(N,) bool: the whole of each face (N,) surely keeps it, seen by the cameras `seen` (N, M)."""
        surface = self.predictor.surface
        centre, radius = _circles(surface, face)
        total = self.predictor.totals(centre, seen)
        at_centre = np.sqrt(np.maximum(variance(total, self.predictor.directions(self.error, face)), 0.0))
        share = radius / nearest(self.predictor.cameras, centre)
        with np.errstate(invalid="ignore"):
            most = at_centre + CHANGE * share * np.sqrt(np.maximum(spread(total), 0.0))
        return (share < SMALL) & (most <= self.largest)


def nearest(cameras: Sequence[Camera], points: np.ndarray) -> np.ndarray:
    """(N,) least distance [mm] between points (N, 3) and one of the cameras."""
    return np.min([np.linalg.norm(points - camera.position, axis=1) for camera in cameras], axis=0)


def _circles(surface: Surface, face: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(N, 3) centres of faces and (N,) how far their corners are away [mm]."""
    corner = surface.vertices[surface.faces[face]]
    centre = corner.mean(axis=1)
    return centre, np.linalg.norm(corner - centre[:, None], axis=2).max(axis=1)
