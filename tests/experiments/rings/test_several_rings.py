"""camring optimise --ring … --ring …: what is printed and written is what the library finds, exports show the same."""

import csv
import dataclasses
import json

import matplotlib.image
import numpy as np
import pytest
import trimesh

import exact
import meshes
import placement
from experiments.cli.app import main
from experiments.request import rig as rig_file
from tests.experiments.exports.test_export import (  # noqa: F401 - further readers of what is exported
    Exported,
    test_colmap_reads_the_same_cameras,
    test_gltf_cameras_project_the_same,
    test_gltf_shows_the_site_and_each_frustum,
    test_opencv_projects_the_same,
    test_table_says_the_same,
    test_transforms_follow_opengl,
)
from tests.experiments.report.test_report import chromium, opened  # noqa: F401 - the browser
from tests.placement.rings.by_hand import alone, bound_of
from tests.support.browser import PATIENCE

RINGS = exact.Ring(), exact.Ring(16.0, 380.0, (54.0, 36.0))


@pytest.fixture(scope="module")
def desk(tmp_path_factory, quick_search):
    folder = tmp_path_factory.mktemp("desk")
    parts = [trimesh.creation.box((30, 30, 2)), trimesh.creation.box((4, 30, 20))]
    trimesh.boolean.union(parts, engine="manifold").export(folder / "scan.stl")
    (folder / "rig.toml").write_text(quick_search, encoding="utf-8")
    return folder


def asked(desk, *options):
    rings = ("--ring", "30x400", "--ring", "16x380@54x36:1")
    return ("optimise", desk / "scan.stl", "--rig", desk / "rig.toml", *rings, "--cameras", 3, *options)


@pytest.fixture(scope="module")
def written(desk):
    """The folder with everything that is written, and the file that says what was found."""
    out = desk / "out"
    arguments = asked(desk, "--certify", "--export", "colmap,transforms,opencv,glb,csv,mesh", "--report", "--out", out)
    with pytest.raises(SystemExit) as end:
        main([str(word) for word in arguments])
    assert not end.value.code
    return out, json.loads((out / "several_rings.json").read_text(encoding="utf-8"))


class OnRings(Exported):
    """The layout on several rings with everything exported from it, and its cameras according to `exact`."""

    def __init__(self, desk, written):
        self.folder, content = written
        self.scan, self.resolution = desk / "scan.stl", (3600, 2400)
        self.angles_deg = [one["ring_angle_deg"] for one in content["cameras"]]
        self.points = np.random.default_rng(7).uniform(-25, 25, (200, 3))
        self.cameras, self.names, numbers = [], [], [0, 0]
        for one in content["cameras"]:
            (made,) = RINGS[one["ring"] - 1].cameras([np.radians(one["ring_angle_deg"])])
            pixels = np.array(self.resolution, dtype=float)
            self.cameras.append(
                exact.Camera(made.position, made.rotation, made.target_distance, made.fov, pixels)
            )  # fmt: skip
            numbers[one["ring"] - 1] += 1
            self.names.append(f"ring_{one['ring']}_camera_{numbers[one['ring'] - 1]:02d}")


@pytest.fixture(scope="module")
def exported(desk, written):
    return OnRings(desk, written)


def test_the_file_says_what_the_library_finds(desk, written, quick_search):
    _, content = written
    search = dict(line.split(" = ") for line in quick_search.strip().splitlines()[1:])
    settings = {name: json.loads(value) for name, value in search.items() if name != "certify"}
    settings = placement.Settings(**settings | {"polish_steps": ()}, certificate_step=float(np.radians(15)))
    mesh = meshes.load(desk / "scan.stl")
    found = placement.optimise_rings(mesh, RINGS, 3, most=(None, 1), settings=settings, workers=1)
    assert [(one["ring"] - 1, one["ring_angle_rad"]) for one in content["cameras"]] == list(
        zip(found.ring_of, found.angles, strict=True)
    )
    assert (content["area_mm2"], content["fraction_of_all_rings"]) == (found.area, found.fraction)
    assert content["all_rings_area_mm2"] == found.maximum_area
    assert content["smallest_separation_mm"] == pytest.approx(found.smallest_separation)
    assert content["rings"][1]["most_cameras"] == 1 and content["rings"][1]["fov_mm"] == [54.0, 36.0]
    assert content["certificate"]["bound_fraction"] == bound_of(found).bound_fraction
    one, two = content["rings_alone"]
    assert one["area_mm2"] == alone(found)[0].area and one["fraction_of_all_rings"] == found.alone[0].fraction
    assert two == {"refused": "it takes at most 1 of the 3 cameras"}


