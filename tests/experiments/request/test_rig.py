"""Rig files: what they set, what wins over them, what is refused, and the one that is written to start from."""

import dataclasses
import json
import re

import numpy as np
import pytest
import trimesh

import exact
import meshes
import placement
from experiments.layouts.layout_file import constraints_of
from experiments.request import options as request_options
from experiments.request import rig as rig_file
from experiments.request.option_kinds import NUMBER
from experiments.request.option_text import parse_angles, parse_arcs


@pytest.fixture
def write(tmp_path):
    def written(text, name="rig.toml"):
        (tmp_path / name).write_text(text, encoding="utf-8")
        return tmp_path / name

    return written


@pytest.fixture
def scan(tmp_path):
    """A step, in metres."""
    step = trimesh.boolean.union(
        [trimesh.creation.box((30, 30, 2)), trimesh.creation.box((4, 30, 20))], engine="manifold"
    )
    step.apply_scale(0.001).export(tmp_path / "scan.stl")
    return tmp_path / "scan.stl"


def test_the_file_to_start_from_holds_every_key_and_says_what_holds_without_it(camring, tmp_path):
    path = tmp_path / "rig.toml"
    status, out, err = camring("rig", "init", path)
    assert (status, out) == (0, "")
    assert f"--rig {path}" in " ".join(err.split())
    assert rig_file.rig(path) == rig_file.rig()
    text = path.read_text(encoding="utf-8")
    for section, keys in request_options.sections().items():
        part = text.partition(f"\n[{section}]\n")[2].partition("\n[")[0]
        for name, key in keys.items():
            # Its meaning stands above each; one without a default is commented out.
            assert re.search(rf"^# \S.*\n{'# ' if key.default is None else ''}{name} = \S", part, flags=re.M), name
            assert key.kind is not NUMBER or "[" in key.meaning or name in ("scale", "give_up"), f"{name} has no unit"
    path.write_text("precious", encoding="utf-8")
    assert camring("rig", "init", path)[0] == 2
    assert path.read_text(encoding="utf-8") == "precious"
    assert camring("rig", "init", path, "--force")[0] == 0
    assert path.read_text(encoding="utf-8") == text


def test_what_stands_commented_out_may_be_uncommented(camring, tmp_path):
    camring("rig", "init", tmp_path / "rig.toml")
    text = (tmp_path / "rig.toml").read_text(encoding="utf-8")
    (tmp_path / "rig.toml").write_text(re.sub(r"^# (\w+ = )", r"\1", text, flags=re.M), encoding="utf-8")
    rig = rig_file.rig(tmp_path / "rig.toml")
    assert (rig.fov, rig.exclude) == ((36.0, 24.0), "top")


def test_without_anything_said_the_library_s_defaults_hold():
    rig = rig_file.rig()
    assert rig.ring((36.0, 24.0)) == exact.Ring()
    assert rig.constraints == placement.Constraints()
    assert rig.settings == placement.Settings()
    assert {field.name for field in dataclasses.fields(placement.Settings)} <= set(request_options.keys())
    n_keys = sum(map(len, request_options.sections().values()))
    assert n_keys == len(request_options.keys())  # no name stands for two keys


EVERYTHING = """
[ring]
diameter = 20
working_distance = 300.0
fov = [40, 30]
focus = [1, 2, 3]
axis = [0, 1, 1]
[cameras]
count = 6
threshold = 3
[constraints]
min_separation = 2.5
min_baseline = 4
min_angle_deg = 1.5
fixed_deg = [0, 90]
forbidden_deg = [[200, 230], [350, 355.5]]
[search]
seed = 7
certify = false
n_samples = 123
temperatures = [0.4, 0.1]
[mesh]
exclude = "faces.txt"
repair = true
scale = 25.4
"""


def test_every_key_arrives(write, tmp_path):
    rig = rig_file.rig(write(EVERYTHING))
    assert rig.ring((1.0, 1.0)) == exact.Ring(20, 300, (40, 30), (1, 2, 3), (0, 1, 1))
    assert (rig.n_cameras, rig.demand.threshold, rig.seed, rig.certify, rig.repair, rig.scale) == (
        6,
        3,
        7,
        False,
        True,
        25.4,
    )
    assert rig.constraints.min_separation == 2.5
    assert rig.constraints.min_baseline == 4.0
    assert np.degrees(rig.constraints.min_angle) == pytest.approx(1.5)
    assert np.degrees(rig.constraints.fixed) == pytest.approx([0, 90])
    assert np.degrees(rig.constraints.forbidden) == pytest.approx(np.array([[200, 230], [350, 355.5]]))
    assert rig.settings == placement.Settings(n_samples=123, temperatures=(0.4, 0.1))
    assert rig.exclude == str(tmp_path / "faces.txt")  # beside the rig file


