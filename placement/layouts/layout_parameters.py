"""From layouts back to the free parameters of `placement.layouts.layout`, whose maps these invert; without JAX."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

# Shares that are 0 or 1 have no finite parameter; the inverse maps stop this far from them.
SMALLEST_SHARE = 1e-12


class Arcs(NamedTuple):
    """Where each of m free cameras may be, in order around the ring; made by `placement.layouts.arcs`.

    Both rows already have i x minimum gap subtracted, do not decrease, and lower <= upper. Where JAX computes with
    them, the arrays are its own.
    """

    lower: Float[np.ndarray, " m"]
    upper: Float[np.ndarray, " m"]
    """First and last shifted angle [rad]."""
    slack: Float[np.ndarray, ""]
    """How far the last shifted angle may run ahead of the first [rad]: the circle closes."""
    fixed: Float[np.ndarray, " f"]
    """Ring angles of the cameras that stay [rad]."""


def gaps_from_angles(angles, minimum_gap: float) -> Float[np.ndarray, " P"]:
    """Parameters of `layout.angles_from_gaps` that give a feasible layout; cameras come back in increasing order.

    Parameters
    ----------
    angles : (M,) array_like
        Ring angles [rad], neighbours at least `minimum_gap` apart, in any order.
    minimum_gap : float
        Least angle between neighbours [rad].

    Examples
    --------
    >>> import jax.numpy as jnp
    >>> from placement.layouts.layout import angles_from_gaps
    >>> parameters = gaps_from_angles([0.2, 3.0, 1.0], 0.1)
    >>> angles_from_gaps(jnp.asarray(parameters), 0.1).round(9).tolist()
    [0.2, 1.0, 3.0]
    """
    theta = np.sort(np.mod(np.asarray(angles, dtype=np.float64), 2 * np.pi))
    gaps = np.diff(theta, append=theta[0] + 2 * np.pi)
    shares = np.maximum(gaps - minimum_gap, 0.0)
    if shares.sum() <= 0:  # the circle is full: there is nothing to share
        shares = np.ones(len(theta))
    logits = np.log(np.maximum(shares / shares.sum(), SMALLEST_SHARE))
    return np.concatenate([theta[:1], logits - logits.mean()])


def arcs_from_angles(angles, arcs: Arcs, minimum_gap: float) -> Float[np.ndarray, " m"]:
    """Parameters of `layout.angles_from_arcs` that give these free cameras.

    Parameters
    ----------
    angles : (m,) array_like
        Ring angles of the free cameras [rad], increasing and each in its arc.
    arcs : Arcs
        Where each may be.
    minimum_gap : float
        Least angle between neighbours [rad].

    Examples
    --------
    >>> arcs = Arcs(np.array([0.0, 0.0]), np.array([1.0, 2.0]), np.array(9.0), np.array([5.0]))
    >>> arcs_from_angles([0.5, 1.75], arcs, 0.5).tolist()
    [0.0, 0.0]
    """
    shifted = np.asarray(angles, dtype=np.float64) - minimum_gap * np.arange(len(angles))
    shares = np.empty(len(shifted))
    for i, value in enumerate(shifted):
        least, most = float(arcs.lower[i]), float(arcs.upper[i])
        if i:
            least = max(least, shifted[i - 1])
            most = min(most, shifted[0] + float(arcs.slack))
        shares[i] = (value - least) / (most - least) if most > least else 0.5
    shares = np.clip(shares, SMALLEST_SHARE, 1 - SMALLEST_SHARE)
    return np.log(shares) - np.log1p(-shares)