def test_the_table_and_the_picture_are_written(desk, written):
    out, content = written
    with (out / "several_rings.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["layout"] for row in rows] == [
        "ring 1 (30 x 400), equidistant", "ring 1 (30 x 400), equidistant, best phase", "ring 1 (30 x 400), optimised",
        "ring 2 (16 x 380)", "all rings",
    ]  # fmt: skip
    mesh = meshes.load(desk / "scan.stl")
    for row in rows:
        if row["refused"]:
            assert not row["area_mm2"] and "at most 1 of the 3" in row["refused"]
            continue
        places = zip(row["rings"].split(), row["ring_angles_deg"].split(), strict=True)
        cameras = [RINGS[int(k) - 1].cameras([np.radians(float(angle))])[0] for k, angle in places]
        found = exact.evaluate(mesh, cameras, depth_axis=(0, 0, 1))
        assert float(row["area_mm2"]) == pytest.approx(found.area, rel=1e-9)
        assert float(row["rms_error_mm"]) == pytest.approx(found.error_rms, rel=1e-6)
        centres = np.array([camera.position for camera in cameras])
        apart = np.linalg.norm(centres[:, None] - centres[None], axis=2) + 1e9 * np.eye(3)
        assert float(row["smallest_separation_mm"]) == pytest.approx(apart.min())
        part = float(row["fraction_of_all_rings"]) * content["all_rings_area_mm2"]
        assert part == pytest.approx(found.area, rel=1e-9)
    assert matplotlib.image.imread(out / "several_rings.png").shape[1] > 1500
    shown = trimesh.load(out / "reconstructable.ply")
    assert isinstance(shown, trimesh.Trimesh) and shown.area == pytest.approx(content["area_mm2"], rel=1e-5)


def test_the_report_shows_what_each_camera_sees(desk, written, exported, chromium):  # noqa: F811
    out, content = written
    page, faults, requests = opened(chromium, out / "report.html", 1280, 900)
    buttons = page.locator("button[data-colouring]")
    assert buttons.all_inner_texts() == ["ring 1 alone", "all rings", "difference", "camera 1", "camera 2", "camera 3"]
    mesh, part = meshes.load(desk / "scan.stl"), 100 * content["fraction_of_all_rings"]
    words = f"all rings: {content['area_mm2']:.2f} mm² reconstructable, {part:.2f} % of what all rings see"
    assert page.inner_text("#caption") == words
    for number, (one, camera) in enumerate(zip(content["cameras"], exported.cameras, strict=True), start=3):
        buttons.nth(number).click(timeout=PATIENCE)
        page.wait_for_selector(f"#plot[data-shown='{number}']", timeout=PATIENCE)
        area = exact.evaluate(mesh, [camera], threshold=1).area
        sees = f"Camera {number - 2} on ring {one['ring']} at {one['ring_angle_deg']:.1f}° sees {area:.2f} mm²."
        assert page.inner_text("#caption") == sees
    assert page.locator("#ring svg circle").count() == 3 and page.locator("#ring svg.ring polyline").count() == 2
    assert content["certificate"]["statement"] in page.inner_text("#certificate")
    gain = content["fraction_of_all_rings"] - content["rings_alone"][0]["fraction_of_all_rings"]
    assert f"{100 * gain:+.2f} % against the best of one ring alone" in page.inner_text("header")
    assert faults == [] and requests == [(out / "report.html").as_uri()]


def test_the_report_says_how_to_repeat_it(desk, written, chromium, tmp_path):  # noqa: F811
    out, content = written
    page, *_ = opened(chromium, out / "report.html", 800, 900)
    rig = tmp_path / "rig.toml"
    rig.write_text(page.locator("#repeat pre").first.inner_text(), encoding="utf-8")
    one, two = rig_file.ring_tables(rig)
    assert (exact.Ring(**one), two.pop("most"), exact.Ring(**two)) == (RINGS[0], 1, RINGS[1])
    again, first = rig_file.rig(rig, True), rig_file.rig(desk / "rig.toml")
    assert (again.n_cameras, again.seed, again.certify, again.exclude) == (3, 0, True, "none")
    step = content["settings"]["certificate_step"]
    assert again.settings == dataclasses.replace(first.settings, certificate_step=step)
    commands = page.locator("#repeat pre").all_inner_texts()[1:]
    assert commands[0].endswith("scan.stl --rig rig.toml --report")
    assert commands[1].endswith("scan.stl --layout several_rings.json")


