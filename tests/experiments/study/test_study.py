"""camring study: what is made of its rows, and that the committed ones come out again."""

import json
from dataclasses import replace
from itertools import pairwise

import matplotlib.image
import numpy as np
import pytest

import exact
import meshes
import placement
from experiments.study.report import CAPTIONS, page
from experiments.study.rows import EquidistantRow, LayoutRow, read_rows, write_rows
from experiments.study.savings import accuracy, headline, savings
from experiments.study.tasks import DENSITY, Plan, equidistant, placed, study_tasks
from tests.support import ROOT

RESULTS = ROOT / "experiments" / "results" / "study"
SITES = (("circ_flat", 50), ("elliptical", 100))


def made_up_rows():
    """Optimised rings that need about two thirds of the cameras of equidistant ones."""
    layouts, even = [], []
    for number, (site, depth) in enumerate(SITES):
        for n in range(2, 8):
            missing = 0.4 * 0.35 ** (n - 2 - 0.3 * number)
            row = LayoutRow(
                "layouts", site, depth, n, 5.0, 0.0, None, "mean", 1 - 1.2 * missing, 0.2 / n, 1 - missing, 1 / n,
                1 - 2 * missing, 0.25 / n, 1 - 1.5 * missing, 0.25 / n, 10.0, 1 - missing, 1 - 0.8 * missing, n != 5,
                1 - 0.9 * missing, n != 5, 1 - missing, 5.2, 900.0, 1000.0, (0.5, 90.25), (0.5, 20.0), (1 - missing,),
            )  # fmt: skip
            layouts += [row, replace(row, part="dense", min_pixel_density=300.0)]
            if n in (4, 6):
                layouts += [replace(row, part="constraints", min_separation_mm=s) for s in (0.0, 3.0, 8.0)]
                layouts += [replace(row, part="constraints", min_angle_deg=a) for a in (1.0, 2.0)]
        even += [EquidistantRow(site, depth, n, 1 - 0.5 * 0.5 ** (n - 2), 0.25 / n) for n in range(2, 13)]
    everywhere = replace(layouts[0], part="all sites", site="all 2", depth_mm=None, objective="worst")
    failed = LayoutRow("constraints", "circ_flat", 50, 4, 3.0, 0.0, None, "mean", failure="MemoryError: no, really")
    return [*layouts, everywhere, failed], even


@pytest.fixture
def folder(tmp_path):
    layouts, even = made_up_rows()
    write_rows(tmp_path / "layouts.csv", LayoutRow, layouts)
    write_rows(tmp_path / "equidistant.csv", EquidistantRow, even)
    tasks = [{"name": "one"}, {"name": "other", "failure": "MemoryError: no, really"}]
    (tmp_path / "record.json").write_text(json.dumps({"tasks": tasks}))
    return tmp_path


def test_rows_come_back_as_they_were_written(folder):
    layouts, even = made_up_rows()
    assert read_rows(folder / "layouts.csv", LayoutRow) == layouts
    assert read_rows(folder / "equidistant.csv", EquidistantRow) == even


def test_page_and_figures_are_made_from_what_is_on_disk(folder, camring):
    status, printed, said = camring("study", "--report-only", "--out", folder)
    assert status == 1 and "1 of 2 tasks failed, the first with MemoryError: no, really" in said
    assert "99 % of the ring maximum: fewer optimised" in printed
    page = (folder / "study.md").read_text(encoding="utf-8")
    for words in (
        "| circ_flat, 50 mm ", "MemoryError: no, really", "One layout for all sites", "at most 0.00 %",
        "with at least 300 pixels to a square millimetre", "4.00 times that of as many equidistant cameras",
        "As proposed it is 0.80 times that on the mean", "| 94.12, 0.050 ",
    ):  # fmt: skip
        assert words in page
    assert (
        "10 of 12 layouts on the 5° grid were proven" in page and page.count("*9") >= 2
    )  # two that were not, in italics
    for name in ("study_curves", "study_errors", "study_savings", "study_constraints"):
        assert f"]({name}.png)" in page
        assert (folder / f"{name}.pdf").read_bytes()[:5] == b"%PDF-"
        assert matplotlib.image.imread(folder / f"{name}.png").std() > 0.02


