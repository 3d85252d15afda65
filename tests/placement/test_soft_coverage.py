import dataclasses
import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import TypeCheckError

import exact
from placement.samples.profiles import RingProfiles
from placement.samples.sampled_coverage import SampledCoverage
from placement.surrogate import soft_coverage as module_under_test
from placement.surrogate.soft_coverage import (
    SOFT_MINIMUM,
    Baseline,
    Changes,
    at_least,
    signed_distances,
    soft_coverage_of,
)
from placement.surrogate.surrogate import Surrogate

COLD = jnp.asarray(1e-9)
soft_coverage = jax.jit(module_under_test.soft_coverage, static_argnums=4)


@pytest.fixture(scope="module")
def profiles():
    """Random arcs on a grid of 48 angles, with one point always and one never visible."""
    rng = np.random.default_rng(0)
    grid = 2 * np.pi * np.arange(48) / 48
    middle, half_width = rng.uniform(0, 2 * np.pi, 200), rng.uniform(0.2, 2.5, 200)
    distance = half_width - np.abs(np.angle(np.exp(1j * (grid[:, None] - middle))))
    distance[:, 0], distance[:, 1] = np.pi, -np.pi
    return RingProfiles.of(distance, rng.uniform(0.5, 2.0, 200))


def arrays(profiles):
    """Profiles and one row of weights that add up to 1."""
    return changes_of(profiles), jnp.asarray(profiles.weights[None] / profiles.weights.sum())


def changes_of(profiles):
    return Changes(jnp.asarray(profiles.behind), jnp.asarray(profiles.ahead))


@pytest.mark.parametrize(("n_events", "threshold"), [(1, 1), (2, 1), (4, 2), (5, 3), (6, 6), (3, 5)])
def test_at_least_against_enumeration(n_events, threshold):
    probabilities = np.random.default_rng(n_events).random((n_events, 7))
    expected = np.zeros(7)
    for outcome in itertools.product([0, 1], repeat=n_events):
        if sum(outcome) >= threshold:
            happens = np.array(outcome)[:, None]
            expected += np.prod(happens * probabilities + (1 - happens) * (1 - probabilities), axis=0)
    found = at_least(jnp.asarray(probabilities), threshold)
    assert np.abs(np.asarray(found) - expected).max() < 1e-14


@pytest.mark.parametrize("threshold", [1, 2, 3])
@pytest.mark.parametrize("min_baseline", [0.0, 12.0])
def test_cold_soft_coverage_is_the_hard_coverage_of_the_samples(profiles, threshold, min_baseline):
    rng = np.random.default_rng(1)
    hard = SampledCoverage(profiles, exact.Demand(threshold, min_baseline), exact.Ring())
    baseline = Baseline(jnp.asarray(30.0), jnp.asarray(min_baseline)) if min_baseline else None
    for _ in range(10):
        angles = rng.uniform(-10, 10, 5)
        soft = soft_coverage(jnp.asarray(angles), *arrays(profiles), COLD, threshold, baseline)
        assert float(soft) * profiles.weights.sum() == pytest.approx(hard.fraction(angles), abs=1e-9)


@pytest.mark.parametrize("threshold", [2, 3])
@pytest.mark.parametrize("max_error", [0.05, 0.08, 0.2])
def test_a_bound_on_the_error_is_carried_and_differentiated(profiles, threshold, max_error):
    """Of points of unlike noise; cold it is the samples' own, which goes by the exact formula on a ring."""
    rng = np.random.default_rng(4)
    noisy = dataclasses.replace(profiles, noise=rng.uniform(0.5, 2.0, len(profiles.weights)))
    demand = exact.Demand(threshold, max_error=max_error)
    hard, surrogate = SampledCoverage(noisy, demand, exact.Ring()), Surrogate(noisy, demand, exact.Ring())
    slope = jax.jit(jax.grad(lambda at: soft_coverage_of(surrogate.points, at, jnp.asarray(0.3), threshold)))
    counted = []
    for _ in range(6):
        angles = rng.uniform(-10, 10, 5)
        counted.append(hard.fraction(angles))
        assert surrogate.at(angles, temperature=1e-9) == pytest.approx(counted[-1], abs=1e-9)
        ends = [surrogate.at(angles + np.array([step, 0, 0, 0, 0]), temperature=0.3) for step in (1e-6, -1e-6)]
        assert float(slope(jnp.asarray(angles))[0]) == pytest.approx((ends[0] - ends[1]) / 2e-6, rel=1e-5, abs=1e-5)
    free = SampledCoverage(noisy, exact.Demand(threshold), exact.Ring())
    assert max(counted) > 0 and (max_error > 0.1 or max(counted) < free.profiles.weights.sum())


