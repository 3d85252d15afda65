"""The page in a real browser: what one drags, presses and reads there."""

import json
import math
import re

import numpy as np
import pytest
import trimesh

import exact
from tests.experiments.design.served import SEPARATION, Looked, evaluated
from tests.support.browser import PATIENCE


def drag(window, camera, degrees, steps=12):
    """Drag a camera around the ring, to an angle."""
    window.page.evaluate("scrollTo(0, 0)")
    x, y = window.centre("#ring .camera .touch", camera)
    middle_x, middle_y = window.centre("#ring")
    start, radius = math.atan2(middle_y - y, x - middle_x), math.hypot(x - middle_x, y - middle_y)
    turn = (math.radians(degrees) - start + math.pi) % (2 * math.pi) - math.pi
    window.page.mouse.move(x, y)
    window.page.mouse.down()
    for step in range(1, steps + 1):
        angle = start + turn * step / steps
        window.page.mouse.move(middle_x + radius * math.cos(angle), middle_y - radius * math.sin(angle))
    window.page.mouse.up()
    window.known()


def test_a_camera_is_dragged_by_a_finger_on_a_tablet(chromium, server, camring, scan):
    tablet = Looked(chromium, server.address, 820, 1180, has_touch=True, is_mobile=True)
    page, before = tablet.page, tablet.angles()
    page.locator("#ring").scroll_into_view_if_needed()
    (x, y), (middle_x, middle_y) = tablet.centre("#ring .camera .touch", 1), tablet.centre("#ring")
    fingers = page.context.new_cdp_session(page)

    def touch(what, *places):
        points = [{"x": at_x, "y": at_y} for at_x, at_y in places]
        fingers.send("Input.dispatchTouchEvent", {"type": what, "touchPoints": points})

    start, radius = math.atan2(middle_y - y, x - middle_x), math.hypot(x - middle_x, y - middle_y)
    scrolled = page.evaluate("scrollY")
    touch("touchStart", (x, y))
    for step in range(1, 13):
        angle = start + math.radians(20) * step / 12
        touch("touchMove", (middle_x + radius * math.cos(angle), middle_y - radius * math.sin(angle)))
    touch("touchEnd")
    page.wait_for_timeout(200)
    tablet.known()
    turned = (tablet.angles()[1] - before[1] + 180) % 360 - 180
    assert abs(turned - 20) < 2 and tablet.angles()[0] == before[0]
    assert page.evaluate("scrollY") == scrolled  # the page stays where it is meanwhile
    shown = tablet.number("area"), tablet.number("error")
    assert shown == evaluated(camring, scan, "--angles-deg", said_angles(tablet))
    assert tablet.faults == []
    page.close()


def said_angles(window):
    return ",".join(f"{angle:.3f}" for angle in window.angles())


def test_fractions_are_those_of_the_ring_maximum(window, scan):
    # Of 8 cameras in a short search; by heart, the same layout and the equidistant one against it.
    mesh, ring = trimesh.load(scan), exact.Ring()
    areas = [
        exact.evaluate(mesh, ring.cameras(angles)).area
        for angles in (np.radians(window.angles()), ring.equidistant(3), ring.equidistant(8))
    ]
    window.page.wait_for_selector("html[data-ring=known]", timeout=PATIENCE)
    ours, even = (float(window.number(name)) for name in ("fraction", "even-fraction"))
    assert [ours, even] == pytest.approx([100 * areas[0] / areas[2], 100 * areas[1] / areas[2]], abs=0.006)
    assert float(window.number("fraction-gain")) == pytest.approx(ours - even, abs=0.011)
    drag(window, 0, 75.0)
    share = float(window.number("fraction")) / ours
    assert share == pytest.approx(float(window.number("area")) / areas[0], abs=2e-4)


