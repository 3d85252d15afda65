"""What accuracy costs in area: layouts that none beats in both, by exact figures."""

import itertools

import numpy as np
import pytest
import trimesh

import exact
import placement
from placement import Constraints, PlacementError, Settings, TradedLayout, TradeOff
from placement.samples.sampled_coverage import SampledCoverage

RING = exact.Ring()
QUICK = Settings(n_samples=1500, n_angles=60, n_starts=3, ring_cameras=24, exact_candidates=3, certificate_step=0.35)


@pytest.fixture(scope="module")
def trench():
    """A floor between two walls and a bridge, which two neighbouring cameras see more of than opposite ones."""
    parts = [((40, 40, 2), (0, 0, -1)), ((2, 40, 20), (8, 0, 10)), ((2, 40, 20), (-8, 0, 10)), ((30, 3, 2), (0, 4, 24))]
    return trimesh.util.concatenate([trimesh.creation.box(size).apply_translation(at) for size, at in parts])


@pytest.fixture(scope="module")
def problem(trench):
    return placement.Problem(trench, RING, settings=QUICK)


@pytest.fixture(scope="module")
def found(problem):
    return problem.tradeoff(4)


def test_every_figure_is_that_of_the_exact_evaluation(trench, problem, found):
    for layout in (*found.layouts, *found.compared):
        # Depth is along the axis of the ring, whatever cameras there are.
        own = exact.evaluate(trench, RING.cameras(layout.angles), depth_axis=RING.axis)
        assert layout.area == pytest.approx(own.area, rel=1e-12)
        assert layout.fraction == pytest.approx(own.area / problem.ring_maximum.areas[0], rel=1e-12)
        # Errors are averages over parts of the surface, which depend to 1e-8 on how it is divided.
        own = exact.evaluate(trench, RING.cameras(layout.angles), depth_axis=RING.axis, all_views=True)
        assert layout.error_rms == pytest.approx(own.error_rms, rel=1e-9)


def test_none_beats_another_in_both(found):
    assert len(found.layouts) >= 3
    for one, other in itertools.pairwise(found.layouts):
        assert one.fraction > other.fraction and one.error_rms > other.error_rms
    for layout in found.compared:
        assert any(one.fraction >= layout.fraction and one.error_rms <= layout.error_rms for one in found.layouts)
    assert {layout.kind for layout in found.compared} == {"equidistant", "opposite pairs"}
    assert found.bound_fraction is not None and found.bound_fraction > found.layouts[0].fraction - 0.02


def test_an_exhaustive_search_on_samples_finds_little_more(problem, found):
    coverage = SampledCoverage(problem.profiles, problem.demand, RING)
    sampled = np.array([(coverage.fraction(layout.angles), coverage.error(layout.angles)) for layout in found.layouts])
    step, tried = np.radians(15), []
    for three in itertools.combinations(range(24), 3):
        # 30 degrees are the least at which cameras are 5 mm apart, on this grid.
        last = [k for k in range(three[2] + 2, 24) if three[0] + 24 - k >= 2]
        if last and three[1] - three[0] >= 2 and three[2] - three[1] >= 2:
            tried.append(np.stack(coverage.measured_with_one_more(step * np.array(three), step * np.array(last))))
    worth, error = np.concatenate(tried, axis=1)
    assert len(worth) == 24 * 19 * 18 * 17 // 24
    # None of ours could have much more area at its own error.
    for fraction, most in sampled:
        assert worth[error <= most].max(initial=0.0) - fraction < 0.003
    # How much more area each has than ours of about the same error, or less.
    ours = np.where(sampled[:, 1:] <= 1.02 * error, sampled[:, :1], 0.0).max(axis=0)
    assert (worth - ours > 0.01).mean() < 0.002 and (worth - ours).max() < 0.03


def test_no_camera_moved_gives_more_area_at_no_more_error(problem, found):
    coverage = SampledCoverage(problem.profiles, problem.demand, RING)
    searched = [np.array(layout.angles) for layout in found.layouts if layout.kind == "searched"]
    for angles, camera in itertools.product(searched, range(4)):
        worth, error = coverage.measured_with_one_more(np.delete(angles, camera))
        allowed = error <= coverage.error(angles)
        assert worth[allowed].max(initial=0.0) - coverage.worth(angles) < 0.001 + 1e-9


def test_the_knee_is_named(found):
    assert found.knee in found.layouts
    three = [TradedLayout((0.0, 1.0), "searched", 1.0, *at) for at in ((0.9, 0.4), (0.89, 0.1), (0.8, 0.08))]
    words = TradeOff(tuple(three), (), None).words
    assert words == (
        "Giving up 1.00% of the ring maximum lessens the error from 0.4000 to 0.1000 mm; giving up another 9.00% "
        "lessens it only to 0.0800 mm."
    )
    assert TradeOff(tuple(three[:1]), (), None).words == "One layout has both the most area and the least error."
    assert TradeOff(tuple(three[1:]), (), None).words.startswith("Giving up 9.00% lessens it to 0.0800")


def test_constraints_hold_and_the_same_seed_gives_the_same(trench):
    constraints = Constraints(min_separation=9.0, fixed=(0.3,), forbidden=((1.0, 2.0),))
    quick = {"settings": QUICK, "certify": False, "constraints": constraints}
    one, other = (placement.tradeoff(trench, RING, 3, **quick) for _ in range(2))
    assert one == other and one.bound_fraction is None
    for layout in (*one.layouts, *one.compared):
        assert constraints.violations(RING, layout.angles) == []


def test_what_triangulates_nothing_is_refused(trench):
    with pytest.raises(PlacementError, match="errors take two"):
        placement.tradeoff(trench, RING, 3, threshold=1, settings=QUICK)
    with pytest.raises(PlacementError):
        placement.tradeoff(trench, RING, 1, settings=QUICK)
