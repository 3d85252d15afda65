"""Dense matches of two images: semi-global matching in both directions, what agrees, to a part of a pixel."""

import cv2
import numpy as np

from experiments.simulate.rectify import Rectified

# Sides of the blocks that are compared [pixels].
BLOCK = 5
# What a change of disparity between neighbours costs: by one, and by more, for each pixel of a block.
CHANGE_BY_ONE, CHANGE_BY_MORE = 4, 32
# Contrast beyond which more makes no difference to the matcher, its greatest.
MOST_CONTRAST = 63
# By how much of its cost a match must beat the next best [percent], and specks of so few pixels are dropped.
UNIQUE, SPECK, SPECK_RANGE = 5, 60, 2
# Matches in both directions must agree to this [pixels].
AGREE = 1.0
# The finest part of a pixel that the matcher tells.
PARTS = 16.0
# Steps of least squares below that part, the width of their window and the most that each may change [pixels].
STEPS, WINDOW, MOST_CHANGE = 3, 9, 0.5
# Images with less contrast than this in a window tell nothing [grey levels, squared gradient].
LEAST_CONTRAST = 1.0


def disparities(pair: Rectified, one: np.ndarray, two: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Disparities of the turned images of a pair, each seen from its own; nan where there is no match.

    Parameters
    ----------
    pair : Rectified
    one, two : (H, W) uint8
        The images of both cameras, grey.

    Returns
    -------
    two of (h, w) float32
        The point at (x, y) of the first turned image lies at (x - d, y) of the second, with d of the first array; at
        (x + d, y) the other way about, with d of the second.
    """
    left, right = pair.turned(one, 0), pair.turned(two, 1)
    matcher = cv2.StereoSGBM.create(
        minDisparity=0, numDisparities=pair.n_disparities, blockSize=BLOCK, P1=CHANGE_BY_ONE * BLOCK**2,
        P2=CHANGE_BY_MORE * BLOCK**2, disp12MaxDiff=-1, preFilterCap=MOST_CONTRAST, uniquenessRatio=UNIQUE,
        speckleWindowSize=SPECK, speckleRange=SPECK_RANGE, mode=cv2.STEREO_SGBM_MODE_SGBM,
    )  # fmt: skip
    of_left = _found(matcher.compute(left, right), pair.inside(one.shape, 0, WINDOW))
    mirrored = _mirrored(matcher.compute(_mirrored(right), _mirrored(left)))
    of_right = _found(mirrored, pair.inside(two.shape, 1, WINDOW))
    agreed_left, agreed_right = _agreed(of_left, of_right, -1.0), _agreed(of_right, of_left, 1.0)
    return refined(left, right, agreed_left, -1.0), refined(right, left, agreed_right, 1.0)


def _found(scaled: np.ndarray, inside: np.ndarray) -> np.ndarray:
    return np.where((scaled < 0) | ~inside, np.nan, scaled / PARTS).astype(np.float32)


def _mirrored(image: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(image[:, ::-1])


def _agreed(disparity: np.ndarray, other: np.ndarray, sign: float) -> np.ndarray:
    """The disparities with which those of the other image agree; nan for the rest."""
    there = _sampled(other, disparity, sign, cv2.INTER_NEAREST)
    with np.errstate(invalid="ignore"):
        return np.where(np.abs(there - disparity) <= AGREE, disparity, np.nan).astype(np.float32)


def _sampled(image: np.ndarray, disparity: np.ndarray, sign: float, how: int) -> np.ndarray:
    """The image at (x + sign d, y); nan beyond its border."""
    x, y = np.meshgrid(np.arange(disparity.shape[1], dtype=np.float32), np.arange(disparity.shape[0], dtype=np.float32))
    at = np.where(np.isnan(disparity), -1e6, x + sign * disparity).astype(np.float32)
    return cv2.remap(image, at, y, how, borderMode=cv2.BORDER_CONSTANT, borderValue=float("nan"))


def refined(image: np.ndarray, other: np.ndarray, disparity: np.ndarray, sign: float) -> np.ndarray:
    """The disparities after some steps of least squares in windows, each along the gradient of the other image.

    Both images are exposed alike: a point is as bright in one as in the other.

    Examples
    --------
    >>> x = np.arange(60, dtype=np.float32)
    >>> image, other = (np.tile(100 + 50 * np.sin((x + shift) / 3), (20, 1)) for shift in (0.0, 2.3))
    >>> found = refined(image, other, np.full((20, 60), 2.0, dtype=np.float32), -1.0)
    >>> round(float(found[10, 30]), 1)
    2.3
    """
    image, other = image.astype(np.float32), other.astype(np.float32)
    slope = cv2.Sobel(other, cv2.CV_32F, 1, 0, ksize=1) / 2
    known = ~np.isnan(disparity)
    for _ in range(STEPS):
        there, along = (np.nan_to_num(_sampled(one, disparity, sign, cv2.INTER_CUBIC)) for one in (other, slope))
        difference, along = np.where(known, image - there, 0.0), np.where(known, sign * along, 0.0)
        steepness, push = _mean(along * along), _mean(along * difference)
        change = np.divide(push, steepness, out=np.zeros_like(push), where=steepness > LEAST_CONTRAST)
        disparity = disparity + np.clip(change, -MOST_CHANGE, MOST_CHANGE)
    return disparity


def _mean(values: np.ndarray) -> np.ndarray:
    return cv2.boxFilter(np.ascontiguousarray(values, dtype=np.float32), -1, (WINDOW, WINDOW))