def test_a_dragged_camera_has_the_numbers_that_evaluate_prints(window, camring, scan, rig):
    before = window.number("area"), window.number("error")
    drag(window, 0, 75.0)
    assert abs(window.angles()[0] - 75.0) < 1.0
    # Typed in, it is the angle that is shown, to all its digits.
    window.page.locator("#cameras input[type=number]").nth(0).fill("77.125")
    window.page.keyboard.press("Enter")
    window.known()
    assert window.angles()[0] == 77.125
    shown = window.number("area"), window.number("error")
    assert shown == evaluated(camring, scan, "--angles-deg", said_angles(window)) != before
    even = window.number("even-area"), window.number("even-error")
    assert even == evaluated(camring, scan, "--cameras", 3)
    assert float(window.number("gain")) == pytest.approx(float(shown[0]) - float(even[0]), abs=1.01e-4)
    # The estimate is one: of some thousand points.
    assert float(window.number("sampled")) == pytest.approx(float(shown[0]), rel=0.03)


def test_cameras_are_added_removed_fixed_and_all_of_it_undone(fresh_window, camring, scan):
    window = fresh_window
    page, start = window.page, window.angles()
    page.click("#add")
    window.known()
    assert len(window.angles()) == 4
    x, y = window.centre("#ring .camera .touch", 1)
    middle_x, middle_y = window.centre("#ring")
    page.mouse.dblclick(2 * middle_x - x, 2 * middle_y - y)  # opposite to the second camera there is room
    window.known()
    opposite = (window.angles()[1] + 180) % 360
    assert len(window.angles()) == 5 and abs(window.angles()[4] - opposite) < 3
    shown = window.number("area"), window.number("error")
    assert shown == evaluated(camring, scan, "--angles-deg", said_angles(window))
    page.locator("#cameras input[type=checkbox]").nth(0).check()
    page.wait_for_selector("#ring .camera.fixed")
    held = window.angles()[0]
    drag(window, 0, held + 40)
    assert window.angles()[0] == held
    assert page.locator("#cameras button").nth(0).is_disabled()
    page.locator("#cameras button").nth(4).click()
    window.known()
    assert len(window.angles()) == 4
    for _ in range(4):
        page.click("#undo")
    window.known()
    assert window.angles() == start and page.locator("#undo").is_disabled()
    for _ in range(4):
        page.keyboard.press("Control+y")
    window.known()
    assert len(window.angles()) == 4 and page.locator("#ring .camera.fixed").count() == 1
    assert page.locator("#redo").is_disabled()
    # What was tried is still there, with its numbers, and two of it beside each other.
    rows = page.locator("#tried tr")
    assert rows.count() == 5
    page.locator("#tried input").nth(0).check()
    page.locator("#tried input").nth(2).check()
    assert page.locator("#beside figure").count() == 2
    assert f"{shown[0]} mm²" in page.locator("#beside figure").nth(1).inner_text()
    page.locator("#tried tr button").nth(4).click()
    window.known()
    assert window.angles() == start


def test_separation_and_forbidden_arcs_are_kept_while_dragging(window):
    page = window.page
    for where in (5.0, 120.0, 118.0, 240.0, 300.0):
        drag(window, 0, where)
        apart = exact.Ring().separations(np.radians(window.angles()))
        assert (apart + 99 * np.eye(3)).min() >= SEPARATION - 1e-3
        assert float(window.number("separation")) >= SEPARATION
    page.fill("#from", "20")
    page.fill("#to", "70")
    page.click("#forbid button")
    page.wait_for_selector("#ring .forbidden")
    drag(window, 0, 45.0)
    assert not 20 < window.angles()[0] < 70
    assert min(abs(window.angles()[0] - 20), abs(window.angles()[0] - 70)) < 1e-3
    # A request that the cameras would break is refused, and nothing has changed.
    separation = page.get_by_label("separation of any two cameras in mm, as a number")
    separation.fill("29")
    page.keyboard.press("Enter")
    assert "do not meet the constraints" in window.said() and "less than 29 mm" in window.said()
    assert separation.input_value() == "6"
    page.click("#arcs button")
    page.wait_for_selector("#ring .forbidden", state="detached")


