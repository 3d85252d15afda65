"""Which faces lie side by side, and the bodies that they make."""

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components


def neighbours(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of faces that share an edge which no third face has.

    Returns
    -------
    (N, 2) and (N,) ndarray
        The two faces, and whether they are wound alike (run along the edge in opposite directions).

    Examples
    --------
    >>> pairs, alike = neighbours(np.array([[0, 1, 2], [2, 1, 3], [0, 4, 2]]))
    >>> pairs.tolist(), alike.tolist()
    ([[0, 2], [0, 1]], [False, True])
    """
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    forward = edges[:, 0] < edges[:, 1]
    low, high = np.minimum(*edges.T), np.maximum(*edges.T)
    key = low * (int(faces.max(initial=0)) + 1) + high
    order = np.argsort(key, kind="stable")
    new_edge = np.r_[True, np.diff(key[order]) != 0, True]
    starts = np.flatnonzero(new_edge)
    pairs = starts[:-1][np.diff(starts) == 2]
    first, second = order[pairs], order[pairs + 1]
    return np.stack([first // 3, second // 3], axis=1), forward[first] != forward[second]


class Bodies(NamedTuple):
    """What faces hang together by edges that no third face has."""

    pairs: np.ndarray
    """(N, 2) faces side by side."""
    alike: np.ndarray
    """(N,) bool: those wound alike."""
    body: np.ndarray
    """(F,) number of the body of each face."""
    closed: np.ndarray
    """(B,) bool: bodies all of whose faces have three such neighbours."""


def bodies(faces: np.ndarray) -> Bodies:
    """The bodies that faces (F, 3) make.

    Examples
    --------
    >>> bodies(np.array([[0, 1, 2], [2, 1, 3], [4, 5, 6]])).body.tolist()
    [0, 0, 1]
    """
    pairs, alike = neighbours(faces)
    n_bodies, body = connected(pairs, len(faces))
    is_border = np.bincount(pairs.ravel(), minlength=len(faces)) < 3
    return Bodies(pairs, alike, body, np.bincount(body, weights=is_border, minlength=n_bodies) == 0)


def connected(pairs: np.ndarray, n_faces: int) -> tuple[int, np.ndarray]:
    """How many bodies the pairs (N, 2) of faces make, and the number (F,) of the body of each face."""
    links = coo_matrix((np.ones(len(pairs), dtype=np.int8), pairs.T), shape=(n_faces, n_faces))
    return connected_components(links, directed=False)
