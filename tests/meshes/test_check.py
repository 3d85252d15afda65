import numpy as np
import pytest
import trimesh

import meshes


def mesh_of(vertices, faces):
    return trimesh.Trimesh(vertices, faces, process=False)


def box(size=1.0, at=(0, 0, 0)):
    result = trimesh.creation.box((size, size, size))
    return result.apply_translation(at)


def test_a_sound_mesh_comes_back_itself():
    mesh = box()
    assert meshes.check(mesh) is mesh
    assert mesh.metadata["watertight"] is True and mesh.metadata["repairs"] == []


def test_an_open_mesh_is_fine():
    mesh = mesh_of([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    assert meshes.check(mesh).metadata["watertight"] is False


def test_not_a_mesh():
    with pytest.raises(
        meshes.MeshError, match=r"scene: str, not a trimesh.Trimesh; load it with `meshes.load\(path\)`"
    ):
        meshes.check("site.stl", name="scene")


def test_no_faces():
    with pytest.raises(meshes.MeshError, match="mesh: 0 vertices and no faces; needed is at least one triangle"):
        meshes.check(trimesh.Trimesh())


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e300])
def test_vertices_must_be_finite(value):
    mesh = box()
    mesh.vertices[3, 1] = value
    with pytest.raises(
        meshes.MeshError,
        match=r"vertex 3 is \(-0.5, -?(nan|inf|1e[+]300), 0.5\), and 0 more are like it; needed are finite",
    ):
        meshes.check(mesh, repair=True)


def test_a_vertex_no_face_uses_may_be_anything():
    mesh = mesh_of([[0, 0, 0], [1, 0, 0], [0, 1, 0], [np.nan] * 3], [[0, 1, 2]])
    assert meshes.check(mesh).area == 0.5


@pytest.mark.parametrize("at", [0.0, 1e6])
def test_faces_without_area_are_named_and_removed(at):
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]]) + at
    mesh = mesh_of(vertices, [[0, 1, 2], [0, 1, 3], [1, 1, 2]])
    repaired = meshes.check(mesh)
    assert repaired.metadata["notes"] == ["left out 2 faces of zero area"] and repaired.metadata["repairs"] == []
    assert len(repaired.faces) == 1 and len(repaired.vertices) == 3
    assert len(mesh.faces) == 3  # the caller's mesh is left as it was


def test_only_faces_without_area_cannot_be_repaired():
    mesh = mesh_of([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2], [0, 0, 1]])
    with pytest.raises(meshes.MeshError, match="all 2 faces have zero area; needed is at least one face with area"):
        meshes.check(mesh, repair=True)


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_small_and_large_faces_have_area(size):
    assert meshes.check(box(size)).metadata["repairs"] == []


def test_repeated_faces():
    mesh = box()
    twice = mesh_of(mesh.vertices, np.vstack([mesh.faces, np.roll(mesh.faces[4], 1)]))
    repaired = meshes.check(twice)
    assert repaired.area == mesh.area and repaired.metadata["watertight"]
    assert repaired.metadata["notes"] == ["left out 1 face that repeated another"]


def test_a_repaired_mesh_knows_the_faces_of_its_file():
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
    broken = mesh_of(vertices, [[0, 0, 1], [0, 1, 2], [1, 2, 0], [3, 1, 2]])
    assert meshes.file_faces(broken)[0].tolist() == [0, 1, 2, 3]
    repaired = meshes.check(broken, repair=True)
    number, count = meshes.file_faces(repaired)
    assert (number.tolist(), count) == ([1, 3], 4)
    # It keeps them through a second repair, a copy and a motion.
    repaired.faces = [[0, 1, 2], [1, 1, 1]]
    again = meshes.check(repaired, repair=True).copy().apply_translation((1, 2, 3))
    assert (meshes.file_faces(again)[0].tolist(), meshes.file_faces(again)[1]) == ([1], 4)


def test_a_sheet_with_two_sides_is_no_repetition():
    meshes.check(mesh_of([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 1]]))


def test_mixed_winding():
    mesh = trimesh.creation.icosphere(2)
    faces = mesh.faces.copy()
    faces[::7] = faces[::7, ::-1]
    mixed = mesh_of(mesh.vertices, faces)
    with pytest.raises(
        meshes.MeshError, match=r"neighbouring faces \d+ and \d+ are wound in opposite senses, and so are"
    ):
        meshes.check(mixed)
    repaired = meshes.check(mixed, repair=True)
    assert repaired.is_winding_consistent and repaired.volume == pytest.approx(mesh.volume)
    assert repaired.metadata["repairs"] == [f"turned {len(faces[::7])} faces round to wind all alike"]


