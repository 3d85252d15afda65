"""camring check: all about a mesh file, in a table, as JSON and as a picture."""

import json

import numpy as np
import pytest
from PIL import Image

import meshes
from tests.meshes.defects import bowl, mesh_of, near, sheet, turned


@pytest.fixture
def scan(tmp_path):
    mesh = bowl()
    faces = np.vstack([turned(mesh.faces, near(mesh, np.random.default_rng(0), 0.2)), [[0, 0, 1]]])
    (tmp_path / "scan.ply").write_bytes(mesh_of(mesh.vertices, faces).export(file_type="ply"))
    return tmp_path / "scan.ply"


def test_table_and_picture(camring, scan, tmp_path):
    status, out, err = camring("check", scan, "--out", tmp_path / "scan.png")
    words = " ".join(out.replace("│", " ").split())
    assert status == 2 and "camring: " in err and "wound in opposite senses" in err
    assert "20 x 20 x 10 mm" in words and "289 faces in the file" in words
    assert "mixed: " in words and "+z" in words and "left out 1 face of zero area" in words
    assert "faces round to wind all alike" in words and "--repair winds them alike" in words
    with Image.open(tmp_path / "scan.png") as picture:
        assert picture.size[0] > 800 and "wrote" in err


def test_json(camring, scan):
    status, out, _ = camring("check", scan, "--json")
    found = json.loads(out)
    assert status == 2 and found["n_mixed"] > 0 and found["watertight"] and found["n_bodies"] == 1
    assert found["opening"] == pytest.approx([0, 0, 1], abs=0.1)
    assert "repair=True" not in found["refused"] and found["unit"] is None


def test_an_open_sheet_opens_to_its_front():
    mesh = sheet()
    assert meshes.inspect(mesh).opening == pytest.approx([0, 0, 1], abs=0.15)
    mesh.invert()
    found = meshes.inspect(mesh, seen_from=[[0, 0, 400.0]])
    assert found.back_share == 1.0 and found.repairs == ("turned 1 open part (288 faces) to face the cameras",)
    assert found.n_border_edges == 48 and not found.watertight


@pytest.mark.parametrize("factor, units", [
    (0.001, ["metres", "--scale 1000"]),
    (0.1, ["centimetres it would be 20 mm (--scale 10)", "inches it would be 50.8 mm (--scale 25.4)"]),
    (1 / 25.4, ["inches", "--scale 25.4"]),
    (1000.0, ["micrometres", "--scale 0.001"]),
])  # fmt: skip
def test_a_mesh_in_another_unit(camring, tmp_path, factor, units):
    mesh = bowl()
    mesh.apply_scale(factor).export(tmp_path / "scan.stl")
    status, out, _ = camring("check", tmp_path / "scan.stl", "--json")
    found = json.loads(out)
    assert status == 0 and all(words in found["unit"] for words in units)
    assert "used as it is" in camring("check", tmp_path / "scan.stl")[1]


@pytest.mark.parametrize("name", ["circ_artery", "none.stl"])
def test_what_is_no_mesh_file_is_refused(camring, name):
    status, out, err = camring("check", name)
    assert (status, out) == (2, "") and err.startswith("camring: ")