@pytest.mark.parametrize("threshold", [1, 2, 3])
@pytest.mark.parametrize("min_baseline", [0.0, 12.0])
def test_moving_cameras_over_the_grid_agrees_with_the_area_of_each_layout(profiles, threshold, min_baseline):
    hard = SampledCoverage(profiles, exact.Demand(threshold, min_baseline), exact.Ring(), n_grid=24)
    others = np.array([0.3, 2.2, 4.0])
    expected = [hard.worth([*others, angle]) for angle in hard.grid]
    assert np.abs(hard.worth_with_one_more(others) - expected).max() < 1e-3  # single precision
    if min_baseline == 0.0:
        pairs = [[hard.worth([*others[:2], a, b]) for a in hard.pair_grid] for b in hard.pair_grid]
        assert np.abs(hard.worth_with_two_more(others[:2]) - pairs).max() < 1e-3


@pytest.fixture(scope="module")
def two_sites(profiles):
    """The same points, dealt out to two sites of which one is harder to see."""
    hard_ones = np.argsort(profiles.visible.sum(axis=0)) < 100
    of = RingProfiles.of(profiles.signed_distance, profiles.weights / profiles.weights.sum())
    return dataclasses.replace(of, site=hard_ones.astype(np.int64))


@pytest.mark.parametrize("min_baseline", [0.0, 12.0])
def test_of_several_sites_the_least_counts(two_sites, min_baseline):
    hard = SampledCoverage(two_sites, exact.Demand(2, min_baseline), exact.Ring(), n_grid=24)
    soft = Surrogate(two_sites, exact.Demand(2, min_baseline), exact.Ring())
    others = np.array([0.3, 2.2, 4.0])
    alone = [
        SampledCoverage(two_sites.subset(two_sites.site == k), exact.Demand(2, min_baseline), exact.Ring())
        for k in (0, 1)
    ]
    sums = [float(part.profiles.weights[part.covered(others)].sum()) for part in alone]
    assert hard.fraction(others) == pytest.approx(min(sums), abs=1e-12)
    assert 0 <= min(sums) - soft.at(others, 1e-9) + 1e-12 <= SOFT_MINIMUM * np.log(2) + 1e-9
    assert np.abs(hard.worth_with_one_more(others) - [hard.worth([*others, a]) for a in hard.grid]).max() < 1e-5
    if min_baseline == 0.0:
        pairs = [[hard.worth([*others[:2], a, b]) for a in hard.pair_grid] for b in hard.pair_grid]
        assert np.abs(hard.worth_with_two_more(others[:2]) - pairs).max() < 1e-5


def test_permuting_cameras_and_full_turns_change_nothing(profiles):
    angles, baseline = np.array([0.1, 1.4, 2.0, 5.0]), Baseline(jnp.asarray(30.0), jnp.asarray(9.0))

    def value(layout):
        return float(soft_coverage(jnp.asarray(layout), *arrays(profiles), jnp.asarray(0.1), 2, baseline))

    for order in itertools.permutations(range(4)):
        assert value(angles[list(order)]) == pytest.approx(value(angles), abs=1e-14)
    assert value(angles + 2 * np.pi * np.array([3, -2, 1, 0])) == pytest.approx(value(angles), abs=1e-13)


def test_one_camera_more_never_lowers_it(profiles):
    rng = np.random.default_rng(2)
    angles = rng.uniform(0, 7, 6)
    values = [float(soft_coverage(jnp.asarray(angles[:n]), *arrays(profiles), jnp.asarray(0.2))) for n in range(1, 7)]
    assert values[0] == 0.0  # one camera, two views wanted
    assert (np.diff(values) >= 0).all() and values[-1] <= 1


