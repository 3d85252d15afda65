"""What the page says: what was done, why something cannot be, and when no camera sees anything."""

import re

import trimesh

from tests.experiments.design.served import Looked, evaluated, served
from tests.support.browser import PATIENCE


def test_what_was_done_is_told(fresh_window):
    window = fresh_window
    page, start = window.page, window.angles()
    page.click("#improve")
    page.wait_for_selector("#told:not([hidden])", timeout=PATIENCE)
    assert re.fullmatch(
        r"improve: exact area \+[\d.]+ mm², RMS error [+−][\d.]+ mm \([+−]\d+ %\)", page.inner_text("#told")
    )
    # However many steps it took, they are one to take back.
    assert page.locator("#tried tr").count() == 2
    page.click("#undo")
    window.known()
    assert window.angles() == start and page.locator("#undo").is_disabled()
    # A camera is put as near as may be, and that is said.
    angle = page.get_by_label("ring angle of camera 1 in degrees")
    angle.fill(str(start[1] + 1))
    page.keyboard.press("Enter")
    assert f"camera 1 cannot sit at {start[1] + 1:g}°" in window.said()
    assert f"the nearest place is {window.angles()[0]:.3f}°" in window.said()
    angle.fill("30")
    page.keyboard.press("Enter")
    window.known()
    assert window.angles()[0] == 30.0
    page.locator("#cameras input[type=checkbox]").nth(0).check()
    page.wait_for_selector("#ring .camera.fixed")
    page.evaluate("scrollTo(0, 0)")
    page.mouse.click(*window.centre("#ring .camera .touch", 0))
    page.wait_for_selector("#said >> text=camera 1 is fixed")
    # To press a camera is not to move it.
    rows = page.locator("#tried tr").count()
    page.mouse.click(*window.centre("#ring .camera .touch", 2))
    page.wait_for_timeout(200)
    assert page.locator("#tried tr").count() == rows


def test_limits_begin_where_they_make_sense(window):
    page = window.page
    assert page.get_by_label("limit greatest blur").is_disabled()
    assert "--pupil" in page.get_by_text("greatest blur").get_attribute("title")
    for label, value in (("greatest error", "0.2"), ("sharp from a depth of", "380")):
        page.get_by_label(f"limit {label}").click()
        page.wait_for_selector("html[data-numbers=known]", timeout=PATIENCE)
        page.wait_for_function(
            "([label, value]) => document.querySelector(`[aria-label^='${label}'][type=number]`).value === value",
            arg=[label, value],
        )
    assert "for matches to 0.5 px on images of 3600 x 2400 px" in page.inner_text("#error-words")


def test_what_rested_in_the_hand_keeps_its_numbers(fresh_window):
    window = fresh_window
    page = window.page
    x, y = window.centre("#ring .camera .touch", 0)
    middle_x, middle_y = window.centre("#ring")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(middle_x + 0.8 * (x - middle_x), middle_y - 0.6 * (x - middle_x), steps=5)
    window.known()
    held = window.number("area")
    page.mouse.up()
    page.wait_for_selector("#tried tr >> nth=1", timeout=PATIENCE)
    assert page.locator("#tried tr").nth(0).locator("td").nth(2).inner_text() == held == window.number("area")


def test_a_mesh_out_of_sight(chromium, camring, tmp_path, scan, rig):
    away = trimesh.load(scan).apply_translation((0, 100, 0))
    away.export(tmp_path / "away.stl")
    with served(tmp_path, tmp_path / "away.stl", "--rig", rig) as running:
        looked = Looked(chromium, running.address)
        words = looked.page.inner_text("#nothing")
        assert "no camera sees any of the surface" in words and "y from 85 to 115" in words
        assert "--place auto" in words and looked.number("fraction") in ("–", "computing…")
        looked.page.wait_for_selector("html[data-ring=known]", timeout=PATIENCE)
        assert looked.number("fraction") == "–"
        for search in ("#improve", "#optimise", "#trade-off"):
            looked.page.evaluate("document.getElementById('said').hidden = true")
            looked.page.click(search)
            assert "no camera sees any of the surface" in looked.said()
        looked.page.click("#place")
        looked.page.wait_for_selector("#tried >> text=ring placed", timeout=PATIENCE)
        looked.page.wait_for_selector("#nothing", state="hidden", timeout=PATIENCE)
        looked.known()
        shown = looked.number("area"), looked.number("error")
        asked = ("--place", "auto", "--cameras", len(looked.angles()))
        assert shown == evaluated(camring, tmp_path / "away.stl", *asked) and float(shown[0]) > 100
        looked.page.close()
        assert looked.faults == []
        assert "warning: no camera sees any of the surface" in running.end()[1]
