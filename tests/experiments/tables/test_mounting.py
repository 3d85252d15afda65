"""How much each camera's mounting matters, held against areas of cameras that are mounted a little off."""

import numpy as np
import pytest
import trimesh

import exact
from experiments.tables.mounting import mounting, mounting_content, mounting_table
from experiments.terminal.console import terminal

RING = exact.Ring(fov=(14.0, 14.0))
ANGLES = np.array([0.3, 1.1, 4.0])
STEP = np.radians(1e-3)


@pytest.fixture(scope="module")
def scenes():
    wall = trimesh.util.concatenate(
        [trimesh.creation.box((30, 30, 1)), trimesh.creation.box((1, 9, 14)).apply_translation((1, 0, 8))]
    )
    turned = wall.copy().apply_transform(trimesh.transformations.rotation_matrix(0.4, (0, 0, 1)))
    return [exact.Scene(wall), exact.Scene(turned)]


def area(scenes, cameras):
    return np.mean([exact.evaluate(scene, cameras).area for scene in scenes])


def by_turning(scenes, i, axis):
    """Change of the mean area for a degree by which camera i turns about an axis, from a thousandth to either side."""
    found = []
    for by in (STEP, -STEP):
        cameras = list(RING.cameras(ANGLES))
        old = cameras[i]
        turn = trimesh.transformations.rotation_matrix(by, axis)[:3, :3]
        cameras[i] = exact.Camera(
            old.position, old.rotation @ turn.T, old.target_distance, old.fov, old.resolution
        )  # fmt: skip
        found.append(area(scenes, cameras))
    return (found[0] - found[1]) / 2e-3


def test_a_degree_of_each_mounting(scenes):
    found = mounting(scenes, RING, ANGLES, exact.Demand())
    for i, camera in enumerate(RING.cameras(ANGLES)):
        high, low = (area(scenes, RING.cameras(ANGLES + by * np.eye(3)[i])) for by in (STEP, -STEP))
        assert found.along_ring[i] == pytest.approx((high - low) / 2e-3, rel=1e-4, abs=1e-4)
        right, down, look = camera.rotation
        assert found.roll[i] == pytest.approx(by_turning(scenes, i, look), rel=1e-4, abs=1e-4)
        tilts = [by_turning(scenes, i, axis) for axis in (right, down)]
        assert found.tilt[i] == pytest.approx(np.hypot(*tilts), rel=1e-4, abs=1e-4)
    assert found.tilt.max() > 1.0 and np.abs(found.roll).max() > 0.1


def test_what_is_shown_is_what_was_found(scenes, capsys):
    found = mounting(scenes, RING, ANGLES, exact.Demand())
    content = mounting_content(found, ANGLES)
    assert [row["ring_angle_deg"] for row in content] == np.degrees(ANGLES).tolist()
    assert [row["tilt_mm2_per_deg"] for row in content] == found.tilt.tolist()
    terminal().print(mounting_table(found, ANGLES))
    shown = capsys.readouterr().out
    assert f"{found.along_ring[0]:+.2f}" in shown and f"{found.tilt[2]:.2f}" in shown


def test_with_a_bounded_error_there_is_none(scenes):
    assert mounting(scenes, RING, ANGLES, exact.Demand(max_error=0.1)) is None
