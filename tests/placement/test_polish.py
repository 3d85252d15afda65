"""Layouts end in local optima of the exact area, at smooth ones, at kinks, and where a constraint stops them."""

import numpy as np
import pytest
import trimesh

import exact
import placement
from placement import Constraints, Settings
from placement.layouts.arcs import LayoutSpace
from placement.search.polish import Slopes, polish
from placement.sites import checked_sites

RING = exact.Ring()
RING_AREA = 2000.0


@pytest.fixture(scope="module")
def walls():
    parts = [trimesh.creation.box((30, 30, 1))]
    parts += [trimesh.creation.box((1, 20, 14)).apply_translation((x, 0, 8)) for x in (-6, 1, 7)]
    return trimesh.util.concatenate(parts)


def slopes_of(meshes, objective="mean", **asked):
    sites = checked_sites(meshes, objective=objective)
    return Slopes.of(sites, RING, exact.Demand(**asked), [RING_AREA] * len(sites.members))


def best_move(meshes, angles, space, **asked):
    """The most that a single camera gains by a move of up to a degree, of the mean of `RING_AREA`, by `evaluate`."""
    meshes = meshes if isinstance(meshes, list) else [meshes]

    def fraction(layout):
        return np.mean([exact.evaluate(one, RING.cameras(layout), **asked).area for one in meshes]) / RING_AREA

    start, gains = fraction(angles), [-1.0]
    for camera in space.free_cameras(angles):
        for by in np.radians([0.003, 0.02, 0.1, 0.23, 0.4, 0.7, 1.0]):
            for moved in (angles + by * np.eye(len(angles))[camera], angles - by * np.eye(len(angles))[camera]):
                gains += [fraction(moved) - start] if space.allows(moved) else []
    return max(gains)


def test_it_ends_where_no_camera_gains(walls):
    space, start = LayoutSpace(RING, 3, Constraints()), np.array([0.1, 0.5, 0.9])
    end, n_tried = polish(slopes_of(walls), space, start, 20, thorough=True)
    assert best_move(walls, start, space) > 1e-4 and n_tried > 30
    assert best_move(walls, end, space) < 1e-5
    assert exact.evaluate(walls, RING.cameras(end)).area > exact.evaluate(walls, RING.cameras(start)).area + 50


def test_it_keeps_what_a_layout_must(walls):
    limits = Constraints(min_separation=8.0, fixed=(0.2,), forbidden=((2.0, 2.6),))
    space, start = LayoutSpace(RING, 4, limits), np.array([0.2, 1.99, 2.61, 4.0])
    end, _ = polish(slopes_of(walls), space, start, 20, thorough=True)
    assert space.allows(end) and 0.2 in end
    assert best_move(walls, end, space) < 1e-5
    slope = exact.gradient(walls, RING.cameras(end)).on_ring(RING).angle
    # Somebody would go on if it were allowed to.
    assert np.abs(slope).max() > 1.0


class Landscape:
    """A fraction over the angle of a single camera: a low hill at 0.3°, and from a cliff at 1.2° on it falls slowly."""

    def of_all(self, angles):
        fraction, slope = self.at(float(angles[0]))
        return fraction, np.array([slope])

    def at(self, angle):
        at = np.degrees(angle)
        if at < 1.2:
            return 0.5 + 5e-7 * (1 - (at / 0.3 - 1) ** 2), np.degrees(-1e-6 * (at / 0.3 - 1) / 0.3)
        return 0.5 + 2e-5 - 1e-5 * (at - 1.2), np.degrees(-1e-5)

    def jumps(self, angles, camera, faces):
        return np.zeros(0)

    def in_turn(self, angles, cameras, move):
        angle = move(angles, 0, self.at)
        return angles if angle is None else np.array([angle])


def test_what_comes_within_a_degree_by_a_move_is_looked_at_too():
    end, _ = polish(Landscape(), LayoutSpace(RING, 1, Constraints()), [0.0], 8, thorough=True)
    assert Landscape().of_all(end)[0] > 0.5 + 1.8e-5


