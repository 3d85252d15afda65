"""How sensors are turned about their optical axes: by the rule of a ring, or each by a roll of its own."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

import exact
from placement.samples.profiles import Visibility
from placement.samples.sampling import sample_surface
from tests.support.scenes import AWKWARD

ANGLES = np.array([0.0, 0.4, 2.0, 3.3, 5.9])
RINGS = [exact.Ring(), exact.Ring(45.0, 80.0, (30.0, 12.0), (3.0, -4.0, 5.0), (0.3, -0.4, -0.9))]


def azimuth(ring, direction):
    """Of a direction, as ring angles are counted."""
    x, y, _ = direction @ ring.frame
    return np.arctan2(y, x)


@pytest.mark.parametrize("ring", RINGS)
def test_tangential_sensors_lie_a_quarter_turn_from_radial_ones(ring):
    for radial, turned in zip(ring.cameras(ANGLES), replace(ring, roll="tangential").cameras(ANGLES), strict=True):
        assert np.array_equal(turned.position, radial.position)
        expected = [radial.rotation[1], -radial.rotation[0], radial.rotation[2]]
        assert turned.rotation == pytest.approx(np.array(expected), abs=1e-15)


@pytest.mark.parametrize("ring", RINGS)
@pytest.mark.parametrize("along", [0.0, 1.0, -2.5])
def test_one_direction_for_all_is_where_the_width_of_every_image_lies(ring, along):
    ring = replace(ring, roll=along)
    direction = ring.frame @ [np.cos(along), np.sin(along), 0]
    for camera in ring.cameras(ANGLES):
        # As far as the direction is across the optical axis it is all along the width, and none of it along the height.
        assert camera.rotation[0] @ direction > 0 and camera.rotation[1] @ direction == pytest.approx(0, abs=1e-14)
    (above,) = replace(ring, diameter=1e-6).cameras([0.7])
    assert azimuth(ring, above.rotation[0]) == pytest.approx(along, abs=1e-6)


@pytest.mark.parametrize("roll", ["radial", "tangential", 0.6])
def test_rolls_of_a_ring_give_its_cameras_from_a_radial_one(roll):
    ring = replace(RINGS[1], roll=roll)
    given = RINGS[1].cameras(ANGLES, rolls=ring.rolls(ANGLES))
    for camera, again in zip(ring.cameras(ANGLES), given, strict=True):
        assert np.array_equal(camera.rotation, again.rotation)


def test_a_roll_turns_clockwise_as_the_camera_looks():
    ring, roll = RINGS[1], 0.3
    (camera,) = ring.cameras([2.0], rolls=[roll])
    (radial,) = ring.cameras([2.0])
    about = trimesh.transformations.rotation_matrix(roll, radial.rotation[2])[:3, :3]
    assert camera.rotation == pytest.approx(radial.rotation @ about.T, abs=1e-14)
    # What was to the right of the middle comes to lie above it: the image turns against the camera.
    right = radial.rotation[0] + np.array(ring.focus)
    assert camera.project([right])[0, 1] < camera.resolution[1] / 2


def test_half_a_turn_changes_no_area():
    scene, ring = exact.Scene(AWKWARD["channel"]()), exact.Ring(60.0, 120.0, (30.0, 12.0))
    rolls = np.array([0.0, 0.5, -1.0, 2.0, 0.1])
    one, other = (exact.evaluate(scene, ring.cameras(ANGLES, rolls=rolls + by)).area for by in (0.0, np.pi))
    assert one == pytest.approx(other, rel=1e-12)


def test_a_square_field_of_view_does_not_care_for_quarter_turns():
    scene = exact.Scene(AWKWARD["channel"]())
    areas = [
        exact.evaluate(scene, exact.Ring(60.0, 120.0, (20.0, 20.0), roll=roll).cameras(ANGLES)).area
        for roll in ("radial", "tangential")
    ]
    assert areas[0] == pytest.approx(areas[1], rel=1e-12)


@pytest.mark.parametrize("roll", ["tangential", 0.9])
def test_samples_are_seen_as_the_cameras_project_them(roll):
    plate = trimesh.creation.box((60, 60, 1))
    samples = sample_surface(plate, 2000, exclude=plate.face_normals[:, 2] < 0.5)
    ring = exact.Ring(roll=roll)
    seen = Visibility(plate).from_angles(samples, ring, ANGLES)
    for camera, found in zip(ring.cameras(ANGLES), seen, strict=True):
        pixels = camera.project(samples.points)
        assert np.array_equal(found, ((pixels >= 0) & (pixels <= camera.resolution)).all(axis=1))
        assert 0 < found.sum() < len(found)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: exact.Ring(roll="upright"), r"roll is 'upright'; it must be \"radial\", .* or a number \[rad\]"),
        (lambda: exact.Ring(roll=None), r"roll is None; it must be \"radial\", "),
        (lambda: exact.Ring(roll=np.nan), r"roll is nan; it must be from"),
        (lambda: exact.Ring().cameras([0.0, 1.0], rolls=[0.0]), r"rolls are .*; they must be 2 numbers"),
        (lambda: exact.Ring().cameras([0.0], rolls=[np.inf]), r"rolls are .*; they must be 1 numbers"),
        (lambda: exact.Ring().cameras([0.0], rolls="flat"), r"rolls are 'flat'; they must be 1 numbers"),
    ],
)
def test_impossible_rolls(make, message):
    with pytest.raises(exact.ExactError, match=message):
        make()