def test_winding_of_an_open_mesh_follows_most_of_its_faces():
    plane = trimesh.creation.box((1, 1, 1)).subdivide().slice_plane((0, 0, 0.1), (0, 0, 1))
    top = plane.faces.copy()
    top[:2] = top[:2, ::-1]
    repaired = meshes.check(mesh_of(plane.vertices, top), repair=True)
    np.testing.assert_array_equal(repaired.face_normals.round(9), plane.face_normals.round(9))


def test_one_sided_surface():
    n = 12
    turn = np.arange(n) * 2 * np.pi / n
    rims = [
        np.column_stack(
            [(3 + s * np.cos(turn / 2)) * np.cos(turn), (3 + s * np.cos(turn / 2)) * np.sin(turn), s * np.sin(turn / 2)]
        )
        for s in (-1, 1)
    ]
    faces = []
    for i in range(n):
        a, b = i, n + i
        c, d = (i + 1, n + i + 1) if i + 1 < n else (n, 0)  # after one turn the rims change places
        faces += [[a, b, c], [b, d, c]]
    with pytest.raises(meshes.MeshError, match="one-sided, like a Moebius strip: .* joined on crosswise. Cut it"):
        meshes.check(mesh_of(np.vstack(rims), faces), repair=True)


def test_inside_out():
    mesh = box(2.0, at=(1e4, 0, 0))
    mesh.invert()
    with pytest.raises(
        meshes.MeshError, match=r"closed, but inside-out \(its volume is -8\), so that every face is seen"
    ):
        meshes.check(mesh)
    repaired = meshes.check(mesh, repair=True)
    assert repaired.volume == pytest.approx(8)
    assert repaired.metadata["repairs"] == ["turned 1 body outside-out"]


def test_one_body_of_two_inside_out():
    wrong = box(at=(5, 0, 0))
    wrong.invert()
    both = trimesh.util.concatenate([box(), wrong])
    with pytest.raises(meshes.MeshError, match="inside-out"):
        meshes.check(both)
    assert meshes.check(both, repair=True).volume == pytest.approx(2)


def test_a_hollow_body_is_not_inside_out():
    hollow = box(0.5)
    hollow.invert()
    both = trimesh.util.concatenate([box(), hollow])
    assert meshes.check(both) is both
    assert both.volume == pytest.approx(1 - 0.125)


def test_everything_at_once_is_repaired():
    mesh = box()
    faces = np.vstack([mesh.faces[:, ::-1], mesh.faces[3, ::-1], [[0, 0, 1]]])
    faces[5] = faces[5, ::-1]
    repaired = meshes.check(mesh_of(mesh.vertices, faces), repair=True)
    assert repaired.volume == pytest.approx(1) and repaired.is_watertight
    assert len(repaired.metadata["repairs"]) == 2 and len(repaired.metadata["notes"]) == 2


def test_a_million_coincident_vertices_are_quick(tmp_path):
    corners = np.tile(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=float), (50_000, 1))
    soup = mesh_of(corners, np.arange(len(corners)).reshape(-1, 3))
    path = tmp_path / "same.stl"
    path.write_bytes(meshes.stl_bytes(soup))
    mesh = meshes.load(path)
    assert len(mesh.faces) == 1 and mesh.metadata["notes"] == ["left out 49999 faces that repeated another"]


@pytest.mark.parametrize("shape", ["box", "tilted", "peak"])
def test_top_surface(shape):
    mesh = box(2.0)
    if shape == "tilted":
        mesh.apply_transform(trimesh.transformations.rotation_matrix(1e-3, (1, 0, 0)))
    if shape == "peak":
        mesh = trimesh.creation.icosphere()
    top = meshes.top_surface(mesh)
    assert top.shape == (len(mesh.faces),) and top.dtype == bool
    assert mesh.area_faces[top].sum() == pytest.approx(4.0 if shape == "box" else 0.0)


def test_top_surface_after_rounding_to_single_precision():
    mesh = box(2.0, at=(0, 0, 99.123456789))
    mesh.vertices = mesh.vertices.astype(np.float32)
    assert mesh.area_faces[meshes.top_surface(mesh)].sum() == pytest.approx(4.0)


def test_top_surface_of_nothing():
    assert meshes.top_surface(trimesh.Trimesh()).shape == (0,)
    ceiling = mesh_of([[0, 0, 1], [0, 1, 1], [1, 0, 1]], [[0, 1, 2]])  # faces down
    assert not meshes.top_surface(ceiling).any()