def test_what_is_asked_can_be_changed(window, camring, scan):
    page = window.page
    for label, value in (("ring diameter in mm", "40"), ("working distance in mm", "300")):
        page.get_by_label(f"{label}, as a number").fill(value)
        page.keyboard.press("Enter")
    page.get_by_label("limit greatest angle from the normal").click()  # checked once the server knows
    page.get_by_label("greatest angle from the normal in °, as a number").fill("70")
    page.keyboard.press("Enter")
    window.known()
    options = ("--diameter", "40", "--working-distance", "300", "--max-incidence-deg", "70")
    shown = window.number("area"), window.number("error")
    assert shown == evaluated(camring, scan, "--angles-deg", said_angles(window), *options)
    assert "at most 70° from its normal" in page.inner_text("#words")
    # A slider is dragged like a camera.
    page.get_by_label("ring diameter in mm", exact=True).focus()
    page.keyboard.press("ArrowRight")
    window.known()
    assert page.get_by_label("ring diameter in mm, as a number").input_value() == "40.5"
    for label in ("views that a point needs", "baseline of some two views in mm"):
        page.get_by_label(f"{label}, as a number").fill("3" if "views that" in label else "12")
        page.keyboard.press("Enter")
    window.known()
    options = (*options, "--diameter", "40.5", "--threshold", "3", "--min-baseline", "12")
    assert window.number("area") == evaluated(camring, scan, "--angles-deg", said_angles(window), *options)[0]


def test_the_keyboard_is_enough(window):
    page = window.page
    page.locator("#ring .camera").nth(1).focus()
    before = window.angles()[1]
    for key in ("ArrowLeft", "ArrowLeft", "Shift+ArrowRight"):
        page.keyboard.press(key)
    window.known()
    assert window.angles()[1] == pytest.approx(before + 1.9, abs=2e-3)
    assert page.locator("#ring .camera").nth(1).get_attribute("aria-valuetext") == f"{window.angles()[1]:.3f} degrees"
    page.keyboard.press("f")
    page.wait_for_selector("#ring .camera.fixed")
    page.keyboard.press("f")
    page.wait_for_selector("#ring .camera.fixed", state="detached")
    page.keyboard.press("Delete")
    window.known()
    assert len(window.angles()) == 2


def test_improve_and_stop(window):
    page = window.page
    drag(window, 0, 30.0)
    before = float(window.number("area"))
    page.click("#improve")
    page.wait_for_selector("#job:not([hidden])")
    page.wait_for_selector("#job[hidden]", state="attached", timeout=PATIENCE)
    window.known()
    assert float(window.number("area")) > before
    assert "improved" in page.inner_text("#tried")
    page.click("#one-more")
    page.wait_for_selector("#tried >> text=one camera more", timeout=PATIENCE)
    window.known()
    assert len(window.angles()) == 4
    page.click("#optimise")
    page.wait_for_selector("#stop:not([disabled])")
    # The page goes on meanwhile, and what was asked for is not begun twice.
    assert page.locator("#improve").is_disabled()
    drag(window, 2, window.angles()[2] + 3)
    page.click("#stop")
    page.wait_for_selector("#job[hidden]", state="attached")
    page.wait_for_selector("#told:not([hidden]) >> text=stopped")
    assert "optimised" not in page.inner_text("#tried")
    page.click("#optimise")
    page.wait_for_selector("#tried >> text=optimised", timeout=PATIENCE)
    window.known()
    assert len(window.angles()) == 4


def test_curves_fill_in_and_their_points_are_layouts(window, camring, scan):
    page = window.page
    page.click("#counts")
    # Points come one number of cameras after another, and stay when it is stopped.
    page.wait_for_selector("#curves .point[aria-label^='optimised: 4 cameras']", state="attached", timeout=PATIENCE)
    page.click("#stop")
    page.wait_for_selector("#job[hidden]", state="attached")
    label = page.locator("#curves .point[aria-label^='optimised: 2 cameras']").get_attribute("aria-label")
    page.locator("#curves .point[aria-label^='optimised: 2 cameras']").click()
    page.wait_for_selector("#tried >> text=2 cameras from a curve")
    window.known()
    assert len(window.angles()) == 2
    # Angles are shown to a thousandth of a degree.
    area = exact.evaluate(trimesh.load(scan), exact.Ring().cameras(np.radians(window.angles()))).area
    assert float(window.number("area")) == pytest.approx(area, rel=1e-4)
    page.wait_for_selector("html[data-ring=known]", timeout=PATIENCE)
    assert float(re.search(r"([\d.]+) %", label)[1]) == pytest.approx(float(window.number("fraction")), abs=0.011)
    page.click("#trade-off")
    page.wait_for_selector("svg[aria-label='trade-off'] .point.optimised", state="attached", timeout=PATIENCE)
    page.wait_for_selector("#job[hidden]", state="attached", timeout=PATIENCE)
    point = page.locator("svg[aria-label='trade-off'] .point.optimised").last
    error = float(re.search(r"([\d.]+) mm", point.get_attribute("aria-label"))[1])
    point.focus()
    page.keyboard.press("Enter")
    page.wait_for_timeout(300)
    window.known()
    assert float(window.number("error")) == pytest.approx(error, abs=1.01e-4)


