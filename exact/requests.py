"""What a request to the evaluator may be; everything else is refused before any work is done."""

import sys
from collections.abc import Sequence

import numpy as np

from exact.cameras import Camera
from exact.errors import ExactError
from exact.whole_numbers import is_whole

# Two cameras are "at least that far apart" if they fall short of it by rounding only.
SAME_LENGTH = 1e-12


def checked_threshold(threshold: int, n_cameras: int) -> int:
    """`threshold` as an int, if that many of `n_cameras` can see a point."""
    if not (is_whole(threshold) and 1 <= threshold <= n_cameras):
        raise ExactError(
            f"threshold is {threshold} with {n_cameras} cameras; it must be a whole number from 1 to the number of "
            "cameras: add cameras or lower the threshold"
        )
    return int(threshold)


def checked_workers(workers: int) -> int:
    """Number of processes as an int, at least 1."""
    if not (is_whole(workers) and workers >= 1):
        raise ExactError(f"workers is {workers}; it must be a whole number, at least 1")
    return int(workers)


def far_apart(cameras: Sequence[Camera], min_baseline: float) -> np.ndarray | None:
    """(M, M) bool: pairs of cameras at least `min_baseline` [mm] apart; None for 0, where any pair will do."""
    if not 0 <= min_baseline <= sys.float_info.max:  # written so that nan is refused
        raise ExactError(f"min_baseline is {min_baseline}; it must be finite and at least 0 [mm]")
    if min_baseline == 0:
        return None
    position = np.array([camera.position for camera in cameras]).reshape(-1, 3)
    return np.linalg.norm(position[:, None] - position[None, :], axis=2) >= min_baseline * (1 - SAME_LENGTH)


def checked_cameras(cameras: Sequence[Camera]) -> tuple[Camera, ...]:
    """At least one camera."""
    cameras = tuple(cameras)
    if not cameras:
        raise ExactError("there are no cameras; at least one is needed")
    for camera in cameras:
        if not isinstance(camera, Camera):
            raise ExactError(f"a camera is a {type(camera).__name__}; exact.Camera is needed: see Ring.cameras")
    return cameras


def checked_mask(exclude, n_faces: int) -> np.ndarray:
    """(F,) bool: `exclude`, or nothing for None."""
    if exclude is None:
        return np.zeros(n_faces, dtype=bool)
    mask = np.asarray(exclude)
    if mask.dtype != bool or mask.shape != (n_faces,):
        raise ExactError(
            f"exclude is an array of {mask.dtype} with shape {mask.shape}; it must be bool with one entry for each of "
            f"the {n_faces} faces"
        )
    return mask


def checked_weights(weights, n_faces: int) -> np.ndarray | None:
    """(F,) float: `weights`, or None."""
    if weights is None:
        return None
    values = np.asarray(weights, dtype=np.float64)
    if values.shape != (n_faces,) or not np.isfinite(values).all() or (values < 0).any():
        raise ExactError(
            f"weights has shape {values.shape}; it must be finite, not negative, one for each of the {n_faces} faces"
        )
    return values
