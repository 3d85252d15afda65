"""What must hold for every mesh and every set of cameras."""

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

import exact
from tests.support.random_requests import MESHES, RELATIVE, close, few, mesh_names, request, ring_of, seeds
from tests.support.scenes import together


@few
@given(mesh_names, seeds)
def test_moving_everything_together_changes_nothing(name, seed):
    rng, mesh, cameras = request(seed, name)
    rigid = trimesh.transformations.random_rotation_matrix(rng.random(3))
    rigid[:3, 3] = rng.uniform(-1e3, 1e3, 3)
    before = exact.evaluate(mesh, cameras, threshold=2)
    after = exact.evaluate(mesh.copy().apply_transform(rigid), [c.moved(rigid) for c in cameras], threshold=2)
    assert close(before.level_areas, after.level_areas, mesh)


@few
@given(mesh_names, seeds, st.floats(1e-3, 1e3))
def test_scaling_scales_areas_by_the_square(name, seed, factor):
    rng, mesh, _ = request(seed, name)
    ring = ring_of(rng, mesh)
    angles = rng.uniform(0, 2 * np.pi, 3)
    scaled = exact.Ring(
        ring.diameter * factor, ring.working_distance * factor, (ring.fov[0] * factor, ring.fov[1] * factor)
    )
    before = exact.evaluate(mesh, ring.cameras(angles), threshold=2)
    after = exact.evaluate(mesh.copy().apply_scale(factor), scaled.cameras(angles), threshold=2)
    assert close(before.level_areas, after.level_areas / factor**2, mesh)


@few
@given(mesh_names, seeds)
def test_splitting_faces_changes_nothing(name, seed):
    rng, mesh, cameras = request(seed, name)
    # Each face is cut at the middle of its edges; neighbours stay joined or not, just as they were.
    vertices, faces, parent = trimesh.remesh.subdivide(mesh.vertices, mesh.faces, return_index=True)
    split = trimesh.Trimesh(vertices, faces, process=False)
    before, after = (exact.evaluate(m, cameras, threshold=2) for m in (mesh, split))
    assert close(before.level_areas, after.level_areas, mesh)
    children = np.concatenate([np.full(len(v), k) for k, v in parent.items()])
    order = np.concatenate(list(parent.values()))
    summed = np.bincount(children, weights=after.face_areas[order], minlength=len(mesh.faces))
    assert close(before.face_areas, summed, mesh)


@few
@given(mesh_names, seeds)
def test_order_of_faces_cameras_and_corners_changes_nothing(name, seed):
    rng, mesh, cameras = request(seed, name)
    faces, corners = rng.permutation(len(mesh.faces)), rng.permutation(len(mesh.vertices))
    turned = np.array(
        [np.roll(face, shift) for face, shift in zip(mesh.faces[faces], rng.integers(0, 3, len(faces)), strict=True)]
    )
    shuffled = trimesh.Trimesh(mesh.vertices[corners], np.argsort(corners)[turned], process=False)
    before = exact.evaluate(mesh, cameras, threshold=2)
    after = exact.evaluate(shuffled, [cameras[i] for i in rng.permutation(len(cameras))], threshold=2)
    assert close(before.level_areas, after.level_areas, mesh)
    assert close(before.face_areas[faces], after.face_areas, mesh)


@few
@given(mesh_names, seeds, st.integers(-3, 3))
def test_full_turns_change_nothing(name, seed, turns):
    rng = np.random.default_rng(seed)
    mesh = MESHES[name]
    ring = ring_of(rng, mesh)
    angles = rng.uniform(0, 2 * np.pi, 3)
    before = exact.evaluate(mesh, ring.cameras(angles), threshold=2)
    after = exact.evaluate(mesh, ring.cameras(angles + 2 * np.pi * turns), threshold=2)
    assert close(before.level_areas, after.level_areas, mesh)


@few
@given(mesh_names, seeds)
def test_one_camera_more_never_lowers_a_level(name, seed):
    _, mesh, cameras = request(seed, name, n_cameras=5)
    before = exact.evaluate(mesh, cameras[:4], threshold=4)
    after = exact.evaluate(mesh, cameras, threshold=4)
    assert (after.level_face_areas >= before.level_face_areas - RELATIVE * mesh.area).all()


