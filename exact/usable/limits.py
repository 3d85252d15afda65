"""When a view can be used: what an image must show of a point for a matcher to find it again."""

from dataclasses import dataclass

import numpy as np

from exact.cameras import Camera
from exact.errors import ExactError
from exact.usable.optics import Optics


@dataclass(frozen=True)
class Limits:
    """What makes a view of a point usable. Without any limit, as in Wachter 2021, to be seen is enough.

    Parameters
    ----------
    min_pixel_density : float, optional
        Least number of pixels to a square millimetre of the surface, foreshortening included [px/mm²].
    max_incidence : float, optional
        Greatest angle between the line of sight and the normal of the surface, above 0 and below a right angle [rad].
    depth_of_field : (2,) tuple of float, optional
        Least and greatest depth along the optical axis [mm].
    max_blur : float, optional
        Greatest diameter of the disc as which the lens images a point [pixels]; it takes the pupil of the `Optics`.

    Raises
    ------
    ExactError
        If a value makes no sense.

    Examples
    --------
    >>> Limits(max_incidence=1.0, min_pixel_density=500.0).words
    ['at most 57.3° from its normal', 'by at least 500 px/mm²']
    """

    min_pixel_density: float | None = None
    max_incidence: float | None = None
    depth_of_field: tuple[float, float] | None = None
    max_blur: float | None = None

    def __post_init__(self):
        for name, unit in (("min_pixel_density", "px/mm²"), ("max_blur", "pixels")):
            value = getattr(self, name)
            if value is None:
                continue
            if not (isinstance(value, int | float | np.number) and 0 < value < np.inf):
                raise ExactError(f"{name} is {value!r}; it must be a number, positive and finite [{unit}]")
            object.__setattr__(self, name, float(value))
        if self.max_incidence is not None:
            angle = self.max_incidence
            if not (isinstance(angle, int | float | np.number) and 0 < angle < np.pi / 2):
                raise ExactError(f"max_incidence is {angle!r}; it must be above 0 and below pi / 2 [rad]")
            object.__setattr__(self, "max_incidence", float(angle))
        if self.depth_of_field is not None:
            try:
                near, far = (float(depth) for depth in self.depth_of_field)
            except (TypeError, ValueError, OverflowError) as error:
                raise ExactError(
                    f"depth_of_field is {self.depth_of_field!r}; it must be two depths, near and far [mm]"
                ) from error
            if not 0 <= near < far:
                raise ExactError(
                    f"depth_of_field is {(near, far)}; the first must be at least 0 and less than the second [mm]"
                )
            object.__setattr__(self, "depth_of_field", (near, far))

    @property
    def is_any(self) -> bool:
        """Whether there is any limit."""
        return self != Limits()

    @property
    def words(self) -> list[str]:
        """What a view must be, each limit as the end of "seen ..."."""
        found = []
        if self.max_incidence is not None:
            found.append(f"at most {np.degrees(self.max_incidence):.4g}° from its normal")
        if self.min_pixel_density is not None:
            found.append(f"by at least {self.min_pixel_density:.4g} px/mm²")
        if self.depth_of_field is not None:
            found.append("{:.5g} to {:.5g} mm deep".format(*self.depth_of_field))
        if self.max_blur is not None:
            found.append(f"blurred by at most {self.max_blur:.4g} px")
        return found

    def refuse_without(self, optics: Optics) -> None:
        """Refuse a limit that these optics say nothing about.

        Raises
        ------
        ExactError
        """
        if self.max_blur is not None and optics.pupil is None:
            raise ExactError(f"max_blur is {self.max_blur:g} px, and the pupil is not known; give the optics a pupil")

    def depths(self, camera: Camera, optics: Optics, height: np.ndarray) -> tuple[float, np.ndarray]:
        """Least and greatest depth [mm] of the usable part of faces whose planes a camera is `height` (F,) [mm] above.

        A face with normal n at depth z is imaged with f² h / z³ pixels to a square millimetre, where h is the height
        of the camera above its plane: so pixel density, too, is a limit on depth alone.
        """
        near, far = (0.0, np.inf) if self.depth_of_field is None else self.depth_of_field
        if self.max_blur is not None:
            nearest, farthest = optics.sharp(camera, self.max_blur)
            near, far = max(near, nearest), min(far, farthest)
        farthest = np.full(len(height), far)
        if self.min_pixel_density is not None:
            dense = np.prod(optics.focal(camera)) * np.maximum(height, 0.0) / self.min_pixel_density
            farthest = np.minimum(farthest, np.cbrt(dense))
        return near, farthest

    def met(self, points: np.ndarray, normals: np.ndarray, camera: Camera, optics: Optics) -> np.ndarray:
        """(N,) bool: whether a camera's view of points (N, 3) [mm] with unit normals (N, 3) is usable, if it is one."""
        away = camera.position - points
        depth, height = -away @ camera.rotation[2], np.einsum("ni,ni->n", away, normals)
        return self.met_at(depth, height, np.linalg.norm(away, axis=1), camera, optics)

    def met_at(
        self, depth: np.ndarray, height: np.ndarray, distance: np.ndarray, camera: Camera, optics: Optics
    ) -> np.ndarray:
        """The same for points at `depth` and `distance` from cameras like this one, at `height` over their planes."""
        near, far = self.depths(camera, optics, height)
        usable = (depth >= near) & (depth <= far)
        if self.max_incidence is not None:
            usable &= height >= np.cos(self.max_incidence) * distance
        return usable
