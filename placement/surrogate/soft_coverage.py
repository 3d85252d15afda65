"""Soft coverage: a differentiable stand-in for the reconstructable fraction, seen by the optimiser only.

A point at signed angular distance s from the next change of its visibility counts as seen with probability
sigmoid(s / temperature). The views are taken as independent events, so the probability of at least T views is
the upper tail of a Poisson-binomial distribution, built up one camera at a time. As the temperature falls to 0
this becomes the true coverage of the samples.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

import placement.surrogate.double_precision  # noqa: F401 - angles to 1e-9 rad

# Width of the soft minimum over several sites, in fractions: what differs by less counts about alike.
SOFT_MINIMUM = 0.01


class Baseline(NamedTuple):
    """Two of the views that reconstruct a point must be at least `minimum` apart."""

    diameter: Float[Array, ""]
    """Ring diameter [mm]."""
    minimum: Float[Array, ""]
    """Least chord between the two [mm]."""


class Points(NamedTuple):
    """What soft coverage needs of the points; a pytree, so that new values do not compile again."""

    signed_distance: Float[Array, "K N"]
    weights: Float[Array, "S N"]
    baseline: Baseline | None


def signed_distances(angles: Float[Array, " M"], signed_distance: Float[Array, "K N"]) -> Float[Array, "M N"]:
    """Signed angular distance [rad] of each point at each ring angle: periodic linear interpolation.

    Parameters
    ----------
    angles : (M,) Array
        Ring angles [rad]; full turns change nothing.
    signed_distance : (K, N) Array
        `RingProfiles.signed_distance`, on the grid 2 pi k / K.

    Examples
    --------
    >>> profile = jnp.array([[1.0], [0.0], [-1.0], [0.0]])
    >>> signed_distances(jnp.array([0.0, jnp.pi / 4]), profile).ravel().tolist()
    [1.0, 0.5]
    """
    n_angles = signed_distance.shape[0]
    position = jnp.mod(angles / (2 * jnp.pi), 1.0) * n_angles
    left = jnp.floor(position)
    share = (position - left)[:, None]
    left = left.astype(int) % n_angles
    return (1 - share) * signed_distance[left] + share * signed_distance[(left + 1) % n_angles]


def at_least(probabilities: Float[Array, "M N"], threshold: int) -> Float[Array, " N"]:
    """Probability that at least `threshold` of M independent events happen, in O(M threshold) per point.

    Parameters
    ----------
    probabilities : (M, N) Array
        Probability of each event, for each of N points.
    threshold : int
        1 or more. More than M gives 0.

    Examples
    --------
    >>> coins = jnp.full((3, 1), 0.5)
    >>> at_least(coins, 2).tolist()
    [0.5]
    """
    n_points = probabilities.shape[1]
    none_yet = jnp.zeros((threshold + 1, n_points)).at[0].set(1.0)

    def add(counts, probability):  # counts[t]: P(exactly t so far), the last one P(at least threshold)
        gained = counts[:-1] * probability
        stayed = jnp.concatenate([counts[:-1] * (1 - probability), counts[-1:]])
        return stayed.at[1:].add(gained), None

    counts, _ = jax.lax.scan(add, none_yet, probabilities, unroll=True)
    return counts[-1]


def apart(
    angles: Float[Array, " M"],
    probabilities: Float[Array, "M N"],
    baseline: Baseline,
    temperature: Float[Array, ""],
) -> Float[Array, " N"]:
    """Soft probability that two cameras that see a point are at least the minimum baseline apart.

    The pairs are taken as independent, and "apart" is a sigmoid of the chord of width temperature x d/2; both
    become exact as the temperature falls.
    """
    first, second = jnp.triu_indices(angles.shape[0], k=1)
    chord = baseline.diameter * jnp.abs(jnp.sin((angles[first] - angles[second]) / 2))
    width = temperature * baseline.diameter / 2
    far = jax.nn.sigmoid((chord - baseline.minimum) / width)
    pair = probabilities[first] * probabilities[second] * far[:, None]
    return 1 - jnp.prod(1 - pair, axis=0)


def soft_coverage(
    angles: Float[Array, " M"],
    signed_distance: Float[Array, "K N"],
    weights: Float[Array, "S N"],
    temperature: Float[Array, ""],
    threshold: int = 2,
    baseline: Baseline | None = None,
) -> Float[Array, ""]:
    """Weighted sum over the points of the soft probability of being reconstructable; the least of several sums.

    Parameters
    ----------
    angles : (M,) Array
        Ring angles [rad], in any order.
    signed_distance : (K, N) Array
        Ring profiles [rad].
    weights : (S, N) Array
        What each point counts in each of S sums. With shares of the ring maximum the result is a fraction of it. Of
        several sums the soft minimum is taken, which is below the least by at most SOFT_MINIMUM x log S.
    temperature : () Array
        Width of the step from unseen to seen [rad], positive. An array, not a Python float: a jitted caller
        would compile again for each value of the latter.
    threshold : int
        How many cameras must see a point.
    baseline : Baseline, optional
        Demand two views at least this far apart.

    Returns
    -------
    () Array
        At least 0, but for the soft minimum, and at most the greatest sum of weights; 0 for no points.

    Examples
    --------
    >>> seen_from_the_right = jnp.array([[1.5], [0.0], [-1.5], [0.0]])
    >>> cold, weights = jnp.asarray(1e-3), jnp.ones((1, 1))
    >>> round(float(soft_coverage(jnp.array([-0.5, 0.5]), seen_from_the_right, weights, cold)), 9)
    1.0
    >>> round(float(soft_coverage(jnp.array([0.5, 2.5]), seen_from_the_right, weights, cold)), 9)
    0.0
    """
    probabilities = jax.nn.sigmoid(signed_distances(angles, signed_distance) / temperature)
    covered = at_least(probabilities, threshold)
    if baseline is not None:
        covered = covered * apart(angles, probabilities, baseline, temperature)
    sums = weights @ covered
    if sums.shape[0] == 1:
        return sums[0]
    return -SOFT_MINIMUM * jax.nn.logsumexp(-sums / SOFT_MINIMUM)


@eqx.filter_jit
def compiled_coverage(angles, points: Points, temperature, threshold: int):
    """`soft_coverage` of the points, compiled once for each shape of them and each threshold."""
    return soft_coverage(angles, points.signed_distance, points.weights, temperature, threshold, points.baseline)
