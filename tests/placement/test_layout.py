import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import exact
from placement import Constraints, PlacementError
from placement.layouts.arcs import LayoutSpace
from placement.layouts.distinct import canonical, distinct
from placement.layouts.layout import angles_from_arcs, angles_from_gaps
from placement.layouts.layout_parameters import gaps_from_angles

QUICK = settings(max_examples=60, deadline=None)
any_angle = st.floats(-7, 14)
any_parameter = st.floats(-1e3, 1e3)
from_gaps, from_arcs = jax.jit(angles_from_gaps), jax.jit(angles_from_arcs)


@QUICK
@given(st.lists(any_parameter, min_size=4, max_size=7), st.floats(0, 1))
def test_gaps_are_feasible_whatever_the_parameters(parameters, fullness):
    n_cameras = len(parameters) - 1
    minimum_gap = fullness * 2 * np.pi / n_cameras
    angles = np.asarray(from_gaps(jnp.array(parameters), jnp.asarray(minimum_gap)))
    gaps = np.diff(angles, append=angles[0] + 2 * np.pi)
    assert np.isfinite(angles).all()
    assert gaps.min() >= minimum_gap - 1e-9 and gaps.sum() == pytest.approx(2 * np.pi)


@QUICK
@given(st.integers(1, 6), st.floats(0, 0.9), st.integers(0, 2**32 - 1))
def test_gaps_round_trip(n_cameras, fullness, seed):
    separation = fullness * (30 * np.sin(np.pi / n_cameras) if n_cameras > 1 else 30)
    space = LayoutSpace(exact.Ring(), n_cameras, Constraints(min_separation=separation))
    layout = space.random(np.random.default_rng(seed))
    parameters = gaps_from_angles(layout, space.minimum_gap)
    again = np.asarray(from_gaps(jnp.asarray(parameters), jnp.asarray(space.minimum_gap)))
    assert np.abs(np.exp(1j * canonical(again)) - np.exp(1j * canonical(layout))).max() < 1e-6


@st.composite
def requests(draw):
    """Number of cameras and demands of constraints, often impossible ones."""
    n_fixed, n_arcs = draw(st.integers(0, 2)), draw(st.integers(0, 2))
    fixed = tuple(draw(any_angle) for _ in range(n_fixed))
    forbidden = tuple((start, start + draw(st.floats(0.01, 4.5))) for start in [draw(any_angle) for _ in range(n_arcs)])
    demands = dict(min_separation=draw(st.floats(0, 16)), fixed=fixed, forbidden=forbidden)
    return draw(st.integers(max(1, n_fixed), 5)), demands


@QUICK
@given(requests(), st.integers(0, 2**32 - 1))
def test_random_layouts_and_maps_meet_every_constraint(request, seed):
    n_cameras, constraints = request[0], Constraints(**request[1])
    try:
        space = LayoutSpace(exact.Ring(), n_cameras, constraints)
    except PlacementError:
        assume(False)
        raise
    rng = np.random.default_rng(seed)
    layout = space.random(rng)
    assert constraints.violations(space.ring, layout) == []
    assume(space.n_free > 0)
    parameters, arcs = space.parameters(layout)
    gap = jnp.asarray(space.minimum_gap)

    def to_angles(parameters):
        parameters = jnp.asarray(parameters)
        return np.asarray(from_gaps(parameters, gap) if arcs is None else from_arcs(parameters, arcs, gap))

    difference = canonical(to_angles(parameters)) - canonical(layout)
    assert np.abs(np.exp(1j * difference) - 1).max() < 1e-5
    elsewhere = to_angles(rng.normal(scale=20, size=parameters.shape))
    assert constraints.violations(space.ring, elsewhere) == []


STRUTS = tuple((start, start + 0.3) for start in range(6))


def test_thousands_of_cameras_find_room_beside_fixed_ones():
    constraints = Constraints(0.0, fixed=(0.0, 1.0, 2.0, 4.0))  # 4 billion ways to share them among the arcs
    space = LayoutSpace(exact.Ring(), 3000, constraints)
    layout = space.random(np.random.default_rng(0))
    assert len(layout) == 3000 and space.constraints.violations(space.ring, layout) == []


@pytest.mark.parametrize("separation", [0.0, 0.5])
def test_many_cameras_are_shared_among_the_arcs_in_more_ways_than_can_be_listed(separation):
    constraints = Constraints(separation, forbidden=STRUTS)
    space, rng = LayoutSpace(exact.Ring(), 40, constraints), np.random.default_rng(0)
    layouts = [space.random(rng) for _ in range(5)]
    for layout in layouts:
        assert constraints.violations(space.ring, layout) == []
        parameters, arcs = space.parameters(layout)
        assert arcs is not None
        again = np.asarray(from_arcs(jnp.asarray(parameters), arcs, jnp.asarray(space.minimum_gap)))
        assert np.abs(np.exp(1j * canonical(again)) - np.exp(1j * canonical(layout))).max() < 1e-5
    shares = [np.histogram(np.mod(layout, 2 * np.pi), bins=[0, 1, 2, 3, 4, 5, 6.29])[0] for layout in layouts]
    assert len({tuple(share.tolist()) for share in shares}) == len(shares)