def test_without_a_ring_that_takes_all_cameras_there_is_nothing_to_compare_with(camring, desk, tmp_path):
    rings = ("--ring", "30x400:2", "--ring", "16x380@54x36:1", "--cameras", 3, "--report")
    status, _, err = camring(
        "optimise", desk / "scan.stl", "--rig", desk / "rig.toml", *rings, "--out", tmp_path / "out"
    )
    assert status == 0, err
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "against the best" not in page and ">difference<" not in page and page.count("data-colouring=") == 4
    assert "No layout of ring 1 (30 x 400) alone: it takes at most 2 of the 3 cameras." in page
    assert "at most 2 of the cameras" in page and "most = 2" in page


def test_what_is_printed(camring, desk, tmp_path):
    status, out, err = camring(*asked(desk, "--out", tmp_path / "out"))
    assert status == 0 and "wrote" in err
    words = " ".join(out.split())
    assert "all rings together (8 cameras on each)" in words
    assert "no layout of ring 2 (16 x 380) alone: it takes at most 1 of the 3 cameras" in words
    assert "optimised cameras: ring 1 (30 x 400 mm): at" in words and "ring 2 (16 x 380 mm): at" in words
    status, out, _ = camring(*asked(desk, "--out", tmp_path / "other", "--json", "--target", "0.99999"))
    assert status == 1 and len(json.loads(out)["layouts"]) == 5


def test_evaluate_and_export_take_its_file(camring, desk, written, exported, tmp_path):
    out, content = written
    layout = out / "several_rings.json"
    images, areas = tmp_path / "images", tmp_path / "areas"
    status, printed, err = camring(
        "evaluate", desk / "scan.stl", "--layout", layout, "--json", "--target", "0.5", "--rig", desk / "none.toml"
    )
    assert status == 2 and "a layout brings its own ring" in err
    asked = ("evaluate", desk / "scan.stl", "--layout", layout, "--images", images, "--out", areas)
    status, printed, err = camring(*asked, "--json", "--target", "0.5")
    assert status == 0, err
    told = json.loads(printed)
    assert told["area_mm2"] == pytest.approx(content["area_mm2"], rel=1e-12)
    assert told["errors_mm"]["rms"] == pytest.approx(content["rms_error_mm"], rel=1e-9)
    assert told["ring_of_camera"] == [one["ring"] for one in content["cameras"]] and len(told["rings"]) == 2
    around = [camera for ring in RINGS for camera in ring.cameras(ring.equidistant(360))]
    maximum = exact.evaluate(meshes.load(desk / "scan.stl"), around).area
    assert told["ring_maximum_mm2"] == pytest.approx(maximum, rel=1e-12)
    single = [exact.evaluate(meshes.load(desk / "scan.stl"), [one], threshold=1).area for one in exported.cameras]
    assert told["camera_areas_mm2"] == pytest.approx(single, rel=1e-12)
    assert len(list(images.glob("camera_*.png"))) == 3
    status, printed, _ = camring("evaluate", desk / "scan.stl", "--layout", layout)
    assert status == 0 and "ring angle [degrees]" in printed and f"{content['area_mm2']:.4f}" in printed
    status, _, err = camring("export", layout, "--format", "csv,opencv", "--out", tmp_path / "same")
    assert status == 0, err
    same, first = ((folder / "cameras.csv").read_bytes() for folder in (tmp_path / "same", out))
    assert same == first
    status, printed, _ = camring(
        "export", layout, "--format", "csv", "--resolution", "1200x800", "--out", tmp_path / "less"
    )
    assert status == 0 and "3 cameras, 1200 x 800 pixels each" in printed


@pytest.mark.parametrize("command", ["compare", "report", "simulate", "design"])
def test_other_commands_say_that_they_do_not(camring, desk, written, tmp_path, command):
    layout, scan = written[0] / "several_rings.json", desk / "scan.stl"
    asked = {
        "compare": (layout, layout, "--mesh", scan),
        "report": (layout, "--mesh", scan, "--out", tmp_path),
        "simulate": (scan, "--layout", layout, "--out", tmp_path),
        "design": (scan, "--layout", layout, "--no-browser"),
    }[command]
    status, out, err = camring(command, *asked)
    assert (status, out) == (2, "") and "is a layout on several rings; camring evaluate and export take one" in err


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"rings": []}, '"rings" must list at least one ring'),
        ({"rings": [{"diameter_mm": 3.0}]}, 'ring 1 of "rings" must give diameter_mm, working_distance_mm and fov_mm'),
        ({"cameras": []}, '"cameras" must list at least one camera'),
        ({"cameras": [{"ring": 3, "ring_angle_rad": 0.0}]}, 'camera 1 of "cameras" must give its "ring", a whole'),
        ({"cameras": [{"ring": 1}]}, 'camera 1 of "cameras" must give "ring_angle_rad" or "ring_angle_deg"'),
        ({"cameras": [{"ring": 1, "ring_angle_rad": 0.0, "ring_angle_deg": 9.0}]}, "are not the same angles"),
        ({"n_cameras": 4}, '"n_cameras" is 4, and there are 3 cameras'),
        ({"ring": {}}, "there is no field 'ring'; did you mean rings?"),
    ],
)
def test_a_file_that_was_changed_is_refused(camring, desk, written, tmp_path, change, said):
    content = json.loads((written[0] / "several_rings.json").read_text(encoding="utf-8")) | change
    (tmp_path / "changed.json").write_text(json.dumps(content), encoding="utf-8")
    status, out, err = camring("evaluate", desk / "scan.stl", "--layout", tmp_path / "changed.json")
    assert (status, out) == (2, "") and said in " ".join(err.split()) and "Traceback" not in err


