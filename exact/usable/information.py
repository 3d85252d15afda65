"""How accurately a point is triangulated: first-order propagation of the noise of matches.

With X_c = R (X - C) = (x, y, z) and focal lengths f in pixels, a camera images X at (f x / z, f y / z), whose
derivative by X is J = f [[1/z, 0, -x/z²], [0, 1/z, -y/z²]] R. Found in images to a standard deviation of s pixels, the
point has the information Λ = Σ JᵀJ / s² over the cameras that see it, the covariance Λ⁻¹, and along a unit vector u the
standard deviation √(uᵀ Λ⁻¹ u).
"""

from collections.abc import Sequence

import numpy as np

from exact.cameras import Camera
from exact.usable.optics import Optics

# Rows and columns of the six distinct numbers of a symmetric (3, 3) matrix.
ROWS, COLUMNS = np.array([0, 0, 0, 1, 1, 2]), np.array([0, 1, 2, 1, 2, 2])
# Of which axes of a camera, right, down and look, its information has products: the five numbers in its own axes.
FIRST, SECOND = np.array([0, 1, 0, 1, 2]), np.array([0, 1, 2, 2, 2])
# Below this part of the cube of its trace a determinant is rounding: the cameras do not triangulate.
SINGULAR = 1e-14


def information(points: np.ndarray, cameras: Sequence[Camera], optics: Optics) -> np.ndarray:
    """(N, M, 6) information [1/mm²] that each camera gives about points (N, 3) [mm], as xx, xy, xz, yy, yz, zz.

    A camera tells nothing about points in its plane or behind it.

    Examples
    --------
    >>> camera = Camera.look_at((0, 0, 400), target=(0, 0, 0), up=(0, 1, 0), fov=(36, 24))
    >>> information(np.zeros((1, 3)), [camera], Optics())[0, 0].tolist()  # (100 px/mm / 0.5 px)² across, none along
    [40000.0, 0.0, 0.0, 40000.0, 0.0, 0.0]
    """
    return np.stack([of_camera(points.T, camera, optics).T for camera in cameras], axis=1)


def of_camera(points: np.ndarray, camera: Camera, optics: Optics) -> np.ndarray:
    """(6, N) the same of one camera about points (3, N): JᵀJ has five numbers in its axes, and turns with R.

    By einsum, not BLAS: for matrices this thin, threads that wait for each other cost more than they bring.
    """
    x, y, depth = np.einsum("ij,jn->in", camera.rotation, points) - (camera.rotation @ camera.position)[:, None]
    inverse = np.divide(1.0, depth, out=np.zeros_like(depth), where=depth > 0)
    wide, high = (optics.focal(camera) / optics.match_noise) ** 2
    x *= inverse
    y *= inverse
    squared = inverse * inverse
    numbers = np.empty((5, len(depth)))
    numbers[0], numbers[1] = wide * squared, high * squared
    numbers[2], numbers[3] = -x * numbers[0], -y * numbers[1]
    numbers[4] = -x * numbers[2] - y * numbers[3]
    return np.einsum("in,ij->jn", numbers, _symmetric(camera.rotation[FIRST], camera.rotation[SECOND]))


def _symmetric(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """(N, 6) distinct numbers of the products of vectors (N, 3), plus the transposes of those of two different ones."""
    product = one[:, ROWS] * two[:, COLUMNS]
    turned = one[:, COLUMNS] * two[:, ROWS]
    return product + np.where((FIRST == SECOND)[:, None], 0.0, turned)


def variance(total: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """(N,) variance [mm²] of points with information (N, 6) [1/mm²] along unit vectors, (N, 3) or (3,).

    Infinite where the information does not suffice, as that of a single camera.
    """
    xx, xy, xz, yy, yz, zz = np.ascontiguousarray(total.T)
    u, v, w = np.moveaxis(direction, -1, 0)
    cofactor = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    determinant = xx * cofactor[0] + xy * cofactor[1] + xz * cofactor[2]
    form = (
        u * u * cofactor[0] + v * v * (xx * zz - xz * xz) + w * w * (xx * yy - xy * xy)
        + 2 * (u * v * cofactor[1] + u * w * cofactor[2] + v * w * (xy * xz - xx * yz))
    )  # fmt: skip
    possible = determinant > SINGULAR * (xx + yy + zz) ** 3
    return np.divide(form, determinant, out=np.full(len(total), np.inf), where=possible)


def spread(total: np.ndarray) -> np.ndarray:
    """(N,) sum of the variances [mm²] along three axes of points with information (N, 6): no direction has more."""
    return np.sum([variance(total, axis) for axis in np.eye(3)], axis=0)
