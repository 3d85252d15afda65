"""Rolls at the command line, in rig files and in layout files, and what commands make of them."""

import json

import matplotlib.image
import numpy as np
import pytest
import trimesh

import exact
from experiments.layouts.layout_file import read
from experiments.report.scene import drawn_surface
from experiments.request import rig as rig_file
from tests.support.files import LAYOUT, RING, put

# A plate 100 mm long and 30 mm wide in the focus: a camera above sees 36 x 24 mm of it, or 24 x 30 where the width of
# its image lies across the plate.
ALONG, ACROSS = 36.0 * 24.0, 24.0 * 30.0


@pytest.fixture
def plate(tmp_path):
    corners = np.array([[-50, -15, 0], [50, -15, 0], [50, 15, 0], [-50, 15, 0]], dtype=float)
    path = tmp_path / "plate.ply"
    trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]]).export(path)
    return path


def test_options_rig_files_and_what_wins(tmp_path):
    def roll(**options):
        return rig_file.rig(**options).ring((1.0, 1.0)).roll

    assert (roll(), roll(roll="tangential"), roll(roll_deg=90.0)) == ("radial", "tangential", np.pi / 2)
    word, angle = (
        put(tmp_path, "a.toml", '[ring]\nroll = "tangential"'),
        put(tmp_path, "b.toml", "[ring]\nroll_deg = 180"),
    )
    assert (roll(path=word), roll(path=angle)) == ("tangential", np.pi)
    assert (roll(path=word, roll_deg=0.0), roll(path=angle, roll="radial")) == (0.0, "radial")


# From straight above, all but.
NARROW = ("--diameter", "0.01", "--min-baseline", "0", "--threshold", "1", "--exclude", "none")


@pytest.mark.parametrize(
    ("roll", "angle", "area"),
    [
        (("--roll", "radial"), 90, ALONG), (("--roll", "radial"), 0, ACROSS), (("--roll", "tangential"), 0, ALONG),
        (("--roll-deg", "0"), 0, ALONG), (("--roll-deg", "0"), 90, ALONG), (("--roll-deg", "90"), 37, ACROSS),
    ],
)  # fmt: skip
def test_evaluate_turns_the_field_of_view(camring, plate, roll, angle, area):
    status, out, err = camring("evaluate", plate, "--angles-deg", angle, *roll, *NARROW, "--json")
    assert status == 0, err
    assert json.loads(out)["area_mm2"] == pytest.approx(area, rel=1e-4)


def test_a_layout_brings_its_rolls(camring, plate, tmp_path):
    """Two sensors of their own rolls: both along the plate, then crossed."""
    for rolls, area in (([0.0, 0.0], ALONG), ([0.0, 90.0], 24.0 * 24.0)):
        ring = RING | {"diameter_mm": 0.01}
        layout = put(
            tmp_path, "layout.json", json.dumps(LAYOUT | {"ring": ring, "angles_deg": [90, 270], "rolls_deg": rolls})
        )
        brought = read(layout).rolls
        assert brought is not None and np.degrees(brought) == pytest.approx(rolls)
        images = tmp_path / f"images{rolls[1]:g}"
        status, out, err = camring(
            "evaluate", plate, "--layout", layout, "--exclude", "none", "--images", images, "--json"
        )
        assert status == 0, err
        assert json.loads(out)["area_mm2"] == pytest.approx(area, rel=1e-4)
        assert matplotlib.image.imread(images / "camera_02.png").size


def test_layouts_with_rolls_and_without_are_compared(camring, plate, tmp_path):
    given = LAYOUT | {"ring": RING | {"diameter_mm": 0.01}, "angles_deg": [90, 270]}
    crossed = put(tmp_path, "layout.json", json.dumps(given | {"rolls_deg": [0.0, 90.0]}))
    other = put(tmp_path, "other.json", json.dumps(given))
    assert read(other).rolls is None
    status, out, err = camring("compare", crossed, other, "--mesh", plate, "--out", tmp_path / "compared", "--json")
    assert status == 0, err
    areas = [one["area_mm2"] for one in json.loads(out)["layouts"]]
    assert areas == pytest.approx([24.0 * 24.0, ALONG], rel=1e-4)


def test_the_designer_takes_no_layout_with_rolls_of_its_own(camring, plate, tmp_path):
    layout = put(tmp_path, "layout.json", json.dumps(LAYOUT | {"rolls_deg": [0, 90]}))
    status, _, err = camring("design", plate, "--layout", layout, "--no-browser")
    assert status == 2
    assert "gives each camera a roll of its own, which the designer does not know" in err


