"""Optics, limits, bounded errors, obstacles and lights at the command line, in rig files and in layout files."""

import json

import pytest
import trimesh

import exact
import meshes

WALL = [trimesh.creation.box((30, 30, 2)), trimesh.creation.box((4, 30, 20))]
LIGHT = (20.0, 0.0, 300.0)
ASKED = {
    "options": ["--max-error", "0.12", "--max-incidence-deg", "80", "--min-pixel-density", "300", "--depth-of-field",
                "380:402", "--pixels", "3600x2400", "--match-noise", "0.6", "--light", "20,0,300"],
    "key": '[demand]\nmax_error = 0.12\n[limits]\nmax_incidence_deg = 80\nmin_pixel_density = 300\n'
           'depth_of_field = [380, 402]\n[optics]\nresolution = [3600, 2400]\nmatch_noise = 0.6\n'
           '[mesh]\nlight = [[20, 0, 300]]\nobstacle = ["lamp.stl"]\n',
}  # fmt: skip
DEMAND = exact.Demand(
    max_error=0.12, depth_axis=(0, 0, 1), optics=exact.Optics(match_noise=0.6),
    limits=exact.Limits(max_incidence=1.3962634015954636, min_pixel_density=300.0, depth_of_field=(380, 402)),
)  # fmt: skip


@pytest.fixture
def desk(tmp_path, monkeypatch):
    trimesh.boolean.union(WALL, engine="manifold").export(tmp_path / "scan.stl")
    lamp = trimesh.creation.box((5, 5, 2), trimesh.transformations.translation_matrix((6, 5, 60)))
    lamp.export(tmp_path / "lamp.stl")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def scene(desk):
    return exact.Scene(meshes.load(desk / "scan.stl"), obstacles=(meshes.load(desk / "lamp.stl"),), lights=(LIGHT,))


@pytest.mark.parametrize("way", ASKED)
def test_evaluate_asks_for_all_of_it(camring, desk, way):
    if way == "key":
        (desk / "rig.toml").write_text(ASKED["key"], encoding="utf-8")
        more = ["--rig", "rig.toml"]
    else:
        more = [*ASKED["options"], "--obstacle", "lamp.stl"]
    status, printed, _ = camring("evaluate", "scan.stl", "--angles-deg", "10,100,200,300", "--json", *more)
    assert status == 0
    ring = exact.Ring()
    cameras = ring.cameras([0.17453292519943295, 1.7453292519943295, 3.490658503988659, 5.235987755982989])
    wanted, told = exact.evaluate(scene(desk), cameras, demand=DEMAND), json.loads(printed)
    assert told["area_mm2"] == pytest.approx(wanted.area, rel=1e-9)
    of_one = {"threshold": 1, "limits": DEMAND.limits, "optics": DEMAND.optics}
    single = [exact.evaluate(scene(desk), [camera], **of_one).area for camera in cameras]
    assert told["camera_areas_mm2"] == pytest.approx(single, rel=1e-9) and max(single) <= told["level_areas_mm2"][0]
    assert wanted.area < 0.95 * exact.evaluate(scene(desk).mesh, cameras).area


def test_a_layout_brings_its_demand_along(camring, desk, quick_search):
    (desk / "rig.toml").write_text(ASKED["key"] + quick_search, encoding="utf-8")
    status, printed, _ = camring(
        "optimise", "scan.stl", "--cameras", "3", "--rig", "rig.toml", "--out", "out", "--json"
    )
    assert status == 0
    content = json.loads((desk / "out" / "layout.json").read_text(encoding="utf-8"))
    names = [row["layout"] for row in json.loads(printed)["layouts"]]
    assert names[0] == "equidistant" and names[-1] == "optimised"
    assert content["give_up"] == 0.005 and content["lights"] == [list(LIGHT)] and len(content["obstacles"]) == 1
    assert content["most_area"]["fraction_of_ring_maximum"] >= content["fractions_of_ring_maximum"]["optimised"]
    found = exact.evaluate(scene(desk), exact.Ring().cameras(content["angles_rad"]), demand=DEMAND)
    assert content["areas_mm2"]["optimised"] == pytest.approx(found.area, rel=1e-9)
    assert content["rms_errors_mm"]["optimised"] == pytest.approx(found.error_rms, rel=1e-6)
    more = ("--layout", "out/layout.json", "--light", "20,0,300", "--obstacle", "lamp.stl", "--json")
    status, printed, _ = camring("evaluate", "scan.stl", *more)
    assert status == 0 and json.loads(printed)["area_mm2"] == pytest.approx(found.area, rel=1e-9)


def test_options_written_as_text_change_what_a_layout_asks_for(camring, desk):
    ring = {"diameter_mm": 30, "working_distance_mm": 400, "fov_mm": [36, 24]}
    layout = {"format": "camring layout", "version": 1, "ring": ring, "angles_deg": [10, 20, 30]}
    (desk / "layout.json").write_text(json.dumps(layout), encoding="utf-8")
    options = ("--depth-of-field", "380:399.5", "--pixels", "1800x1200", "--max-error", "1.1", "--json")
    status, printed, _ = camring("evaluate", "scan.stl", "--layout", "layout.json", *options)
    limits, optics = exact.Limits(depth_of_field=(380, 399.5)), exact.Optics(resolution=(1800, 1200))
    cameras = exact.Ring().cameras([0.17453292519943295, 0.3490658503988659, 0.5235987755982988])
    # All cameras sit to one side: depth is measured along the axis of the ring all the same.
    demand = exact.Demand(max_error=1.1, depth_axis=(0, 0, 1), limits=limits, optics=optics)
    wanted = exact.evaluate(meshes.load("scan.stl"), cameras, demand=demand).area
    assert status == 0 and json.loads(printed)["area_mm2"] == pytest.approx(wanted, rel=1e-9)
    assert 0 < wanted < exact.evaluate(meshes.load("scan.stl"), cameras).area


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [
        ("--pixels", "3600", "--pixels is '3600'; it must be width x height in pixels"),
        ("--depth-of-field", "380-400", "--depth-of-field is '380-400'; it must be two numbers in millimetres"),
        ("--light", "0,0", "--light is '0,0'; it must be three numbers"),
        ("--obstacle", "none.stl", "none.stl: no such file"),
        ("--max-blur", "2", "give the optics a pupil"),
        ("--max-error", "0", "max_error is 0.0; it must be a number, positive"),
        ("--error", "sideways", 'it must be "depth" or "normal"'),
    ],
)
def test_what_makes_no_sense_is_refused(camring, desk, option, value, words):
    status, printed, said = camring("evaluate", "scan.stl", "--cameras", "3", option, value)
    assert status == 2 and printed == "" and words in " ".join(said.split())
    assert "Traceback" not in said
