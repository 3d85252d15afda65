"""The exact area and its derivative by every camera, from one evaluation."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from exact.cameras import Camera
from exact.demand import Criterion, Demand
from exact.derivative.borders import borders_of
from exact.derivative.motion import EXTENT, POSITION, ROTATION, TARGET, swept
from exact.derivative.on_ring import RingDerivative, on_ring
from exact.errors import ExactError
from exact.evaluate import of_tally
from exact.requests import ASKED, checked, checked_cameras, checked_workers, shows
from exact.results import Reconstruction
from exact.ring import Ring
from exact.scene import Scene
from exact.visibility.coverage import tally
from exact.visibility.surface import Surface

if TYPE_CHECKING:
    import trimesh

# A camera is in the plane of a face if it is nearer to it than this part of its distance from the surface.
IN_PLANE = 1e-9


@dataclass(frozen=True, eq=False)
class Derivative:
    """How an area changes with each of M cameras, while all others stay.

    Attributes
    ----------
    position : (M, 3) float
        By the place of the camera, which keeps its rotation and its field of view [mm²/mm].
    rotation : (M, 3) float
        By a turn of the camera, where it stands, about the world's axes x, y and z [mm²/rad].
    half_extent : (M, 2) float
        By half the width and half the height of the field of view at unit depth, `Camera.half_extent` [mm²].
    target_distance : (M,) float
        By the distance for which an image is focused, unless the optics say which: of limits on blur alone [mm²/mm].
    """

    position: np.ndarray
    rotation: np.ndarray
    half_extent: np.ndarray
    target_distance: np.ndarray
    _cameras: tuple[Camera, ...] = field(repr=False)

    def on_ring(self, ring: Ring) -> RingDerivative:
        """The same by ring angle, radius and height of each camera on its ring, and by its roll.

        Raises
        ------
        ExactError
            If a camera is none of this ring.

        Examples
        --------
        >>> import trimesh
        >>> ring, box = Ring(fov=(6, 6)), trimesh.creation.box((10, 10, 1))
        >>> derivative = gradient(box, ring.cameras([0.0, 2.0])).on_ring(ring)
        >>> bool(derivative.height.sum() > 0), derivative.angle.shape  # farther off, a pixel as wide sees the same
        (True, (2,))
        """
        return on_ring(ring, self._cameras, self.position, self.rotation, self.half_extent, self.target_distance)


@dataclass(frozen=True, eq=False)
class Gradient(Derivative):
    """An exact area and its derivative, from `exact.gradient`.

    Attributes
    ----------
    reconstruction : Reconstruction
        As of `evaluate`, to the last bit.
    by_level : tuple of Derivative
        Of the areas seen by at least 1, 2, .. `threshold` cameras, as `Reconstruction.level_areas`.
    in_plane : (M,) int
        Faces in whose plane each camera is. There the area has no derivative: on one side of the plane the camera sees
        the face, on the other it does not. What is given is that with such faces as they are.
    """

    reconstruction: Reconstruction
    by_level: tuple[Derivative, ...]
    in_plane: np.ndarray

    @property
    def area(self) -> float:
        """Reconstructable area [mm²], weighted if weights were given."""
        return self.reconstruction.area


@shows(ASKED)
def gradient(mesh: "trimesh.Trimesh | Scene", cameras: Sequence[Camera], *, workers: int = 1, **asked: Any) -> Gradient:
    """The area that `evaluate` gives, and its exact derivative by everything a camera can do.

    The surface that counts ends at its faces' sides, which do not move, and at shadows of silhouettes and borders of
    views, which move with one camera each. The derivative is the sum over these of length times velocity across: not a
    difference of two areas, and not of samples.

    It does not exist where a camera is in the plane of a face, at which the area jumps (`Gradient.in_plane` counts such
    faces). Where a shadow falls along the side of a face, or two along each other, it may differ from one side to the
    other; what is given is that of one of them. With a greatest incidence, whose circles are cut along chords, it is
    exact to some 1e-3.

    Parameters
    ----------
    mesh, cameras, workers
        As for `evaluate`.
    **asked
        What counts, and on what, as for `evaluate`; without `max_error`.

    Returns
    -------
    Gradient

    Raises
    ------
    ExactError
        If the request is not possible, or bounds the predicted error.

    Examples
    --------
    >>> import trimesh
    >>> from exact import Camera
    >>> plate = trimesh.Trimesh([[-50, -50, 0], [50, -50, 0], [50, 50, 0], [-50, 50, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> above = Camera.look_at((0, 0, 100), (0, 0, 0), up=(0, 1, 0), fov=(20, 10))
    >>> found = gradient(plate, [above], threshold=1)
    >>> round(found.area, 9), round(float(found.position[0, 2]), 9)  # 20 h/100 times 10 h/100: it grows with the height
    (200.0, 4.0)
    """
    scene, demand = checked(mesh, asked)
    cameras = checked_cameras(cameras)
    demand.refuse_fewer(len(cameras))
    refuse_without_derivative(demand)
    surface, criterion = scene.surface, demand.of(cameras, scene.surface)
    seen = tally(surface, cameras, criterion, scene.counted, checked_workers(workers), lit=scene.lit, keep_cuts=True)
    pieces = seen.pieces.take(np.flatnonzero(seen.pieces.seen.any(axis=1)))
    borders = borders_of(surface, pieces, seen.cuts)
    gained = swept(surface, cameras, borders, demand)
    if scene.weights is not None:
        gained *= scene.weights[borders.face][:, None]

    def parts(which: Criterion) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, tuple[Camera, ...]]:
        counts = which.met(pieces.seen, pieces.face)[borders.piece]
        camera = borders.camera[counts]
        columns = [np.bincount(camera, one, minlength=len(cameras)) for one in gained[counts].T]
        total = np.stack(columns, axis=1).astype(np.float64)  # of nothing at all, a count is whole
        return total[:, POSITION], total[:, ROTATION], total[:, EXTENT], total[:, TARGET][:, 0], cameras

    by_level = tuple(Derivative(*parts(Criterion(level))) for level in range(1, demand.threshold + 1))
    found = of_tally(scene, demand, cameras, criterion, seen)
    in_plane = np.array([_in_plane(surface, camera) for camera in cameras])
    return Gradient(*parts(criterion), found, by_level, in_plane)


def refuse_without_derivative(demand: Demand) -> None:
    """Refuse a demand under which the derivative of an area is not known.

    Raises
    ------
    ExactError
    """
    if demand.max_error is not None:
        raise ExactError(
            f"max_error is {demand.max_error:g} mm; the derivative of an area is known without a bound on the error "
            "only: leave max_error out, and ask for a min_baseline instead"
        )


def _in_plane(surface: Surface, camera: Camera) -> int:
    """How many faces have the camera in their plane."""
    planes = surface.planes
    away = camera.position - planes.centre
    height = planes.normal @ away - planes.offset
    near = np.abs(height) <= IN_PLANE * (np.linalg.norm(away) + planes.scale)
    return int((near & (surface.areas > 0)).sum())
