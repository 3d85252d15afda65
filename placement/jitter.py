"""Pose variants of a site, for an instrument that is never exactly where it should be."""

import numpy as np
import trimesh

import exact
from exact.whole_numbers import is_whole
from placement.errors import PlacementError
from placement.layouts.constraints import checked_seed


def jitter(
    mesh: trimesh.Trimesh,
    tilt_deg: float = 2.0,
    shift_mm: float = 1.0,
    n: int = 5,
    seed: int = 0,
    focus: tuple[float, float, float] = (0.0, 0.0, 0.0),
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0),
) -> list[trimesh.Trimesh]:
    """The site as it is and in further poses: tilted about the focus, then shifted.

    Directions of tilt are uniform around `axis`, its angle is uniform up to `tilt_deg`, and shifts are uniform in a
    ball of radius `shift_mm`.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        The site [mm].
    tilt_deg : float
        Greatest tilt [degrees], up to 90.
    shift_mm : float
        Greatest shift [mm].
    n : int
        Number of poses, the original among them.
    seed : int
        Same seed, same poses.
    focus : (3,) tuple of float
        What the ring looks at [mm].
    axis : (3,) tuple of float
        The ring's axis, of any length; no pose turns about it.

    Returns
    -------
    list of trimesh.Trimesh
        n meshes with the faces of `mesh` in the same order, without vertices that no face uses; the first is not moved.

    Raises
    ------
    PlacementError
        If a number is out of its range, or the axis is no direction.

    Examples
    --------
    >>> poses = jitter(trimesh.creation.box((10, 10, 2)), tilt_deg=3.0, shift_mm=0.5, n=4)
    >>> len(poses), [round(float(pose.volume), 9) for pose in poses]
    (4, [200.0, 200.0, 200.0, 200.0])
    """
    if not (np.isfinite(tilt_deg) and 0 <= tilt_deg <= 90):
        raise PlacementError(f"tilt_deg is {tilt_deg}; it must be from 0 to 90 [degrees]")
    if not (np.isfinite(shift_mm) and shift_mm >= 0):
        raise PlacementError(f"shift_mm is {shift_mm}; it must be finite and at least 0 [mm]")
    if not (is_whole(n) and n >= 1):
        raise PlacementError(f"number of poses is {n}; it must be a whole number, at least 1")
    try:
        frame = exact.Ring(axis=axis).frame
    except exact.ExactError as error:
        raise PlacementError(str(error)) from error
    rng = np.random.default_rng(checked_seed(seed))
    still = mesh.copy()
    still.remove_unreferenced_vertices()  # they need not be finite
    poses = [still]
    for _ in range(int(n) - 1):
        towards, tilt = rng.uniform(0, 2 * np.pi), np.radians(tilt_deg) * rng.random()
        shift = rng.normal(size=3)
        shift *= shift_mm * np.cbrt(rng.random()) / np.linalg.norm(shift)
        about = frame @ (np.cos(towards), np.sin(towards), 0.0)
        rigid = trimesh.transformations.rotation_matrix(tilt, about, point=focus)
        rigid[:3, 3] += shift
        poses.append(still.copy().apply_transform(rigid))
    return poses
