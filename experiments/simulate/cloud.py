"""The reconstruction: one set of points from the depth maps of all cameras, where they agree from all of them."""

from collections.abc import Sequence

import numpy as np

import exact
from experiments.simulate.depth_map import AGREE, pixel_rays


def merged(cameras: Sequence[exact.Camera], depths: Sequence[np.ndarray], weights: Sequence[np.ndarray]) -> np.ndarray:
    """(N, 3) points [mm], each the weighted mean of what the depth maps say of one place.

    A pixel of the first camera gives a point, together with the pixels of all others that show the same place at the
    same depth, to their predicted errors; what is then left of the second camera's does, and so on.

    Parameters
    ----------
    cameras : (M,) sequence of exact.Camera
        Their `resolution` is that of the depth maps.
    depths, weights : (M,) sequences of (H, W) ndarray
        Depths along the optical axes [mm], nan where there is none, and the inverse of their variances [1/mm²].

    Examples
    --------
    >>> from dataclasses import replace
    >>> cameras = [replace(one, resolution=np.array([9, 6])) for one in exact.Ring().cameras([0.0, np.pi])]
    >>> flat = [(-one.position @ np.array([0, 0, 1.0]) / pixel_rays(one)[:, 2]).reshape(6, 9) for one in cameras]
    >>> len(merged(cameras, flat, [np.ones((6, 9))] * 2))  # both look at the same 54 places
    54
    """
    left = [np.isfinite(depth) for depth in depths]
    rays = [pixel_rays(camera) for camera in cameras]
    points = []
    for i, camera in enumerate(cameras):
        pixel = np.flatnonzero(left[i])
        depth, weight = depths[i].ravel()[pixel], weights[i].ravel()[pixel]
        place = camera.position + depth[:, None] * rays[i][pixel]
        total, mean = weight.copy(), weight * depth
        for j in range(i + 1, len(cameras)):
            at, deep = _pixel_of(cameras[j], place)
            inside = np.flatnonzero(at >= 0)
            there, theirs = depths[j].ravel()[at[inside]], weights[j].ravel()[at[inside]]
            with np.errstate(invalid="ignore", divide="ignore"):
                within = AGREE * np.sqrt(1 / weight[inside] + 1 / theirs)
                agrees = left[j].ravel()[at[inside]] & (np.abs(there - deep[inside]) <= within)
            same = inside[agrees]
            total[same] += theirs[agrees]
            mean[same] += theirs[agrees] * (depth[same] + (there - deep[inside])[agrees])
            left[j].ravel()[at[same]] = False
        points.append(camera.position + (mean / total)[:, None] * rays[i][pixel])
    return np.concatenate(points)


def _pixel_of(camera: exact.Camera, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Number of the pixel that each point falls on, -1 beyond the image, and the depth of each point [mm]."""
    column, row = np.floor(camera.project(points)).T
    width, height = camera.resolution
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    number = np.where(inside, row * width + column, -1).astype(np.int64)
    return number, (points - camera.position) @ camera.rotation[2]
