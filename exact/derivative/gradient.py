"""The exact area and its derivative by every camera, from one evaluation."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from exact.cameras import Camera
from exact.demand import Criterion
from exact.derivative.derivative import Derivative, MovingBorders, refuse_without_derivative
from exact.evaluate import of_tally
from exact.requests import ASKED, checked, checked_cameras, checked_workers, shows
from exact.results import Reconstruction
from exact.scene import Scene
from exact.visibility.coverage import tally
from exact.visibility.surface import Surface

if TYPE_CHECKING:
    import trimesh

# A camera is in the plane of a face if it is nearer to it than this part of its distance from the surface.
IN_PLANE = 1e-9


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
        What counts, and on what, as for `evaluate`; without `max_error` and `max_disparity_gradient`.

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
    moving = MovingBorders.of(scene, demand, cameras, seen)
    by_level = tuple(moving.derivative(Criterion(level)) for level in range(1, demand.threshold + 1))
    found = of_tally(scene, demand, cameras, criterion, seen)
    in_plane = np.array([_in_plane(surface, camera) for camera in cameras])
    return Gradient(**vars(moving.derivative(criterion)), reconstruction=found, by_level=by_level, in_plane=in_plane)


def _in_plane(surface: Surface, camera: Camera) -> int:
    """How many faces have the camera in their plane."""
    planes = surface.planes
    away = camera.position - planes.centre
    height = planes.normal @ away - planes.offset
    near = np.abs(height) <= IN_PLANE * (np.linalg.norm(away) + planes.scale)
    return int((near & (surface.areas > 0)).sum())