@few
@given(mesh_names, seeds)
def test_one_occluder_more_never_raises_the_others(name, seed):
    rng, mesh, cameras = request(seed, name)
    size = np.abs(mesh.vertices).max()
    triangle = rng.uniform(-size, size, (1, 3)) + rng.normal(0, size / 2, (3, 3))
    more = together(mesh, trimesh.Trimesh(triangle, [[0, 1, 2]], process=False))
    before = exact.evaluate(mesh, cameras, threshold=3)
    after = exact.evaluate(more, cameras, threshold=3)
    assert (after.level_face_areas[:, :-1] <= before.level_face_areas + RELATIVE * mesh.area).all()


@few
@given(mesh_names, seeds)
def test_levels_are_nested_and_add_up_to_the_single_views(name, seed):
    _, mesh, cameras = request(seed, name)
    result = exact.evaluate(mesh, cameras, threshold=4)
    slack = RELATIVE * mesh.area
    assert (result.level_face_areas[0] <= mesh.area_faces + slack).all()
    assert (np.diff(result.level_face_areas, axis=0) <= slack).all()
    assert (result.level_face_areas[-1] >= 0).all()
    # Counting each point once for each level it reaches is counting it once for each camera that sees it.
    views = [exact.view(mesh, camera) for camera in cameras]
    assert close(result.level_face_areas.sum(axis=0), sum(view.face_areas for view in views), mesh)
    parts = [result.to_mesh(level).area for level in range(5)]
    assert sum(parts) == pytest.approx(mesh.area, rel=RELATIVE)
    assert parts[4] == pytest.approx(result.area, rel=RELATIVE, abs=slack)


@few
@given(mesh_names, seeds)
def test_fewer_levels_asked_for_are_the_same(name, seed):
    _, mesh, cameras = request(seed, name, n_cameras=9)  # more than one block
    all_levels = exact.evaluate(mesh, cameras, threshold=9).level_areas
    for threshold in (1, 2, 3, 8):
        result = exact.evaluate(mesh, cameras, threshold=threshold)
        assert close(result.level_areas, all_levels[:threshold], mesh)


@few
@given(mesh_names, seeds)
def test_a_baseline_never_adds_and_a_small_one_takes_nothing(name, seed):
    rng, mesh, cameras = request(seed, name)
    plain = exact.evaluate(mesh, cameras, threshold=2)
    distances = sorted(np.linalg.norm(a.position - b.position) for i, a in enumerate(cameras) for b in cameras[:i])
    assert exact.evaluate(mesh, cameras, threshold=2, min_baseline=distances[0] / 2).area == pytest.approx(plain.area)
    assert exact.evaluate(mesh, cameras, threshold=2, min_baseline=distances[-1] * 1.01).area == 0.0
    # With one distance left out, what only that pair sees is missing: compare with all pairs united one by one.
    middle = exact.evaluate(mesh, cameras, threshold=2, min_baseline=distances[-1])
    pair = max(
        ((a, b) for i, a in enumerate(cameras) for b in cameras[:i]),
        key=lambda pair: np.linalg.norm(pair[0].position - pair[1].position),
    )
    assert close(middle.face_areas, exact.evaluate(mesh, pair, threshold=2).face_areas, mesh)


@few
@given(mesh_names, seeds, st.booleans(), st.booleans())
def test_what_each_camera_sees_is_what_it_sees_by_itself(name, seed, all_views, with_more):
    rng, mesh, cameras = request(seed, name, 4)
    scene, limits = exact.Scene(mesh, rng.random(len(mesh.faces)) < 0.2, rng.uniform(0, 2, len(mesh.faces))), {}
    if with_more:
        scene, limits = exact.Scene(mesh, lights=((5.0, 8.0, 300.0),)), {"limits": exact.Limits(max_incidence=1.2)}
    found = exact.evaluate(scene, cameras, threshold=2, all_views=all_views, **limits).camera_areas
    alone = [exact.evaluate(scene, [camera], threshold=1, **limits).area for camera in cameras]
    assert all(close(one, other, mesh) for one, other in zip(found, alone, strict=True))
