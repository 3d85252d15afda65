"""camring simulate: what it prints and leaves behind, that it goes on where it was, and what it refuses."""

import csv
import json

import cv2
import numpy as np
import pytest
import trimesh
from PIL import Image

import exact
from experiments.cli.commands import simulate as command
from experiments.simulate import drawings, photographs

# Small enough for seconds, large enough for matches.
SMALL = ("--pixels", "240x160", "--rays", "4")
ANGLES = [10.0, 130.0, 250.0]


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    """A step on a plate, in colours of its own, and a layout that names pairs to match."""
    folder = tmp_path_factory.mktemp("desk")
    parts = [trimesh.creation.box((30, 30, 2)), trimesh.creation.box((8, 12, 6))]
    step = trimesh.boolean.union(parts, engine="manifold")
    step.export(folder / "step.stl")
    fine = step.subdivide_to_size(0.5)
    lot = np.random.default_rng(0).integers(0, 256, (len(fine.faces), 3))
    trimesh.Trimesh(fine.vertices, fine.faces, face_colors=lot, process=False).export(folder / "coloured.ply")
    content = {
        "format": "camring layout", "version": 1, "angles_deg": ANGLES,
        "ring": {"diameter_mm": 30, "working_distance_mm": 400, "fov_mm": [36, 24]},
        "robustness": {"accurate_pairs": [{"cameras": [1, 2]}, {"cameras": [2, 3]}]},
    }  # fmt: skip
    (folder / "layout.json").write_text(json.dumps(content), encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def made(desk):
    """What a first run leaves, and its figures."""
    from tests.conftest import main

    with pytest.raises(SystemExit) as end:
        main(["simulate", str(desk / "step.stl"), "--layout", str(desk / "layout.json"), *SMALL, "--out",
              str(desk / "sim")])  # fmt: skip
    assert not end.value.code
    return desk / "sim", json.loads((desk / "sim" / "simulation.json").read_text(encoding="utf-8"))


@pytest.fixture
def undrawn(monkeypatch):
    """No pictures, which take longer than all the rest."""
    for name in ("write_prediction", "write_errors", "write_depths"):
        monkeypatch.setattr(drawings, name, lambda *_: None)


def test_what_it_leaves_is_whole_and_agrees(made):
    folder, figures = made
    layout, even = figures["layouts"]
    assert (layout["layout"], even["layout"]) == ("layout", "equidistant")
    assert layout["pairs"] == [[1, 2], [2, 3]] and len(even["pairs"]) == 3
    assert layout["ring_angles_deg"] == pytest.approx(ANGLES) and even["ring_angles_deg"] == pytest.approx(
        [120, 240, 360]
    )
    with (folder / "simulation.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for one in figures["layouts"]:
        of = [row for row in rows if row["layout"] == one["layout"]]
        for by in ("views", "incidence [degrees]", "density [px/mm²]"):
            chosen = [row for row in of if row["by"] == by]
            areas = np.array([float(row["area_mm2"]) for row in chosen])
            near = np.array([float(row["within_0.3_mm"]) for row in chosen])
            assert areas.sum() == pytest.approx(one["seen_area_mm2"], rel=1e-9), by
            assert (near * areas).sum() / areas.sum() == pytest.approx(one["measured_shares_of_seen"]["0.3"]), by
        # What two cameras see of which no pair is named, has no gradient.
        paired = sum(float(row["area_mm2"]) for row in of if row["by"] == "disparity gradient")
        assert (paired < 0.9 * one["seen_area_mm2"]) if one is layout else (paired > 0.99 * one["seen_area_mm2"])
        assert one["predicted_area_mm2"] == pytest.approx(one["seen_area_mm2"], rel=0.02)
        # A plate that faces the cameras comes out, its steep sides hardly.
        assert one["measured_areas_mm2"]["0.5"] > 0.8 * 36 * 24 * 0.9
        for name in ("depths.png", "reconstruction.ply"):
            assert (folder / one["layout"] / name).stat().st_size > 10_000
    points = trimesh.load(folder / "layout" / "reconstruction.ply")
    top = points.vertices[(np.abs(points.vertices[:, :2]) < [3, 5]).all(axis=1)]
    assert np.median(top[:, 2]) == pytest.approx(3.0, abs=0.1)
    assert len(np.unique(points.colors, axis=0)) > 20
    for name in ("prediction.png", "errors.png"):
        with Image.open(folder / name) as picture:
            assert picture.size[0] > 1000 and len(picture.convert("L").getcolors(10_000)) > 50


def test_cameras_beside_the_images_are_theirs(made):
    """OpenCV, by the file beside the images, puts the corners of the step where the picture changes colour."""
    folder, _ = made
    (first, *_) = json.loads((folder / "layout" / "opencv.json").read_text(encoding="utf-8"))["cameras"]
    picture = cv2.imread(str(folder / "layout" / "images" / first["image"]))
    assert picture.shape == (first["height"], first["width"], 3) == (160, 240, 3)
    # Beyond the plate nothing is lit.
    corners = np.array([[x, y, 1.0] for x in (-15.0, 15.0) for y in (-15.0, 15.0)])
    turn, _ = cv2.Rodrigues(np.array(first["R"]))
    pixels, _ = cv2.projectPoints(corners, turn, np.array(first["t"]), np.array(first["K"]), np.zeros(5))
    outline = cv2.convexHull(pixels.astype(np.float32)).reshape(-1, 2)
    inside = np.zeros((160, 240), dtype=np.uint8)
    cv2.fillConvexPoly(inside, np.round(outline).astype(np.int32), 1)
    inner, outer = cv2.erode(inside, np.ones((5, 5))) == 1, cv2.dilate(inside, np.ones((5, 5))) == 0
    bright = picture.max(axis=2)
    assert (bright[inner] > 15).mean() > 0.98
    assert not outer.any() or bright[outer].max() == 0


def test_stopped_and_started_again_it_renders_no_image_twice(made, desk, tmp_path, camring, monkeypatch, undrawn):
    folder, figures = made
    rendered = []
    render = photographs.Photographer._take

    def counted(self, path, camera):
        rendered.append(path.name)
        if len(rendered) == 3:
            raise KeyboardInterrupt
        render(self, path, camera)

    monkeypatch.setattr(photographs.Photographer, "_take", counted)
    request = ("simulate", desk / "step.stl", "--layout", desk / "layout.json", *SMALL, "--out", tmp_path / "again")
    assert camring(*request)[0] == 130
    assert not (tmp_path / "again" / "simulation.json").exists()
    assert camring(*request)[0] == 0
    # Two before it was stopped, the third at last, and three of the equidistant ring.
    assert len(rendered) == 3 + 1 + 3
    assert json.loads((tmp_path / "again" / "simulation.json").read_text(encoding="utf-8")) == figures
    for image in (folder / "layout" / "images").iterdir():
        assert (tmp_path / "again" / "layout" / "images" / image.name).read_bytes() == image.read_bytes()
    status, _, said = camring(*request)
    assert status == 2 and "already holds simulation.csv" in said
    assert camring(*request, "--force")[0] == 0 and len(rendered) == 7
    assert camring(*request, "--force", "--seed", "1", "--no-equidistant")[0] == 0 and len(rendered) == 10


def test_colours_of_its_own(desk, tmp_path, camring, undrawn):
    request = ("simulate", desk / "coloured.ply", "--cameras", "2", "--texture", "own", *SMALL)
    status, printed, said = camring(*request, "--out", tmp_path / "sim", "--json")
    assert status == 0, said
    (even,) = json.loads(printed)["layouts"]
    assert even["layout"] == "equidistant" and even["points"] > 10_000
    picture = np.asarray(Image.open(tmp_path / "sim" / "equidistant" / "images" / "camera_01.png")).reshape(-1, 3)
    lit = picture[picture.max(axis=1) > 40].astype(float)
    assert np.corrcoef(lit[:, 0], lit[:, 2])[0, 1] < 0.5  # unlike the reds of tissue


def test_quick_images_have_the_shape_of_the_field_of_view(desk, tmp_path, camring, monkeypatch, undrawn):
    monkeypatch.setattr(command, "QUICK", 120)
    request = ("simulate", desk / "step.stl", "--cameras", "2", "--fov", "30x30", "--quick", "--rays", "1")
    status, printed, _ = camring(*request, "--out", tmp_path / "sim")
    assert status == 0 and "120 x 120 pixels" in printed


REFUSED = {
    ("--cameras", "2", "--layout", "layout.json"): "give the cameras in exactly one way",
    (): "give the cameras in exactly one way",
    ("--layout", "layout.json", "--fov", "30x30"): "a layout brings its own ring",
    ("--layout", "layout.json", "--roll", "tangential"): "a layout brings its own ring",
    ("--layout", "layout.json", "--quick", "--pixels", "90x60"): "--quick makes images of 900 pixels",
    ("--cameras", "2", "--pixels", "300x300"): "300 x 300 pixels over 36 x 24 mm are not square; give --pixels 300x200",
    ("--cameras", "1"): "1 camera gives no pair of images to match; at least 2 are needed",
    ("--cameras", "2", "--texture", "wood"): "texture is 'wood'; it must be tissue or own",
    ("--cameras", "2", "--texture", "own"): "step.stl gives its surface no colours",
    ("--cameras", "2", "--rays", "0"): "rays is 0; it must be a whole number from 1 to 4096",
    ("--cameras", "2", "--sensor-noise", "-1"): "sensor_noise is -1.0; it must be at least 0",
    ("--cameras", "2", "--grain", "nan"): "grain is nan; it must be positive",
    ("--cameras", "2", "--focus", "500,0,0"): "no camera sees any part",
}


@pytest.mark.parametrize("options", REFUSED, ids=" ".join)
def test_what_makes_no_sense_is_refused(desk, tmp_path, camring, monkeypatch, options):
    monkeypatch.chdir(desk)
    status, printed, said = camring("simulate", "step.stl", *options, "--out", tmp_path / "sim")
    assert (status, printed) == (2, "") and REFUSED[options] in " ".join(said.split())
    assert not list(tmp_path.rglob("*.png"))


def test_without_the_extra_it_says_what_to_install(desk, tmp_path, camring, monkeypatch):
    monkeypatch.setattr("experiments.cli.extras.find_spec", lambda name: None if name == "mitsuba" else True)
    status, _, said = camring("simulate", desk / "step.stl", "--cameras", "2", "--out", tmp_path / "sim")
    assert status == 2 and not (tmp_path / "sim").exists()
    assert "needs mitsuba, which is not installed; pip install 'camring[simulate]'" in " ".join(said.split())


def test_lamps_stand_beside_the_cameras_unless_there_are_others(desk, tmp_path, camring, undrawn):
    """With one lamp far to the side, the far flank of the step is dark, and does not count."""
    request = ("simulate", desk / "step.stl", "--layout", desk / "layout.json", *SMALL, "--no-equidistant", "--json")
    status, printed, _ = camring(*request, "--light", "200,0,100", "--out", tmp_path / "side")
    assert status == 0
    (aside,) = json.loads(printed)["layouts"]
    mesh = trimesh.load(desk / "step.stl")
    cameras = exact.Ring().cameras(np.radians(ANGLES))
    lit = exact.evaluate(mesh, cameras, lights=[(200.0, 0.0, 100.0)]).area
    assert aside["predicted_area_mm2"] == pytest.approx(lit, rel=1e-12)
    assert lit < exact.evaluate(mesh, cameras).area - 5


def test_cameras_that_are_turned_take_turned_images(desk, tmp_path, camring, undrawn):
    content = json.loads((desk / "layout.json").read_text(encoding="utf-8"))
    del content["robustness"]
    angles, rolls = [20.0, 200.0], [90.0, 60.0]
    content |= {"angles_deg": angles, "rolls_deg": rolls}
    (tmp_path / "turned.json").write_text(json.dumps(content), encoding="utf-8")
    request = ("simulate", desk / "step.stl", "--layout", tmp_path / "turned.json", "--fov", "24x16", *SMALL)
    assert camring(*request, "--out", tmp_path / "sim")[0] == 2  # a layout brings its own field of view
    status, printed, said = camring(*request[:4], *SMALL, "--out", tmp_path / "sim", "--json")
    assert status == 0, said
    turned, even = json.loads(printed)["layouts"]
    assert turned["rolls_deg"] == pytest.approx(rolls) and "rolls_deg" not in even
    cameras = exact.Ring().cameras(np.radians(angles), np.radians(rolls))
    own = exact.evaluate(trimesh.load(desk / "step.stl"), cameras).area
    assert turned["predicted_area_mm2"] == pytest.approx(own, rel=1e-9)
    written = json.loads((tmp_path / "sim" / "layout" / "opencv.json").read_text(encoding="utf-8"))["cameras"]
    for one, camera in zip(written, cameras, strict=True):
        assert np.array(one["R"]) == pytest.approx(camera.rotation, abs=1e-9)


def test_a_report_in_the_same_folder_shows_it(desk, tmp_path, camring, quick_search):
    out, step = tmp_path / "out", desk / "step.stl"
    (tmp_path / "rig.toml").write_text(quick_search, encoding="utf-8")
    request = ("optimise", step, "--rig", tmp_path / "rig.toml", "--cameras", 2, "--no-robustness", "--out", out)
    assert camring(*request)[0] == 0
    small = ("--pixels", "180x120", "--rays", "1", "--no-equidistant")
    assert camring("simulate", step, "--layout", out / "layout.json", *small, "--out", out)[0] == 0
    (one,) = json.loads((out / "simulation.json").read_text(encoding="utf-8"))["layouts"]

    def reported():
        status, _, said = camring("report", out, "--mesh", step, "--force")
        return status, " ".join(said.split()), (out / "report.html").read_text(encoding="utf-8")

    status, said, page = reported()
    assert status == 0, said
    assert "What came out of images" in page and f"<td>{one['measured_areas_mm2']['0.3']:.1f}</td>" in page
    assert page.count('<img class="picture" src="data:image/png;base64,') == 2
    text = (out / "simulation.json").read_text(encoding="utf-8")
    content = json.loads(text)
    content["layouts"][0]["ring_angles_deg"][0] += 1e-3
    (out / "simulation.json").write_text(json.dumps(content), encoding="utf-8")
    status, said, page = reported()
    assert status == 0 and "is of another layout or mesh" in said and "What came out of images" not in page
    (out / "simulation.json").write_text(text.replace("measured_areas_mm2", "areas"), encoding="utf-8")
    status, said, _ = reported()
    assert status == 2 and "is no result of camring simulate" in said
