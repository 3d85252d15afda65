"""Results as meshes: what evaluate --out and optimise --export mesh write, read by other programs' readers."""

import json

import numpy as np
import pygltflib
import pytest
import trimesh
from matplotlib.colors import to_rgb
from plyfile import PlyData

import exact
import meshes
from exact.show import UNCOUNTED_COLOUR, UNSEEN_COLOUR, colours
from experiments.cli.app import main

SINGLE = 1e-5  # relative: these files hold single precision


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    path = tmp_path_factory.mktemp("scans") / "scan.stl"
    parts = [trimesh.creation.box((30, 30, 2)), trimesh.creation.box((4, 30, 20))]
    trimesh.boolean.union(parts, engine="manifold").export(path)
    return path


def evaluate(scan, folder, *arguments):
    with pytest.raises(SystemExit) as end:
        main(["evaluate", str(scan), *arguments, "--out", str(folder)])
    assert not end.value.code
    return folder


@pytest.fixture(scope="module")
def areas(tmp_path_factory, scan):
    """What is written of three cameras of which three must see a point; the top of the wall does not count."""
    return evaluate(scan, tmp_path_factory.mktemp("areas"), "--angles-deg", "0,90,200", "--threshold", "3",
                    "--exclude", "top", "--diameter", "120")  # fmt: skip


@pytest.fixture(scope="module")
def expected(scan, areas):
    """Area [mm²] by number of views, from the library."""
    mesh, ring = meshes.load(scan), exact.Ring(diameter=120.0)
    top = meshes.top_surface(mesh)
    levels = exact.evaluate(mesh, ring.cameras(np.radians([0, 90, 200])), threshold=3, exclude=top).level_areas
    counted = mesh.area - mesh.area_faces[top].sum()
    by_views = {-1: mesh.area_faces[top].sum(), 0: counted - levels[0], 1: levels[0] - levels[1],
                2: levels[1] - levels[2], 3: levels[2]}  # fmt: skip
    assert min(by_views.values()) > 10  # there is something of each to tell apart
    return by_views


def test_ply_tells_colour_and_number_of_views_of_each_face(areas, expected):
    file = PlyData.read(areas / "coverage.ply")
    vertex, face = file["vertex"], file["face"]
    corners = np.stack([vertex["x"], vertex["y"], vertex["z"]], axis=1)[np.stack(face["vertex_indices"])]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    palette = colours(3, 3)
    assert set(face["n_views"].tolist()) == set(expected)
    for n_views, wanted in expected.items():
        of_these = face["n_views"] == n_views
        assert area[of_these].sum() == pytest.approx(wanted, rel=SINGLE)
        shown = {(row["red"], row["green"], row["blue"]) for row in face.data[of_these]}
        assert shown == {tuple(np.round(255 * palette[n_views]).astype(int).tolist())}


def test_gltf_has_an_object_for_each_number_of_views(areas, expected):
    scene = trimesh.load_scene(areas / "coverage.glb")
    names = {-1: "not counted", 0: "seen by no camera", 1: "seen by 1 camera", 2: "seen by 2 cameras",
             3: "seen by 3 cameras or more"}  # fmt: skip
    assert set(scene.geometry) == set(names.values())
    for n_views, name in names.items():
        assert 1e6 * scene.geometry[name].area == pytest.approx(expected[n_views], rel=SINGLE)
    height = 1000 * scene.extents[1]  # metres, y up
    assert height == pytest.approx(20, rel=SINGLE)

    file = pygltflib.GLTF2().load(areas / "coverage.glb")
    told = {material.name: material.pbrMetallicRoughness.baseColorFactor for material in file.materials}
    for n_views, colour in ((-1, UNCOUNTED_COLOUR), (0, UNSEEN_COLOUR)):
        linear = np.array(told[names[n_views]][:3])
        srgb = 1.055 * linear ** (1 / 2.4) - 0.055  # glTF's colours are linear
        np.testing.assert_allclose(srgb, to_rgb(colour), atol=1e-6)
    for mesh in file.meshes:
        assert file.materials[mesh.primitives[0].material].name == mesh.name


