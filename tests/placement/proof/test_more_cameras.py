"""One camera more is never worse: what is known of fewer cameras is not lost, and bounds of more hold for fewer."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

import exact
import placement
from placement import Constraints, PlacementError, Settings
from placement.layouts.arcs import LayoutSpace

RING = exact.Ring()
# So little that a search by itself is poor.
POOR = Settings(
    n_samples=300, n_angles=36, n_starts=1, n_start_phases=1, n_pair_searches=1, n_grid=24, exact_candidates=1,
    exact_phases=1, n_phases=1, ring_cameras=16, polish_steps=(), certificate_step=float(np.radians(15)),
)  # fmt: skip
GOOD = replace(POOR, n_samples=2000, n_starts=12, n_grid=360, exact_candidates=4)


@pytest.fixture(scope="module")
def walls():
    parts = [trimesh.creation.box((30, 30, 1))]
    parts += [trimesh.creation.box((1, 12, 14)).apply_translation((x, y, 8)) for x, y in ((-6, 4), (1, -3), (7, 5))]
    return trimesh.util.concatenate(parts)


def optimised(mesh, n_cameras, settings, **asked):
    return placement.optimise(mesh, RING, n_cameras, settings=settings, certify=False, give_up=0.0, workers=1, **asked)


def test_a_known_layout_of_fewer_cameras_is_not_lost(walls):
    known = optimised(walls, 4, GOOD)
    alone = optimised(walls, 5, POOR)
    found = optimised(walls, 5, POOR, starts=[known.angles])
    assert found.area >= known.area and found.area >= alone.area
    assert found.starts == (known.angles,) and alone.starts == ()
    (made_up,) = [one for one in found.candidates if one.origin == "start"]
    assert set(known.angles) < set(made_up.angles)
    assert exact.evaluate(walls, RING.cameras(made_up.angles)).area == pytest.approx(made_up.area, rel=1e-12)


def test_known_layouts_leave_room_for_what_is_found_without_them(walls):
    """The best layout of three cameras and one more, wherever it sits, is 7 % worse here than the best of four."""
    settings = replace(GOOD, n_angles=36, n_grid=120, exact_candidates=2, polish_steps=(0.02,), polish_candidates=1)
    known = optimised(walls, 3, settings)
    alone = optimised(walls, 4, settings)
    found = optimised(walls, 4, settings, starts=[known.angles])
    assert found.area >= alone.area - 1e-3


def test_a_layout_of_as_many_cameras_is_a_start_as_it_is(walls):
    known = optimised(walls, 4, GOOD)
    found = optimised(walls, 4, POOR, starts=[known.angles])
    assert found.area >= known.area


def test_what_leaves_no_room_or_breaks_a_constraint_is_left_out(walls):
    wide = Constraints(min_separation=24.0)  # 106 degrees: none fits beside two that face each other
    for n_cameras, start in ((3, [0.0, np.pi]), (2, [0.0, 1.0])):
        found = optimised(walls, n_cameras, POOR, starts=[start], constraints=wide)
        assert not [one for one in found.candidates if one.origin == "start"]


@pytest.mark.parametrize("start", [[], [0.0, np.nan], [0.0, 1.0, 2.0, 3.0], [[0.0, 1.0]]])
def test_a_start_that_is_no_layout_is_refused(walls, start):
    with pytest.raises(PlacementError, match="start 2 is .*has 1 to 3 finite ring angles"):
        optimised(walls, 3, POOR, starts=[[0.0], start])


def test_areas_and_bounds_grow_with_the_cameras(walls):
    settings = replace(POOR, certificate_seconds=3.0)
    found = placement.recommend_count(walls, RING, 1.0, settings=settings, max_cameras=7, workers=1)
    areas = [one.placement.most_area.area for one in found.counts]
    certificates = [one.placement.certificate for one in found.counts]
    assert len(areas) >= 4 and areas == sorted(areas)
    bounds = [one.bound_fraction for one in certificates]
    assert bounds == sorted(bounds)
    for one in certificates:
        assert one.gap == pytest.approx(one.bound_fraction - one.layout_fraction)
        assert one.grid_bound_fraction <= one.bound_fraction and one.grid_gap <= one.gap


def test_room_for_one_more_is_told_for_every_layout():
    assert LayoutSpace(RING, 9, Constraints()).leaves_room
    assert not LayoutSpace(RING, 10, Constraints()).leaves_room  # ten take up to 20 gaps of 19.2 degrees
    assert not LayoutSpace(RING, 4, Constraints(forbidden=((0.0, 4.0),))).leaves_room
    assert LayoutSpace(RING, 4, Constraints(min_separation=0.0, forbidden=((0.0, 6.0),))).leaves_room
    rng, grid, told = np.random.default_rng(0), np.radians(np.arange(0, 360, 0.1)), 0
    for _ in range(60):
        fixed = tuple(rng.uniform(0, 1) + np.array([0.0, 2.5])[: rng.integers(0, 3)])
        forbidden = ((4.0, 4.0 + rng.uniform(0.1, 2.0)),)[: rng.integers(0, 2)]
        limits = Constraints(rng.uniform(1, 8), fixed=fixed, forbidden=forbidden)
        try:
            space = LayoutSpace(RING, int(rng.integers(2, 7)), limits)
        except PlacementError:
            continue
        told += space.leaves_room
        for _ in range(20 * space.leaves_room):
            assert space.allowed(grid, space.random(rng)).any()
    assert told > 10
