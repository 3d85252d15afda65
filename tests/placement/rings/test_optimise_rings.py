"""Which camera sits on which ring: exact, never worse than one ring, as good as an exhaustive search."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

import exact
import placement
from tests.placement.rings.by_hand import QUICK, alone, best_of_three, bound_of, cameras, choices, grid, pit, wall

OUTER, INNER = exact.Ring(), exact.Ring(diameter=16.0, working_distance=380.0, fov=(40.0, 26.0))
SITES = {"wall": wall, "pit": pit}


def optimised(mesh, rings, n_cameras, settings=QUICK, **asked):
    return placement.optimise_rings(mesh, rings, n_cameras, settings=settings, workers=1, **asked)


@pytest.fixture(scope="module", params=SITES)
def site(request):
    return SITES[request.param]()


@pytest.fixture(scope="module")
def found(site):
    return optimised(site, (OUTER, INNER), 3, replace(QUICK, polish_steps=(0.02,)), certify=False)


def test_areas_and_errors_are_those_of_cameras_built_by_hand(site, found):
    layouts = [cameras(found.rings, one.ring_of, one.angles) for one in found.candidates]
    assert [one.area for one in found.candidates] == pytest.approx(exact.areas(site, layouts), rel=1e-9)
    proposed = exact.evaluate(site, cameras(found.rings, found.ring_of, found.angles), depth_axis=(0, 0, 1))
    assert found.area == pytest.approx(proposed.area, rel=1e-9)
    assert found.error_rms == pytest.approx(proposed.error_rms, rel=1e-6)
    everyone = [one for ring in found.rings for one in cameras([ring] * 24, range(24), ring.equidistant(24))]
    maximum = exact.evaluate(site, everyone).area
    assert found.maximum_area == pytest.approx(maximum, rel=1e-9)
    assert found.fraction == pytest.approx(proposed.area / maximum, rel=1e-9)
    for camera, own in zip(found.cameras, cameras(found.rings, found.ring_of, found.angles), strict=True):
        assert np.allclose(camera.position, own.position) and np.allclose(camera.rotation, own.rotation)


def test_no_ring_alone_is_better(site, found):
    singles = alone(found)
    assert [one.ring for one in singles] == [OUTER, INNER] and {one.n_cameras for one in singles} == {3}
    assert found.most_area.area >= max(one.most_area.area for one in singles) * (1 - 1e-12)
    assert found.area >= max(one.area for one in singles) * (1 - 1e-12)
    assert found.fraction >= found.most_area.fraction - found.give_up
    for one, single in zip(found.alone, singles, strict=True):
        even = exact.evaluate(site, cameras([single.ring] * 3, range(3), single.ring.equidistant(3)))
        assert one.equidistant_fraction == pytest.approx(even.area / found.maximum_area, rel=1e-9)
        assert one.best_equidistant_fraction is not None and one.best_equidistant_fraction >= one.equidistant_fraction
        assert one.fraction == pytest.approx(single.area / found.maximum_area, rel=1e-9)


@pytest.mark.parametrize("most", [None, (None, 1)])
def test_an_exhaustive_search_finds_nothing_better(site, most):
    rings = OUTER, INNER
    found = optimised(site, rings, 3, most=most)
    ring_of, angles = grid(rings, 24)
    sets = exact.view_sets(site, cameras(rings, ring_of, angles))
    best = best_of_three(sets, list(choices(rings, ring_of, angles, 3, most=most)))
    assert found.most_area.area >= best * (1 - 1e-9)  # the best layout of the grid is among those scored
    bound = bound_of(found)
    assert bound.bound_fraction * found.maximum_area >= best
    assert bound.fraction == pytest.approx(best / found.maximum_area, rel=3e-5)
    assert bound.proven
    assert bound.gap == pytest.approx(bound.bound_fraction - found.fraction)
    without = max(one.area for one in found.candidates if one.origin != "certificate")
    assert without >= 0.997 * best


def test_one_ring_is_what_optimise_finds(site):
    single = placement.optimise(site, OUTER, 3, settings=QUICK, certify=False, workers=1)
    found = optimised(site, [OUTER], 3, certify=False)
    assert found.most_area.area >= single.most_area.area and found.area >= single.area
    assert alone(found)[0].angles == single.angles
    assert found.maximum_area == single.ring_area
    assert set(found.ring_of) == {0}


def test_the_same_again():
    one, other = (optimised(wall(), (OUTER, INNER), 2) for _ in range(2))
    assert (one.ring_of, one.angles, one.areas) == (other.ring_of, other.angles, other.areas)
    assert one.certificate == other.certificate and one.candidates == other.candidates


def test_a_camera_on_the_axis_looks_into_a_shaft():
    """The floor of a deep shaft is seen from the axis alone, and from the rim of a narrow ring."""
    floor, places = trimesh.creation.box((9, 9, 2)), ((25, 0), (-25, 0), (0, 25), (0, -25))
    mesh = floor
    for x, y in places:
        side = trimesh.creation.box((40, 40, 60))
        side.apply_translation((x, y, 40))
        mesh = mesh + side
    up = mesh.face_normals[:, 2] > 0.5
    axis = exact.Ring(diameter=0.001, working_distance=400.0, fov=(60.0, 60.0))
    wide = exact.Ring(diameter=44.0, fov=(60.0, 60.0))
    exclude = ~up | (mesh.triangles_center[:, 2] > 10)
    found = optimised(mesh, (wide, axis), 3, most=(None, 1), exclude=exclude)
    assert found.alone[1].placement is None and "at most 1 of the 3 cameras" in found.alone[1].refused
    assert found.ring_of == (0, 0, 1)
    assert found.area > 1.1 * alone(found)[0].most_area.area
    own = exact.evaluate(mesh, cameras(found.rings, found.ring_of, found.angles), exclude=exclude)
    assert found.area == pytest.approx(own.area, rel=1e-9)


def test_several_sites_raise_the_worst():
    one, other = wall(), pit()
    found = optimised([one, other], (OUTER, INNER), 4, objective="worst", certify=False)
    own = [exact.evaluate(mesh, cameras(found.rings, found.ring_of, found.angles)).area for mesh in (one, other)]
    assert found.areas == pytest.approx(own, rel=1e-9)
    assert found.fraction == pytest.approx(min(np.array(own) / found.maximum_areas))
    assert found.most_area.fraction >= max(one.fraction for one in found.alone if one.fraction is not None)


@pytest.mark.parametrize(
    "asked",
    [{"max_error": 0.12}, {"min_baseline": 14.0}, {"threshold": 3}, {"threshold": 1},
     {"max_disparity_gradient": 0.3}, {"limits": exact.Limits(max_incidence=1.3), "error": "normal"}],
)  # fmt: skip
def test_what_makes_a_point_count_is_kept(asked):
    mesh = wall()
    found = optimised(mesh, (OUTER, INNER), 3, certify="max_error" not in asked, **asked)
    own = exact.evaluate(mesh, cameras(found.rings, found.ring_of, found.angles), depth_axis=(0, 0, 1), **asked)
    assert found.area == pytest.approx(own.area, rel=1e-9)
    assert found.most_area.area >= max(one.most_area.area for one in alone(found)) * (1 - 1e-12)


def test_faces_lights_and_weights_are_taken():
    mesh = wall()
    about, light = {"exclude": mesh.triangles_center[:, 2] > 16}, (60.0, 0.0, 300.0)
    weights = np.linspace(0.5, 1.5, len(mesh.faces))
    found = optimised(mesh, (OUTER, INNER), 3, certify=False, face_weights=weights, lights=[[light]], **about)
    layout = cameras(found.rings, found.ring_of, found.angles)
    own = exact.evaluate(mesh, layout, weights=weights, lights=[light], **about)
    assert found.area == pytest.approx(own.area, rel=1e-9)


def test_rolls_of_a_ring_are_kept():
    rings = replace(OUTER, roll="tangential"), replace(INNER, roll=0.4)
    found = optimised(wall(), rings, 3, certify=False)
    own = [rings[k].cameras([angle])[0] for k, angle in zip(found.ring_of, found.angles, strict=True)]
    assert found.area == pytest.approx(exact.evaluate(wall(), own).area, rel=1e-9)
