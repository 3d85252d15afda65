"""The images of a layout's cameras as files: each is known by all that it depends on, and never rendered twice."""

import hashlib
import json
from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo

import exact
from experiments.exports.cameras import NamedCamera
from experiments.files.whole import written_whole
from experiments.simulate.render import Renderer, Stage, best_variant
from experiments.simulate.sensor import exposed
from experiments.sweeps.task import sources_digest
from meshes import fingerprint

# Where in a PNG file it says what the image is of.
KEY = "camring"
# What of the program makes an image.
SOURCES = ("render", "sensor", "texture")


class Photographer:
    """Takes the images of one stage.

    Parameters
    ----------
    stage : Stage
    sensor_noise : float
        Of a white pixel: see `sensor.exposed`.
    variant : str, optional
        Of Mitsuba; the quickest that runs here by default.
    """

    def __init__(self, stage: Stage, sensor_noise: float, variant: str | None = None):
        self._stage, self._noise, self._variant = stage, sensor_noise, variant
        self._renderer: Renderer | None = None
        self._depends = {
            "mesh": fingerprint(stage.mesh),
            "colours": None if stage.colours is None else hashlib.sha256(stage.colours.tobytes()).hexdigest(),
            "lamps": stage.lamps.tolist(),
            "focus": stage.focus.tolist(),
            "optics": [stage.optics.resolution, stage.optics.pupil, stage.optics.focus_distance],
            "grain": stage.grain,
            "rays": stage.rays,
            "seed": stage.seed,
            "noise": sensor_noise,
            "sources": [sources_digest(f"experiments.simulate.{name}", ()) for name in SOURCES],
        }

    def key(self, camera: exact.Camera) -> str:
        """SHA-256, in hexadecimal, of all that a camera's image depends on."""
        posed = [camera.position.tolist(), camera.rotation.tolist(), camera.target_distance, camera.fov.tolist()]
        return hashlib.sha256(json.dumps([self._depends, posed], sort_keys=True).encode()).hexdigest()

    def missing(self, folder: Path, cameras: Sequence[NamedCamera]) -> list[str]:
        """Names of the images that the folder does not hold yet."""
        return [one.image for one in cameras if _key_of(folder / one.image) != self.key(one.camera)]

    def take(
        self, folder: Path, cameras: Sequence[NamedCamera], report: Callable[[str], object] = lambda name: None
    ) -> list[np.ndarray]:
        """Write what is missing in the folder, and give all images, grey, (H, W) uint8 each.

        `report` is called with the name of each image that was made.
        """
        missing = self.missing(folder, cameras)
        for one in cameras:
            if one.image in missing:
                self._take(folder / one.image, one.camera)
                report(one.image)
        return [_grey(folder / one.image) for one in cameras]

    def _take(self, path: Path, camera: exact.Camera) -> None:
        if self._renderer is None:
            self._renderer = Renderer(self._stage, self._variant or best_variant())
        key = self.key(camera)
        # Each camera has noise of its own, the same wherever in a layout it stands.
        seed = int(key[:7], 16)
        said = PngInfo()
        said.add_text(KEY, key)
        picture = exposed(self._renderer.light(camera, seed), self._noise, seed)
        with written_whole(path) as temporary:
            Image.fromarray(picture).save(temporary, pnginfo=said)


def _key_of(path: Path) -> str | None:
    """What an image file says that it is of; None if it says nothing, or is none."""
    try:
        with Image.open(path) as image:
            image.load()
            return image.info.get(KEY)
    except (OSError, ValueError, SyntaxError):
        return None


def _grey(path: Path) -> np.ndarray:
    with Image.open(path) as image:
        return cv2.cvtColor(np.asarray(image.convert("RGB")), cv2.COLOR_RGB2GRAY)
