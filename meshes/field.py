"""Signed distances from which a surgical site is modelled.

A field is a number per point, about its distance to a surface [mm]: positive in the air, negative in the tissue. The
smooth minimum of two fields is the union of their tissue with a fillet, the smooth maximum the union of their air.
Fields are only near distances; what matters is that they are continuous and of slope about one.
"""

import numpy as np

FAR = 1e3  # stands for "nowhere near" [mm]: beyond any site, so that minimum and maximum drop it


def smooth_min(a: np.ndarray, b: np.ndarray, width: float) -> np.ndarray:
    """Minimum of two fields, rounded where they differ by less than `width` [mm].

    Examples
    --------
    >>> smooth_min(np.array([0.0, 0.0]), np.array([0.0, 5.0]), 4.0).tolist()
    [-1.0, 0.0]
    """
    overlap = np.maximum(width - np.abs(a - b), 0.0)
    return np.minimum(a, b) - overlap * overlap / (4 * width)


def smooth_max(a: np.ndarray, b: np.ndarray, width: float) -> np.ndarray:
    """Maximum of two fields, rounded where they differ by less than `width` [mm]."""
    return -smooth_min(-a, -b, width)


def spline(knots: np.ndarray, samples: int) -> np.ndarray:
    """Catmull-Rom curve through `knots`, `samples` points per span.

    Parameters
    ----------
    knots : (K, D) ndarray
        At least two points, of any dimension.

    Returns
    -------
    ((K - 1) * samples + 1, D) ndarray

    Examples
    --------
    >>> spline(np.array([[0.0], [1.0], [4.0]]), 2).ravel().tolist()
    [0.0, 0.375, 1.0, 2.375, 4.0]
    """
    padded = np.vstack([2 * knots[0] - knots[1], knots, 2 * knots[-1] - knots[-2]])
    before, start, end, after = padded[:-3, None], padded[1:-2, None], padded[2:-1, None], padded[3:, None]
    t = (np.arange(samples) / samples)[None, :, None]
    curve = start + 0.5 * t * (
        end - before + t * (2 * before - 5 * start + 4 * end - after + t * (3 * (start - end) + after - before))
    )
    return np.vstack([curve.reshape(-1, knots.shape[1]), knots[-1:]])


def tube(points: np.ndarray, curve: np.ndarray, margin: float = 6.0) -> np.ndarray:
    """Distance to the skin of a swept tube of varying radius; negative inside.

    Parameters
    ----------
    points : (N, 3) ndarray
    curve : (K, 4) ndarray
        x, y, z and radius at points along the axis, joined by straight pieces.
    margin : float
        Points farther than this from the tube's bounding box are `FAR` [mm]; more than any fillet is wide.

    Returns
    -------
    (N,) ndarray

    Examples
    --------
    >>> axis = np.array([[0.0, 0, 0, 1.0], [10.0, 0, 0, 2.0]])
    >>> tube(np.array([[5.0, 0, 2.5], [0, 0, 0], [0, 0, 99]]), axis).tolist()
    [1.0, -1.0, 1000.0]
    """
    reach = curve[:, 3].max() + margin
    near = ((points > curve[:, :3].min(axis=0) - reach) & (points < curve[:, :3].max(axis=0) + reach)).all(axis=1)
    inner = points[near]
    distance = np.full(len(inner), FAR)
    for start, end in zip(curve[:-1], curve[1:], strict=True):
        axis, offset = end[:3] - start[:3], inner - start[:3]
        along = np.clip(offset @ axis / (axis @ axis), 0.0, 1.0)
        gap = offset - along[:, None] * axis
        radius = start[3] + along * (end[3] - start[3])
        distance = np.minimum(distance, np.sqrt(np.einsum("ij,ij->i", gap, gap)) - radius)
    result = np.full(len(points), FAR)
    result[near] = distance
    return result


def ellipsoid(points: np.ndarray, centre: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """(N,) about the distance of (N, 3) points to an ellipsoid along the axes; negative inside."""
    scaled = (points - centre) / radii
    level = np.sqrt((scaled * scaled).sum(axis=1))
    slope = np.sqrt(((scaled / radii) ** 2).sum(axis=1))
    # In the very centre both are zero; the distance there is the smallest radius.
    return np.where(slope > 0, level * (level - 1) / np.where(slope > 0, slope, 1.0), -radii.min())


def ripple(x: np.ndarray, y: np.ndarray, z: np.ndarray, wavelength: float, seed: int) -> np.ndarray:
    """Smooth, deterministic unevenness of mean 0 and amplitude about 1: a few plane waves in fixed directions."""
    # Raw bits: numpy promises that the stream of a bit generator never changes, but not what it makes of it.
    raw = np.random.PCG64(seed).random_raw(20).reshape(5, 4)
    waves = (raw >> np.uint64(11)) * 2.0**-53  # uniform in [0, 1)
    total = np.zeros_like(x)
    for first, second, stretch, phase in waves:
        azimuth, polar = 2 * np.pi * first, np.arccos(2 * second - 1)
        k = 2 * np.pi / (wavelength * (0.7 + 0.6 * stretch))
        direction = np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)
        total += np.sin(k * (direction[0] * x + direction[1] * y + direction[2] * z) + 2 * np.pi * phase)
    return total / np.sqrt(len(waves))
