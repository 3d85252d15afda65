"""Many starts at once: minimise 1 - soft coverage with BFGS while the temperature falls in stages."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jaxtyping import Bool, Float, Int

from placement.layouts.layout import angles_from_arcs, angles_from_gaps
from placement.layouts.layout_parameters import Arcs
from placement.surrogate.soft_coverage import soft_coverage_of
from placement.surrogate.surrogate import Surrogate

# BFGS stops when a step changes parameters [rad or logits] and coverage by less than this, relatively plus
# absolutely: far below what the samples resolve.
STEP_TOLERANCE = 1e-4
COVERAGE_TOLERANCE = 1e-7
# A start whose layout turned by less [rad] than this stood on a flat stretch and was not searched at all.
FLAT_TOLERANCE = 1e-6


class DescentEnd(NamedTuple):
    """Where S starts ended."""

    angles: Float[np.ndarray, "S M"]
    """Ring angles [rad]; the start itself where the search failed."""
    steps: Int[np.ndarray, " S"]
    """BFGS steps over all stages."""
    failed: Bool[np.ndarray, " S"]
    """A value or an angle that is not finite."""
    flat: Bool[np.ndarray, " S"]
    """Did not move."""


def descend(
    parameters: Float[np.ndarray, "S P"],
    arcs: Arcs | None,
    surrogate: Surrogate,
    *,
    minimum_gap: float,
    temperatures: tuple[float, ...],
    max_steps: int,
) -> DescentEnd:
    """Run BFGS from every start at once through all temperatures.

    Parameters
    ----------
    parameters : (S, P) ndarray
        Starts, as `layout_parameters.gaps_from_angles` or, with `arcs`, `arcs_from_angles` give them.
    arcs : Arcs or None
        Arcs of each start, stacked along a first axis of length S; None for the map by gaps.
    surrogate : Surrogate
        What is maximised.
    minimum_gap : float
        Least angle between neighbours [rad].
    temperatures : tuple of float
        Falling widths of the soft step [rad]; the end of one stage starts the next.
    max_steps : int
        BFGS steps per stage at most.

    Returns
    -------
    DescentEnd
        A failed start comes back as it was, marked.
    """
    arcs = jax.tree.map(jnp.asarray, arcs)
    start = jnp.asarray(parameters)
    gap = jnp.asarray(minimum_gap)
    ends = _descend(
        start, arcs, gap, surrogate.points, jnp.asarray(temperatures), surrogate.demand.threshold, int(max_steps)
    )
    first, last, steps, failed = (np.asarray(value) for value in ends)
    moved = np.abs(np.angle(np.exp(1j * (last - first)))).max(axis=1)
    return DescentEnd(last, steps, failed, (moved < FLAT_TOLERANCE) & ~failed)


@eqx.filter_jit
def _descend(parameters, arcs, gap, points, temperatures, threshold, max_steps):
    """Stages outside, starts inside: one BFGS is compiled, whatever their numbers."""
    solver = optx.BFGS(rtol=COVERAGE_TOLERANCE, atol=STEP_TOLERANCE)

    def angles_of(parameters, arcs):
        if arcs is None:
            return angles_from_gaps(parameters, gap)
        return angles_from_arcs(parameters, arcs, gap)

    def loss(parameters, args):
        arcs, temperature = args
        return 1 - soft_coverage_of(points, angles_of(parameters, arcs), temperature, threshold)

    def one_start(parameters, arcs, temperature):
        # throw=False: one bad start must not end the others.
        end = optx.minimise(loss, solver, parameters, (arcs, temperature), max_steps=max_steps, throw=False)
        usable = jnp.isfinite(end.value).all()
        return jnp.where(usable, end.value, parameters), end.stats["num_steps"], ~usable

    arcs_axis = None if arcs is None else 0

    def stage(carry, temperature):
        parameters, steps, failed = carry
        parameters, more, bad = jax.vmap(one_start, (0, arcs_axis, None))(parameters, arcs, temperature)
        return (parameters, steps + more, failed | bad), None

    n_starts = parameters.shape[0]
    carry = (parameters, jnp.zeros(n_starts, int), jnp.zeros(n_starts, bool))
    (end, steps, failed), _ = jax.lax.scan(stage, carry, temperatures)

    final_loss = jax.vmap(lambda p, a: loss(p, (a, temperatures[-1])), (0, arcs_axis))(end, arcs)
    to_angles = jax.vmap(angles_of, (0, arcs_axis))
    first, last = to_angles(parameters, arcs), to_angles(end, arcs)
    failed = failed | ~jnp.isfinite(final_loss) | ~jnp.isfinite(last).all(axis=1)
    last = jnp.where(failed[:, None], first, last)
    return first, last, steps, failed
