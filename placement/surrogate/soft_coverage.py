"""Soft coverage: a differentiable stand-in for the reconstructable fraction, seen by the optimiser only.

A point at signed angular distance s from the next change of its visibility counts as seen with probability
sigmoid(s / temperature). The views are taken as independent events, so the probability of at least T views is
the upper tail of a Poisson-binomial distribution, built up one camera at a time. As the temperature falls to 0
this becomes the true coverage of the samples.
"""

from collections.abc import Sequence
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

import placement.surrogate.double_precision  # noqa: F401 - angles to 1e-9 rad

# Width of the soft minimum over several sites, in fractions: what differs by less counts about alike.
SOFT_MINIMUM = 0.01
# Stands for 0 where a logarithm or a quotient is taken.
NOTHING = 1e-30


class Baseline(NamedTuple):
    """Two of the views that reconstruct a point must be at least `minimum` apart."""

    diameter: Float[Array, ""]
    """Ring diameter [mm]."""
    minimum: Float[Array, ""]
    """Least chord between the two [mm]."""


class Accuracy(NamedTuple):
    """The cameras that see a point must place it accurately enough."""

    diameter: Float[Array, ""]
    """Ring diameter [mm]."""
    spread: Float[Array, " N"]
    """Least sum of their squared distances from their centre with which they do [mm²]."""


class Changes(NamedTuple):
    """Where the visibility of points changes, seen from the grid angles 2 pi k / K: as in `RingProfiles`."""

    behind: Float[Array, "K N"]
    """Angle back to the last change [rad], positive where visible and negative where not."""
    ahead: Float[Array, "K N"]
    """Angle on to the next one [rad], with the same sign."""


class Points(NamedTuple):
    """What soft coverage needs of the points; a pytree, so that new values do not compile again."""

    changes: Changes
    weights: Float[Array, "S N"]
    baseline: Baseline | None
    accuracy: Accuracy | None


def signed_distances(angles: Float[Array, " M"], changes: Changes) -> Float[Array, "M N"]:
    """Signed angular distance [rad] of each point at each ring angle to the nearest change, positive where visible.

    Its slope is 1 or -1 nearly everywhere. pi for a point visible from everywhere, -pi for one from nowhere.

    Parameters
    ----------
    angles : (M,) Array
        Ring angles [rad]; full turns change nothing.
    changes : Changes
        Of N points.

    Examples
    --------
    >>> eighth = jnp.pi / 4  # one point, seen from ring angles up to an eighth of a turn from 0
    >>> behind, ahead = jnp.array([[1.0], [-1.0], [-3.0], [-5.0]]), jnp.array([[1.0], [-5.0], [-3.0], [-1.0]])
    >>> angles = eighth * jnp.array([0.0, 0.5, 2.5, 4.0])
    >>> (signed_distances(angles, Changes(eighth * behind, eighth * ahead)).ravel() / eighth).round(9).tolist()
    [1.0, 0.5, -1.5, -3.0]
    """
    return jax.vmap(_signed_distance, (0, None))(angles, changes)


def _signed_distance(angle: Float[Array, ""], changes: Changes) -> Float[Array, " N"]:
    n_angles = changes.ahead.shape[0]
    step = 2 * jnp.pi / n_angles
    position = jnp.mod(angle / (2 * jnp.pi), 1.0) * n_angles
    before = jnp.floor(position)
    beyond = (position - before) * step
    before = before.astype(int) % n_angles
    behind, ahead, next_ahead = changes.behind[before], changes.ahead[before], changes.ahead[(before + 1) % n_angles]

    still = jax.lax.stop_gradient(beyond)
    sign = jnp.where(behind + ahead > 0, 1.0, -1.0)
    since = jnp.abs(behind) + still  # from the last change
    until = jnp.abs(ahead) - still  # to the next one, below 0 once it is passed
    after = still - step - jnp.abs(next_ahead)  # then this far from the one after it, times -1
    distance = jnp.minimum(jnp.maximum(jnp.minimum(since, until), after), jnp.pi)
    # The slope is known. Said outright, a gradient takes a quarter of the time that one through the minima takes.
    rises = (since < until) | (until < after)
    slope = jnp.where(distance < jnp.pi, jnp.where(rises, sign, -sign), 0.0)
    return sign * distance + slope * (beyond - still)


