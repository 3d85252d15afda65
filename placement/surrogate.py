"""What the optimiser maximises: the soft coverage of one or several sites, ready for JAX."""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from placement.profiles import RingProfiles
from placement.soft_coverage import Baseline, soft_coverage

# The number of points is rounded up to a multiple of this.
POINTS_PER_STEP = 1024


class Points(NamedTuple):
    """What soft coverage needs of the points; a pytree, so that new values do not compile again."""

    signed_distance: Float[Array, "K N"]
    weights: Float[Array, "S N"]
    baseline: Baseline | None


class Surrogate:
    """Soft coverage of the points of ring profiles, for layouts of any number of cameras.

    Parameters
    ----------
    profiles : RingProfiles
        Points that can be covered or not; others only cost time.
    threshold : int
        How many cameras must see a point.
    diameter, min_baseline : float
        Of the ring, and least chord between two of the cameras that see a point [mm].

    Examples
    --------
    >>> from placement.profiles import RingProfiles
    >>> one_point = RingProfiles.of(np.array([[1.5], [0.0], [-1.5], [0.0]]), np.ones(1))
    >>> round(Surrogate(one_point, threshold=2).at([-0.5, 0.5], temperature=1e-3), 9)
    1.0
    """

    def __init__(self, profiles: RingProfiles, threshold: int, diameter: float = 1.0, min_baseline: float = 0.0):
        self.threshold = int(threshold)
        weights = np.zeros((profiles.n_sites, len(profiles.weights)))
        weights[profiles.site, np.arange(len(profiles.site))] = profiles.weights
        # Points without weight fill up to a round number: other sites and seeds then use what is already compiled.
        spare = ((0, 0), (0, -len(profiles.weights) % POINTS_PER_STEP))
        baseline = Baseline(jnp.asarray(float(diameter)), jnp.asarray(float(min_baseline)))
        self.points = Points(
            jnp.asarray(np.pad(profiles.signed_distance, spare)),
            jnp.asarray(np.pad(weights, spare)),
            baseline if min_baseline > 0 else None,
        )

    def at(self, angles, temperature: float) -> float:
        """Soft coverage of a layout of (M,) ring angles [rad] at a temperature [rad]."""
        return float(_coverage(jnp.asarray(angles), self.points, jnp.asarray(temperature), self.threshold))


@eqx.filter_jit
def _coverage(angles, points: Points, temperature, threshold: int):
    return soft_coverage(angles, points.signed_distance, points.weights, temperature, threshold, points.baseline)
