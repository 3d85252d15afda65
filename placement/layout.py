"""Layouts that are feasible by construction: maps from free parameters to ring angles, and back.

Every parameter vector gives a layout in which all neighbours are at least the minimum gap apart, so an
unconstrained minimiser can search over parameters. Two maps:

- *gaps*, for a ring without further demands: angles = phase + cumulative gaps, gap_i = minimum gap + softmax
  share i of what is left of the circle;
- *arcs*, where cameras are fixed or arcs are forbidden: camera i may only be in its own arc [lower_i, upper_i].
  With y_i = angle_i - i x minimum gap the cameras are feasible when the y_i do not decrease and each lies in its
  (shifted) arc, so each y_i is a sigmoid share of the way from the least to the greatest value it may take.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

# Shares that are 0 or 1 have no finite parameter; the inverse maps stop this far from them.
SMALLEST_SHARE = 1e-12


class Arcs(NamedTuple):
    """Where each of m free cameras may be, in order around the ring; made by `placement.arcs`.

    Both rows already have i x minimum gap subtracted, do not decrease, and lower <= upper.
    """

    lower: Float[Array, " m"]
    upper: Float[Array, " m"]
    """First and last shifted angle [rad]."""
    slack: Float[Array, ""]
    """How far the last shifted angle may run ahead of the first [rad]: the circle closes."""
    fixed: Float[Array, " f"]
    """Ring angles of the cameras that stay [rad]."""


def angles_from_gaps(parameters: Float[Array, " M+1"], minimum_gap: Float[Array, ""]) -> Float[Array, " M"]:
    """Ring angles [rad] from (phase, M logits of the shares).

    Parameters
    ----------
    parameters : (M + 1,) Array
        Phase [rad] and the logits of the gaps' shares; any real numbers.
    minimum_gap : () Array
        Least angle between neighbours [rad], at most 2 pi / M.

    Returns
    -------
    (M,) Array
        Increasing ring angles from the phase on.

    Examples
    --------
    >>> np.degrees(angles_from_gaps(jnp.zeros(5), jnp.asarray(0.1))).round(9).tolist()
    [0.0, 90.0, 180.0, 270.0]
    """
    n_cameras = parameters.shape[0] - 1
    slack = 2 * jnp.pi - n_cameras * minimum_gap
    gaps = minimum_gap + slack * jax.nn.softmax(parameters[1:])
    return parameters[0] + jnp.concatenate([jnp.zeros(1), jnp.cumsum(gaps[:-1])])


def gaps_from_angles(angles, minimum_gap: float) -> np.ndarray:
    """Parameters of `angles_from_gaps` that give a feasible layout; cameras come back in increasing order.

    Parameters
    ----------
    angles : (M,) array_like
        Ring angles [rad], neighbours at least `minimum_gap` apart, in any order.
    minimum_gap : float
        Least angle between neighbours [rad].

    Examples
    --------
    >>> parameters = gaps_from_angles([0.2, 3.0, 1.0], 0.1)
    >>> np.asarray(angles_from_gaps(jnp.asarray(parameters), jnp.asarray(0.1))).round(9).tolist()
    [0.2, 1.0, 3.0]
    """
    theta = np.sort(np.mod(np.asarray(angles, dtype=np.float64), 2 * np.pi))
    gaps = np.diff(theta, append=theta[0] + 2 * np.pi)
    shares = np.maximum(gaps - minimum_gap, 0.0)
    if shares.sum() <= 0:  # the circle is full: there is nothing to share
        shares = np.ones(len(theta))
    logits = np.log(np.maximum(shares / shares.sum(), SMALLEST_SHARE))
    return np.concatenate([theta[:1], logits - logits.mean()])


def angles_from_arcs(parameters: Float[Array, " m"], arcs: Arcs, minimum_gap: Float[Array, ""]) -> Float[Array, " M"]:
    """Ring angles [rad] of the m free cameras, each in its own arc, followed by the fixed ones.

    Parameters
    ----------
    parameters : (m,) Array
        Logits of the shares; any real numbers.
    arcs : Arcs
        Where each free camera may be.
    minimum_gap : () Array
        Least angle between neighbours [rad].

    Examples
    --------
    >>> arcs = Arcs(jnp.array([0.0, 0.0]), jnp.array([1.0, 2.0]), jnp.asarray(9.0), jnp.array([5.0]))
    >>> angles_from_arcs(jnp.zeros(2), arcs, jnp.asarray(0.5)).tolist()
    [0.5, 1.75, 5.0]
    """
    shifted = []
    for i in range(parameters.shape[0]):
        least, most = arcs.lower[i], arcs.upper[i]
        if shifted:
            least = jnp.maximum(least, shifted[-1])
            most = jnp.minimum(most, shifted[0] + arcs.slack)
        # most >= least but for rounding
        shifted.append(least + jnp.maximum(most - least, 0.0) * jax.nn.sigmoid(parameters[i]))
    order = jnp.arange(parameters.shape[0])
    return jnp.concatenate([jnp.stack(shifted) + order * minimum_gap, arcs.fixed])


def arcs_from_angles(angles, arcs: Arcs, minimum_gap: float) -> np.ndarray:
    """Parameters of `angles_from_arcs` that give these free cameras.

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
