"""A layout's simulated reconstruction, from images to a comparison with the surface."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

import exact
from experiments.exports import formats
from experiments.exports.cameras import NamedCamera, named_cameras
from experiments.files.errors import InputError
from experiments.files.whole import output_folder
from experiments.request.simulation import Simulation
from experiments.simulate.cloud import merged
from experiments.simulate.compare import Comparison, Samples, compared
from experiments.simulate.depth_map import Estimate, fused, triangulated
from experiments.simulate.match import disparities
from experiments.simulate.photographs import Photographer
from experiments.simulate.rectify import Rectified
from experiments.simulate.render import Stage, refuse_oblong_pixels
from experiments.simulate.truth import TrueDepth, match_noise, true_depth

# Where the images lie, as the exports have it.
IMAGES = "images"
# How the cameras are written beside them.
CAMERAS = ("transforms", "opencv")
# The finest grains of the texture, unless given [pixels at the focus].
GRAIN = 2.0
# How long things take, beside an image.
COST_OF_PAIR, COST_OF_COMPARISON, COST_OF_CAMERA = 2.0, 3.0, 0.5


@dataclass(frozen=True, eq=False)
class Asked:
    """What is simulated.

    Attributes
    ----------
    name : str
        Of the layout, and of its folder.
    scene : exact.Scene
        The surface, what of it counts, and what hides and lights it.
    ring : exact.Ring
    angles : (M,) ndarray
        Ring angles [rad].
    demand : exact.Demand
        What is predicted, with the optics of the cameras.
    simulation : Simulation
    colours : (F, 3) ndarray or None
        Of all faces, those of obstacles too; None for tissue.
    pairs : tuple of (int, int) or None
        Those that are matched; None for all.
    seed : int
    rolls : (M,) ndarray or None
        The cameras' own [rad]; None for those of the ring.
    """

    name: str
    scene: exact.Scene
    ring: exact.Ring
    angles: np.ndarray
    demand: exact.Demand
    simulation: Simulation
    colours: np.ndarray | None = None
    pairs: tuple[tuple[int, int], ...] | None = None
    seed: int = 0
    rolls: np.ndarray | None = None

    def __post_init__(self):
        if len(self.angles) < 2:
            raise InputError(f"{len(self.angles)} camera gives no pair of images to match; at least 2 are needed")
        refuse_oblong_pixels(self.ring.cameras(self.angles[:1])[0], self.demand.optics)

    @property
    def cameras(self) -> tuple[NamedCamera, ...]:
        """The cameras, with the size of their images."""
        return named_cameras(self.ring, self.angles, self.demand.optics.resolution, self.rolls)

    @property
    def matched(self) -> tuple[tuple[int, int], ...]:
        """Pairs that are matched."""
        return tuple(combinations(range(len(self.angles)), 2)) if self.pairs is None else self.pairs

    @property
    def photographer(self) -> Photographer:
        """Who takes the images; lamps stand beside all cameras unless the scene has others."""
        lamps = np.array(self.scene.lights or self.ring.positions(self.angles), dtype=np.float64)
        focal = float(self.demand.optics.focal(self.cameras[0].camera)[0])
        pixel = self.cameras[0].camera.target_distance / focal
        grain = GRAIN * pixel if self.simulation.grain is None else self.simulation.grain
        stage = Stage(
            self.scene.everything, self.colours, lamps, np.array(self.ring.focus), self.demand.optics, grain,
            self.simulation.rays, self.seed,
        )  # fmt: skip
        return Photographer(stage, self.simulation.sensor_noise)

    def steps(self) -> dict[str, float]:
        """What there is to do, and how long it takes beside an image."""
        steps = {self.step(one.image): 1.0 for one in self.cameras}
        steps |= {self.step(one.name): COST_OF_CAMERA for one in self.cameras}
        steps |= {self.step(f"{i} and {j}"): COST_OF_PAIR for i, j in self.matched}
        return steps | {self.step("comparison"): COST_OF_COMPARISON}

    def step(self, what: str) -> str:
        """Name of a step."""
        return f"{self.name}/{what}"

    def done(self, folder: Path) -> list[str]:
        """Steps that an earlier run has left in the folder: images."""
        missing = self.photographer.missing(folder / IMAGES, self.cameras)
        return [self.step(one.image) for one in self.cameras if one.image not in missing]


@dataclass(frozen=True, eq=False)
class Simulated:
    """What came out.

    Attributes
    ----------
    asked : Asked
    depths : (M,) tuple of (H, W) ndarray
        Fused depth maps [mm].
    truths : (M,) tuple of TrueDepth
    comparison : Comparison
    noise : float
        Standard deviation of matches in each image [pixels], measured on surfaces that face the cameras.
    n_points : int
        Points of the reconstruction.
    predicted : exact.Reconstruction
        What the exact evaluator says of the same cameras.
    """

    asked: Asked
    depths: tuple[np.ndarray, ...]
    truths: tuple[TrueDepth, ...]
    comparison: Comparison
    noise: float
    n_points: int
    predicted: exact.Reconstruction

    @property
    def seen(self) -> np.ndarray:
        """(N,) samples that cameras enough see, usably or not."""
        return self.comparison.samples.n_views >= self.asked.demand.threshold

    @property
    def gradient(self) -> np.ndarray:
        """(N,) disparity gradient at each sample, of the matched pair with which it is least."""
        cameras = [one.camera for one in self.asked.cameras]
        return self.comparison.samples.gradient(self.asked.scene.surface, cameras, self.asked.matched)


def prepare(asked: Asked, folder: Path) -> None:
    """Make a folder ready for images and cameras; images that are there already may be of use.

    Raises
    ------
    InputError
        If it cannot be written to.
    """
    formats.prepare(folder, CAMERAS, force=True)
    output_folder(folder / IMAGES, (), force=True)


def simulate(asked: Asked, folder: Path, report: Callable[[str], object] = lambda step: None) -> Simulated:
    """Render, match, triangulate, fuse and compare.

    Images that the folder holds already are taken as they are.

    Parameters
    ----------
    asked : Asked
    folder : Path
        Images and cameras are written into it, and stay.
    report : callable
        Called with the name of each step of `asked.steps` that gets done.

    Raises
    ------
    InputError, exact.ExactError
    """
    samples = Samples.of(asked.scene, [one.camera for one in asked.cameras], asked.demand, asked.seed)
    predicted = exact.evaluate(asked.scene, asked.ring.cameras(asked.angles, asked.rolls), demand=asked.demand)
    prepare(asked, folder)
    formats.write(folder, CAMERAS, asked.cameras, None)
    images = asked.photographer.take(folder / IMAGES, asked.cameras, lambda name: report(asked.step(name)))
    cameras = [one.camera for one in asked.cameras]
    truths = []
    for one in asked.cameras:
        truths.append(true_depth(asked.scene.everything, one.camera))
        report(asked.step(one.name))
    estimates = _estimates(asked, cameras, images, truths, report)
    noises = [match_noise(one, truth) for of_camera, truth in zip(estimates, truths, strict=True) for one in of_camera]
    noise = float(np.nanmedian(noises)) if np.isfinite(noises).any() else float("nan")
    maps = [_fused(one, truth, asked.demand.optics.match_noise) for one, truth in zip(estimates, truths, strict=True)]
    points = merged(cameras, [depth for depth, _ in maps], [weight for _, weight in maps])
    comparison = compared(samples, asked.scene, points, asked.seed)
    report(asked.step("comparison"))
    depths = tuple(depth.astype(np.float32) for depth, _ in maps)
    return Simulated(asked, depths, tuple(truths), comparison, noise, len(points), predicted)


def _estimates(
    asked: Asked,
    cameras: Sequence[exact.Camera],
    images: Sequence[np.ndarray],
    truths: Sequence[TrueDepth],
    report: Callable[[str], object],
) -> list[list[Estimate]]:
    """What each camera's pairs say of the depths of its pixels."""
    # Whoever sets up cameras knows how far what they look at is.
    seen = [truth.depth[np.isfinite(truth.depth)] for truth in truths]
    depths = (float(min(depth.min() for depth in seen)), float(max(depth.max() for depth in seen)))
    found: list[list[Estimate]] = [[] for _ in cameras]
    for i, j in asked.matched:
        pair = Rectified.of(cameras[i], cameras[j], depths)
        of_one, of_two = disparities(pair, images[i], images[j])
        found[i].append(triangulated(pair, of_one, cameras[i], 0, j))
        found[j].append(triangulated(pair, of_two, cameras[j], 1, i))
        report(asked.step(f"{i} and {j}"))
    return found


