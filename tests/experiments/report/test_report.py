"""report.html in a real browser: what it shows, that its buttons work, that it asks no network for anything."""

import csv
import json
import re
import shlex

import matplotlib.image
import numpy as np
import pytest
import trimesh
from playwright.sync_api import sync_playwright

import exact
import meshes
from experiments.cli.app import main
from experiments.layouts.layout_file import read
from experiments.report import request_text as report_words
from experiments.report.scene import drawn_surface
from experiments.request import rig as rig_file
from tests.support.browser import FLAGS, PATIENCE, browser_path

# A name that would do something if it were taken for HTML; the rest of the report must be whole around it.
NASTY = "<img src=x onerror=alert(1)> & <script>alert(2)<script> scán.stl"


@pytest.fixture(scope="module")
def made(tmp_path_factory, quick_search):
    """The folder of one optimisation with a report, of a file with a name that looks like HTML."""
    folder = tmp_path_factory.mktemp("report")
    step = trimesh.boolean.union(
        [trimesh.creation.box((30, 30, 2)), trimesh.creation.box((4, 30, 20))], engine="manifold"
    )
    step.export(folder / NASTY)
    (folder / "quick.toml").write_text(quick_search.replace("certify = false", "certify = true"), encoding="utf-8")
    with pytest.raises(SystemExit) as end:
        main(
            ["optimise", str(folder / NASTY), "--rig", str(folder / "quick.toml"), "--cameras", "3", "--report",
             "--fixed-deg", "10", "--forbidden-deg", "60:90", "--out", str(folder / "out")]
        )  # fmt: skip
    assert not end.value.code
    return folder


@pytest.fixture
def chromium():
    """A browser for each test: pages that are left open go on drawing, which takes long without a graphics card."""
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=browser_path(), args=FLAGS)
        yield browser
        browser.close()