def test_every_share_is_as_likely_whether_listed_or_drawn(monkeypatch):
    constraints = Constraints(9.0, forbidden=((0.5, 1.0), (2.0, 2.2), (4.0, 5.0)))

    def shares():
        space, rng = LayoutSpace(exact.Ring(), 5, constraints), np.random.default_rng(0)
        drawn = [space.random(rng) for _ in range(3000)]
        held = [np.histogram(np.mod(theta, 2 * np.pi), bins=[0, 0.75, 2.1, 4.5, 6.29])[0] for theta in drawn]
        # The first arc goes on where the last one ends.
        found, count = np.unique([[one[0] + one[3], one[1], one[2]] for one in held], axis=0, return_counts=True)
        return {tuple(share): n / 3000 for share, n in zip(found.tolist(), count.tolist(), strict=True)}

    listed = shares()
    monkeypatch.setattr("placement.layouts.arcs.MOST_LISTED", 0)
    drawn = shares()
    assert len(listed) > 3 and listed.keys() == drawn.keys()
    assert max(abs(listed[share] - drawn[share]) for share in listed) < 0.05  # five standard errors


def test_fixed_cameras_stay_and_gradient_is_finite():
    constraints = Constraints(5.0, fixed=(1.0, 4.0), forbidden=((5.0, 6.0),))
    space = LayoutSpace(exact.Ring(), 5, constraints)
    layout = space.random(np.random.default_rng(1))
    parameters, arcs = space.parameters(layout)
    assert arcs is not None
    jacobian = jax.jacobian(angles_from_arcs)(jnp.asarray(parameters), arcs, jnp.asarray(space.minimum_gap))
    assert np.isfinite(jacobian).all()
    assert (np.asarray(jacobian)[-2:] == 0).all()  # the fixed ones come last
    assert np.isfinite(jax.jacobian(angles_from_gaps)(jnp.array([0.0, 800.0, -800.0]), jnp.asarray(0.1))).all()


def test_full_ring_has_one_layout_up_to_its_phase():
    separation = 30 * np.sin(np.pi / 6)
    space = LayoutSpace(exact.Ring(), 6, Constraints(min_separation=separation))
    for layout in (space.random(np.random.default_rng(0)), exact.Ring().equidistant(6, 0.3)):
        assert space.allows(layout)
        assert np.isfinite(space.parameters(layout)[0]).all()


def test_allowed_and_free_cameras():
    space = LayoutSpace(exact.Ring(), 3, Constraints(5.0, fixed=(1.0,), forbidden=((2.0, 3.0),)))
    layout = np.array([4.0, 1.0, 5.5])
    assert space.free_cameras(layout).tolist() == [0, 2]
    assert space.allowed([1.1, 2.5, 3.0, 4.1, 4.6], [1.0, 4.0]).tolist() == [False, False, True, False, True]


def test_distinct_layouts_ignore_the_order_of_cameras_and_full_turns():
    base = np.array([0.001, 2.0, 4.0])
    same = [base + 2 * np.pi, base[[2, 0, 1]], base - 0.004, np.array([2 * np.pi - 0.002, 2.0, 4.0])]
    assert distinct([base, *same, base + 0.5], tolerance=0.01) == [0, 5]
    assert distinct([], 0.1) == []


ERRORS = [
    (12, dict(min_separation=10.0), r"12 cameras at 10 mm need a ring of at least 38\.6 mm; this one takes 9"),
    (2, dict(min_separation=31.0), "needs a ring of at least as much; this one has 30 mm and takes 1 camera"),
    (0, dict(), "number of cameras is 0; it must be a whole number, at least 1"),
    (2.5, dict(), "number of cameras is 2.5"),
    (1, dict(fixed=(0.0, 1.0)), "2 cameras are fixed but the layout has 1"),
    (3, dict(fixed=(0.0, 0.01)), r"fixed cameras contradict the constraints: two cameras are .* apart"),
    (3, dict(fixed=(0.5,), forbidden=((0.0, 1.0),)), "fixed cameras contradict the constraints: camera at 28.6"),
    (3, dict(forbidden=((0.0, 7.0),)), "covers the whole ring"),
    (
        4,
        dict(min_separation=10.0, forbidden=((0.0, 5.0),)),
        "4 cameras at 10 mm do not fit beside 1 forbidden arc: 2 do, or 4 at 6.36 mm",
    ),
    (4, dict(min_baseline=31.0), "no two cameras are 31 mm apart on a ring of 30 mm"),
    (4, dict(min_angle=0.2), "at most 30 mm or an angle of at most 4.29 degrees"),
]


@pytest.mark.usefixtures("unchecked")
@pytest.mark.parametrize(("n_cameras", "demands", "message"), ERRORS)
def test_requests_that_cannot_be_met(n_cameras, demands, message):
    with pytest.raises(PlacementError, match=message):
        LayoutSpace(exact.Ring(), n_cameras, Constraints(**demands))


@pytest.mark.usefixtures("unchecked")
@pytest.mark.parametrize(
    ("demands", "message"),
    [
        (dict(min_separation=-1.0), r"min_separation is -1.0; it must be a number, at least 0 \[mm\]"),
        (dict(min_angle=float("nan")), "min_angle is nan"),
        (dict(min_baseline="5"), "min_baseline is '5'"),
        (dict(forbidden=(1.0,)), "forbidden a row of pairs of ring angles"),
        (dict(fixed=(float("inf"),)), "must be finite"),
    ],
)
def test_constraints_that_make_no_sense(demands, message):
    with pytest.raises(PlacementError, match=message):
        Constraints(**demands)