def at_least(probabilities: Sequence[Float[Array, " N"]] | Float[Array, "M N"], threshold: int) -> Float[Array, " N"]:
    """Probability that at least `threshold` of M independent events happen, in O(M threshold) per point.

    Parameters
    ----------
    probabilities : M arrays of shape (N,)
        Probability of each event, for each of N points.
    threshold : int
        1 or more. More than M gives 0.

    Examples
    --------
    >>> coins = jnp.full((3, 1), 0.5)
    >>> at_least(coins, 2).tolist()
    [0.5]
    """
    impossible = jnp.zeros_like(probabilities[0])
    # counts[t]: P(exactly t so far), the last one P(at least threshold). Arrays of their own, never stacked: cutting
    # a stack apart again makes a gradient five times slower.
    counts = [impossible + 1] + [impossible] * threshold
    for probability in probabilities:
        gained = [count * probability for count in counts[:-1]]
        stayed = [count * (1 - probability) for count in counts[:-1]] + counts[-1:]
        counts = stayed[:1] + [stay + gain for stay, gain in zip(stayed[1:], gained, strict=True)]
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


def accurate(
    angles: Float[Array, " M"],
    probabilities: Float[Array, "M N"],
    accuracy: Accuracy,
    temperature: Float[Array, ""],
) -> Float[Array, " N"]:
    """Soft probability that the cameras which see a point are spread widely enough to place it accurately.

    Views that are seen with probability p count p times in n = Σ p and m = Σ p e^{iθ}, which give the spread
    S = (d/2)² (n - |m|² / n); "widely enough" is a sigmoid of log S - log S_least,
    as wide as the temperature in radians.

    Examples
    --------
    >>> accuracy = Accuracy(jnp.asarray(30.0), jnp.array([400.0, 500.0]))  # two opposite cameras have 2 x 15² = 450
    >>> accurate(jnp.array([0.0, jnp.pi]), jnp.ones((2, 2)), accuracy, jnp.asarray(1e-3)).round(9).tolist()
    [1.0, 0.0]
    """
    n = jnp.sum(probabilities, axis=0)
    x, y = jnp.cos(angles) @ probabilities, jnp.sin(angles) @ probabilities
    spread = (accuracy.diameter / 2) ** 2 * (n - (x**2 + y**2) / jnp.maximum(n, NOTHING))
    enough = jnp.log(jnp.maximum(spread, NOTHING)) - jnp.log(jnp.maximum(accuracy.spread, NOTHING))
    return jax.nn.sigmoid(enough / temperature)


def soft_coverage(
    angles: Float[Array, " M"],
    changes: Changes,
    weights: Float[Array, "S N"],
    temperature: Float[Array, ""],
    threshold: int = 2,
    baseline: Baseline | None = None,
    accuracy: Accuracy | None = None,
) -> Float[Array, ""]:
    """Weighted sum over the points of the soft probability of being reconstructable; the least of several sums.

    Parameters
    ----------
    angles : (M,) Array
        Ring angles [rad], in any order.
    changes : Changes
        Ring profiles of N points.
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
    accuracy : Accuracy, optional
        Demand views that place a point so accurately.

    Returns
    -------
    () Array
        At least 0, but for the soft minimum, and at most the greatest sum of weights; 0 for no points.

    Examples
    --------
    >>> behind, ahead = jnp.array([[1.0], [-1.0], [-3.0], [-5.0]]), jnp.array([[1.0], [-5.0], [-3.0], [-1.0]])
    >>> seen_from_the_right = Changes(jnp.pi / 4 * behind, jnp.pi / 4 * ahead)
    >>> cold, weights = jnp.asarray(1e-3), jnp.ones((1, 1))
    >>> round(float(soft_coverage(jnp.array([-0.5, 0.5]), seen_from_the_right, weights, cold)), 9)
    1.0
    >>> round(float(soft_coverage(jnp.array([0.5, 2.5]), seen_from_the_right, weights, cold)), 9)
    0.0
    """
    probabilities = [jax.nn.sigmoid(_signed_distance(angle, changes) / temperature) for angle in angles]
    covered = at_least(probabilities, threshold)
    if baseline is not None:
        covered = covered * apart(angles, jnp.stack(probabilities), baseline, temperature)
    if accuracy is not None:
        covered = covered * accurate(angles, jnp.stack(probabilities), accuracy, temperature)
    sums = weights @ covered
    if sums.shape[0] == 1:
        return sums[0]
    return -SOFT_MINIMUM * jax.nn.logsumexp(-sums / SOFT_MINIMUM)


def soft_coverage_of(
    points: Points, angles: Float[Array, " M"], temperature: Float[Array, ""], threshold: int
) -> Float[Array, ""]:
    """`soft_coverage` of the points, with all that they must meet."""
    return soft_coverage(
        angles, points.changes, points.weights, temperature, threshold, points.baseline, points.accuracy
    )


@eqx.filter_jit
def compiled_coverage(angles, points: Points, temperature, threshold: int):
    """`soft_coverage_of` the points, compiled once for each shape of them and each threshold."""
    return soft_coverage_of(points, angles, temperature, threshold)