def opened(chromium, path, width, height):
    """The page, and lists of what it complained of and of what it asked for; both grow as it goes on."""
    page = chromium.new_page(viewport={"width": width, "height": height})
    faults, requests = [], []
    page.on("console", lambda message: faults.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("dialog", lambda dialog: (faults.append(f"dialog: {dialog.message}"), dialog.dismiss()))
    page.on("request", lambda request: requests.append(request.url))
    page.goto(path.as_uri())
    page.wait_for_selector("#plot[data-shown='1'], #plot[data-fault]", state="attached", timeout=PATIENCE)
    return page, faults, requests


def pixels(page, path):
    """What the surface looks like, as an image; also left at `path`."""
    page.wait_for_timeout(500)  # the drawing follows the data by some frames
    page.locator("#plot").screenshot(path=path, timeout=PATIENCE)
    return np.round(255 * matplotlib.image.imread(path)[..., :3]).astype(int)


def test_buttons_show_what_they_say_at_desktop_width(made, chromium, tmp_path):
    page, faults, requests = opened(chromium, made / "out" / "report.html", 1280, 900)
    page.screenshot(path=tmp_path / "desktop.png", full_page=True, timeout=PATIENCE)
    buttons = page.locator("button[data-colouring]")
    assert buttons.all_inner_texts() == ["equidistant", "optimised", "difference", "camera 1", "camera 2", "camera 3"]
    content = json.loads((made / "out" / "layout.json").read_text(encoding="utf-8"))
    words = [
        f"equidistant: {content['areas_mm2']['equidistant']:.2f} mm² reconstructable",
        f"optimised: {content['areas_mm2']['optimised']:.2f} mm² reconstructable",
        "The optimised layout gains",
        "Camera 1 at 10.0° sees",
    ]
    pictures = []
    for number, caption in enumerate(words):
        buttons.nth(number).click(timeout=PATIENCE)
        page.wait_for_selector(f"#plot[data-shown='{number}']", timeout=PATIENCE)
        assert page.inner_text("#caption").startswith(caption)
        pressed = page.locator("button[aria-pressed='true']")
        assert pressed.all_inner_texts() == [buttons.nth(number).inner_text()]
        pictures.append(pixels(page, tmp_path / f"surface_{number}.png"))
        # It is drawn indeed: the surface, in more colours than the background and the axes have.
        assert len(np.unique(pictures[-1].reshape(-1, 3), axis=0)) > 50
    for i, one in enumerate(pictures):
        for other in pictures[:i]:
            assert np.mean(np.abs(one - other).max(axis=2) > 20) > 1e-3, "two buttons show the same picture"
    assert faults == []
    assert requests == [(made / "out" / "report.html").as_uri()]


def test_it_fits_a_phone_and_shows_names_as_text(made, chromium, tmp_path):
    page, faults, requests = opened(chromium, made / "out" / "report.html", 390, 844)
    page.screenshot(path=tmp_path / "phone.png", full_page=True, timeout=PATIENCE)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    assert NASTY in page.inner_text("h1")
    assert NASTY in page.title()
    assert NASTY in page.inner_text("#asked")
    assert page.locator("main img").count() == 0
    # One circle or square for each camera and each equidistant one, the arc, and the table beside it.
    assert page.locator("svg.ring .equidistant").count() == 3
    assert page.locator("svg.ring .camera").count() == 3
    assert page.locator("svg.ring rect.fixed").count() == 1
    assert page.locator("svg.ring path.forbidden").count() == 1
    assert page.locator("#ring tbody tr").count() == 3
    kept = json.loads((made / "out" / "layout.json").read_text(encoding="utf-8"))["mounting"]
    assert "tilt [mm² per degree]" in page.locator("#ring thead").inner_text()
    for row, camera in zip(page.locator("#ring tbody tr").all_inner_texts(), kept, strict=True):
        assert f"{camera['roll_mm2_per_deg']:+.2f}, {camera['tilt_mm2_per_deg']:.2f}" in row
    for section in ("layouts", "angles", "robustness", "certificate", "repeat"):
        assert page.locator(f"#{section}").is_visible()
    assert faults == []
    assert len(requests) == 1


def test_later_it_is_the_same_page(made, camring, tmp_path):
    written = (made / "out" / "report.html").read_bytes()
    status, _, err = camring("report", made / "out", "--mesh", made / NASTY, "--out", tmp_path)
    assert status == 0, err
    assert (tmp_path / "report.html").read_bytes() == written
    status, _, err = camring("report", made / "out", "--mesh", made / NASTY)
    assert status == 2
    assert "report.html" in err and "--force" in err


def test_the_layout_must_be_of_this_mesh(made, camring, tmp_path):
    status, _, err = camring("report", made / "out", "--out", tmp_path)
    assert status == 2
    assert "--mesh" in err and "a file; say where it is" in err
    status, _, err = camring("report", made / "out", "--mesh", "circ_flat@50", "--out", tmp_path)
    assert status == 2
    assert "not the same mesh" in err
    (tmp_path / "layout.json").write_text(
        json.dumps(
            {"format": "camring layout", "version": 1, "angles_deg": [0, 90],
             "ring": {"diameter_mm": 30, "working_distance_mm": 400, "fov_mm": [36, 24]}}
        ),
        encoding="utf-8",
    )  # fmt: skip
    status, _, err = camring("report", tmp_path, "--mesh", made / NASTY)
    assert status == 2
    assert "says nothing of" in err and "camring optimise" in err


def test_what_layout_json_holds_is_shown_as_text(made, camring, tmp_path):
    content = json.loads((made / "out" / "layout.json").read_text(encoding="utf-8"))
    name = "<script>alert(1)</script>.stl"
    content["mesh"]["name"] = content["meshes"][0]["name"] = name
    content["certificate"]["statement"] = "</p><script>alert(3)</script>"
    (tmp_path / "layout.json").write_text(json.dumps(content), encoding="utf-8")
    status, _, err = camring("report", tmp_path, "--mesh", made / NASTY)
    assert status == 0, err
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt;.stl" in page


def test_the_curve_of_camring_count_is_shown_if_it_is_of_the_same_request(made, camring, tmp_path):
    content = json.loads((made / "out" / "layout.json").read_text(encoding="utf-8"))
    (tmp_path / "layout.json").write_text(json.dumps(content), encoding="utf-8")
    even = content["fractions_of_ring_maximum"]["equidistant"]
    rows = [
        {"n_cameras": n, "equidistant_fraction": fraction, "best_equidistant_fraction": fraction,
         "optimised_fraction": optimised, "bound_fraction": bound, "proven": proven}
        for n, fraction, optimised, bound, proven in
        ((2, 0.5, 0.55, 0.6, "True"), (3, even, 0.9321, "", ""), (4, 0.97, "", "", ""))
    ]  # fmt: skip
    for first, shown in ((rows[1], True), (rows[1] | {"equidistant_fraction": even - 0.01}, False)):
        with (tmp_path / "count.csv").open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(rows[0]))
            writer.writeheader()
            writer.writerows([rows[0], first, rows[2]])
        status, _, err = camring("report", tmp_path, "--mesh", made / NASTY, "--force")
        assert status == 0, err
        assert ("93.21 %" in (tmp_path / "report.html").read_text(encoding="utf-8")) is shown
        assert ("another request" in err) is not shown


