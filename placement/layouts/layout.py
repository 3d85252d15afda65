"""Layouts that are feasible by construction: maps from free parameters to ring angles.

Every parameter vector gives a layout in which all neighbours are at least the minimum gap apart, so an
unconstrained minimiser can search over parameters. Two maps:

- *gaps*, for a ring without further demands: angles = phase + cumulative gaps, gap_i = minimum gap + softmax
  share i of what is left of the circle;
- *arcs*, where cameras are fixed or arcs are forbidden: camera i may only be in its own arc [lower_i, upper_i].
  With y_i = angle_i - i x minimum gap the cameras are feasible when the y_i do not decrease and each lies in its
  (shifted) arc, so each y_i is a sigmoid share of the way from the least to the greatest value it may take.

The way back is in `placement.layouts.layout_parameters`.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

import placement.surrogate.double_precision  # noqa: F401 - angles to 1e-9 rad
from placement.layouts.layout_parameters import Arcs


def angles_from_gaps(parameters: Float[Array, " P"], minimum_gap: Float[Array, ""] | float) -> Float[Array, " P-1"]:
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
    >>> jnp.degrees(angles_from_gaps(jnp.zeros(5), jnp.asarray(0.1))).round(9).tolist()
    [0.0, 90.0, 180.0, 270.0]
    """
    n_cameras = parameters.shape[0] - 1
    slack = 2 * jnp.pi - n_cameras * minimum_gap
    gaps = minimum_gap + slack * jax.nn.softmax(parameters[1:])
    return parameters[0] + jnp.concatenate([jnp.zeros(1), jnp.cumsum(gaps[:-1])])


def angles_from_arcs(
    parameters: Float[Array, " m"], arcs: Arcs, minimum_gap: Float[Array, ""] | float
) -> Float[Array, " M"]:
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
