"""Diameter and working distance as variables, with the cameras: more area, no less accurate, constraints kept."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import trimesh

import exact
import placement
from tests.support.scenes import rectangle

RING = exact.Ring(diameter=30.0, working_distance=200.0, fov=(30.0, 24.0))
ANGLES = np.radians([20.0, 150.0, 260.0])
WITHIN: dict[str, Any] = {"diameter": (15.0, 45.0), "working_distance": (150.0, 300.0)}


@pytest.fixture(scope="module")
def trench():
    """A floor between two walls."""
    parts = [((40, 40, 2), (0, 0, -1)), ((2, 40, 20), (8, 0, 10)), ((2, 40, 20), (-8, 0, 10))]
    return trimesh.util.concatenate([trimesh.creation.box(size).apply_translation(at) for size, at in parts])


def error_at_focus(cameras):
    """Of a speck at the focus, which all of them see."""
    return exact.evaluate(rectangle((-1e-3, 1e-3), (-1e-3, 1e-3)), cameras, depth_axis=(0, 0, 1)).error_rms


def test_it_reconstructs_more_as_accurately_and_nothing_near_it_does_better(trench):
    found = placement.refine_ring(trench, RING, ANGLES, **WITHIN)
    start, cameras = RING.cameras(ANGLES), found.ring.cameras(found.angles)
    own = exact.evaluate(trench, cameras, depth_axis=(0, 0, 1))
    assert found.area == pytest.approx(own.area, rel=1e-12) and found.error_rms == pytest.approx(own.error_rms)
    assert found.fraction == pytest.approx(own.area / trench.area)
    assert found.area > 1.03 * exact.evaluate(trench, start).area
    assert error_at_focus(cameras) <= error_at_focus(start) * (1 + 1e-6)
    assert 15 <= found.ring.diameter <= 45 and 150 <= found.ring.working_distance <= 300
    assert replace(found.ring, diameter=30.0, working_distance=200.0) == RING
    rng = np.random.default_rng(0)
    for _ in range(60):
        d, h = (getattr(found.ring, name) * (1 + rng.uniform(-0.02, 0.02)) for name in WITHIN)
        near = replace(found.ring, diameter=np.clip(d, 15, 45), working_distance=np.clip(h, 150, 300))
        moved = near.cameras(np.array(found.angles) + rng.uniform(-0.03, 0.03, 3))
        if error_at_focus(moved) <= error_at_focus(start):
            assert exact.evaluate(trench, moved).area <= 1.003 * found.area


def test_one_camera_over_a_plane_below_the_focus_comes_as_near_as_it_may():
    """Its field of view at the focus stays: the nearer, the wider at the plane."""
    plane = rectangle((-400, 400), (-400, 400), -50.0)
    found = placement.refine_ring(plane, replace(RING, diameter=1.0), [0.3], diameter=(0.5, 2.0),
                                  working_distance=(100.0, 300.0), threshold=1)  # fmt: skip
    assert found.ring.working_distance == pytest.approx(100.0)
    assert found.area == pytest.approx(30.0 * 24.0 * 1.5**2, rel=1e-3)


def test_constraints_and_a_bound_on_the_error_are_kept(trench):
    constraints = placement.Constraints(8.0, fixed=(ANGLES[0],), forbidden=((np.radians(160), np.radians(200)),))
    found = placement.refine_ring(trench, RING, ANGLES, constraints=constraints, max_error=0.08, **WITHIN)
    assert constraints.violations(found.ring, found.angles) == []
    cameras = found.ring.cameras(found.angles)
    own = exact.evaluate(trench, cameras, max_error=0.08, depth_axis=(0, 0, 1))
    assert found.area == pytest.approx(own.area, rel=1e-9)
    start = exact.evaluate(trench, RING.cameras(ANGLES), max_error=0.08, depth_axis=(0, 0, 1))
    assert found.area > start.area


def test_rolls_are_variables_too():
    """Two fixed cameras over a long plate, both some way off its length."""
    plate, ring = rectangle((-60, 60), (-14, 14)), replace(RING, diameter=8.0, roll="free")
    constraints = placement.Constraints(fixed=(0.0, np.pi / 2))
    found = placement.refine_ring(
        plate, ring, [0.0, np.pi / 2], rolls=[np.pi / 2 - 0.3, 0.2], diameter=(8, 8), working_distance=(200, 200),
        constraints=constraints,
    )  # fmt: skip
    assert found.rolls is not None and found.angles == (0.0, np.pi / 2)
    assert found.area == pytest.approx(30.0 * 24.0, rel=1e-2)
    assert found.rolls[0] - found.rolls[1] == pytest.approx(np.pi / 2, abs=0.02)  # both look along one direction
    assert found.area == pytest.approx(exact.evaluate(plate, ring.cameras(found.angles, found.rolls)).area)


def test_refused(trench):
    with pytest.raises(
        placement.PlacementError, match="ring diameter is 30 mm to start with; it must be from 10 to 20"
    ):
        placement.refine_ring(trench, RING, ANGLES, diameter=(10, 20), working_distance=(150, 300))
    with pytest.raises(
        placement.PlacementError, match="does not meet the constraints: two cameras are .* start elsewhere"
    ):
        placement.refine_ring(trench, RING, [0.0, 0.1, 3.0], **WITHIN)