def _fused(estimates: list[Estimate], truth: TrueDepth, match_noise: float) -> tuple[np.ndarray, np.ndarray]:
    """The fused depths of one camera and their weights; nothing of one that is in no pair."""
    if not estimates:
        return np.full(truth.depth.shape, np.nan), np.zeros(truth.depth.shape)
    return fused(estimates, match_noise)


def equidistant(asked: Asked) -> Asked:
    """The same with as many cameras, equidistant, all pairs of which are matched."""
    angles = asked.ring.equidistant(len(asked.angles))
    return replace(asked, name="equidistant", angles=angles, rolls=None, pairs=None)


def named_pairs(content: dict[str, Any], n_cameras: int) -> tuple[tuple[int, int], ...] | None:
    """Pairs of cameras that a layout file names to reconstruct from; None if it names none.

    Raises
    ------
    InputError
        If they are no pairs of its cameras.

    Examples
    --------
    >>> named_pairs({"robustness": {"accurate_pairs": [{"cameras": [1, 3]}], "pairs": []}}, 4)
    ((0, 2),)
    """
    kept = content.get("robustness")
    listed = (kept.get("accurate_pairs") or kept.get("pairs")) if isinstance(kept, dict) else None
    if not listed:
        return None
    try:
        pairs = tuple(tuple(sorted(int(number) - 1 for number in pair["cameras"])) for pair in listed)
    except (TypeError, KeyError, ValueError) as error:
        raise InputError('the "pairs" of its "robustness" must each give two "cameras"') from error
    if not all(len(pair) == 2 and 0 <= pair[0] < pair[1] < n_cameras for pair in pairs):
        raise InputError(f'the "pairs" of its "robustness" must be of two of its {n_cameras} cameras, as in [1, 2]')
    return pairs  # type: ignore[return-value]
