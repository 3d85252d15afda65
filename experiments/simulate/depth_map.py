"""Depth maps: depth along the rays of a camera's pixels, triangulated from pairs and fused by what they predict."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

import exact
from experiments.simulate.rectify import Rectified

# Disparities of the four pixels around a ray that differ by more lie on two surfaces [pixels].
SAME_SURFACE = 1.0
# Estimates of a depth agree if they differ by at most so many of their standard deviations.
AGREE = 3.0


@dataclass(frozen=True, eq=False)
class Estimate:
    """Depths [mm] of a camera's pixels from one pair, nan where there is none, and the other camera of the pair.

    `noise` is the standard deviation of a depth of 1 mm by a match with a noise of one pixel in each image: of others
    it grows with the square of the depth.
    """

    depth: np.ndarray
    other: int
    noise: float


def pixel_centres(camera: exact.Camera) -> np.ndarray:
    """(H W, 2) centres of a camera's pixels, row by row, counted from the upper left corner of the image."""
    width, height = camera.resolution.astype(int)
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    return np.stack([x.ravel(), y.ravel()], axis=1)


def pixel_rays(camera: exact.Camera) -> np.ndarray:
    """(H W, 3) rays of a camera's pixels in the world, one millimetre deep."""
    centres, matrix = pixel_centres(camera), camera.intrinsic
    local = (centres - matrix[:2, 2]) / matrix[[0, 1], [0, 1]]
    return local @ camera.rotation[:2] + camera.rotation[2]


def triangulated(pair: Rectified, disparity: np.ndarray, camera: exact.Camera, which: int, other: int) -> Estimate:
    """Depths of the pixels of the first or second camera of a pair (`which`: 0 or 1), by its turned disparities."""
    width, height = camera.resolution.astype(int)
    at = pair.at(pixel_centres(camera) - 0.5, which).astype(np.float32).reshape(height, width, 2)
    known = ~np.isnan(disparity)
    around = [
        cv2.remap(one, at[..., 0], at[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=0.0)
        for one in (np.where(known, disparity, 0.0), known.astype(np.float32), _step(disparity))
    ]
    found = np.where((around[1] > 1 - 1e-4) & (around[2] <= SAME_SURFACE), around[0], np.nan)
    # A point one millimetre deep for the camera is so deep along the direction that the pair shares.
    share = (pixel_rays(camera) @ pair.rotation[2]).reshape(height, width)
    with np.errstate(invalid="ignore"):
        depth = pair.depth(found) / share
    return Estimate(depth.astype(np.float32), other, float(np.sqrt(2.0) / (pair.focal * pair.baseline)))


def _step(disparity: np.ndarray) -> np.ndarray:
    """The greatest change of disparity from a pixel to the next ones right and below."""
    filled = np.nan_to_num(disparity)
    right, below = (
        np.abs(np.diff(filled, axis=1, append=filled[:, -1:])),
        np.abs(np.diff(filled, axis=0, append=filled[-1:])),
    )
    return np.maximum(right, below)


def fused(estimates: Sequence[Estimate], match_noise: float) -> tuple[np.ndarray, np.ndarray]:
    """Depths (H, W) [mm] from all pairs of one camera, weighted by their predicted variances, and the sums of weights.

    A pixel's estimates that disagree with their weighted median are left out.

    Examples
    --------
    >>> near, far = (Estimate(np.full((1, 1), depth), 1, 1e-5) for depth in (400.0, 500.0))
    >>> depth, weight = fused([near, near, far], match_noise=0.5)
    >>> round(float(depth[0, 0]), 3), round(float(weight[0, 0]) * 0.8**2 / 2, 3)  # two of 0.8 mm
    (400.0, 1.0)
    """
    depths = np.stack([one.depth for one in estimates])
    noise = np.array([one.noise for one in estimates])[:, None, None] * match_noise
    known = ~np.isnan(depths)
    filled = np.where(known, depths, np.inf)
    weight = np.where(known, 1 / noise**2, 0.0)
    order = np.argsort(filled, axis=0)
    ordered = np.cumsum(np.take_along_axis(weight, order, axis=0), axis=0)
    middle = (ordered < 0.5 * ordered[-1]).sum(axis=0)
    middle = np.minimum(middle, len(depths) - 1)[None]
    median = np.take_along_axis(np.take_along_axis(filled, order, axis=0), middle, axis=0)[0]
    with np.errstate(invalid="ignore"):
        deviation = noise * median**2
        own = np.where(np.isfinite(deviation), deviation, 0.0)
        weight = np.where(known & (np.abs(filled - median) <= AGREE * own), weight, 0.0)
    total = weight.sum(axis=0)
    depth = np.divide(
        (weight * np.where(known, depths, 0.0)).sum(axis=0), total, out=np.full(total.shape, np.nan), where=total > 0
    )
    with np.errstate(invalid="ignore"):
        return depth, np.where(total > 0, total / depth**4, 0.0)
