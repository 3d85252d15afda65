"""How the images of a simulated reconstruction are made, and which of them are matched."""

from dataclasses import dataclass
from typing import Literal

from experiments.files.errors import InputError


@dataclass(frozen=True)
class Simulation:
    """Images of a simulated reconstruction.

    Parameters
    ----------
    texture : {"tissue", "own"}
        Colours of the surface: those of tissue, from noise in space, or its own, as its file gives them.
    grain : float, optional
        Size of the finest grains of that tissue [mm]; by default two pixels at the focus.
    sensor_noise : float
        Standard deviation of a white pixel, as a part of its brightness [parts]; that of darker ones falls with the
        root of the brightness, as counts of photons do.
    rays : int
        Rays of a pixel, shared among the lamps.
    matched : {"named", "all"}
        Pairs of cameras whose images are matched: those that the layout file names, if it does, or all.

    Raises
    ------
    InputError
        If a value makes no sense.

    Examples
    --------
    >>> Simulation().texture
    'tissue'
    >>> Simulation(rays=0)
    Traceback (most recent call last):
        ...
    experiments.files.errors.InputError: rays is 0; it must be a whole number from 1 to 4096
    """

    texture: Literal["tissue", "own"] = "tissue"
    grain: float | None = None
    sensor_noise: float = 0.01
    rays: int = 8
    matched: Literal["named", "all"] = "named"

    def __post_init__(self):
        for name, words in (("texture", ("tissue", "own")), ("matched", ("named", "all"))):
            if getattr(self, name) not in words:
                raise InputError(f"{name} is {getattr(self, name)!r}; it must be {' or '.join(words)}")
        if self.grain is not None and not 0 < self.grain < float("inf"):
            raise InputError(f"grain is {self.grain!r}; it must be positive and finite [mm]")
        if not 0 <= self.sensor_noise < 1:
            raise InputError(f"sensor_noise is {self.sensor_noise!r}; it must be at least 0 and below 1")
        if not (isinstance(self.rays, int) and 1 <= self.rays <= MOST_RAYS):
            raise InputError(f"rays is {self.rays!r}; it must be a whole number from 1 to {MOST_RAYS}")


# Beyond, an image takes hours and looks no different.
MOST_RAYS = 4096