def saved(window, name, tmp_path):
    with window.page.expect_download(timeout=PATIENCE) as coming:
        window.page.click(f"button[data-file='{name}']")
    path = tmp_path / name
    coming.value.save_as(path)
    return path


def test_out_of_it_and_back(window, camring, scan, tmp_path):
    drag(window, 0, 50.0)
    window.page.locator("#cameras input[type=checkbox]").nth(1).check()
    window.known()
    shown, angles = (window.number("area"), window.number("error")), window.angles()
    path = saved(window, "layout.json", tmp_path)
    content = json.loads(path.read_text(encoding="utf-8"))
    assert f"{content['areas_mm2']['optimised']:.4f}" == shown[0]
    assert f"{content['areas_mm2']['equidistant']:.4f}" == window.number("even-area")
    assert sorted(content["angles_deg"]) == pytest.approx(sorted(angles), abs=1e-3)
    assert np.degrees(content["constraints"]["fixed"]).tolist() == pytest.approx([angles[1]], abs=1e-3)
    assert evaluated(camring, scan, "--layout", path) == shown
    assert saved(window, "report.html", tmp_path).read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert saved(window, "exports.zip", tmp_path).read_bytes().startswith(b"PK")
    window.page.click("#equidistant")
    window.known()
    assert sorted(window.angles()) != sorted(angles)
    window.page.set_input_files("#open", path)
    window.page.wait_for_selector("#tried >> text=opened from a file")
    window.known()
    assert sorted(window.angles()) == sorted(angles)
    assert (window.number("area"), window.number("error")) == shown
    assert window.page.locator("#ring .camera.fixed").count() == 1
    for text in ("no layout", json.dumps(content | {"mesh": {"name": "another", "sha256": "0" * 64}, "meshes": []})):
        (tmp_path / "other.json").write_text(text, encoding="utf-8")
        window.page.evaluate("document.getElementById('said').hidden = true")
        window.page.set_input_files("#open", tmp_path / "other.json")
        assert "no valid JSON" in window.said() or "was made for 'another'" in window.said()
    assert sorted(window.angles()) == sorted(angles)


def test_two_windows_show_the_same(window, chromium, server):
    other = Looked(chromium, server.address)
    drag(window, 0, 70.0)
    other.known()
    assert other.angles() == window.angles() and other.number("area") == window.number("area")
    other.page.click("#add")
    other.known()
    window.page.wait_for_selector("#ring .camera >> nth=3", state="attached")
    window.known()
    assert window.angles() == other.angles() and window.page.inner_text("#tried") == other.page.inner_text("#tried")
    other.page.close()
    assert other.faults == []


@pytest.mark.parametrize(
    ("width", "height", "scheme"), [(1280, 900, "light"), (820, 1180, "light"), (1440, 900, "dark")]
)
def test_it_fits_and_shows_names_as_text(chromium, server, scan, tmp_path, width, height, scheme):
    window = Looked(chromium, server.address, width, height, color_scheme=scheme)
    page = window.page
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert scan.name in page.inner_text("h1") and scan.name in page.title() and page.locator("h1 b").count() == 0
    pictures = []
    for colouring in ("views", "error", "0"):
        page.select_option("#colouring", colouring)
        page.wait_for_timeout(500)
        path = tmp_path / f"{width}_{scheme}_{colouring}.png"
        page.screenshot(path=path, full_page=True, timeout=PATIENCE)
        pictures.append(page.locator("#surface").screenshot(timeout=PATIENCE))
        assert page.locator("#legend li").count() >= 2
    assert len(set(pictures)) == 3
    page.close()
    assert window.faults == []
