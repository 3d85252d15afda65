"""When two layouts are the same."""

import numpy as np


def canonical(angles) -> np.ndarray:
    """(M,) the same layout with ring angles increasing in [0, 2 pi).

    Examples
    --------
    >>> canonical([7.0, -1.0, 2.0]).round(3).tolist()
    [0.717, 2.0, 5.283]
    """
    turned = np.mod(np.asarray(angles, dtype=np.float64), 2 * np.pi)
    turned[turned >= 2 * np.pi] = 0.0  # np.mod rounds tiny negative angles up to a full turn
    return np.sort(turned)


def distinct(layouts: list[np.ndarray], tolerance: float) -> list[int]:
    """Indices of the layouts that differ from every one before them, whatever the order of the cameras.

    Parameters
    ----------
    layouts : list of (M,) ndarray
        Ring angles [rad], best layout first.
    tolerance : float
        Two layouts are the same if no camera differs by more [rad].

    Examples
    --------
    >>> distinct([np.array([0.0, 1.0]), np.array([1.0, 6.28]), np.array([0.0, 2.0])], 0.01)
    [0, 2]
    """
    if not layouts:
        return []
    sorted_angles = np.stack([canonical(layout) for layout in layouts])
    first_is = (np.arange(sorted_angles.shape[1])[:, None] + np.arange(sorted_angles.shape[1])) % sorted_angles.shape[1]
    kept: list[int] = []
    for i, this in enumerate(sorted_angles):
        turns = this[first_is]  # (M, M): the same cameras, counted from each of them
        difference = np.abs(turns[:, None, :] - sorted_angles[kept])
        difference = np.minimum(difference, 2 * np.pi - difference).max(axis=2)
        if not (difference <= tolerance).any():
            kept.append(i)
    return kept
