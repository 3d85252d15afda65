"""`--place auto`: the ring is put over a mesh that lies anywhere, and it is said where, so that it can be again."""

import json
import re

import numpy as np
import pytest
from PIL import Image

import meshes
from tests.meshes.placing.shapes import lying, somewhere, trench


@pytest.fixture(scope="module")
def scans(tmp_path_factory):
    """A trench as it was made, and the same one lying elsewhere."""
    folder = tmp_path_factory.mktemp("scans")
    for name, motion in (("made", np.eye(4)), ("moved", somewhere(4)), ("again", somewhere(6))):
        (folder / f"{name}.ply").write_bytes(lying(trench(), motion).export(file_type="ply"))
    return folder


@pytest.fixture
def rig(tmp_path, quick_search):
    path = tmp_path / "rig.toml"
    path.write_text('[mesh]\nplace = "auto"\n[cameras]\ncount = 3\n' + quick_search, encoding="utf-8")
    return path


def said(err):
    """The options that repeat it, as they stand in what was said."""
    return re.search(r"the same again with (--focus=\S+) (--axis=\S+) (--zero-towards=\S+)", err).groups()


def evaluated(camring, path, *options):
    status, out, err = camring("evaluate", path, "--cameras", 16, "--json", *options)
    return (json.loads(out) if status == 0 else None), " ".join(err.split())


def test_out_of_view_it_is_named(camring, scans):
    found, err = evaluated(camring, scans / "moved.ply")
    assert found is None and "no camera sees any part" in err and "--place auto finds where" in err
    status, out, err = camring("check", scans / "moved.ply")
    assert status == 0 and "--place auto finds a place" in " ".join(out.replace("│", " ").split())
    assert "placed" not in err


def test_placed_and_the_same_again(camring, scans, tmp_path):
    made, err = evaluated(camring, scans / "made.ply")
    assert "placed" not in err and made["mesh"]["place"] is None
    found, err = evaluated(camring, scans / "moved.ply", "--place", "auto", "--out", tmp_path / "out")
    assert found["area_mm2"] == pytest.approx(made["area_mm2"], rel=0.01)
    place = found["mesh"]["place"]
    options = said(err)
    assert place["options"] == " ".join(options) and place["at"] in err
    assert place["focus_mm"] == found["ring"]["focus_mm"] and place["axis"] == found["ring"]["axis"]
    assert place["zero_towards"] == found["ring"]["zero_towards"]
    with Image.open(tmp_path / "out" / "place.png") as picture:
        assert picture.size[0] > 1000
    again, err = evaluated(camring, scans / "moved.ply", *options)
    assert again["area_mm2"] == found["area_mm2"] and "placed" not in err
    _, err = evaluated(camring, scans / "moved.ply", *options, "--out", tmp_path / "out")
    assert "there already" in err or "--force" in err


def test_the_top_surface_of_a_mesh_that_lies_anywhere(camring, scans):
    made, _ = evaluated(camring, scans / "made.ply", "--exclude", "top")
    found, _ = evaluated(camring, scans / "moved.ply", "--exclude", "top", "--place", "auto")
    assert found["mesh"]["excluded"] == made["mesh"]["excluded"] and "top surface" in found["mesh"]["excluded"]
    assert found["area_mm2"] == pytest.approx(made["area_mm2"], rel=0.02)


def test_optimise_and_all_that_reads_its_layout(camring, scans, rig, tmp_path):
    out, path = tmp_path / "out", scans / "moved.ply"
    status, _, err = camring("optimise", path, "--rig", rig, "--out", out, "--report")
    assert status == 0 and (out / "place.png").exists() and said(err)
    layout = json.loads((out / "layout.json").read_text(encoding="utf-8"))
    area, place = layout["areas_mm2"]["optimised"], layout["mesh"]["place"]
    assert place == layout["meshes"][0]["place"] and place["focus_mm"] == layout["ring"]["focus_mm"]
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "zero_towards = [" in page and "ring angle 0 lies towards" in page
    file = out / "layout.json"
    status, printed, _ = camring("evaluate", path, "--layout", file, "--json")
    assert status == 0 and json.loads(printed)["area_mm2"] == pytest.approx(area)
    assert camring("report", out, "--mesh", path, "--out", tmp_path / "page")[0] == 0
    # The same surface, lying elsewhere: the ring of the layout goes there.
    again = (scans / "again.ply", "--place", "auto", "--force", "--json")
    status, printed, err = camring("evaluate", *again, "--layout", file)
    moved = json.loads(printed)
    assert status == 0 and said(err) and moved["area_mm2"] > 500
    assert moved["ring"]["diameter_mm"] == layout["ring"]["diameter_mm"]
    status, printed, err = camring(
        "compare",
        file,
        file,
        "--mesh",
        *again,
        "--out",
        tmp_path / "compared",
    )
    compared = json.loads(printed)
    assert status == 0 and compared["ring"] == moved["ring"] and (tmp_path / "compared" / "place.png").exists()
    assert compared["layouts"][0]["area_mm2"] == pytest.approx(moved["area_mm2"])
    assert compared["mesh"]["place"] == moved["mesh"]["place"]


