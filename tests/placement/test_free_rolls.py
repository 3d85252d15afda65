"""Free rolls: what is found is exact, keeps the constraints, and leaves nothing that an exhaustive search finds."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
import trimesh

import exact
import meshes
import placement
from placement.layouts.arcs import LayoutSpace
from placement.samples.rolled_samples import RolledSamples, canonical_rolled
from placement.search.rolled_coverage import RolledCoverage, RolledLayout
from placement.search.rolled_search import rolled_search
from tests.support.scenes import rectangle

FREE = exact.Ring(roll="free")
QUICK = placement.Settings(
    n_samples=600, n_angles=36, n_starts=4, n_start_phases=2, temperatures=(0.2,),
    n_phases=4, exact_phases=1, exact_candidates=2, n_grid=72,
    ring_cameras=12, polish_steps=(0.02,),
)  # fmt: skip
# 100 mm long and 30 mm wide, in the focus.
PLATE = rectangle((-50, 50), (-15, 15))


def problem(mesh, ring=FREE, **asked):
    return placement.Problem(mesh, ring, settings=QUICK, workers=1, **asked)


def test_two_fixed_cameras_are_turned_along_the_plate():
    """A quarter of the ring apart, one of two radial ones looks across it, and they share 24 x 24 mm."""
    constraints = placement.Constraints(fixed=(0.0, np.pi / 2))
    narrow = replace(FREE, diameter=8.0)
    found = problem(PLATE, narrow).optimise(2, constraints, certify=False)
    radial = problem(PLATE, replace(narrow, roll="radial")).optimise(2, constraints, certify=False)
    assert radial.rolls is None and radial.area == pytest.approx(24.0 * 24.0, rel=1e-2)
    assert found.area == pytest.approx(36.0 * 24.0, rel=1e-2)
    assert np.degrees(found.angles) == pytest.approx([0, 90]) and found.equidistant_area > 0
    # Along x: a quarter turn of the camera at ring angle 0, none of the other.
    assert np.abs(np.sin(np.array(found.rolls) - [np.pi / 2, 0])) == pytest.approx(0, abs=0.05)


@pytest.mark.parametrize(
    "asked",
    [
        {"threshold": 3}, {"min_baseline": 12.0}, {"max_error": 0.12}, {"threshold": 1},
        {"limits": exact.Limits(max_incidence=1.3), "error": "normal"},
    ],
)  # fmt: skip
def test_areas_are_exact_constraints_are_kept_and_no_radial_layout_is_better(asked):
    parts = [trimesh.creation.box((50, 20, 2)), trimesh.creation.box((4, 20, 20)).apply_translation((9, 0, 8))]
    mesh = trimesh.boolean.union(parts, engine="manifold")
    constraints = placement.Constraints(6.0, fixed=(0.5,), forbidden=((2.0, 3.5),))
    found = problem(mesh, **asked).optimise(3, constraints, certify=False)
    radial = problem(mesh, replace(FREE, roll="radial"), **asked).optimise(3, constraints, certify=False)
    assert found.rolls is not None and len(found.rolls) == 3 and found.certificate is None
    assert constraints.violations(FREE, found.angles) == []
    for one in (found, *found.candidates):
        assert constraints.violations(FREE, one.angles) == []
        own = exact.evaluate(mesh, FREE.cameras(one.angles, one.rolls), demand=found.demand)
        assert one.area == pytest.approx(own.area, rel=1e-9)
    again = exact.evaluate(mesh, FREE.cameras(found.angles, found.rolls), demand=found.demand)
    if found.threshold > 1:
        assert found.error_rms == pytest.approx(again.error_rms, rel=1e-9)
    assert found.most_area.area >= radial.most_area.area
    assert found.ring_area == radial.ring_area and found.equidistant_area == radial.equidistant_area
    assert found.fraction >= found.most_area.fraction - found.give_up


def test_one_layout_for_two_sites_raises_the_worst():
    turned = PLATE.copy().apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, (0, 0, 1)))
    found = problem([PLATE, turned], objective="worst").optimise(4, certify=False)
    areas = [exact.evaluate(mesh, FREE.cameras(found.angles, found.rolls)).area for mesh in (PLATE, turned)]
    assert [site.area for site in found.sites] == pytest.approx(areas)
    maxima = [site.ring_area for site in found.sites]
    assert found.fraction == pytest.approx(min(np.array(areas) / maxima))


@pytest.fixture(scope="module")
def sampled():
    mesh = meshes.site("elliptical", depth=50, detail="coarse")
    asked = problem(exact.Scene(mesh, exclude=meshes.top_surface(mesh)))
    return asked, RolledSamples.of(asked.sampled, asked.sites, FREE, asked.demand)


def test_views_of_the_grid_are_those_of_the_cameras_one_by_one(sampled):
    _, samples = sampled
    angles, rolls = np.array([0.3, 1.7, 4.0]), np.array([0.0, 0.9, 2.2])
    views = samples.views(angles, rolls)
    every = list(itertools.product(angles, rolls))
    assert np.array_equal(np.column_stack([views.angles, views.rolls]), every)
    points = np.concatenate([part.points for part, _ in samples.parts])
    for number, (angle, roll) in enumerate(every):
        assert np.array_equal(views.seen[:, number] > 0, samples.seen([angle], [roll])[0])
        (camera,) = FREE.cameras([angle], [roll])
        pixels = camera.project(points[views.seen[:, number] > 0])
        assert ((pixels >= 0) & (pixels <= camera.resolution)).all()


def test_nothing_is_left_to_gain_on_a_grid_of_15_degrees(sampled):
    """Two cameras: all pairs of places and rolls, counted point by point."""
    asked, samples = sampled
    space = LayoutSpace(FREE, 2, placement.Constraints())
    found = rolled_search(asked, space, RolledCoverage(samples, asked.demand), [np.array([0.0, 3.0])])[0]
    places = list(itertools.product(np.radians(range(0, 360, 15)), np.radians(range(0, 180, 15))))
    seen = samples.seen(*np.transpose(places))
    separation = FREE.separations(np.transpose(places)[0])
    best = max(
        float(samples.weights[seen[i] & seen[j]].sum())
        for i, j in itertools.combinations(range(len(places)), 2) if separation[i, j] >= 5.0
    )  # fmt: skip
    both = samples.seen(*found).all(axis=0)
    assert float(samples.weights[both].sum()) >= best
    radial = RolledLayout(np.radians([145.0, 325.0]), np.zeros(2))
    assert best > RolledCoverage(samples, asked.demand).worth(radial) + 0.06


def test_the_same_layout_in_one_form():
    angles, rolls = canonical_rolled([7.0, -0.1, 2.0], [0.1, np.pi / 2, -np.pi / 2 - 0.2])
    assert angles == pytest.approx([7.0 - 2 * np.pi, 2.0, 2 * np.pi - 0.1])
    assert rolls == pytest.approx([0.1, np.pi / 2 - 0.2, np.pi / 2])


def test_what_is_not_known_for_free_rolls_is_refused():
    asked = problem(PLATE)
    for question in (asked.certify, asked.tradeoff):
        with pytest.raises(placement.PlacementError, match=r'for given rolls only.*ask with roll="radial"'):
            question(3)


def test_counting_with_free_rolls_takes_no_more_cameras():
    found = problem(PLATE).count(0.9, certify=False, max_cameras=4)
    assert found.placement is not None and found.placement.rolls is not None
    radial = problem(PLATE, replace(FREE, roll="radial")).count(0.9, certify=False, max_cameras=4)
    assert found.n_cameras is not None and found.n_cameras <= (radial.n_cameras or 5)
