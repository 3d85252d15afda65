"""What layouts are compared by where both their coverage and their error count."""

from collections.abc import Callable

import numpy as np

# From what (C,) layouts are worth and their errors [mm] to what is to be made great.
Value = Callable[[np.ndarray, np.ndarray], np.ndarray]

# Falling short of the least coverage by 1 % of the ring maximum weighs as much as an error e times as large.
PENALTY = 100.0
# An error above the greatest by 1 % weighs as much as 10 % of the ring maximum.
EXCESS_PENALTY = 10.0


def less_error(least: float) -> Value:
    """Of layouts worth at least that, those with less error: minus its logarithm, and a penalty for too little worth.

    Examples
    --------
    >>> value = less_error(0.9)
    >>> bool(value(np.array([0.9]), np.array([0.1])) > value(np.array([0.95]), np.array([0.2])))
    True
    """

    def value(worth: np.ndarray, error: np.ndarray) -> np.ndarray:
        with np.errstate(divide="ignore"):
            return np.asarray(-np.log(error) - PENALTY * np.maximum(least - worth, 0.0))

    return value


def more_coverage(greatest: float) -> Value:
    """Of layouts with at most that error [mm], those worth more: their worth, and a penalty for too great an error.

    Examples
    --------
    >>> value = more_coverage(0.1)
    >>> bool(value(np.array([0.9]), np.array([0.1])) > value(np.array([0.95]), np.array([0.2])))
    True
    """

    def value(worth: np.ndarray, error: np.ndarray) -> np.ndarray:
        with np.errstate(divide="ignore"):
            return np.asarray(worth - EXCESS_PENALTY * np.maximum(np.log(error) - np.log(greatest), 0.0))

    return value


def value_of_one(value: Value, worth: float, error: float) -> float:
    """What a single layout is compared by."""
    return float(value(np.array([worth]), np.array([error]))[0])
