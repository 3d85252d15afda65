"""From the light on a sensor to the picture that it gives."""

import numpy as np

# Where the curve of sRGB begins to bend, and its slope before.
LINEAR, SLOPE = 0.0031308, 12.92


def exposed(light: np.ndarray, noise: float, seed: int) -> np.ndarray:
    """(H, W, 3) picture of 8 bits, sRGB, of the light (H, W, 3) on the sensor, 1 for white.

    Parameters
    ----------
    light : (H, W, 3) float
    noise : float
        Standard deviation of a white pixel; that of others goes with the root of their brightness.
    seed : int

    Examples
    --------
    >>> exposed(np.array([[[0.0, 0.5, 2.0]]]), 0.0, seed=0).tolist()
    [[[0, 188, 255]]]
    """
    shaken = light + noise * np.sqrt(np.maximum(light, 0.0)) * np.random.default_rng(seed).standard_normal(light.shape)
    shaken = np.clip(shaken, 0.0, 1.0)
    curved = np.where(shaken <= LINEAR, SLOPE * shaken, 1.055 * np.maximum(shaken, LINEAR) ** (1 / 2.4) - 0.055)
    return np.round(255 * curved).astype(np.uint8)
