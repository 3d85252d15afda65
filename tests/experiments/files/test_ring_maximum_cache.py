import csv
import json

import pytest

from experiments.files.ring_maximum_cache import RememberedAreas
from tests.support.files import box, put, stl


def test_areas_come_back_to_the_last_bit(tmp_path):
    RememberedAreas(tmp_path / "new")["a"] = 1 / 3
    assert RememberedAreas(tmp_path / "new").get("a") == 1 / 3
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["a"]


@pytest.mark.parametrize("content", [b"", b"0x1.8p", b"nan", b"inf", b"-0x1p+3", b"\xff\xfe"])
def test_a_damaged_file_is_as_good_as_none(tmp_path, content):
    (tmp_path / "a").write_bytes(content)
    assert RememberedAreas(tmp_path).get("a") is None


def test_a_folder_that_cannot_be_used_is_done_without(tmp_path):
    (tmp_path / "file").write_text("no folder")
    areas = RememberedAreas(tmp_path / "file")
    areas["a"] = 1.0
    assert areas.get("a") is None


def test_the_second_run_about_a_site_finds_the_ring_maximum_of_the_first(camring, tmp_path, monkeypatch, quick_search):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "rig.toml").write_text(quick_search)
    layouts = []
    for number in range(2):
        out = tmp_path / f"out{number}"
        arguments = ("circ_flat", "--depth", 50, "--detail", "coarse", "--cameras", 2, "--rig", tmp_path / "rig.toml")
        assert camring("optimise", *arguments, "--no-robustness", "--out", out)[0] == 0
        layouts.append((out / "layouts.csv").read_bytes())
        kept = list((tmp_path / "cache").rglob("ring_maxima/*"))
        assert len(kept) == 1
    assert layouts[0] == layouts[1]
    kept[0].write_text((1e6).hex())  # twenty times as much as there is
    assert camring("optimise", *arguments, "--no-robustness", "--out", tmp_path / "third")[0] == 0
    with (tmp_path / "third" / "layouts.csv").open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            assert float(row["fraction_of_ring_maximum"]) == float(row["area_mm2"]) / 1e6


def test_scoring_layouts_finds_the_ring_maximum_of_earlier_runs(camring, tmp_path, monkeypatch, quick_search):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    mesh, rig = put(tmp_path, "part.stl", stl(box())), put(tmp_path, "rig.toml", quick_search)

    def evaluated():
        return json.loads(camring("evaluate", mesh, "--cameras", 4, "--target", 0.01, "--json")[1])["ring_maximum_mm2"]

    first = evaluated()
    (kept,) = (tmp_path / "cache").rglob("ring_maxima/*")
    assert first == float.fromhex(kept.read_text())
    kept.write_text((1e6).hex())
    assert evaluated() == 1e6
    assert camring("optimise", mesh, "--cameras", 2, "--rig", rig, "--out", tmp_path / "out")[0] == 0
    layout = tmp_path / "out" / "layout.json"
    assert json.loads(camring("compare", layout, layout, "--mesh", mesh, "--json")[1])["ring_maximum_mm2"] == 1e6
