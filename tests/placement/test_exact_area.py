"""The exact area as a function that JAX differentiates."""

import jax
import jax.numpy as jnp
import numpy as np
import optimistix
import pytest
import trimesh

import exact
import placement
from placement import Constraints, PlacementError, Problem, Settings

RING = exact.Ring()
QUICK = Settings(n_samples=200, n_angles=24, ring_cameras=8)
LAYOUT = np.array([0.3, 1.1, 4.0])


@pytest.fixture(scope="module")
def walls():
    parts = [trimesh.creation.box((30, 30, 1))]
    parts += [trimesh.creation.box((1, 20, 14)).apply_translation((x, 0, 8)) for x in (-6, 1, 7)]
    return trimesh.util.concatenate(parts)


@pytest.fixture(scope="module")
def problem(walls):
    return Problem(walls, RING, settings=QUICK)


def test_value_and_derivative_are_those_of_the_evaluator(walls, problem):
    area = placement.exact_area(problem)
    assert area(LAYOUT) == exact.evaluate(walls, RING.cameras(LAYOUT)).area
    value, slope = jax.value_and_grad(area)(LAYOUT)
    assert value == area(LAYOUT) and value.dtype == np.float64
    for i, step in enumerate(1e-5 * np.eye(3)):
        high, low = (exact.evaluate(walls, RING.cameras(LAYOUT + by)).area for by in (step, -step))
        assert slope[i] == pytest.approx((high - low) / 2e-5, rel=1e-5, abs=1e-4)
    assert np.array_equal(jax.jit(jax.grad(area))(LAYOUT), slope)
    assert np.allclose(jax.grad(area)(LAYOUT + 2 * np.pi), slope, rtol=1e-9, atol=1e-9)


def test_it_goes_into_objectives_and_over_batches(problem):
    area = placement.exact_area(problem)
    slope = jax.grad(area)(LAYOUT)
    loss = jax.jit(jax.grad(lambda angles, weight: weight * jnp.log(area(angles)) + jnp.sum(angles)))
    assert np.allclose(loss(LAYOUT, 2.0), 2 * slope / area(LAYOUT) + 1, rtol=1e-12)
    several = jnp.stack([LAYOUT, LAYOUT + 0.1])
    assert np.array_equal(jax.vmap(area)(several), [area(one) for one in several])
    assert np.array_equal(jax.jvp(area, (jnp.array(LAYOUT),), (jnp.array([0.0, 1.0, 0.0]),))[1], slope[1])


def test_bfgs_climbs_from_a_poor_layout_to_a_local_optimum(walls, problem):
    area, start = placement.exact_area(problem), jnp.array([0.1, 0.5, 0.9])
    found = optimistix.minimise(
        lambda angles, _: -area(angles) / 1000, optimistix.BFGS(rtol=1e-8, atol=1e-8), start, max_steps=100
    )
    assert area(found.value) > area(start) + 100
    assert np.abs(jax.grad(area)(found.value)).max() < 1e-3 < 10 < np.abs(jax.grad(area)(start)).max()
    for i in range(3):
        moved = [np.asarray(found.value) + by * np.eye(3)[i] for by in np.radians([-1.0, -0.1, 0.1, 1.0])]
        assert max(exact.areas(walls, [RING.cameras(one) for one in moved])) < area(found.value)


def test_several_sites_and_a_baseline(walls):
    several = Problem([walls, trimesh.creation.box((20, 20, 2))], RING, settings=QUICK)
    area, sites = placement.exact_area(several, Constraints(min_baseline=28.0)), several.sites.members
    expected = sum(exact.evaluate(one.scene, RING.cameras(LAYOUT), min_baseline=28.0).area for one in sites)
    assert area(LAYOUT) == expected < placement.exact_area(several)(LAYOUT)
    assert jax.grad(area)(LAYOUT).shape == (3,)


def test_what_is_no_layout(walls, problem):
    area = placement.exact_area(problem)
    assert np.isnan(area([0.3, np.nan])) and np.isnan(jax.grad(area)(jnp.array([0.3, np.inf]))).all()
    with pytest.raises(PlacementError, match=r"ring angles have shape \(1, 3\); they must be one row"):
        area([LAYOUT])
    with pytest.raises(PlacementError, match="threshold is 2 with 1 camera;"):
        area([0.3])
    with pytest.raises(PlacementError, match="leave max_error out"):
        placement.exact_area(Problem(walls, RING, settings=QUICK, max_error=0.5))
