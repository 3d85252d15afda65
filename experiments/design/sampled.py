"""What a layout reconstructs of sample points: an estimate that is there before the next frame."""

import numpy as np

import exact
from experiments.design.design import Design
from placement.errors import PlacementError
from placement.samples.profiles import Visibility
from placement.samples.sampled_site import faces_towards, heights_of, in_view, noise_of
from placement.samples.sampling import SurfaceSamples, sample_surface
from placement.samples.viewed_samples import samples_met

N_SAMPLES = 6000
# Views that are kept: of the cameras at hand, and of some places they were at.
MOST_VIEWS = 64


class SampledAreas:
    """Areas of layouts by rays to sample points of a surface; of a camera that stays nothing is asked twice.

    Parameters
    ----------
    scene : exact.Scene

    Examples
    --------
    >>> import placement, trimesh
    >>> areas = SampledAreas(exact.Scene(trimesh.creation.box((10, 10, 1))))
    >>> design = Design.of(exact.Ring(), exact.Demand(), placement.Constraints(), [0.0, 3.0])
    >>> 95 < areas.area(design) < 115
    True
    """

    def __init__(self, scene: exact.Scene):
        self._scene = scene
        self._asked: tuple | None = None
        self._views: dict[float, np.ndarray] = {}

    def area(self, design: Design) -> float:
        """Estimate of the reconstructable area [mm²]."""
        demand = design.whole
        asked = design.ring, demand.limits, demand.optics
        if asked != self._asked:
            self._prepare(design)
            self._asked, self._views = asked, {}
        if len(self._samples) == 0:
            return 0.0
        new = [angle for angle in design.angles if angle not in self._views]
        if new:
            seen = self._visibility.from_angles(self._samples, design.ring, new)
            self._views |= dict(zip(new, seen, strict=True))
        theta = np.array(design.angles)
        views = np.stack([self._views[angle] for angle in design.angles])
        for angle in [angle for angle in self._views if angle not in design.angles][:-MOST_VIEWS]:
            del self._views[angle]
        noise, heights = (of(self._samples, design.ring, demand) for of in (noise_of, heights_of))
        met = samples_met(views, theta, demand, design.ring, noise, heights)
        return float(self._samples.weights[met].sum())

    def _prepare(self, design: Design) -> None:
        scene, ring = self._scene, design.ring
        ignored = ~scene.counted | ~faces_towards(scene.everything, ring)
        try:
            samples = sample_surface(scene.everything, N_SAMPLES, ignored, 0, lambda corners: in_view(corners, ring))
        except PlacementError:  # nothing that counts is turned towards it
            samples = SurfaceSamples(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0, dtype=int))
        self._visibility = Visibility(scene.everything, design.whole)
        samples = samples.subset(self._visibility.lit(samples, scene.lights))
        if scene.weights is not None:
            weights = samples.weights * scene.weights[samples.faces]
            samples = SurfaceSamples(samples.points, samples.normals, weights, samples.faces)
        self._samples = samples
