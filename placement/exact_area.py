"""The exact area as a function that JAX differentiates, with the exact derivative, not one of samples."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

import exact
import placement.surrogate.double_precision  # noqa: F401 - an area has more digits than single precision
from exact.derivative.derivative import refuse_without_derivative
from placement.errors import PlacementError, refusing
from placement.layouts.constraints import Constraints
from placement.problem import Problem

AreaOfLayout = Callable[[Float[Array, " M"]], Float[Array, ""]]


def exact_area(problem: Problem, constraints: Constraints | None = None) -> AreaOfLayout:
    """The exact area of a layout as a function of its ring angles, for objectives of one's own.

    `jax.grad`, `jax.value_and_grad`, `jax.jit`, `jax.vmap` and the minimisers of optimistix take it: its derivative is
    that of `exact.gradient`, from the same evaluation. There is no second derivative. Each call takes as long as
    `exact.evaluate`, since that is what it does, on the processor, whatever JAX runs on.

    Parameters
    ----------
    problem : Problem
        Sites, ring and what counts.
    constraints : Constraints, optional
        Of which only the baseline matters: what a layout must keep is left to the caller.

    Returns
    -------
    function
        Of (M,) ring angles [rad], the area [mm²], summed over the sites as `Placement.area` is; nan for angles that are
        not finite.

    Raises
    ------
    PlacementError
        If the area has no derivative, as with `max_error`; from the function, if the angles are no layout of enough
        cameras.

    Examples
    --------
    >>> import jax, trimesh
    >>> from placement import Settings
    >>> quick = Settings(n_samples=200, n_angles=12, ring_cameras=8)
    >>> step = trimesh.util.concatenate([trimesh.creation.box((30, 30, 1)), trimesh.creation.box((1, 8, 30))])
    >>> area = exact_area(Problem(step, exact.Ring(), settings=quick))
    >>> value, derivative = jax.jit(jax.value_and_grad(area))(jnp.array([0.3, 1.0, 4.0]))
    >>> 800 < value < 1000, derivative.shape
    (Array(True, dtype=bool), (3,))
    """
    demand = problem.demanded(Constraints() if constraints is None else constraints)
    with refusing():
        refuse_without_derivative(demand)
    scenes, ring = [site.scene for site in problem.sites.members], problem.ring

    def measured(angles) -> tuple[np.ndarray, np.ndarray]:
        theta = np.asarray(angles, dtype=np.float64)
        if not np.isfinite(theta).all():
            return np.array(np.nan), np.full(theta.shape, np.nan)
        cameras = ring.cameras(np.mod(theta, 2 * np.pi))
        found = [exact.gradient(scene, cameras, demand=demand) for scene in scenes]
        derivative = np.sum([one.on_ring(ring).angle for one in found], axis=0)
        return np.array(sum(one.area for one in found)), derivative

    def called(theta: Array) -> tuple[Array, Array]:
        shapes = jax.ShapeDtypeStruct((), theta.dtype), jax.ShapeDtypeStruct(theta.shape, theta.dtype)
        return jax.pure_callback(measured, shapes, theta, vmap_method="sequential")

    @jax.custom_jvp
    def area(theta: Array) -> Array:
        return called(theta)[0]

    @area.defjvp
    def _(primals, tangents):
        value, derivative = called(*primals)
        return value, derivative @ tangents[0]

    def checked(angles) -> Float[Array, ""]:
        theta = jnp.asarray(angles, dtype=jnp.float64)
        if theta.ndim != 1:
            raise PlacementError(f"ring angles have shape {theta.shape}; they must be one row of M angles [rad]")
        with refusing():
            demand.refuse_fewer(len(theta))
        return area(theta)

    return checked
