import dataclasses
import itertools

import numpy as np
import pytest
import trimesh

import exact
import placement
from placement import Constraints, PlacementError, Settings

RING = exact.Ring()
QUICK = Settings(
    n_samples=1000, n_angles=48, n_starts=6, n_start_phases=2, exact_candidates=4, exact_phases=2, polish_steps=(),
    ring_cameras=16, certificate_step=float(np.radians(15)),
)  # fmt: skip
LAYOUT = (0.4, 1.5, 2.9, 5.0)


@pytest.fixture(scope="module")
def bars():
    beams = [trimesh.creation.box((40, 3, 3)), trimesh.creation.box((3, 30, 3)).apply_translation((-6, 0, 4))]
    beams = [beam.apply_translation((0, 2, 32)) for beam in beams]
    return trimesh.util.concatenate([trimesh.creation.box((40, 40, 2)), *beams])


@pytest.fixture(scope="module")
def problem(bars):
    return placement.Problem(bars, RING, settings=QUICK)


def area(mesh, angles, min_baseline=0.0):
    return exact.evaluate(mesh, RING.cameras(angles), min_baseline=min_baseline).area


@pytest.mark.parametrize("min_baseline", [0.0, 18.0])
def test_failures_are_those_of_the_layouts_without_the_camera(bars, problem, min_baseline):
    found = placement.robustness(problem, LAYOUT, Constraints(min_baseline=min_baseline), n_mountings=2)
    whole = area(bars, RING.equidistant(16))  # the ring maximum does not depend on the baseline
    assert found.fraction == pytest.approx(area(bars, LAYOUT, min_baseline) / whole, rel=1e-9)
    alone = [area(bars, np.delete(LAYOUT, i), min_baseline) / whole for i in range(4)]
    assert found.failed_fractions == pytest.approx(alone, rel=1e-9)
    assert found.worst_failure == min(found.failed_fractions) < found.mean_failure < found.fraction


def test_mounting_errors_are_repeatable_and_as_large_as_said(bars, problem):
    found = placement.robustness(problem, LAYOUT, mounting_error=0.05, n_mountings=5, seed=3)
    assert found == placement.robustness(problem, LAYOUT, mounting_error=0.05, n_mountings=5, seed=3)
    assert found.mounting_fractions != placement.robustness(problem, LAYOUT, n_mountings=5, seed=3).mounting_fractions
    assert len(found.mounting_fractions) == 5 and found.worst_mounting == min(found.mounting_fractions)
    whole = area(bars, RING.equidistant(16))
    every = [
        area(bars, np.array(LAYOUT) + 0.05 * np.array(sides)) / whole for sides in np.ndindex(2, 2, 2, 2)
        for sides in [2 * np.array(sides) - 1]
    ]  # fmt: skip
    for fraction in found.mounting_fractions:
        assert np.isclose(every, fraction, rtol=1e-9).any()
    still = placement.robustness(problem, LAYOUT, mounting_error=0.0, n_mountings=2)
    assert still.mounting_fractions == (still.fraction,) * 2


def test_pairs_add_up_to_what_all_reconstruct(bars, problem):
    found = placement.robustness(problem, LAYOUT, n_mountings=1)
    first = found.pairs[0]
    each = {(i, j): area(bars, [LAYOUT[i], LAYOUT[j]]) for i in range(4) for j in range(i + 1, 4)}
    assert first.area == first.together == pytest.approx(max(each.values()), rel=1e-9)
    together = [pair.together for pair in found.pairs]
    assert together == sorted(together) and 0.999 <= together[-1] / area(bars, LAYOUT) <= 1 + 1e-9
    for pair in found.pairs:
        assert pair.area == pytest.approx(each[pair.cameras], rel=1e-9)


def test_pairs_too_close_for_the_baseline_do_no_work(problem):
    close = (0.0, 0.3, np.pi)
    found = placement.robustness(problem, close, Constraints(min_separation=0.0, min_baseline=10.0), n_mountings=1)
    assert found.accurate_pairs
    assert (0, 1) not in [pair.cameras for pair in (*found.pairs, *found.accurate_pairs)]


@pytest.mark.parametrize(
    "angles", [LAYOUT, (0.1, 0.5, 3.3, 3.6), tuple(RING.equidistant(6)), (0.0, 0.9, 1.8, 2.7, 3.3, 4.4, 5.5)]
)
def test_accurate_pairs_keep_area_and_error_and_are_few(bars, problem, angles):
    found = placement.robustness(problem, angles, n_mountings=1)
    sets = exact.view_sets(bars, RING.cameras(found.angles), depth_axis=(0, 0, 1))
    everyone = sets.errors().rms()
    assert found.error_rms == pytest.approx(everyone, rel=1e-12)
    every = list(itertools.combinations(range(len(angles)), 2))

    def measured(pairs):
        """Area and RMS error from pairs, cameras of each view set taken together by hand."""
        squares = total = 0.0
        for seen, area in zip(sets.seen, sets.areas, strict=True):
            used = {camera for pair in pairs if seen[list(pair)].all() for camera in pair}
            if used:
                # On a ring the error is inversely proportional to the root of the spread of the cameras.
                spread = len(used) - abs(np.exp(1j * np.array(found.angles)[sorted(used)]).sum()) ** 2 / len(used)
                squares, total = squares + area / spread, total + area
        return total, np.sqrt(squares / total) if total else np.inf

    whole, best = measured(every)
    kept, error = measured([pair.cameras for pair in found.accurate_pairs])
    # All that is seen is about as deep, so that depths do not matter to ratios of errors.
    assert kept >= 0.985 * whole and error <= 1.12 * best
    assert found.accurate_pairs[-1].together == pytest.approx(kept, rel=1e-9)
    assert found.accurate_pairs[-1].error <= 1.1 * everyone
    if len(every) <= 15:  # none of all choices of fewer pairs will do
        for fewer in itertools.combinations(every, len(found.accurate_pairs) - 1):
            area, error = measured(fewer)
            assert area < 0.995 * whole or error > 1.08 * best