def test_the_place_is_that_of_one_ring(camring, desk, written):
    layout = written[0] / "several_rings.json"
    status, _, err = camring("evaluate", desk / "scan.stl", "--layout", layout, "--place", "auto")
    assert status == 2 and "--place finds the place of one ring" in err


TABLES = """
[[ring]]

[[ring]]
diameter = 16
working_distance = 380
fov = [54, 36]
most = 1
"""


def test_a_rig_file_takes_several_rings(camring, desk, tmp_path, quick_search):
    rig = tmp_path / "several.toml"
    rig.write_text(TABLES + quick_search, encoding="utf-8")
    common = ("--cameras", 3, "--json")
    told = camring("optimise", desk / "scan.stl", "--rig", rig, *common, "--out", tmp_path / "one")
    same = camring(*asked(desk, *common, "--out", tmp_path / "two"))
    one, two = (json.loads(out) for _, out, _ in (told, same))
    assert one == two and [ring["most_cameras"] for ring in one["rings"]] == [None, 1]
    turned = ("--fov", "40x30", "--roll-deg", 10)
    status, out, _ = camring("optimise", desk / "scan.stl", "--rig", rig, *common, *turned, "--out", tmp_path / "three")
    rings = json.loads(out)["rings"]
    assert status == 0 and [ring["fov_mm"] for ring in rings] == [[40.0, 30.0]] * 2
    assert [ring["roll"] for ring in rings] == pytest.approx([np.radians(10)] * 2)
    status, _, err = camring("count", desk / "scan.stl", "--rig", rig, "--out", tmp_path / "out")
    assert status == 2 and "has 2 rings, tables [[ring]], of which camring optimise alone takes several" in err


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("diametre = 3", "there is no key 'diametre' in [[ring]]; did you mean diameter?"),
        ("most = 1.5", "most in [[ring]] is 1.5; it must be a whole number"),
        ("diameter = 'wide'", "diameter in [[ring]] is 'wide'; it must be a number"),
        ("diameter = 0", "ring diameter is 0"),
        ("most = -1", "most is (None, -1); it must give a whole number"),
    ],
)
def test_tables_that_cannot_be_are_refused(camring, desk, tmp_path, table, said):
    rig = tmp_path / "several.toml"
    rig.write_text(f"[[ring]]\n[[ring]]\n{table}\n", encoding="utf-8")
    status, out, err = camring("optimise", desk / "scan.stl", "--rig", rig, "--out", tmp_path / "out")
    assert (status, out) == (2, "") and said in " ".join(err.split()) and "Traceback" not in err


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--ring", "30by400"), "--ring is '30by400'; it must be diameter x working distance"),
        (("--ring", "30x400:"), "--ring is '30x400:'; it must be"),
        (("--ring", "30x400:1.5"), "--ring is '30x400:1.5'; it must be"),
        (("--ring", "30x400@"), "--ring is '30x400@'; it must be"),
        (("--ring", "nanx400"), "--ring is 'nanx400'; it must be"),
        (("--ring", "0x400"), "--ring is '0x400'; it must be"),
        (("--diameter", 20), "each ring says what --diameter does; leave it out, or the rings"),
        (("--fixed-deg", "10"), "fixed cameras and forbidden arcs are those of one ring"),
        (("--roll", "free"), "the rolls of ring 1 are free, which is known for one ring only"),
        (("--min-angle-deg", 1), "min_angle is known for one ring only"),
        (("--min-separation", 40), "3 cameras do not fit on these rings: ring 1 1, ring 2 1"),
    ],
)
def test_what_cannot_be_is_refused(camring, desk, tmp_path, options, said):
    status, out, err = camring(*asked(desk, *options, "--out", tmp_path / "out"))
    assert (status, out) == (2, "")
    assert said in " ".join(err.split()) and "Traceback" not in err
