"""Several meshes, poses and weights at the command line; what a layout keeps when something goes wrong."""

import csv
import dataclasses
import io
import json
import re
from contextlib import redirect_stderr, redirect_stdout

import numpy as np
import pytest
import trimesh

import exact
import meshes
import placement
from experiments.cli.app import main
from experiments.layouts import layout_file

RING = exact.Ring()


@pytest.fixture(scope="module")
def desk(tmp_path_factory, quick_search):
    """Two meshes, a floor below a bar that lies across differently, and a rig file that makes the search quick."""
    folder = tmp_path_factory.mktemp("desk")
    for name, turned in (("a", 0.3), ("b", 1.4)):
        beam = trimesh.creation.box((40, 4, 3)).apply_translation((0, 0, 33))
        beam.apply_transform(trimesh.transformations.rotation_matrix(turned, (0, 0, 1)))
        trimesh.util.concatenate([trimesh.creation.box((40, 40, 2)), beam]).export(folder / f"{name}.stl")
    (folder / "rig.toml").write_text(quick_search, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def both(desk):
    """The folder of one layout for both meshes, and what was printed."""
    asked = ("a.stl", "b.stl", "--objective", "worst", "--cameras", "3", "--export", "glb,csv", "--rig", "rig.toml")
    asked = [str(desk / word) if word.endswith((".stl", ".toml")) else word for word in asked]
    said, told = io.StringIO(), io.StringIO()
    with redirect_stdout(said), redirect_stderr(told), pytest.raises(SystemExit) as end:
        main(["optimise", *asked, "--out", str(desk / "both")])
    assert not end.value.code, told.getvalue()
    return desk / "both", said.getvalue(), told.getvalue()


def fractions(desk, angles, min_count=2):
    """Exact fractions of the ring maximum of both meshes."""
    found = []
    for name in ("a", "b"):
        mesh = meshes.load(desk / f"{name}.stl")
        whole = exact.evaluate(mesh, RING.cameras(RING.equidistant(8)), threshold=min_count).area
        found.append(exact.evaluate(mesh, RING.cameras(angles), threshold=min_count).area / whole)
    return found


def test_one_layout_for_the_worst_of_two(desk, both):
    content = json.loads((both[0] / "layout.json").read_text(encoding="utf-8"))
    assert content["version"] == 1
    assert [mesh["name"] for mesh in content["meshes"]] == ["a.stl", "b.stl"]
    assert content["objective"] == "worst"
    ours = fractions(desk, content["angles_rad"])
    for mesh, fraction in zip(content["meshes"], ours, strict=True):
        assert mesh["sha256"] == meshes.fingerprint(meshes.load(desk / mesh["name"]))
        (areas,) = mesh["areas_of_poses_mm2"]
        assert areas["optimised"] / areas["ring_maximum"] == pytest.approx(fraction, rel=1e-12)
    assert content["mesh"] == {key: content["meshes"][0][key] for key in content["mesh"]}
    assert content["fractions_of_ring_maximum"]["optimised"] == pytest.approx(min(ours), rel=1e-12)
    assert content["areas_mm2"]["optimised"] == pytest.approx(
        sum(mesh["areas_of_poses_mm2"][0]["optimised"] for mesh in content["meshes"])
    )
    words = " ".join(both[1].split())
    assert "the worst of 2 meshes" in words
    assert "a.stl: 24 faces" in words
    assert "b.stl: 24 faces" in words
    assert "the meshes written show a.stl, the first" in " ".join(both[2].split())
    assert (both[0] / "site_and_cameras.glb").exists()


def test_what_is_left_when_a_camera_fails_or_sits_askew(desk, both):
    content = json.loads((both[0] / "layout.json").read_text(encoding="utf-8"))
    kept = content["robustness"]
    assert [found["layout"].split(",")[0] for found in kept["layouts"]] == ["equidistant", "equidistant", "optimised"]
    with (both[0] / "layouts.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for found, row in zip(kept["layouts"], rows, strict=True):
        angles = np.radians(found["ring_angles_deg"])
        alone = [min(fractions(desk, np.delete(angles, camera))) for camera in range(3)]
        assert found["fractions_without_camera"] == pytest.approx(alone, rel=1e-9)
        assert float(row["worst_failure_fraction"]) == pytest.approx(min(alone), rel=1e-9)
        assert float(row["mean_failure_fraction"]) == pytest.approx(np.mean(alone), rel=1e-9)
        assert len(found["fractions_mounted_off"]) == 5
        assert float(row["worst_mounting_fraction"]) == min(found["fractions_mounted_off"])
        quantiles = [float(row[f"triangulation_angle_{percent}_percent_deg"]) for percent in (5, 50, 95)]
        assert 0 < quantiles[0] <= quantiles[1] <= quantiles[2] <= float(row["widest_triangulation_angle_deg"])
        assert quantiles[0] <= float(row["mean_triangulation_angle_deg"]) <= quantiles[2]
    assert kept["layouts"][-1]["ring_angles_deg"] == pytest.approx(content["angles_deg"])
    every = [
        min(fractions(desk, np.array(content["angles_rad"]) + np.radians(sides)))
        for sides in 2 * np.array(list(np.ndindex(2, 2, 2))) - 1
    ]
    for fraction in kept["layouts"][-1]["fractions_mounted_off"]:
        assert np.isclose(every, fraction, rtol=1e-9).any()
    assert max(kept["best_layouts_fractions"]) == content["fractions_of_ring_maximum"]["optimised"]
    assert len(kept["distances_in_best_layouts_deg"]) == 3


def test_pairs_are_named_by_the_numbers_of_the_layout(desk, both):
    content = json.loads((both[0] / "layout.json").read_text(encoding="utf-8"))
    areas = sum(mesh["areas_of_poses_mm2"][0]["optimised"] for mesh in content["meshes"])
    angles, scans = content["angles_rad"], [meshes.load(desk / f"{name}.stl") for name in ("a", "b")]
    for pair in content["robustness"]["pairs"]:
        chosen = [angles[number - 1] for number in pair["cameras"]]
        seen = sum(exact.evaluate(mesh, RING.cameras(chosen)).area for mesh in scans)
        assert pair["share_of_area"] == pytest.approx(seen / areas, rel=1e-9)
    first, last = content["robustness"]["pairs"][0], content["robustness"]["pairs"][-1]
    assert first["share_of_area"] == first["share_with_pairs_before"]
    assert 0.999 <= last["share_with_pairs_before"] <= 1 + 1e-9
    one, two = first["cameras"]
    words = " ".join(both[1].split())
    assert f"{one} and {two} │ {np.degrees(angles[one - 1]):.1f} and {np.degrees(angles[two - 1]):.1f}" in words
    assert f"1 ({np.degrees(angles[0]):.1f}°)" in words  # in the consensus


def test_other_commands_take_such_a_layout(camring, desk, both, tmp_path):
    content = json.loads((both[0] / "layout.json").read_text(encoding="utf-8"))
    for mesh in content["meshes"]:
        status, out, err = camring("evaluate", desk / mesh["name"], "--layout", both[0] / "layout.json", "--json")
        area = mesh["areas_of_poses_mm2"][0]["optimised"]
        assert json.loads(out)["area_mm2"] == pytest.approx(area, rel=1e-12)
    export = ("export", both[0] / "layout.json", "--format", "glb", "--out", tmp_path)
    for number, mesh in enumerate(content["meshes"]):  # it was made for each of them
        assert camring(*export, "--mesh", desk / mesh["name"], "--out", tmp_path / str(number))[0] == 0
    status, _, err = camring(*export, "--mesh", "circ_flat", "--out", tmp_path / "other")
    assert status == 2
    assert "was made for 'a.stl' or 'b.stl', and circ_flat" in " ".join(err.split())


def test_poses_weights_of_sites_and_of_faces(camring, desk, tmp_path, quick_search):
    rig = tmp_path / "rig.toml"
    more = "[sites]\nsite_weights = [1, 3]\nfalloff_mm = 30\n[poses]\njitter = 2\ntilt_deg = 4\n"
    rig.write_text(more + quick_search, encoding="utf-8")
    asked = ("optimise", desk / "a.stl", desk / "b.stl", "--cameras", 2, "--rig", rig, "--shift-mm", 0.5)
    status, out, err = camring(*asked, "--no-robustness", "--json", "--out", tmp_path)
    assert status == 0, err
    content = json.loads(out)
    assert content["poses"] == {"n": 2, "tilt_deg": 4.0, "shift_mm": 0.5}
    assert content["falloff_mm"] == 30
    assert "robustness" not in content
    assert "worst_failure_fraction" not in content["layouts"][0]
    total, areas = 0.0, 0.0
    for mesh, weight in zip(content["meshes"], (1, 3), strict=True):
        assert mesh["weight"] == weight
        poses = placement.jitter(meshes.load(desk / mesh["name"]), 4, 0.5, 2, seed=0)
        for pose, told in zip(poses, mesh["areas_of_poses_mm2"], strict=True):
            counts = placement.falloff(pose, RING, 30.0)
            found = exact.evaluate(pose, RING.cameras(content["angles_rad"]), weights=counts).area
            whole = exact.evaluate(pose, RING.cameras(RING.equidistant(8)), weights=counts).area
            assert (told["optimised"], told["ring_maximum"]) == pytest.approx((found, whole), rel=1e-12)
            total += weight * found / whole / 8
            areas += found / 2
    assert content["fractions_of_ring_maximum"]["optimised"] == pytest.approx(total, rel=1e-12)
    assert content["areas_mm2"]["optimised"] == pytest.approx(areas, rel=1e-12)


REFUSED = {
    "weights": (("a.stl", "b.stl", "--site-weights", "1"), r"site_weights are \(1\.0,\), and there are 2 meshes; give"),
    "weights in words": (("a.stl", "--site-weights", "one"), r"--site-weights is 'one'; it must be numbers"),
    "negative": (("a.stl", "b.stl", "--site-weights", "1,-1"), r"it must be numbers, at least 0"),
    "objective": (("a.stl", "b.stl", "--objective", "best"), r"objective is 'best'; it must be \"mean\" or \"worst\""),
    "faces of two": (("a.stl", "b.stl", "--exclude", "faces.txt"), r"face indices of one mesh, and there are 2"),
    "fields of view": (
        ("circ_flat", "eye_anterior"),
        r"meant for fields of view of 36x24 and .* mm; say which with --fov",
    ),
    "poses": (("a.stl", "--jitter", "0"), r"number of poses is 0"),
    "tilt": (("a.stl", "--jitter", "2", "--tilt-deg", "100"), r"tilt_deg is 100"),
    "falloff": (("a.stl", "--falloff-mm", "0"), r"distance is 0"),
    "two depths": (("circ_flat@50", "--depth", "100"), r"circ_flat@50 says the depth, and so does --depth 100"),
    "no depth": (("circ_flat@deep",), r"after @ stands the depth in millimetres, as in circ_flat@50"),
    "another depth": (("circ_flat@50", "circ_flat@7"), r"circ_flat has no depth 7"),
    "depth of files": (("a.stl", "b.stl", "--depth", "50"), r"--depth and --detail belong to built-in sites"),
    "scale of sites": (("circ_flat", "circ_artery", "--scale", "2"), r"leave the scale of 2 out"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_does_not_fit_is_refused(camring, desk, tmp_path, name):
    words, message = REFUSED[name]
    words = [str(desk / word) if word.endswith(".stl") else word for word in words]
    status, out, err = camring("optimise", *words, "--rig", desk / "rig.toml", "--out", tmp_path / "out")
    assert (status, out) == (2, "")
    assert re.search(message, " ".join(err.split())), err


def test_the_depth_of_a_site_may_stand_in_its_name(camring, desk, tmp_path, monkeypatch):
    at = json.loads(camring("evaluate", "circ_flat@100", "--cameras", 2, "--json")[1])
    apart = json.loads(camring("evaluate", "circ_flat", "--depth", 100, "--cameras", 2, "--json")[1])
    assert at == apart
    assert at["mesh"]["name"] == "circ_flat, depth 100 mm"
    monkeypatch.chdir(tmp_path)
    trimesh.creation.box((9, 9, 9)).export("circ_flat@100.stl")
    (tmp_path / "circ_flat@100.stl").rename("circ_flat@100")  # a file of that name goes first, whatever it is
    status, _, err = camring("evaluate", "circ_flat@100", "--cameras", 2)
    assert status == 2
    assert "circ_flat@100" in err


def test_reading_a_layout_knows_all_constraints():
    # By heart, for it loads no JAX.
    assert set(layout_file.CONSTRAINTS) == {field.name for field in dataclasses.fields(placement.Constraints)}


def test_a_baseline_that_cannot_be_is_refused(camring, desk, tmp_path):
    content = {
        "format": "camring layout",
        "version": 1,
        "ring": {"diameter_mm": 30, "working_distance_mm": 400, "fov_mm": [36, 24]},
        "angles_deg": [0, 180],
        "constraints": {"min_baseline": -3.0},
    }
    (tmp_path / "layout.json").write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(SystemExit) as end:
        main(["evaluate", str(desk / "a.stl"), "--layout", str(tmp_path / "layout.json")])
    assert end.value.code == 2
    content["constraints"] = {"min_angle": np.radians(1.0)}
    (tmp_path / "layout.json").write_text(json.dumps(content), encoding="utf-8")
    read = layout_file.read(tmp_path / "layout.json")
    assert read.demand.min_baseline == pytest.approx(2 * np.hypot(400, 15) * np.sin(np.radians(0.5)))