def test_errors_from_pairs_are_those_of_their_cameras(bars):
    sets = exact.view_sets(bars, RING.cameras(LAYOUT), depth_axis=(0, 0, 1))
    pairs = np.zeros((4, 4), dtype=bool)
    pairs[0, 2] = pairs[2, 0] = True
    alone = exact.evaluate(bars, RING.cameras([LAYOUT[0], LAYOUT[2]]), depth_axis=(0, 0, 1))
    found = sets.errors(pairs=pairs)
    assert found.weights.sum() == pytest.approx(alone.area, rel=1e-9)
    for error in ("depth", "normal"):
        assert found.rms(error) == pytest.approx(alone.errors.rms(error), rel=1e-6)
    kept = sets.errors(cameras=[True, False, True, False])
    assert kept.rms() == pytest.approx(found.rms(), rel=1e-9)
    assert sets.errors(pairs=~np.eye(4, dtype=bool)).rms() == pytest.approx(sets.errors().rms(), rel=1e-12)


def test_fewer_cameras_than_the_threshold_reconstruct_nothing(problem):
    found = placement.robustness(problem, LAYOUT[:2], n_mountings=1)
    assert found.failed_fractions == (0.0, 0.0)


def test_consensus_of_the_best_layouts(bars):
    result = placement.optimise(bars, RING, 3, settings=QUICK, certify=False)
    found = placement.consensus(result)
    assert found.fractions == tuple(c.fraction for c in result.candidates[:10]) and len(found.fractions) > 3
    by_hand = []
    for camera in result.angles:
        nearest = [
            min(abs((camera - other + np.pi) % (2 * np.pi) - np.pi) for other in candidate.angles)
            for candidate in result.candidates[:10]
            if candidate.angles != result.angles
        ]
        by_hand.append(np.median(nearest))
    assert found.distances == pytest.approx(by_hand, abs=1e-12)
    alone = placement.optimise(bars, RING, 3, settings=QUICK, certify=False, give_up=0.0)
    assert placement.consensus(alone, n_layouts=1).distances == (0.0, 0.0, 0.0)


def test_fewest_cameras(bars):
    found = placement.recommend_count(bars, RING, 0.55, settings=QUICK, max_cameras=9, certify=False)
    assert [c.n_cameras for c in found.counts] == list(range(2, found.counts[-1].n_cameras + 1))
    reached = [c.n_cameras for c in found.counts if c.fraction >= 0.55]
    even = [c.n_cameras for c in found.counts if c.equidistant_fraction >= 0.55]
    assert found.n_cameras == reached[0] and found.n_equidistant == even[0] == found.counts[-1].n_cameras
    assert found.saved == found.n_equidistant - found.n_cameras >= 1
    assert found.placement.n_cameras == found.n_cameras
    for c in found.counts:
        whole = area(bars, RING.equidistant(16))
        assert c.equidistant_fraction == pytest.approx(area(bars, RING.equidistant(c.n_cameras)) / whole, rel=1e-12)
        most = c.placement.most_area.fraction
        assert most >= c.best_equidistant_fraction
        # What reaches the target gives up no more than leaves it reached; what does not gives nothing up.
        assert c.fraction >= max(0.55, most - 0.005) if most >= 0.55 else c.fraction == most
        assert c.placement.error_rms <= c.placement.most_area_error_rms


def test_every_number_has_its_certificate_and_is_told_as_soon_as_it_is_there(problem):
    told = []
    found = placement.recommend(problem, 0.2, Constraints(), range(2, 5), on_count=told.append)
    assert tuple(told) == found.counts and found.n_cameras == 2
    assert all(c.placement.certificate.proven for c in found.counts)


def test_a_target_out_of_reach_and_cameras_that_do_not_fit(bars):
    wide = Constraints(min_separation=25.0)  # at most 3 fit
    found = placement.recommend_count(
        bars, RING, 1.0, constraints=wide, settings=dataclasses.replace(QUICK, n_starts=2), max_cameras=5, certify=False
    )
    assert found.n_cameras is None and found.saved is None and found.placement is None
    assert [c.placement is None for c in found.counts] == [False, False, True, True]
    assert found.counts[-1].fraction is None and found.counts[-1].equidistant_fraction > 0


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (dict(target=0.0), "target is 0.0; it must be a fraction"),
        (dict(target=99), "target is 99"),
        (dict(max_cameras=1), "max_cameras is 1; it must be a whole number, at least 2"),
        (dict(constraints=Constraints(fixed=(0.0, 1.0, 2.0)), max_cameras=2), "at least 3 here"),
        (dict(constraints=Constraints(min_separation=31.0)), "a separation of 31 mm"),
    ],
)
def test_errors(bars, wrong, message):
    with pytest.raises(PlacementError, match=message):
        placement.recommend_count(bars, RING, **{"settings": QUICK, **wrong})