def test_headline_for_scripts(folder, camring):
    status, printed, _ = camring("study", "--report-only", "--json", "--out", folder)
    said = json.loads(printed)
    assert status == 1 and said["tasks"] == {"done": 1, "failed": 1, "failures": ["MemoryError: no, really"]}
    assert set(said["files"]) == {str(file) for file in folder.iterdir()}
    assert said["headline"] == [*headline(savings(*made_up_rows())), *accuracy(made_up_rows()[0])]
    first = said["fewest_cameras"][0]
    counts = {"optimised": 4, "as_accurate": 5, "equidistant": 6}
    assert first == {"site": "circ_flat", "depth_mm": 50, "target": 0.95} | counts


def test_savings_are_counted_by_hand():
    found = {(one.site, one.target): one for one in savings(*made_up_rows())}
    # 1 - 0.4 * 0.35^k >= 0.95 for k >= 1.98, 1 - 0.5 * 0.5^k for k >= 3.32; n is k + 2.
    assert (found["circ_flat", 0.95].optimised, found["circ_flat", 0.95].equidistant) == (4, 6)
    assert found["elliptical", 0.95].optimised == 5 and found["circ_flat", 0.99].saved == 8 - 6
    # Errors 0.2 / n against 0.25 / 6: five; those of 1 / n are never as accurate.
    assert found["circ_flat", 0.95].as_accurate == 5
    assert found["circ_flat", 0.999].saved is None  # not within 7 cameras
    words = headline(list(found.values()))
    assert words[0].startswith("95 % of the ring maximum: fewer optimised than equidistant cameras reach it on 2 of 2")
    assert "on 2 it is out of reach" in words[2]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--report-only"], "holds no finished run"),
        (["--report-only", "--quick"], "leave out --quick"),
        (["--detail", "huge"], "--detail is 'huge'"),
        (["--scheduler", "tcp://127.0.0.1:1"], "no Dask scheduler answers"),
    ],
)
def test_refusals(camring, tmp_path, arguments, message, monkeypatch):
    monkeypatch.setattr("experiments.sweeps.pool.PATIENCE", 1)
    status, printed, said = camring("study", *arguments, "--out", tmp_path / "out")
    assert status == 2 and message in said and "Traceback" not in said and not printed


def test_the_plan_covers_ten_sites_and_two_to_twelve_cameras():
    named = [about for about, _ in study_tasks(Plan.of(False, "coarse"))]
    of_layouts = [about for about in named if about["part"] == "layouts"]
    assert len(of_layouts) == 10 and all(about["counts"] == list(range(2, 13)) for about in of_layouts)
    separations = {about["min_separation_mm"] for about in named if about["part"] in ("layouts", "constraints")}
    assert separations == {0.0, 3.0, 5.0, 8.0}
    assert [about["counts"] for about in named if about["part"] == "all sites"] == [list(range(2, 7))]
    dense = [about for about in named if about["part"] == "dense"]
    assert len(dense) == 10 and all(about["min_pixel_density"] == DENSITY for about in dense)