def test_the_reconstructable_part_has_its_area(areas, expected):
    for name in ("reconstructable.stl", "reconstructable.ply"):
        assert trimesh.load_mesh(areas / name).area == pytest.approx(expected[3], rel=SINGLE)


def test_errors_stand_beside_their_colours(scan, tmp_path, capsys):
    evaluate(scan, tmp_path, "--angles-deg", "0,100,220")
    told = json.loads((tmp_path / "evaluation.json").read_text(encoding="utf-8"))
    assert f"RMS {told['errors_mm']['rms']:.4f} mm" in capsys.readouterr().out
    face, vertex = (PlyData.read(tmp_path / "errors.ply")[name] for name in ("face", "vertex"))
    corners = np.stack([vertex[axis] for axis in "xyz"], axis=1)[np.stack(face["vertex_indices"].tolist())]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    assert area.sum() == pytest.approx(told["area_mm2"], rel=SINGLE)
    # At the centre of each triangle; errors hardly change over one.
    rms = np.sqrt(area @ face["depth_error"] ** 2 / area.sum())
    assert rms == pytest.approx(told["errors_mm"]["rms"], rel=1e-2)
    bright = face["red"].astype(int) + face["green"] + face["blue"]
    best, worst = np.argsort(face["depth_error"])[[0, -1]]
    assert bright[best] > bright[worst]
    scene = trimesh.load_scene(tmp_path / "errors.glb")
    assert sum(1e6 * part.area for part in scene.geometry.values()) == pytest.approx(told["area_mm2"], rel=SINGLE)
    assert all(name.startswith(("to ", "above ")) for name in scene.geometry)
    assert PlyData.read(tmp_path / "reconstructable.ply")["face"]["parent"].max() >= 0


def test_nothing_reconstructable_leaves_no_mesh_of_it(scan, tmp_path, capsys):
    evaluate(scan, tmp_path, "--angles-deg", "0,90", "--min-baseline", "21")
    assert (tmp_path / "reconstructable.stl").exists()
    capsys.readouterr()
    evaluate(scan, tmp_path, "--angles-deg", "0,90", "--min-baseline", "22", "--force")  # they are 21.2 mm apart
    assert "nothing is reconstructable, so there is no mesh of it" in capsys.readouterr().err.replace("\n", " ")
    assert json.loads((tmp_path / "evaluation.json").read_text(encoding="utf-8"))["area_mm2"] == 0.0
    # An earlier result's mesh would pass for this one's.
    assert sorted(file.name for file in tmp_path.iterdir()) == ["coverage.glb", "coverage.ply", "evaluation.json"]


@pytest.mark.parametrize("name", ["coverage.ply", "coverage.glb", "reconstructable.ply"])
def test_no_mesh_is_replaced_without_force(scan, tmp_path, capsys, name):
    (tmp_path / name).write_text("mine", encoding="utf-8")
    for command in (["evaluate", str(scan), "--cameras", "2"], ["optimise", str(scan), "--export", "mesh"]):
        with pytest.raises(SystemExit) as end:
            main([*command, "--out", str(tmp_path)])
        assert end.value.code == 2
        assert f"already holds {name}" in capsys.readouterr().err.replace("\n", " ")
    assert [file.name for file in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text(encoding="utf-8") == "mine"


def test_an_unknown_export_is_refused_before_anything_is_computed(scan, tmp_path, capsys):
    with pytest.raises(SystemExit) as end:
        main(["optimise", str(scan), "--export", "colmap,meshes", "--out", str(tmp_path / "out")])
    assert end.value.code == 2
    said = capsys.readouterr().err.replace("\n", " ")
    assert "--export: there is no format 'meshes'; choose from" in said
    assert "Did you mean mesh?" in said
    assert not (tmp_path / "out").exists()
