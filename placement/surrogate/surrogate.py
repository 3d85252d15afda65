"""What the optimiser maximises: the soft coverage of one or several sites, ready for JAX.

JAX takes a second to import, so it is only when points or a value are asked for.
"""

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

import exact
from placement.samples.profiles import RingProfiles

if TYPE_CHECKING:
    from placement.surrogate.soft_coverage import Points

# The number of points is rounded up to a multiple of this.
POINTS_PER_STEP = 1024


class Surrogate:
    """Soft coverage of the points of ring profiles, for layouts of any number of cameras.

    Parameters
    ----------
    profiles : RingProfiles
        Points that can be covered or not; others only cost time.
    demand : exact.Demand
        What makes a point count.
    ring : exact.Ring
        Where cameras may be.

    Examples
    --------
    >>> from placement.samples.profiles import RingProfiles
    >>> one_point = RingProfiles.of(np.array([[1.5], [0.0], [-1.5], [0.0]]), np.ones(1))
    >>> round(Surrogate(one_point, exact.Demand(), exact.Ring()).at([-0.5, 0.5], temperature=1e-3), 9)
    1.0
    """

    def __init__(self, profiles: RingProfiles, demand: exact.Demand, ring: exact.Ring):
        self.demand = demand
        self._profiles, self._ring = profiles, ring

    @cached_property
    def points(self) -> "Points":
        """The points as arrays of JAX."""
        import jax.numpy as jnp

        from placement.surrogate.soft_coverage import Baseline, Changes, Points

        profiles = self._profiles
        weights = np.zeros((profiles.n_sites, len(profiles.weights)))
        weights[profiles.site, np.arange(len(profiles.site))] = profiles.weights
        # Points without weight fill up to a round number: other sites and seeds then use what is already compiled.
        spare = ((0, 0), (0, -len(profiles.weights) % POINTS_PER_STEP))
        baseline = Baseline(jnp.asarray(self._ring.diameter), jnp.asarray(self.demand.baseline))
        return Points(
            Changes(jnp.asarray(np.pad(profiles.behind, spare)), jnp.asarray(np.pad(profiles.ahead, spare))),
            jnp.asarray(np.pad(weights, spare)),
            baseline if self.demand.baseline > 0 else None,
        )

    def at(self, angles, temperature: float) -> float:
        """Soft coverage of a layout of (M,) ring angles [rad] at a temperature [rad]."""
        import jax.numpy as jnp

        from placement.surrogate.soft_coverage import compiled_coverage

        return float(
            compiled_coverage(jnp.asarray(angles), self.points, jnp.asarray(temperature), self.demand.threshold)
        )
