"""The disparity gradient of a pair of cameras, and what a bound on it leaves."""

import numpy as np
import pytest
import trimesh

import exact

RING = exact.Ring()


def plate(tilt):
    """10 x 10 mm through the focus, turned about y by `tilt` out of the plane of the ring."""
    flat = trimesh.Trimesh([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], [[0, 1, 2], [0, 2, 3]])
    return flat.apply_transform(trimesh.transformations.rotation_matrix(tilt, (0, 1, 0)))


@pytest.mark.parametrize("tilt_deg", [10.0, 45.0, 80.0])
def test_a_tilted_plate_is_matched_up_to_the_tangent(tilt_deg):
    """Across a plane tilted along the baseline b at depth z, 1/z has the slope tan(tilt) / z in the image."""
    tilt = np.radians(tilt_deg)
    cameras = RING.cameras([0.0, np.pi])
    slope = 30.0 / 400.0 * np.tan(tilt)
    for factor, area in ((1 + 1e-9, 100.0), (1 - 1e-9, 0.0)):
        found = exact.evaluate(plate(tilt), cameras, max_disparity_gradient=factor * slope)
        assert found.area == pytest.approx(area, rel=1e-12)
    # Beside a third camera half way, whose pairs have the baseline 15 √2 and a middle at 7.5 mm across: the plane is
    # seen from the same height or from another, by 7.5 mm · sin(tilt) over 400 mm · cos(tilt).
    third = RING.cameras([0.0, np.pi, np.pi / 2])
    near = [15 * np.sqrt(2) / (400 * np.cos(tilt) + side * 7.5 * np.sin(tilt)) for side in (1, -1)]
    views = [np.array([-side * 7.5, -7.5, -400.0]) / np.linalg.norm([7.5, 7.5, 400.0]) for side in (1, -1)]
    normal = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    slopes = [one * np.sqrt(1 - (normal @ view) ** 2) for one, view in zip(near, views, strict=True)]
    least = min(*slopes, slope)
    for factor, area in ((1 + 1e-9, 100.0), (1 - 1e-9, 0.0)):
        found = exact.evaluate(plate(tilt), third, max_disparity_gradient=factor * least)
        assert found.area == pytest.approx(area, rel=1e-12)


def test_the_pair_must_be_far_apart_and_alike_at_once():
    steep, cameras = plate(np.radians(80.0)), RING.cameras([0.0, 0.1, np.pi])
    close, wide = 30 * np.sin(0.05), 30 * np.cos(0.05)
    assert exact.evaluate(steep, cameras, max_disparity_gradient=0.1).area == pytest.approx(100.0)
    assert exact.evaluate(steep, cameras, min_baseline=wide).area == pytest.approx(100.0)
    both = exact.evaluate(steep, cameras, max_disparity_gradient=0.1, min_baseline=1.01 * close)
    assert both.area == 0.0
    assert both.words == (
        "seen by at least 2 cameras, two of them at least 1.514 mm apart, these two with a disparity gradient of at "
        "most 0.1"
    )


def test_turning_and_scaling_change_nothing_and_what_it_leaves_grows_with_it():
    channel = trimesh.creation.annulus(6.0, 8.0, 30.0)
    cameras = RING.cameras([0.2, 0.7, 2.5, 4.0])
    areas = [exact.evaluate(channel, cameras, max_disparity_gradient=one).area for one in (0.2, 1.0, 5.0, 1e6)]
    assert areas == sorted(areas) and areas[0] < 0.9 * areas[-1]
    assert areas[-1] == pytest.approx(exact.evaluate(channel, cameras).area, rel=1e-9)
    turn = trimesh.transformations.random_rotation_matrix(np.array([0.1, 0.5, 0.8]))
    turn[:3, 3] = (30.0, -200.0, 7.0)
    moved = channel.copy().apply_transform(turn)
    found = exact.evaluate(moved, [one.moved(turn) for one in cameras], max_disparity_gradient=1.0)
    assert found.area == pytest.approx(areas[1], rel=1e-9)
    larger = exact.Ring(60.0, 800.0, (72.0, 48.0)).cameras([0.2, 0.7, 2.5, 4.0])
    found = exact.evaluate(channel.copy().apply_scale(2.0), larger, max_disparity_gradient=1.0)
    assert found.area == pytest.approx(4 * areas[1], rel=1e-9)
    # A surface that is painted, and one that is cut by errors too, hold the same.
    sets = exact.view_sets(channel, cameras)
    assert sets.area(max_disparity_gradient=1.0) == pytest.approx(areas[1], rel=1e-9)
    bounded = exact.evaluate(channel, cameras, max_disparity_gradient=1.0, max_error=0.2)
    assert 0 < bounded.area < areas[1]
    assert bounded.area == pytest.approx(
        exact.evaluate(channel, cameras, max_disparity_gradient=1.0).area_to(0.2), rel=1e-6
    )
    assert bounded.to_mesh().area == pytest.approx(bounded.area, rel=1e-6)


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"max_disparity_gradient": 0.0}, "max_disparity_gradient is 0.0; it must be a number, positive"),
        ({"max_disparity_gradient": float("nan")}, "max_disparity_gradient is nan"),
        ({"max_disparity_gradient": "steep"}, "max_disparity_gradient is 'steep'"),
        ({"max_disparity_gradient": 1.0, "threshold": 1}, "with max_disparity_gradient at least 2 cameras are needed"),
    ],
)
def test_what_makes_no_sense_is_refused(asked, words):
    with pytest.raises(exact.ExactError, match=words):
        exact.evaluate(plate(0.0), RING.cameras([0.0]), **({"threshold": 1} | asked))


def test_without_a_derivative_it_says_so():
    with pytest.raises(exact.ExactError, match="leave max_disparity_gradient out"):
        exact.gradient(plate(0.1), RING.cameras([0.0, 1.0]), max_disparity_gradient=1.0)
