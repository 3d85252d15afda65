"""camring tradeoff: what it prints and leaves behind, and that a report shows it."""

import csv
import json

import matplotlib.image
import numpy as np
import pytest
import trimesh

import exact
import meshes

RING = exact.Ring()


@pytest.fixture(scope="module")
def desk(tmp_path_factory, quick_search):
    """A floor between two walls, and a rig file that makes the search quick."""
    folder = tmp_path_factory.mktemp("desk")
    parts = [((40, 40, 2), (0, 0, -1)), ((2, 40, 20), (8, 0, 10)), ((2, 40, 20), (-8, 0, 10))]
    solids = [trimesh.creation.box(size).apply_translation(at) for size, at in parts]
    trimesh.util.concatenate(solids).export(folder / "trench.stl")
    (folder / "rig.toml").write_text(quick_search, encoding="utf-8")
    return folder


def test_table_picture_and_words_agree_and_stand_in_the_report(camring, desk, tmp_path):
    out, request = tmp_path / "out", (desk / "trench.stl", "--rig", desk / "rig.toml", "--cameras", 3, "--no-certify")
    status, printed, err = camring("tradeoff", *request, "--out", out, "--json")
    assert status == 0, err
    found = json.loads(printed)
    with (out / "tradeoff.csv").open(encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    assert [row["layout"] for row in table] == [row["layout"] for row in found["layouts"]]
    mesh = meshes.load(desk / "trench.stl")
    for row, words in zip(found["layouts"], table, strict=True):
        assert [float(angle) for angle in words["ring_angles_deg"].split()] == row["ring_angles_deg"]
        cameras = RING.cameras(np.radians(row["ring_angles_deg"]))
        own = exact.evaluate(mesh, cameras, depth_axis=RING.axis)
        assert float(words["area_mm2"]) == row["area_mm2"] == pytest.approx(own.area, rel=1e-9)
        # Errors are averages over parts of the surface, which depend to 1e-8 on how it is divided.
        own = exact.evaluate(mesh, cameras, depth_axis=RING.axis, all_views=True)
        assert row["rms_error_mm"] == pytest.approx(own.error_rms, rel=1e-9)
    assert sum(row["knee"] for row in found["layouts"]) == 1
    assert found["bound_fraction"] is None and found["in_words"].endswith(".")
    image = matplotlib.image.imread(out / "tradeoff.png")
    assert image.shape[0] > 500 and np.ptp(image[..., :3]) > 0.5

    assert camring("optimise", *request, "--out", out, "--force", "--report", "--no-robustness")[0] == 0
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "What accuracy costs" in page and page.count("the knee") == 1
    best = max(row["area_mm2"] for row in found["layouts"])
    assert f"{best:.2f}" in page
    (out / "tradeoff.csv").write_text("layout,knee\nsearched,True\n", encoding="utf-8")
    status, _, err = camring("report", out / "layout.json", "--mesh", desk / "trench.stl", "--out", out, "--force")
    assert status == 2 and "is no table of camring tradeoff" in err


def test_refusals(camring, desk, tmp_path):
    request = ("tradeoff", desk / "trench.stl", "--rig", desk / "rig.toml", "--out", tmp_path / "out")
    status, _, err = camring(*request, "--cameras", 3, "--threshold", 1)
    assert status == 2 and "errors take two" in err and "Traceback" not in err
    (tmp_path / "out").mkdir(exist_ok=True)
    (tmp_path / "out" / "tradeoff.csv").write_text("mine", encoding="utf-8")
    status, _, err = camring(*request, "--cameras", 3)
    assert status == 2 and "--force" in err