def test_count(camring, scans, rig, tmp_path):
    status, printed, err = camring(
        "count", scans / "moved.ply", "--rig", rig, "--target", 0.3, "--max-cameras", 3, "--json",
        "--out", tmp_path / "out",
    )  # fmt: skip
    assert status == 0 and said(err) and (tmp_path / "out" / "place.png").exists()
    assert json.loads(printed)["layout"]["mesh"]["place"]["options"] == " ".join(said(err))


def test_check(camring, scans, tmp_path):
    status, printed, err = camring(
        "check", scans / "moved.ply", "--place", "auto", "--json", "--out", tmp_path / "check.png"
    )
    found = json.loads(printed)
    assert status == 0 and found["place"]["options"] == " ".join(said(err)) and found["in_view"] > 0.1
    assert found["place"]["axis"] == pytest.approx(found["opening"], abs=0.15)


def test_a_built_in_site_is_in_its_place(camring):
    status, printed, err = camring("evaluate", "circ_flat", "--cameras", 16, "--place", "auto", "--json")
    found = json.loads(printed)
    assert status == 0 and said(err) and found["ring"]["axis"] == pytest.approx([0, 0, 1], abs=0.05)
    right = json.loads(camring("evaluate", "circ_flat", "--cameras", 16, "--json")[1])["area_mm2"]
    assert found["area_mm2"] == pytest.approx(right, rel=0.01)


def test_an_inside_out_scan_is_repaired_first(camring, scans, tmp_path):
    mesh = meshes.load(scans / "moved.ply")
    mesh.invert()
    path = tmp_path / "inverted.ply"
    path.write_bytes(mesh.export(file_type="ply"))
    right, _ = evaluated(camring, scans / "moved.ply", "--place", "auto")
    found, _ = evaluated(camring, path, "--place", "auto", "--repair")
    assert found["area_mm2"] == pytest.approx(right["area_mm2"], rel=0.01)
    found, err = evaluated(camring, path, "--place", "auto")
    assert found is None and "inside-out" in err and "--repair" in err and "repair=True" not in err


def test_a_mesh_in_inches(camring, scans, tmp_path):
    mesh = meshes.load(scans / "moved.ply")
    mesh.apply_scale(1 / 25.4).export(tmp_path / "inches.stl")
    status, out, _ = camring("evaluate", tmp_path / "inches.stl", "--cameras", 2, "--place", "auto", "--json")
    (warning,) = json.loads(out)["mesh"]["warnings"]
    assert status == 0 and "in inches it would be" in warning and "--scale 25.4" in warning


@pytest.mark.parametrize("options, words", [
    (("--place", "up"), "--place is 'up'; it must be auto or none"),
    (("--place", "auto", "--focus", "0,0,1"), "--place auto finds what --focus gives"),
    (("--place", "auto", "--zero-towards", "0,1,0"), "--place auto finds what --zero-towards gives"),
    (("--axis", "0,0"), "--axis is '0,0'; it must be three numbers"),
    (("--zero-towards", "0,0,1"), "zero_towards is (0.0, 0.0, 1.0), which lies along the ring axis"),
])  # fmt: skip
def test_what_makes_no_sense_is_refused(camring, scans, options, words):
    found, err = evaluated(camring, scans / "made.ply", *options)
    assert found is None and words in err


def test_one_mesh_at_a_time(camring, scans, tmp_path):
    status, _, err = camring(
        "optimise", scans / "made.ply", scans / "moved.ply", "--place", "auto", "--out", tmp_path / "out"
    )
    assert status == 2 and "over one mesh, and there are 2" in " ".join(err.split())


def test_an_option_wins_over_the_rig_file(camring, scans, rig):
    found, err = evaluated(camring, scans / "made.ply", "--rig", rig, "--place", "none", "--focus", "0,0,1")
    assert found["ring"]["focus_mm"] == [0, 0, 1] and found["mesh"]["place"] is None and "placed" not in err