def test_the_request_can_be_repeated(made, camring, tmp_path):
    layout = read(made / "out" / "layout.json")
    layout = report_words.Made(layout.content, (layout.ring,), layout.demand)
    (tmp_path / "rig.toml").write_text(report_words.rig(layout), encoding="utf-8")
    again, first = rig_file.rig(tmp_path / "rig.toml"), rig_file.rig(
        made / "quick.toml", count=3, fixed_deg="10", forbidden_deg="60:90"
    )  # fmt: skip
    np.testing.assert_allclose(again.constraints.forbidden, first.constraints.forbidden)
    np.testing.assert_allclose(again.constraints.fixed, first.constraints.fixed)
    assert again.settings == first.settings
    assert (again.n_cameras, again.seed, again.certify) == (3, 0, True)
    assert again.exclude == "none"
    assert re.search(r"scán\.stl.* --rig rig\.toml", report_words.command(layout))
    program, command, name, *options = shlex.split(report_words.evaluation(layout))
    assert (program, command, name) == ("camring", "evaluate", NASTY)
    options[options.index("rig.toml")] = tmp_path / "rig.toml"
    status, printed, err = camring("evaluate", made / NASTY, *options, "--json")
    assert status == 0, err
    assert json.loads(printed)["area_mm2"] == pytest.approx(layout.content["areas_mm2"]["optimised"], rel=1e-9)


@pytest.mark.parametrize("min_baseline", [0.0, 22.0])
def test_every_colour_has_the_area_of_the_exact_evaluator(min_baseline):
    mesh = meshes.site("circ_artery", depth=50, detail="coarse")
    ring, exclude = exact.Ring(), meshes.top_surface(mesh)
    angles = np.array([0.3, 1.1, 3.9])
    drawn = drawn_surface(exact.Scene(mesh, exclude=exclude), ring, angles, exact.Demand(2, min_baseline))
    corners = (drawn.origin + drawn.step * drawn.vertices)[drawn.triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    assert area.sum() == pytest.approx(mesh.area, rel=1e-4)
    for colouring in drawn.colourings:
        for number, shade in enumerate(colouring.shades):
            if shade.area is not None:  # coordinates are rounded to a micrometre
                assert area[colouring.shade == number].sum() == pytest.approx(shade.area, abs=0.2)
    for colouring, layout in zip(drawn.colourings, (ring.equidistant(3), angles), strict=False):
        expected = exact.evaluate(mesh, ring.cameras(layout), exclude=exclude, min_baseline=min_baseline)
        assert f"{expected.area:.2f} mm² reconstructable" in colouring.caption
    for camera, seen in zip(ring.cameras(angles), drawn.camera_areas, strict=True):
        assert seen == pytest.approx(exact.evaluate(mesh, [camera], threshold=1, exclude=exclude).area, rel=1e-9)


def test_a_fine_site_makes_a_small_file(made):
    """At most 8 MB with 20 000 faces: the surface, and a report that has next to none."""
    mesh = trimesh.load_mesh(meshes.standard_file("circ_overhang", 50)).subdivide()
    assert len(mesh.faces) > 17_000
    scene = exact.Scene(mesh, exclude=meshes.top_surface(mesh))
    drawn = drawn_surface(scene, exact.Ring(), np.linspace(0.1, 6.0, 4), exact.Demand())
    surface = len(drawn.packed()) * 20_000 / len(mesh.faces)
    assert surface + (made / "out" / "report.html").stat().st_size < 8e6