def test_an_option_wins_over_the_file_and_the_file_over_the_default(write):
    path = write(EVERYTHING)
    words = dict(fov="10x20", fixed_deg="45", forbidden_deg="60:90,350:10", exclude="none")
    rig = rig_file.rig(path, count=2, min_separation=0.0, diameter=None, repair=False, **words)
    assert (rig.n_cameras, rig.constraints.min_separation, rig.repair, rig.exclude) == (2, 0.0, False, "none")
    assert rig.fov == (10.0, 20.0)
    assert np.degrees(rig.constraints.fixed) == pytest.approx([45])
    assert np.degrees(rig.constraints.forbidden) == pytest.approx(np.array([[60, 90], [350, 10]]))
    assert (rig.diameter, rig.demand.threshold, rig.constraints.min_baseline) == (20.0, 3, 4.0)
    assert rig_file.rig(path, fixed_deg="", forbidden_deg="").constraints.fixed == ()
    assert rig_file.rig(write("")) == rig_file.rig()


REFUSED = {
    "[ring]\ndiamter = 30": r"no key 'diamter' in \[ring\]; did you mean diameter\? Keys of \[ring\] are diameter,",
    "[ring]\nxyz = 30": r"no key 'xyz' in \[ring\]\. Keys of \[ring\] are",
    "[constraint]\nmin_separation = 1": r"no section \[constraint\]; did you mean \[constraints\]\? Sections are",
    "[ring]\ncount = 4": r"count in \[ring\] is in the wrong place; it belongs below \[cameras\]",
    "diameter = 30": r"diameter stands in no section; it belongs below \[ring\]",
    "ring = 30": r"ring is 30; needed is a section \[ring\]",
    "[ring]\ndiameter = '30'": r"diameter in \[ring\] is '30'; it must be a number",
    "[ring]\ndiameter = true": r"diameter in \[ring\] is True; it must be a number",
    "[ring]\ndiameter = nan": r"diameter in \[ring\] is nan; it must be a number",
    "[ring]\nfov = 36": r"fov in \[ring\] is 36; it must be a list of two numbers, as in \[36\.0, 24\.0\]",
    "[ring]\nfov = [36, 24, 1]": r"must be a list of two numbers",
    "[ring]\nfocus = [0, 0]": r"must be a list of three numbers",
    "[cameras]\ncount = 4.0": r"count in \[cameras\] is 4\.0; it must be a whole number",
    "[cameras]\nthreshold = true": r"it must be a whole number",
    "[constraints]\nfixed_deg = 90": r"must be a list of numbers, as in",
    "[constraints]\nfixed_deg = ['a']": r"must be a list of numbers, as in",
    "[constraints]\nforbidden_deg = [60, 90]": r"must be a list of \[start, end\], as in \[\[60",
    "[search]\ncertify = 1": r"certify in \[search\] is 1; it must be true or false",
    "[search]\nn_sample = 10": r"did you mean n_samples\?",
    "[mesh]\nexclude = 3": r"exclude in \[mesh\] is 3; it must be a text in quotes",
    "[ring\n": r"is not a rig file: it holds no valid TOML \(.*line 1",
    # Right in kind, but out of range: whoever uses the value says so.
    "[ring]\ndiameter = -1": r"ring diameter is -1",
    "[constraints]\nmin_separation = -1": r"min_separation is -1\.0; it must be a number, at least 0 \[mm\]",
    "[search]\nn_samples = 0": r"n_samples is 0; it must be a whole number >= 1",
    "[mesh]\nscale = 2.0": r"circ_flat is in millimetres; leave the scale of 2 out",
}


@pytest.mark.parametrize("text", REFUSED)
def test_what_is_not_understood_is_refused_with_its_name(camring, write, tmp_path, text):
    status, out, err = camring("optimise", "circ_flat", "--rig", write(text), "--out", tmp_path / "out")
    assert (status, out) == (2, "")
    assert re.search(REFUSED[text], " ".join(err.split())), err
    assert not (tmp_path / "out" / "layout.json").exists()


