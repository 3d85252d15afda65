"""Derivatives of an area by its cameras, summed over the moving borders of what counts."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from exact.cameras import Camera
from exact.demand import Criterion, Demand
from exact.derivative.borders import Borders, borders_of
from exact.derivative.motion import EXTENT, POSITION, ROTATION, TARGET, swept
from exact.derivative.on_ring import RingDerivative, on_ring
from exact.errors import ExactError
from exact.ring import Ring
from exact.scene import Scene
from exact.visibility.coverage import Tally
from exact.visibility.pieces.pieces import Pieces


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

    def of_camera(self, number: int) -> "Derivative":
        """The same of one of the cameras alone."""
        one = slice(number, number + 1)
        return Derivative(
            self.position[one], self.rotation[one], self.half_extent[one], self.target_distance[one],
            self._cameras[one],
        )  # fmt: skip

    def on_ring(self, ring: Ring) -> RingDerivative:
        """The same by ring angle, radius and height of each camera on its ring, and by its roll.

        Raises
        ------
        ExactError
            If a camera is none of this ring.

        Examples
        --------
        >>> import trimesh
        >>> from exact import gradient
        >>> ring, box = Ring(fov=(6, 6)), trimesh.creation.box((10, 10, 1))
        >>> derivative = gradient(box, ring.cameras([0.0, 2.0])).on_ring(ring)
        >>> bool(derivative.height.sum() > 0), derivative.angle.shape  # farther off, a pixel as wide sees the same
        (True, (2,))
        """
        return on_ring(ring, self._cameras, self.position, self.rotation, self.half_extent, self.target_distance)


@dataclass(frozen=True, eq=False)
class MovingBorders:
    """The borders of the pieces that cameras see, and what each piece gains where they move.

    Attributes
    ----------
    cameras : (M,) tuple of Camera
    pieces : Pieces
    borders : Borders
    gained : (N, 9) float
        Area [mm²], weighted if weights were given, at each border per unit of its camera's parameters (`motion`).
    """

    cameras: tuple[Camera, ...]
    pieces: Pieces
    borders: Borders
    gained: np.ndarray

    @classmethod
    def of(cls, scene: Scene, demand: Demand, cameras: Sequence[Camera], seen: Tally) -> "MovingBorders":
        """Of what has been `seen`, with its cuts kept; those that are not among them do not move."""
        pieces = seen.pieces.take(np.flatnonzero(seen.pieces.seen.any(axis=1)))
        borders = borders_of(scene.surface, pieces, seen.cuts)
        gained = swept(scene.surface, cameras, borders, demand)
        if scene.weights is not None:
            gained *= scene.weights[borders.face][:, None]
        return cls(tuple(cameras), pieces, borders, gained)

    def derivative(self, criterion: Criterion) -> Derivative:
        """Of the area of what meets a criterion."""
        counts = criterion.met(self.pieces.seen, self.pieces.face)[self.borders.piece]
        camera, n_cameras = self.borders.camera[counts], len(self.cameras)
        columns = [np.bincount(camera, one, minlength=n_cameras) for one in self.gained[counts].T]
        total = np.stack(columns, axis=1).astype(np.float64)  # of nothing at all, a count is whole
        parts = total[:, POSITION], total[:, ROTATION], total[:, EXTENT], total[:, TARGET][:, 0]
        return Derivative(*parts, self.cameras)


def refuse_without_derivative(demand: Demand) -> None:
    """Refuse a demand under which the derivative of an area is not known.

    Raises
    ------
    ExactError
    """
    if not demand.has_derivative:
        bounds = {"max_error": (demand.max_error, " mm"), "max_disparity_gradient": (demand.max_disparity_gradient, "")}
        name, value, unit = next((name, *bound) for name, bound in bounds.items() if bound[0] is not None)
        raise ExactError(
            f"{name} is {value:g}{unit}; the derivative of an area is known without such a bound only: leave {name} "
            "out, and ask for a min_baseline instead"
        )
