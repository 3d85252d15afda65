"""Ways to share work among layouts give what evaluating each by itself gives."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import exact
from exact.one_more import in_turn
from tests.support.random_requests import MESHES, close, few, mesh_names, request, seeds

thresholds = st.integers(1, 3)


def counted(rng, mesh):
    """Some faces that do not count, and weights of the others."""
    return rng.random(len(mesh.faces)) < 0.2, rng.uniform(0, 2, len(mesh.faces))


@few
@given(mesh_names, seeds, thresholds, st.booleans())
def test_one_more_camera(name, seed, threshold, with_baseline):
    check_one_more(name, seed, threshold, with_baseline)


@few
@given(mesh_names, seeds, thresholds, st.booleans(), st.floats(1e-3, 1e3))
def test_one_more_camera_with_similar_images(name, seed, threshold, with_baseline, steepest):
    check_one_more(name, seed, max(threshold, 2), with_baseline, max_disparity_gradient=steepest)


def check_one_more(name, seed, threshold, with_baseline, **more):
    rng, mesh, cameras = request(seed, name, 5)
    exclude, weights = counted(rng, mesh)
    apart = np.linalg.norm(cameras[0].position - cameras[1].position) if with_baseline else 0.0
    asked = dict(threshold=threshold, exclude=exclude, min_baseline=apart, weights=weights, **more)
    others = exact.OneMore(mesh, cameras[:3], **asked)
    for camera in cameras[3:]:
        alone = exact.evaluate(mesh, [*cameras[:3], camera], **asked)
        assert close(others.area(camera), alone.area, mesh)


@settings(few, max_examples=8)
@given(mesh_names, seeds, thresholds, st.booleans(), st.booleans(), st.integers(2, 6))
def test_cameras_that_move_in_turn(name, seed, threshold, with_baseline, with_more, n_cameras):
    """Each sees where those before it went, and the area is that of all of them as they are at its turn."""
    rng, mesh, cameras = request(seed, name, n_cameras + 3)
    exclude, weights = counted(rng, mesh)
    apart = float(np.linalg.norm(cameras[0].position - cameras[1].position)) if with_baseline else 0.0
    steepest = {"max_disparity_gradient": 0.5} if with_more and threshold > 1 else {}
    limits = exact.Limits(max_incidence=1.2) if with_more else exact.Limits()
    demand = exact.Demand(min(threshold, n_cameras), apart, limits=limits, **steepest)
    scenes = [exact.Scene(mesh, exclude, weights), exact.Scene(mesh, lights=((5.0, 8.0, 300.0),))]
    now, new = list(cameras[:n_cameras]), list(cameras[n_cameras:])
    which = rng.permutation(n_cameras)[: rng.integers(1, n_cameras + 1)].tolist()
    had = []

    def turn(k, layouts):
        had.append(k)
        for one in (now[k], new[0]):
            for scene, layout in zip(scenes, layouts, strict=True):
                every = [*now[:k], one, *now[k + 1 :]]
                assert close(layout.area(one), exact.evaluate(scene, every, demand=demand).area, mesh)
        if not new[1:]:
            return None
        now[k] = new.pop(0)
        return now[k]

    moved = in_turn(scenes, cameras[:n_cameras], demand, which, turn)
    assert had == which and list(moved) == now


@settings(few, max_examples=6)
@given(mesh_names, seeds, thresholds, st.booleans(), st.sampled_from(["depth", "normal"]))
def test_one_more_view(name, seed, threshold, with_limits, error):
    rng, mesh, cameras = request(seed, name, 5)
    exclude, weights = counted(rng, mesh)
    limits = exact.Limits(max_incidence=1.2) if with_limits else exact.Limits()
    asked = dict(threshold=threshold, exclude=exclude, weights=weights, limits=limits, error=error)
    bounded = asked
    if threshold > 1:
        largest = exact.evaluate(mesh, cameras[:4], **asked).error_quantiles([0.5])[0]
        bounded = asked if np.isnan(largest) else asked | {"max_error": largest}
    for demand in (asked, bounded):
        others = exact.OneMoreView(mesh, cameras[:3], **demand)
        for camera in (cameras[4], cameras[3]):
            alone = exact.evaluate(mesh, [*cameras[:3], camera], **demand)
            seen = others.seen(camera)
            assert close(seen.sets.area(), alone.area, mesh)
            assert close(seen.errors.weights.sum(), alone.area, mesh)
            drawn = seen.to_mesh()
            is_met, factor = drawn.face_attributes["met"], weights[drawn.face_attributes["parent"]]
            assert close(drawn.area_faces[is_met] @ factor[is_met], alone.area, mesh)
            if threshold > 1 and alone.area > 1e-6 * mesh.area:
                assert seen.errors.rms(error) == pytest.approx(alone.error_rms, rel=1e-6)


def test_one_more_camera_and_no_other():
    mesh = MESHES["channel"]
    _, _, (camera, other) = request(3, "channel", 2)
    nobody = exact.OneMore(mesh, [], threshold=1)
    assert nobody.area(camera) == pytest.approx(exact.view(mesh, camera).area)
    assert nobody.area(other) == pytest.approx(exact.view(mesh, other).area)
    assert exact.OneMoreView(mesh, [], threshold=1).seen(camera).sets.area() == pytest.approx(nobody.area(camera))


@few
@given(mesh_names, seeds)
def test_view_sets_give_every_threshold_every_failure_and_every_pair(name, seed):
    rng, mesh, cameras = request(seed, name, 4)
    exclude, weights = counted(rng, mesh)
    sets = exact.view_sets(mesh, cameras, exclude=exclude, weights=weights)
    assert len(np.unique(sets.seen, axis=0)) == len(sets.seen) and sets.seen.any(axis=1).all()
    scene = exact.Scene(mesh, exclude, weights)
    for level, area in enumerate(exact.evaluate(scene, cameras, threshold=4).level_areas, start=1):
        assert close(sets.area(threshold=level), area, mesh)
    for kept in itertools.combinations(range(4), 3):
        some = [cameras[i] for i in kept]
        alone = exact.evaluate(scene, some, threshold=2).area
        assert close(sets.area(threshold=2, cameras=np.isin(np.arange(4), kept)), alone, mesh)
    parts = sets.to_mesh()
    factor = weights[parts.face_attributes["parent"]]
    drawn = np.bincount(parts.face_attributes["set"] + 1, parts.area_faces * factor, len(sets.seen) + 1)
    assert close(drawn[1:], sets.areas, mesh)
    assert close(parts.area, mesh.area_faces[~exclude].sum(), mesh)
    far = np.array([[np.linalg.norm(a.position - b.position) for a in cameras] for b in cameras])
    apart = np.median(far[far > 0])
    with_baseline = exact.evaluate(scene, cameras, min_baseline=apart).area
    assert close(sets.area(threshold=2, far=far >= apart * (1 - 1e-12)), with_baseline, mesh)
    assert close(sets.area(min_baseline=apart), with_baseline, mesh)


@pytest.mark.parametrize("workers", [1, 2])
def test_areas_of_many_layouts_are_those_of_each_to_the_last_bit(workers):
    mesh = MESHES["channel"]
    exclude, weights = counted(np.random.default_rng(0), mesh)
    _, _, cameras = request(5, "channel", 9)
    layouts = [cameras[:3], cameras[3:5], cameras[5:]]
    steps = []
    found = exact.areas(mesh, layouts, exclude=exclude, weights=weights, workers=workers, report=steps.append)
    assert found.tolist() == [exact.evaluate(mesh, one, exclude=exclude, weights=weights).area for one in layouts]
    assert steps == [1, 1, 1]
    assert exact.areas(mesh, [], workers=workers).tolist() == []


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda mesh, some: exact.OneMore(mesh, some, threshold=4), "threshold is 4 with 3 cameras"),
        (lambda mesh, some: exact.OneMore(mesh, some, min_baseline=-1), "min_baseline is -1"),
        (lambda mesh, some: exact.OneMore(mesh, some).area("here"), "a camera is a str"),
        (lambda mesh, some: exact.areas(mesh, [some, some[:1]], threshold=2), "threshold is 2 with 1 camera;"),
        (lambda mesh, some: exact.areas(mesh, [some], workers=0), "workers is 0"),
        (lambda mesh, some: exact.view_sets(mesh, []), "there are no cameras"),
    ],
)
def test_refusals(ask, message):
    _, mesh, cameras = request(1, "channel", 2)
    with pytest.raises(exact.ExactError, match=message):
        ask(mesh, cameras)
