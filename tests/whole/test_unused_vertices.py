"""A vertex that no face with area uses changes nothing, wherever it is."""

import numpy as np
import pytest
import trimesh

import exact
import meshes
import placement
from placement.samples.profiles import Visibility
from placement.samples.sampling import sample_surface
from tests.support.scenes import above, rectangle, together

SLOPE = 0.005  # so flat that a scale of 1e8 mm would take the two plates for one plane
CROSSING = together(*(rectangle((-5, 5), (-5, 5), lambda x, y, rise=rise: rise * SLOPE * x) for rise in (1, -1)))
EXPECTED = 100.0 * np.hypot(1, SLOPE)  # of each plate the half that is above the other
FAR = [np.nan, np.inf, -np.inf, 1e300, 1e30, 1e8]
QUICK = placement.Settings(
    n_samples=300, n_angles=24, n_starts=2, n_phases=3, exact_phases=1, exact_candidates=1, ring_cameras=12,
    polish_steps=(),
)  # fmt: skip


def with_vertex(mesh, coordinate):
    """The mesh and a vertex that no face uses, first and last, so that the numbers of the others change too."""
    far = np.full((1, 3), coordinate)
    return trimesh.Trimesh(np.concatenate([far, mesh.vertices, far]), mesh.faces + 1, process=False)


def with_face(mesh, coordinate):
    """The mesh and a face without area, which reaches far from its first vertex."""
    far = with_vertex(mesh, coordinate)
    return trimesh.Trimesh(far.vertices, np.concatenate([far.faces, [[0, 1, 0]]]), process=False)


def saved(mesh, folder, ending):
    """The mesh in a file that names all of its vertices."""
    path = folder / f"scan.{ending}"
    if ending == "ply":
        lines = ["ply", "format ascii 1.0", f"element vertex {len(mesh.vertices)}",
                 *(f"property double {axis}" for axis in "xyz"), f"element face {len(mesh.faces)}",
                 "property list uchar int vertex_indices", "end_header"]  # fmt: skip
        lines += [" ".join(map(repr, vertex)) for vertex in mesh.vertices.tolist()]
        lines += ["3 " + " ".join(map(str, face)) for face in mesh.faces.tolist()]
    else:
        lines = ["v " + " ".join(map(repr, vertex)) for vertex in mesh.vertices.tolist()]
        lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in mesh.faces.tolist()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("coordinate", FAR)
def test_areas(coordinate):
    mesh, cameras = with_vertex(CROSSING, coordinate), [above(), above(3.0)]
    assert exact.view(CROSSING, cameras[0]).area == pytest.approx(EXPECTED, rel=1e-12)
    assert exact.view(mesh, cameras[0]).area == exact.view(CROSSING, cameras[0]).area
    found, expected = (exact.evaluate(one, cameras) for one in (mesh, CROSSING))
    assert found.face_areas.tolist() == expected.face_areas.tolist()
    assert found.to_mesh().bounds.tolist() == expected.to_mesh().bounds.tolist()
    assert exact.OneMore(mesh, cameras[:1]).area(cameras[1]) == exact.OneMore(CROSSING, cameras[:1]).area(cameras[1])
    assert exact.view_sets(mesh, cameras).areas.tolist() == exact.view_sets(CROSSING, cameras).areas.tolist()


@pytest.mark.parametrize("coordinate", [1e30, 1e8, -1e8])
def test_areas_beside_a_face_without_area(coordinate):
    found = exact.evaluate(with_face(CROSSING, coordinate), [above()], threshold=1)
    assert found.face_areas.tolist() == [*exact.evaluate(CROSSING, [above()], threshold=1).face_areas.tolist(), 0.0]
    closed = trimesh.creation.box((10, 10, 10))
    assert exact.view(with_face(closed, coordinate), above(fov=(90, 90))).area == pytest.approx(100, rel=1e-12)


@pytest.mark.parametrize("ending", ["ply", "obj"])
@pytest.mark.parametrize("coordinate", FAR)
def test_files(tmp_path, ending, coordinate):
    path = saved(with_vertex(CROSSING, coordinate), tmp_path, ending)
    mesh = meshes.load(path, scale=1.0)
    assert meshes.fingerprint(mesh) == meshes.fingerprint(CROSSING)
    assert len(mesh.vertices) == 8 and mesh.metadata["repairs"] == []
    assert exact.view(mesh, above()).area == pytest.approx(EXPECTED, rel=1e-12)


@pytest.mark.parametrize("coordinate", FAR)
def test_vertices_of_a_file_in_the_same_place_are_still_merged(tmp_path, coordinate):
    box = trimesh.creation.box((10, 10, 10))
    loose = trimesh.Trimesh(box.triangles.reshape(-1, 3), np.arange(36).reshape(-1, 3), process=False)
    mesh = meshes.load(saved(with_vertex(loose, coordinate), tmp_path, "ply"))
    assert mesh.metadata["watertight"] and len(mesh.vertices) == 8
    loose.invert()
    with pytest.raises(meshes.MeshError, match="inside-out"):
        meshes.load(saved(with_vertex(loose, coordinate), tmp_path, "ply"))


def test_a_check_leaves_the_callers_mesh_and_keeps_its_attributes():
    mesh = with_vertex(CROSSING, np.nan)
    mesh.face_attributes["colour"] = np.arange(4)
    mesh.metadata["patient"] = "phantom"
    checked = meshes.check(mesh)
    assert len(mesh.vertices) == 10 and len(checked.vertices) == 8
    assert checked.face_attributes["colour"].tolist() == [0, 1, 2, 3] and checked.metadata["patient"] == "phantom"
    assert (checked.triangles == CROSSING.triangles).all()


@pytest.mark.parametrize("coordinate", FAR)
def test_samples_see_the_same(coordinate):
    mesh, ring = with_vertex(CROSSING, coordinate), exact.Ring()
    samples = sample_surface(mesh, 200)
    assert (samples.points == sample_surface(CROSSING, 200).points).all()
    angles = ring.equidistant(3)
    seen, expected = (Visibility(one).from_angles(samples, ring, angles) for one in (mesh, CROSSING))
    assert (seen == expected).all() and 0 < expected.mean() < 1


@pytest.mark.parametrize("coordinate", [1e30, 1e8])
def test_samples_see_the_same_beside_a_face_without_area(coordinate):
    ring = exact.Ring()
    samples, angles = sample_surface(CROSSING, 200), ring.equidistant(3)
    seen = Visibility(with_face(CROSSING, coordinate)).from_angles(samples, ring, angles)
    assert (seen == Visibility(CROSSING).from_angles(samples, ring, angles)).all()
    assert meshes.top_surface(with_face(trimesh.creation.box(), coordinate))[:12].sum() == 2


@pytest.mark.parametrize("coordinate", FAR)
def test_poses_and_layouts(coordinate):
    mesh = with_vertex(CROSSING, coordinate)
    poses, expected = (placement.jitter(one, n=3) for one in (mesh, CROSSING))
    for pose, like in zip(poses, expected, strict=True):
        assert (pose.triangles == like.triangles).all()
    found, other = (placement.optimise(one, exact.Ring(), 2, settings=QUICK, certify=False) for one in (mesh, CROSSING))
    assert found.area == other.area and found.angles == other.angles


def test_the_hint_at_the_unit_looks_at_faces_only(tmp_path, recwarn):
    meshes.load(saved(with_vertex(CROSSING, 1e8), tmp_path, "ply"))
    assert not recwarn
