"""Where on a surface given cameras reconstruct points to a given error."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import KDTree

from exact.cameras import Camera
from exact.usable.information import information, of_camera, spread, variance
from exact.usable.optics import Optics
from exact.visibility.surface import Surface

# Within a distance r of a point at depth z an error changes by less than this times r / z of the greatest error of any
# direction: depth and the angles between rays change by r / z, and the directions of the rays by as many radians.
CHANGE = 10.0
# Of so few cameras information is found as quickly anew as it is kept.
FEW = 16
# Pairs of a face and a camera whose information is kept: 100 MB.
MOST_KEPT = 2_000_000
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

    def totals(self, points: np.ndarray, seen: np.ndarray) -> np.ndarray:
        """(N, 6) information [1/mm²] about points (N, 3) [mm] from the cameras that see them, (N, M) bool."""
        columns, total = np.ascontiguousarray(points.T), np.zeros((6, len(points)))
        for i in np.flatnonzero(seen.any(axis=0)):
            camera = self.cameras[i]
            chosen = np.flatnonzero(seen[:, i])
            if 2 * len(chosen) > len(points):  # to pick most of them out takes longer than to compute all
                total += of_camera(columns, camera, self.optics) * seen[:, i]
            else:
                total[:, chosen] += of_camera(columns[:, chosen], camera, self.optics)
        return total.T

    def errors(self, error: str, face: np.ndarray, inner: np.ndarray, seen: np.ndarray) -> np.ndarray:
        """(N,) standard deviation [mm] at points given by face and face coordinates (N, 2), seen by `seen` (N, M)."""
        return self.deviations(error, face, self.totals(self.surface.points(face, inner), seen))

    def deviations(self, error: str, face: np.ndarray, total: np.ndarray) -> np.ndarray:
        """(N,) standard deviation [mm] of points on the faces (N,) about which this (N, 6) is known."""
        along = self.surface.normals[face] if error == "normal" else self.axis
        return np.sqrt(np.maximum(variance(total, along), 0.0))


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
    _kept: dict = field(default_factory=dict, repr=False)

    @cached_property
    def _faces(self) -> tuple[np.ndarray, np.ndarray]:
        """`sizes` of all faces."""
        surface = self.predictor.surface
        return sizes(self.predictor.cameras, surface.vertices[surface.faces])

    def excess(self, face: np.ndarray, inner: np.ndarray, seen: np.ndarray) -> np.ndarray:
        """(N,) by how much an error is greater than the greatest allowed, relatively; at most 1e6."""
        found = self.predictor.errors(self.error, face, inner, seen)
        return np.minimum(found / self.largest - 1, 1e6)

    def holds_all_over(self, face: np.ndarray, seen: np.ndarray) -> np.ndarray:
        """(N,) bool: the whole of each face (N,) surely keeps it, seen by the cameras `seen` (N, M)."""
        at_centre, change = self._over(face, seen)
        return at_centre + change <= self.largest

    def fails_all_over(self, face: np.ndarray, seen: np.ndarray) -> np.ndarray:
        """(N,) bool: no point of each face (N,) keeps it, seen by no more than the cameras `seen` (N, M)."""
        at_centre, change = self._over(face, seen)
        return at_centre - change > self.largest

    def _over(self, face: np.ndarray, seen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(N,) error at the centre of each face, and by how much others on it may differ; inf if that is not known."""
        predictor = self.predictor
        centre, share = (of_faces[face] for of_faces in self._faces)
        known = self._known(face)
        if known is None:
            total = predictor.totals(centre, seen)
        else:
            row, camera = np.nonzero(seen)
            faces, of_cameras = known
            which = np.searchsorted(faces, face)[row] * len(predictor.cameras) + camera
            begins = np.searchsorted(row, np.arange(len(face) + 1))
            chosen = csr_array((np.ones(len(row)), which, begins), shape=(len(face), len(of_cameras)))
            total = chosen @ of_cameras
        at_centre = predictor.deviations(self.error, face, total)
        with np.errstate(invalid="ignore"):
            change = CHANGE * share * np.sqrt(np.maximum(spread(total), 0.0))
        return np.where(np.isfinite(at_centre), at_centre, 0.0), np.where(share < SMALL, change, np.inf)

    def _known(self, face: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Faces with these among them, ascending, and what each camera tells about their centres, (F * M, 6).

        None if that were too much to keep, or not worth it. Of many cameras it is kept, since the same faces are asked
        about again and again.
        """
        surface, cameras = self.predictor.surface, self.predictor.cameras
        if len(cameras) <= FEW:
            return None
        faces, told = self._kept.get("told", (np.zeros(0, dtype=int), np.zeros((0, len(cameras), 6))))
        new = np.setdiff1d(face, faces)
        if len(new) * len(cameras) > MOST_KEPT:
            return None
        if (len(faces) + len(new)) * len(cameras) > MOST_KEPT:
            faces, told = faces[:0], told[:0]
            new = np.unique(face)
        if len(new):
            points = surface.vertices[surface.faces[new]].mean(axis=1)
            order = np.argsort(np.concatenate([faces, new]), kind="stable")
            faces = np.concatenate([faces, new])[order]
            told = np.concatenate([told, information(points, cameras, self.predictor.optics)])[order]
            self._kept["told"] = faces, told
        return faces, told.reshape(-1, 6)


def sizes(cameras: Sequence[Camera], corner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(N, 3) centres of triangles (N, 3, 3) [mm], and (N,) how far they reach from there beside the nearest camera."""
    centre = corner.mean(axis=1)
    radius = np.linalg.norm(corner - centre[:, None], axis=2).max(axis=1)
    return centre, radius / distance_from(cameras, centre)


def distance_from(cameras: Sequence[Camera], points: np.ndarray) -> np.ndarray:
    """(N,) distance of points (N, 3) from the nearest of the cameras [mm]."""
    return np.asarray(KDTree([camera.position for camera in cameras]).query(points)[0])