def test_committed_study_is_whole_and_comes_out_again():
    layouts = read_rows(RESULTS / "layouts.csv", LayoutRow)
    even = read_rows(RESULTS / "equidistant.csv", EquidistantRow)
    docs = ROOT / "docs"
    assert all((docs / "images" / name).exists() for name in CAPTIONS)
    assert (docs / "study.md").read_text(encoding="utf-8") == page(layouts, even, list(CAPTIONS), "images/")
    named = study_tasks(Plan.of(False, "coarse"))
    assert len(layouts) == sum(len(about["counts"]) for about, _ in named if about["part"] != "equidistant")
    assert not [row.failure for row in (*layouts, *even) if row.failure]
    of_sites = [row for row in layouts if row.part == "layouts"]
    for row in of_sites:
        assert row.most_area_fraction >= row.best_equidistant_fraction >= row.equidistant_fraction
        assert row.most_area_fraction - 0.005 - 1e-9 <= row.fraction <= row.most_area_fraction + 1e-9
        assert row.error_rms_mm <= row.most_area_error_rms_mm * (1 + 1e-6)
        assert row.most_area_fraction >= row.grid_layout_fraction - 1e-9
        assert row.surface_bound_fraction >= row.grid_layout_fraction - 1e-9
        assert row.bound_fraction >= row.most_area_fraction - 0.004  # the samples' own error
        assert row.smallest_separation_mm >= 5.0 - 1e-9
    for site in {(row.site, row.depth_mm) for row in of_sites}:
        of = sorted((row.n_cameras, row.most_area_fraction) for row in of_sites if (row.site, row.depth_mm) == site)
        assert all(more >= less - 1e-9 for (_, less), (_, more) in pairwise(of)), "more cameras reconstruct no less"
    hashes = json.loads((RESULTS / "record.json").read_text(encoding="utf-8"))["mesh_hashes"]
    assert hashes["circ_flat 50 coarse"] == meshes.EXPECTED["circ_flat", 50.0, "coarse"].fingerprint

    site = ["circ_flat", 50, hashes["circ_flat 50 coarse"]]
    rings = {row.n_cameras: row for row in even if (row.site, row.depth_mm) == ("circ_flat", 50)}
    again = equidistant(site, "coarse", [2, 5])
    assert again["fractions"] == pytest.approx([rings[n].fraction for n in (2, 5)], rel=1e-9)
    assert again["errors_rms_mm"] == pytest.approx([rings[n].error_rms_mm for n in (2, 5)], rel=1e-9)
    row = next(
        row for row in layouts
        if row.part == "constraints" and (row.site, row.depth_mm, row.n_cameras) == ("circ_flat", 50, 4)
        and row.min_separation_mm == 8
    )  # fmt: skip
    (found,) = placed([site], "coarse", "mean", [4], 8.0, 0.0, None, certify=False)["layouts"]
    assert row.most_area_fraction - 1e-6 <= found["most_area_fraction"] <= row.most_area_fraction + 1e-3


@pytest.mark.parametrize(("site", "depth"), [("circ_flat", 50), ("elliptical", 100)])
def test_committed_layouts_have_the_areas_and_errors_that_they_say(site, depth):
    """A search that finds more does not make a row wrong: its layout has the area that it says."""
    layouts = read_rows(RESULTS / "layouts.csv", LayoutRow)
    mesh, ring = meshes.site(site, depth, "coarse"), exact.Ring()
    of = [one for one in layouts if (one.site, one.depth_mm) == (site, depth)]
    for one in of[::4]:
        baseline = placement.Constraints(min_angle=float(np.radians(one.min_angle_deg))).baseline(ring)
        seen, most = (
            exact.evaluate(
                mesh, ring.cameras(np.radians(angles)), exclude=meshes.top_surface(mesh), min_baseline=baseline,
                limits=exact.Limits(min_pixel_density=one.min_pixel_density), depth_axis=ring.axis,
            )
            for angles in (one.angles_deg, one.most_area_angles_deg)
        )  # fmt: skip
        assert (seen.area, seen.area / one.ring_area_mm2) == pytest.approx((one.area_mm2, one.fraction), rel=1e-9)
        assert most.area / one.ring_area_mm2 == pytest.approx(one.most_area_fraction, rel=1e-9)
        errors = seen.errors.rms(), most.errors.rms()
        assert errors == pytest.approx((one.error_rms_mm, one.most_area_error_rms_mm), rel=1e-6)