@pytest.mark.parametrize("threshold", [1, 2, 3])
@pytest.mark.parametrize("min_baseline", [None, 12.0])
def test_gradient_against_finite_differences(profiles, threshold, min_baseline):
    baseline = None if min_baseline is None else Baseline(jnp.asarray(30.0), jnp.asarray(min_baseline))

    @jax.jit
    def value(angles):
        return soft_coverage(angles, *arrays(profiles), jnp.asarray(0.3), threshold, baseline)

    angles, step = jnp.array([0.313, 1.777, 2.513, 4.4321]), 1e-6
    gradient = jax.jit(jax.grad(value))(angles)
    for i in range(4):
        shift = step * jnp.eye(4)[i]
        slope = (value(angles + shift) - value(angles - shift)) / (2 * step)
        assert float(gradient[i]) == pytest.approx(float(slope), rel=1e-6, abs=1e-9)


def test_signed_distances_rise_or_fall_like_the_angle_in_arcs_of_any_width():
    rng, step = np.random.default_rng(3), 1e-6
    profile = changes_of(RingProfiles.of(rng.normal(size=(12, 200)), np.ones(200)))  # most arcs hold one grid angle
    angles = jnp.asarray(rng.uniform(0, 2 * np.pi, 50))
    at = jax.jit(signed_distances)
    _, slope = jax.jvp(lambda theta: at(theta, profile), (angles,), (jnp.ones(50),))
    difference = np.asarray(at(angles + step, profile) - at(angles - step, profile)) / (2 * step)
    assert np.allclose(np.abs(slope), 1, atol=1e-12)
    at_a_turn = np.abs(np.abs(difference) - 1) > 1e-6
    assert at_a_turn.mean() < 1e-3 and np.allclose(slope[~at_a_turn], difference[~at_a_turn], atol=1e-6)


TRAPS = {
    "coincident cameras": ([1.0, 1.0, 1.0], 0.1),
    "camera on a grid angle": ([0.0, 2 * np.pi / 48, 2 * np.pi], 0.1),
    "opposite cameras": ([0.0, np.pi, 2.0], 0.1),
    "tiny temperature": ([0.1, 2.0, 4.0], 1e-300),
    "huge temperature": ([0.1, 2.0, 4.0], 1e300),
    "many turns": ([1e6, -1e6, 3.0], 0.1),
}


value_and_gradient = jax.jit(jax.value_and_grad(module_under_test.soft_coverage), static_argnums=4)


@pytest.mark.parametrize("trap", TRAPS)
@pytest.mark.parametrize("min_baseline", [None, 0.0, 30.0])
@pytest.mark.parametrize("points", ["all", "always visible", "never visible", "none", "without weight"])
def test_finite_value_and_gradient_at_traps(profiles, trap, min_baseline, points):
    angles, temperature = TRAPS[trap]
    changes, weights = arrays(profiles)
    column = {"all": slice(None), "always visible": [0], "never visible": [1], "none": [], "without weight": [2]}
    index = jnp.arange(weights.shape[1])[jnp.asarray(column[points], int) if points != "all" else slice(None)]
    changes = jax.tree.map(lambda angle: angle[:, index], changes)
    weights = weights[:, index] * (0.0 if points == "without weight" else 1.0)
    baseline = None if min_baseline is None else Baseline(jnp.asarray(30.0), jnp.asarray(min_baseline))
    value, gradient = value_and_gradient(jnp.asarray(angles), changes, weights, jnp.asarray(temperature), 2, baseline)
    assert np.isfinite(value) and -1e-12 <= value <= 1 + 1e-12
    assert np.isfinite(gradient).all()


def test_signed_distances_are_periodic():
    quarter = np.pi / 2
    profile = changes_of(RingProfiles.of(np.array([[1.0], [1.0], [1.0], [-3.0]]), np.ones(1)))
    angles = jnp.array([3.5 * quarter, -0.5 * quarter, 7.5 * quarter])
    between_last_and_first = jax.jit(signed_distances)(angles, profile)
    assert np.allclose(between_last_and_first, -0.25 * quarter, atol=1e-12)  # hidden from 2.25 to 3.75 quarters


def test_annotated_shapes_hold(profiles):
    """In tests, all of `placement` is imported with its annotations checked at run time."""
    value = soft_coverage(jnp.zeros(2), *arrays(profiles), jnp.asarray(0.1))
    assert value.shape == () and value.dtype == jnp.float64
    with pytest.raises(TypeCheckError):
        module_under_test.soft_coverage(jnp.zeros((2, 1)), *arrays(profiles), jnp.asarray(0.1))
    with pytest.raises(TypeCheckError):
        dataclasses.replace(profiles, weights=profiles.weights[1:])
    with pytest.raises(TypeCheckError):
        SampledCoverage(profiles, exact.Demand(), exact.Ring(), n_grid=24.5)