def test_optimise_and_report_with_rolls(camring, plate, tmp_path, quick_search):
    (tmp_path / "quick.toml").write_text(quick_search, encoding="utf-8")
    out = tmp_path / "out"
    status, _, err = camring(
        "optimise", plate, "--rig", tmp_path / "quick.toml", "--cameras", 2, "--roll-deg", 0, "--report", "--out", out
    )
    assert status == 0, err
    made = read(out / "layout.json")
    assert made.ring.roll == 0.0 and made.rolls is None
    content = json.loads((out / "layout.json").read_text(encoding="utf-8"))
    # All images lie along the plate, wherever the cameras sit.
    assert content["areas_mm2"]["optimised"] == pytest.approx(ALONG, rel=1e-2)
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "the width of every image along ring angle 0°" in page and "roll_deg = 0.0" in page
    assert "<th>roll [°]</th>" in page and page.count('class="width"') == 2 + 1


def test_the_borders_of_views_are_drawn_where_they_meet_the_surface():
    box, angles, rolls = trimesh.creation.box((10, 9, 8)), np.array([0.3, 2.0]), np.array([0.4, -1.0])
    ring = exact.Ring(focus=(1.0, 2.0, 0.0), axis=(0.1, 0.0, 1.0))
    drawn = drawn_surface(exact.Scene(box), ring, angles, exact.Demand(), rolls=rolls)
    even = ring.cameras(ring.equidistant(2))
    for corners, camera in zip(drawn.fields, (*even, *ring.cameras(angles, rolls)), strict=True):
        width, height = camera.resolution
        assert camera.project(corners) == pytest.approx(
            np.array([[0, 0], [width, 0], [width, height], [0, height]]), abs=1e-9
        )
        levels = corners @ ring.frame[:, 2]
        assert np.ptp(levels) < 1e-9 and levels[0] == pytest.approx((box.vertices @ ring.frame[:, 2]).max(), abs=0.01)
    assert [one.cameras.tolist() for one in drawn.colourings] == [[0, 1], [2, 3], [2, 3], [2], [3]]


def test_free_rolls_from_the_command_line_to_the_report(camring, plate, tmp_path, quick_search):
    """Two fixed cameras a quarter of the ring apart: turned, both look along the plate."""
    (tmp_path / "quick.toml").write_text(quick_search, encoding="utf-8")
    out, fixed = tmp_path / "out", ("--rig", tmp_path / "quick.toml", "--fixed-deg", "0,90", "--diameter", 8)
    status, printed, err = camring(
        "optimise", plate, *fixed, "--cameras", 2, "--roll", "free", "--report", "--export", "opencv", "--out", out
    )
    assert status == 0, err
    assert "for free rolls nothing is told of faults and of a bound" in err and "optimised rolls [degrees]:" in printed
    made, content = read(out / "layout.json"), json.loads((out / "layout.json").read_text(encoding="utf-8"))
    assert made.ring.roll == "free" and made.rolls is not None
    assert np.abs(np.sin(made.rolls - [np.pi / 2, 0])) == pytest.approx(0, abs=0.1)
    assert content["areas_mm2"]["optimised"] == pytest.approx(ALONG, rel=2e-2)
    table = (out / "layouts.csv").read_text(encoding="utf-8").splitlines()
    assert table[0].endswith(",rolls_deg") and table[1].endswith("0.0 0.0")
    turns = [camera["R"] for camera in json.loads((out / "opencv.json").read_text(encoding="utf-8"))["cameras"]]
    assert turns == pytest.approx(np.array([one.rotation for one in made.ring.cameras(made.angles, made.rolls)]))
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "<dt>sensors</dt><dd>free</dd>" in page and "roll = &#34;free&#34;" in page and "<th>roll [°]</th>" in page

    status, printed, err = camring("evaluate", plate, "--layout", out / "layout.json", "--exclude", "none", "--json")
    assert status == 0, err
    assert json.loads(printed)["area_mm2"] == pytest.approx(content["areas_mm2"]["optimised"], rel=1e-12)
    # Beside one of radial sensors, for which the ring maximum is the same.
    assert camring("optimise", plate, *fixed, "--cameras", 2, "--no-robustness", "--out", tmp_path / "radial")[0] == 0
    layouts = (out / "layout.json", tmp_path / "radial" / "layout.json")
    status, printed, err = camring("compare", *layouts, "--mesh", plate, "--json")
    assert status == 0, err
    first, second = (one["fraction_of_ring_maximum"] for one in json.loads(printed)["layouts"])
    assert first > 1.3 * second
    status, _, err = camring("design", plate, "--roll", "free", "--no-browser", "--cameras", 2)
    assert status == 2 and "the designer turns sensors as the ring says" in err
