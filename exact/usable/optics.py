"""What the cameras' optics are: pixels, noise of a match between two images, and what decides on sharpness."""

from dataclasses import dataclass

import numpy as np

from exact.cameras import Camera, finite_vector, length
from exact.errors import ExactError
from exact.whole_numbers import is_whole


@dataclass(frozen=True)
class Optics:
    """Pixels, matching and lens of all cameras of a layout.

    Parameters
    ----------
    resolution : (2,) tuple of int
        Pixels across the width and the height of the field of view.
    match_noise : float
        Standard deviation with which a point is found in an image, along each of its axes [pixels].
    pupil : float, optional
        Diameter of the entrance pupil [mm]; of a pinhole, by default, everything is sharp.
    focus_distance : float, optional
        Depth along the optical axis at which images are sharpest [mm]; that of the cameras' target by default.

    Raises
    ------
    ExactError
        If a value makes no sense.

    Examples
    --------
    >>> camera = Camera.look_at((0, 0, 400), target=(0, 0, 0), up=(0, 1, 0), fov=(36, 24))
    >>> Optics().focal(camera)  # 100 px/mm at the target
    array([40000., 40000.])
    >>> [round(depth, 2) for depth in Optics(pupil=4.0).sharp(camera, blur=2.0)]
    [398.01, 402.01]
    """

    resolution: tuple[int, int] = (3600, 2400)
    match_noise: float = 0.5
    pupil: float | None = None
    focus_distance: float | None = None

    def __post_init__(self):
        pixels = finite_vector("resolution", self.resolution, 2).tolist()
        if not all(is_whole(number) and number >= 1 for number in pixels):
            raise ExactError(f"resolution is {self.resolution!r}; it must be two whole numbers, at least 1 [pixels]")
        object.__setattr__(self, "resolution", (int(pixels[0]), int(pixels[1])))
        noise = self.match_noise
        if not (isinstance(noise, int | float | np.number) and 0 < noise < 1e6):
            raise ExactError(f"match_noise is {noise!r}; it must be a number, positive and below 1e6 [pixels]")
        object.__setattr__(self, "match_noise", float(noise))
        for name in ("pupil", "focus_distance"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, length(name.replace("_", " "), getattr(self, name)))

    def focal(self, camera: Camera) -> np.ndarray:
        """(2,) focal lengths of a camera [pixels], along right and down (Wachter 2021, Eq. 1 and 2)."""
        return camera.target_distance * np.array(self.resolution) / camera.fov

    def sharp(self, camera: Camera, blur: float) -> tuple[float, float]:
        """Least and greatest depth [mm] at which a point is imaged as a disc of at most `blur` [pixels].

        With the pupil's diameter D and the focus distance g, the disc of a point at depth z is, at depth g, as wide as
        D times the distance of z from g over z: z is from g / (1 + c) to g / (1 - c), where c is the blur allowed, as a
        length at depth g, over D.
        """
        if self.pupil is None:
            return 0.0, np.inf
        focus = camera.target_distance if self.focus_distance is None else self.focus_distance
        share = blur * focus / float(self.focal(camera).max()) / self.pupil
        return focus / (1 + share), focus / (1 - share) if share < 1 else np.inf
