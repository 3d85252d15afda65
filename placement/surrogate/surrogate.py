"""What the optimiser maximises: the soft coverage of one or several sites, ready for JAX.

JAX takes a second to import, so it is only when points or a value are asked for.
"""

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

import exact
from placement.errors import PlacementError
from placement.layouts.constraints import Constraints
from placement.samples.profiles import RingProfiles

if TYPE_CHECKING:
    from jax import Array

    from placement.problem import Problem
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

        from placement.surrogate.soft_coverage import Accuracy, Baseline, Changes, Points

        profiles, demand = self._profiles, self.demand
        weights = np.zeros((profiles.n_sites, len(profiles.weights)))
        weights[profiles.site, np.arange(len(profiles.site))] = profiles.weights
        # Points without weight fill up to a round number: other sites and seeds then use what is already compiled.
        spare = ((0, 0), (0, -len(profiles.weights) % POINTS_PER_STEP))
        diameter = jnp.asarray(self._ring.diameter)
        baseline = accuracy = None
        if demand.baseline > 0:
            baseline = Baseline(diameter, jnp.asarray(demand.baseline))
        if demand.max_error is not None:
            accuracy = Accuracy(diameter, jnp.asarray(np.pad(profiles.noise / demand.max_error**2, spare[1])))
        return Points(
            Changes(jnp.asarray(np.pad(profiles.behind, spare)), jnp.asarray(np.pad(profiles.ahead, spare))),
            jnp.asarray(np.pad(weights, spare)),
            baseline,
            accuracy,
        )

    def at(self, angles, temperature: float) -> float:
        """Soft coverage of a layout of (M,) ring angles [rad] at a temperature [rad]."""
        import jax.numpy as jnp

        from placement.surrogate.soft_coverage import compiled_coverage

        return float(
            compiled_coverage(jnp.asarray(angles), self.points, jnp.asarray(temperature), self.demand.threshold)
        )


def soft_coverage(
    problem: "Problem", temperature: float = 0.03, constraints: Constraints | None = None
) -> Callable[["Array"], "Array"]:
    """What the search maximises, as a function of the ring angles that JAX can differentiate.

    Unlike the exact area it is an estimate, from the samples of the problem.

    Parameters
    ----------
    problem : Problem
        Sites, ring, and what makes a point count.
    temperature : float
        Width of the step from unseen to seen [rad], positive: the smaller, the nearer to the area and the steeper.
    constraints : Constraints, optional
        Only their baseline matters here.

    Returns
    -------
    callable
        From (M,) ring angles [rad], of any number of cameras M, to soft coverage as a fraction of the sampled ring
        maximum, a () Array. It may be given to `jax.grad`, `jax.jit`, `jax.vmap` and any minimiser of JAX.

    Raises
    ------
    PlacementError
        If the temperature is not positive.

    Examples
    --------
    >>> import jax, jax.numpy as jnp, trimesh
    >>> from placement import Problem, Settings
    >>> bar = trimesh.creation.box((60, 10, 1))
    >>> problem = Problem(bar, exact.Ring(), settings=Settings(n_samples=200, n_angles=36, ring_cameras=8))
    >>> coverage = soft_coverage(problem, temperature=0.3)
    >>> slope = jax.grad(coverage)(jnp.array([0.5, 3.6]))  # both would rather look along the bar
    >>> slope.shape, bool(jnp.isfinite(slope).all()), slope.dtype
    ((2,), True, dtype('float64'))
    """
    if not (isinstance(temperature, int | float | np.number) and 0 < temperature < np.inf):
        raise PlacementError(f"temperature is {temperature!r}; it must be positive and finite [rad]")
    import jax.numpy as jnp

    from placement.surrogate.soft_coverage import soft_coverage_of

    _, surrogate = problem.coverage(Constraints() if constraints is None else constraints)
    points, threshold = surrogate.points, surrogate.demand.threshold
    width = jnp.asarray(temperature, dtype=float)
    return lambda angles: soft_coverage_of(points, jnp.asarray(angles), width, threshold)
