"""Colours of the surface: those of tissue, from seeded noise in space, which hold at any density of pixels."""

from functools import lru_cache

import numpy as np
from scipy import ndimage

# Voxels along each side of the noise, which repeats beyond. Turned against all surfaces, it repeats along no line.
N_VOXELS = 128
# Widths of the noise's octaves [voxels], and of how many voxels the finest grains are.
OCTAVES = (0.8, 2.4, 7.2)
VOXELS_OF_A_GRAIN = 1.6
# Dark and bright tissue, as parts of the light that is reflected.
DARK, BRIGHT = np.array([0.28, 0.04, 0.04]), np.array([0.92, 0.70, 0.60])
# Standard deviations from the mean that reach from dark to bright.
CONTRAST = 4.0


@lru_cache(maxsize=1)
def tissue(seed: int) -> np.ndarray:
    """(128, 128, 128, 3) reflectances from 0 to 1, seamless where they repeat.

    Examples
    --------
    >>> found = tissue(0)
    >>> found.shape, bool(0 <= found.min() and found.max() <= 1), bool((found == tissue(0)).all())
    ((128, 128, 128, 3), True, True)
    """
    white = np.random.default_rng(seed).standard_normal((len(OCTAVES), *[N_VOXELS] * 3), dtype=np.float32)
    total = np.zeros([N_VOXELS] * 3, dtype=np.float32)
    for width, one in zip(OCTAVES, white, strict=True):
        octave = ndimage.gaussian_filter(one, width, mode="wrap")
        total += octave / octave.std()
    share = np.clip(0.5 + total / total.std() / CONTRAST, 0.0, 1.0)[..., None]
    return (DARK + share * (BRIGHT - DARK)).astype(np.float32)