def test_a_rig_file_that_is_not_there(camring, tmp_path):
    status, _, err = camring("evaluate", "circ_flat", "--rig", tmp_path / "no.toml")
    assert status == 2
    assert re.search(r"cannot read rig file .*no\.toml.*camring rig init writes one", " ".join(err.split()))


@pytest.mark.parametrize(
    ("parse", "text", "message"),
    [
        (parse_arcs, "60-90", r"--forbidden-deg is '60-90'; it must be arcs start:end in degrees.*60:90,200:230"),
        (parse_arcs, "60:90:100", "must be arcs"),
        (parse_arcs, "60:inf", "must be arcs"),
        (parse_angles, "0;90", "must be numbers separated by commas"),
    ],
)
def test_words_of_options_that_are_not_understood(parse, text, message):
    with pytest.raises(ValueError, match=message):
        parse(text)


def test_optimise_meets_what_file_and_options_ask_for(camring, write, scan, tmp_path, quick_search):
    rig = write(
        "[ring]\nfov = [60, 40]\n[cameras]\ncount = 3\n[constraints]\nmin_baseline = 9.0\nfixed_deg = [10]\n[mesh]\n"
        'scale = 1000\nexclude = "top"\n' + quick_search
    )
    out = tmp_path / "out"
    arguments = ("optimise", scan, "--rig", rig, "--forbidden-deg", "60:200", "--min-separation", "6", "--out", out)
    status, printed, err = camring(*arguments, "--json", "--target", "1")
    assert status == 1, err  # eight cameras that may sit anywhere see more
    assert "target missed: the optimised 3 cameras reach 0." in " ".join(err.split())
    content = json.loads(printed)
    names = [row["layout"].split(",")[0] for row in content["layouts"]]
    assert [name for name in names if name != "most area"] == ["equidistant", "equidistant", "optimised"]
    written = json.loads((out / "layout.json").read_text(encoding="utf-8"))
    assert {key: content[key] for key in written} == written
    kept = constraints_of(written["constraints"])
    assert kept == rig_file.rig(rig, forbidden_deg="60:200", min_separation=6.0).constraints
    ring = exact.Ring(fov=(60, 40))
    assert kept.violations(ring, written["angles_rad"]) == []
    mesh = meshes.load(scan, scale=1000)
    area = exact.evaluate(
        mesh, ring.cameras(written["angles_rad"]), exclude=meshes.top_surface(mesh), min_baseline=9.0
    ).area
    assert written["areas_mm2"]["optimised"] == pytest.approx(area, rel=1e-12)
    assert area > 100  # mm², not m²

    # The layout brings its baseline along: others score it in the same way.
    again = camring("evaluate", scan, "--scale", 1000, "--layout", out / "layout.json", "--exclude", "top", "--json")
    assert json.loads(again[1])["area_mm2"] == pytest.approx(area, rel=1e-12)
    assert json.loads(again[1])["min_baseline_mm"] == 9.0
    by_hand = {key: written[key] for key in ("format", "version", "ring")} | {"angles_deg": [120, 240, 360]}
    other = write(json.dumps(by_hand), "mine.json")
    compared = ("compare", other, out / "layout.json", "--mesh", scan, "--scale", 1000, "--exclude", "top", "--json")
    compared = json.loads(camring(*compared)[1])
    assert compared["min_baseline_mm"] == 9.0
    assert compared["layouts"][1]["area_mm2"] == pytest.approx(area, rel=1e-12)


def test_constraints_that_cannot_be_met_are_refused_with_what_can(camring, scan, tmp_path):
    asked = ("optimise", scan, "--scale", 1000, "--cameras", 4, "--out", tmp_path / "out")
    status, _, err = camring(*asked, "--min-separation", 10, "--forbidden-deg", "0:286.4789")
    assert status == 2
    assert "4 cameras at 10 mm do not fit beside 1 forbidden arc: 2 do, or 4 at 6.36 mm" in " ".join(err.split())
    status, _, err = camring(*asked, "--min-angle-deg", 5)
    assert status == 2
    assert "an angle of at most 4.29 degrees" in " ".join(err.split())