def test_several_sites_with_a_baseline_and_the_worst_of_them(walls):
    meshes = [walls, walls.copy().apply_transform(trimesh.transformations.rotation_matrix(0.5, (0, 0, 1)))]
    space, start = LayoutSpace(RING, 2, Constraints()), np.array([0.1, 1.5])
    mean = slopes_of(meshes, min_baseline=12.0)
    end, _ = polish(mean, space, start, 20)
    assert best_move(meshes, end, space, min_baseline=12.0) < 2e-5
    worst = slopes_of(meshes, "worst", min_baseline=12.0)
    other, _ = polish(worst, space, start, 20)
    assert worst.of_all(other)[0] > max(worst.of_all(start)[0], worst.of_all(end)[0] - 1e-6)
    assert worst.of_all(other)[0] == min(
        exact.evaluate(one, RING.cameras(other), min_baseline=12.0).area / RING_AREA for one in meshes
    )


def test_where_a_face_comes_into_sight_is_known(walls):
    """The wall over x = -6 shows its side at x = -5.5 to cameras beyond that plane, all at once."""
    at = np.arccos(-5.5 / 15)
    (offset,) = slopes_of(walls, threshold=1).jumps(np.array([at + 0.01]), 0, faces=True)
    assert offset == pytest.approx(-0.01, abs=1e-6)
    before, after = (exact.evaluate(walls, RING.cameras([at + by]), threshold=1).area for by in (1e-7, offset + 0.01))
    assert after > before + 100
    assert not len(slopes_of(walls, threshold=1).jumps(np.array([at + 0.01]), 0, faces=False))


def test_slopes_are_those_of_the_fraction(walls):
    slopes, layout = slopes_of(walls), np.array([0.3, 1.1, 4.0])
    fraction, slope = slopes.of_all(layout)
    assert fraction == exact.evaluate(walls, RING.cameras(layout)).area / RING_AREA
    own = {}

    def looked_at(angles, camera, along):
        own[camera] = along(angles[camera])

    assert slopes.in_turn(layout, [2, 0, 1], looked_at).tolist() == layout.tolist() and list(own) == [2, 0, 1]
    for camera, (value, alone) in own.items():
        assert (value, alone) == pytest.approx((fraction, slope[camera]), rel=1e-10)
        step = 1e-5 * np.eye(3)[camera]
        high, low = (slopes.of_all(layout + by)[0] for by in (step, -step))
        assert alone == pytest.approx((high - low) / 2e-5, rel=1e-5, abs=1e-7)


def test_leading_candidates_are_polished_whatever_the_number_of_processes(walls):
    quick = Settings(
        n_samples=400, n_angles=36, n_starts=2, n_start_phases=1, exact_candidates=2, exact_phases=1, n_phases=4,
        ring_cameras=8, polish_candidates=2,
    )  # fmt: skip
    one, two = (
        placement.optimise(walls, RING, 3, settings=quick, certify=False, give_up=0.0, workers=n) for n in (1, 2)
    )
    assert one.angles == two.angles and one.candidates == two.candidates
    ends = [found for found in one.candidates if found.origin == "polish"]
    assert len(ends) >= 2 and one.most_area is ends[0] and one.search.n_moves > 20
    space = LayoutSpace(RING, 3, one.constraints)
    gained = best_move(walls, np.array(one.angles), space) * RING_AREA / one.ring_area
    assert gained < 1e-5
    assert one.fraction > max(found.fraction for found in one.candidates if found.origin != "polish")


def test_a_bounded_error_is_polished_without_derivatives(walls):
    quick = Settings(
        n_samples=400, n_angles=36, n_starts=2, n_start_phases=1, exact_candidates=1, exact_phases=1, ring_cameras=8,
        polish_candidates=1, polish_sweeps=1,
    )  # fmt: skip
    found = placement.optimise(walls, RING, 2, settings=quick, certify=False, max_error=0.09)
    assert found.search.n_moves > 0 and 0 < found.fraction < 1
