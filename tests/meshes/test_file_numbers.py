"""Faces keep the numbers that the file gives them, whatever loading, cutting and mending do."""

import json

import numpy as np
import pytest
import trimesh

import exact
import meshes
from tests.meshes.file_variants import VARIANTS
from tests.meshes.one_solid import POLYGONS, TRIANGLES, VERTICES, obj


def written(folder, name, content):
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def areas_of_file_faces(mesh):
    number, count = meshes.file_faces(mesh)
    return np.bincount(number, weights=mesh.area_faces, minlength=count)


POLYGON_AREAS = [300.0, 300.0, 140.0, 70.0, 70.0, 70.0, 70.0, 140.0]


@pytest.mark.parametrize("name", ["OBJ, Unix", "PLY text, Unix", "PLY little-endian", "OFF, Unix"])
def test_a_polygon_is_one_face(tmp_path, name):
    variant = VARIANTS[name]
    mesh = meshes.load(written(tmp_path, variant.name, variant.content))
    assert len(mesh.faces) == 20
    assert areas_of_file_faces(mesh) == pytest.approx(np.array(POLYGON_AREAS), rel=1e-9)


def test_a_quad_before_triangles(tmp_path):
    faces = [POLYGONS[2], *TRIANGLES[:8], [0, 0, 1], *TRIANGLES[10:]]
    mesh = meshes.load(written(tmp_path, "a.obj", obj(faces)))
    expected = [140.0, *(area_of(face) for face in faces[1:])]
    assert areas_of_file_faces(mesh) == pytest.approx(np.array(expected), rel=1e-9)


def area_of(face):
    a, b, c = (np.array(VERTICES[corner]) for corner in face)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a))


def test_faces_without_corners_enough_are_counted(tmp_path):
    text = obj().replace("f 7", "f 1 2\nf 7", 1)
    mesh = meshes.load(written(tmp_path, "a.obj", text))
    assert areas_of_file_faces(mesh) == pytest.approx(np.array([300.0, 0.0, *POLYGON_AREAS[1:]]), rel=1e-9)


@pytest.mark.parametrize("options", [{}, {"repair": True}, {"two_sided": True}])
def test_through_a_repair_and_with_both_sides(tmp_path, options):
    faces = [[0, 0, 1], *TRIANGLES]
    mesh = meshes.load(written(tmp_path, "a.obj", obj(faces)), **options)
    assert areas_of_file_faces(mesh) == pytest.approx(np.array([0.0, *map(area_of, TRIANGLES)]), rel=1e-9)
    assert meshes.file_faces(mesh)[1] == 21


def test_a_message_names_the_face_of_the_file(tmp_path):
    faces = [[0, 0, 1], [0, 1, 1], *POLYGONS[:1], POLYGONS[1][::-1], *POLYGONS[2:]]
    with pytest.raises(meshes.MeshError, match=r"neighbouring faces (3 and \d|\d and 3) are wound in opposite"):
        meshes.load(written(tmp_path, "a.obj", obj(faces)))


def test_excluded_faces_are_those_of_the_file(camring, tmp_path):
    """A quad of 16 mm² and two triangles of 50 mm² in two materials by turns, each left out once."""
    text = (
        "v -5 -5 0\nv 5 -5 0\nv 5 5 0\nv -5 5 0\nv 6 -2 0\nv 10 -2 0\nv 10 2 0\nv 6 2 0\n"
        "usemtl a\nf 5 6 7 8\nusemtl b\nf 1 2 3\nusemtl a\nf 1 3 4\n"
    )
    path = written(tmp_path, "plates.obj", text)
    for left_out, area in ((0, 100.0), (1, 66.0), (2, 66.0)):
        listed = written(tmp_path, "faces.txt", f"{left_out}\n")
        status, out, _ = camring("evaluate", path, "--cameras", 2, "--exclude", listed, "--json")
        found = json.loads(out)
        assert status == 0 and found["area_mm2"] == pytest.approx(area, rel=1e-12)
        assert "1 faces listed" in found["mesh"]["excluded"]
    listed = written(tmp_path, "faces.txt", "3\n")
    status, _, err = camring("evaluate", path, "--cameras", 2, "--exclude", listed)
    assert status == 2 and "a face index from 0 to 2" in err


def test_the_reconstructable_part_knows_the_faces_of_the_file(tmp_path):
    mesh = meshes.load(written(tmp_path, "a.obj", obj()))
    ring = exact.Ring()
    part = exact.evaluate(mesh, ring.cameras(ring.equidistant(2))).to_mesh()
    assert isinstance(part, trimesh.Trimesh)
    number = meshes.file_faces(mesh)[0]
    assert part.face_attributes["file_face"].tolist() == number[part.face_attributes["parent"]].tolist()
    top = np.bincount(part.face_attributes["file_face"], weights=part.area_faces, minlength=8)
    assert top[1] == pytest.approx(300.0, rel=1e-3) or top[1] < 300.0
