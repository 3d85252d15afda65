"""The committed results of the full run: complete, reproduced where that is quick, and what the page says."""

import json
import shutil

import numpy as np
import pytest

import meshes
from experiments.paper.areas import Area, area_rows, curve, read_areas, reconstructable_areas, write_areas
from experiments.paper.cases import CIRCULAR, FOV, Case, cases
from experiments.paper.fits import chosen_fit, fitted, read_fits
from experiments.paper.published import CAMERA_COUNTS, published_areas
from experiments.paper.report import write_report
from experiments.paper.tables import TABLES, entries, markdown, write_table
from experiments.sweeps.task import Outcome
from tests.support import ROOT

RESULTS = ROOT / "experiments" / "results" / "paper"


@pytest.fixture(scope="module")
def areas():
    return read_areas(RESULTS / "areas.csv")


@pytest.fixture(scope="module")
def fits():
    return read_fits(RESULTS / "fits.csv")


def key(area):
    return (area.site, area.depth_mm, area.fov_mm, area.top_surface_included, area.n_cameras)


def test_all_240_are_there(areas):
    assert len(areas) == 240
    assert {key(area) for area in areas} == set(published_areas())
    assert all(area.area_mm2 > 0 and area.failure == "" for area in areas)


def test_the_record_is_of_the_sites_of_today():
    record = json.loads((RESULTS / "record.json").read_text(encoding="utf-8"))
    assert (record["settings"]["quick"], record["settings"]["detail"]) == (False, "coarse")
    assert record["mesh_hashes"] == {
        f"{case.site} {case.depth} coarse": meshes.EXPECTED[case.site, float(case.depth), "coarse"].fingerprint
        for case in cases(quick=False)
    }
    assert len(record["tasks"]) == 12 * 10 + 12


@pytest.mark.parametrize(
    ("case", "n"),
    [
        (Case("circ_flat", 50, "36x24"), 2),
        (Case("circ_angled", 100, "36x24"), 4),
        (Case("circ_artery", 50, "36x24"), 8),
        (Case("circ_overhang", 100, "36x24"), 6),
        (Case("elliptical", 50, "36x24"), 2),
        (Case("elliptical", 100, "60x60"), 16),
    ],
    ids=lambda value: getattr(value, "key", value),
)
def test_a_subset_is_reproduced(areas, case, n):
    found = reconstructable_areas(case.site, case.depth, "coarse", case.mesh_hash("coarse"), FOV[case.fov], n)
    committed = {key(area): area.area_mm2 for area in areas}
    for included, name in ((True, "included"), (False, "excluded")):
        assert found[name] == pytest.approx(committed[case.site, case.depth, case.fov, included, n], rel=1e-9)


def test_share_of_the_top_surface_is_the_published_one(areas):
    ours, published = {key(area): area.area_mm2 for area in areas}, published_areas()
    for site in CIRCULAR:
        for depth in (50, 100):
            for n in CAMERA_COUNTS:
                with_top, without = (site, depth, "36x24", True, n), (site, depth, "36x24", False, n)
                share = published[with_top] - published[without]
                assert ours[with_top] - ours[without] == pytest.approx(share, abs=0.02)


@pytest.mark.parametrize("depth", [50, 100])
@pytest.mark.parametrize("site", CIRCULAR)
def test_decays_fit_every_circular_site(areas, fits, site, depth):
    case = Case(site, depth, "36x24")
    fit = chosen_fit(fits, case, included=False)
    n, area = curve(areas, case, included=False)
    left = area - fitted(fit, n)
    r_squared = 1 - left @ left / np.sum((area - area.mean()) ** 2)
    assert r_squared >= 0.99
    assert r_squared == pytest.approx(fit.r_squared, abs=1e-12)


def test_every_curve_has_fits_of_both_kinds(fits):
    assert len(fits) == 12 * 2 * 2 * 2  # cases, with and without top surface, ours and published, phases
    for case in cases(quick=False):
        for included in (True, False):
            for source in ("ours", "published"):
                assert chosen_fit(fits, case, included, source) is not None


@pytest.mark.parametrize("spec", TABLES, ids=lambda spec: spec.number)
def test_tables_are_what_the_areas_say(areas, spec, tmp_path):
    write_table(tmp_path, spec, entries(spec, areas, cases(quick=False)))
    for file in tmp_path.iterdir():
        assert file.read_bytes() == (RESULTS / file.name).read_bytes(), file.name


def test_the_page_is_what_the_results_say(areas, fits, tmp_path):
    images = sorted((ROOT / "docs" / "images").glob("paper_figure_*.png"))
    assert len(images) == 6
    names = [file.name.removeprefix("paper_") for file in images]
    where = {"tables": "../experiments/results/paper/", "images": "images/paper_"}
    write_report(tmp_path / "paper.md", areas, fits, cases(quick=False), names, **where)
    assert (tmp_path / "paper.md").read_text() == (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")


def test_report_only_redraws_the_committed_results(tmp_path, camring):
    shutil.copytree(RESULTS, tmp_path / "paper")
    status, printed, _ = camring("paper", "--report-only", "--out", tmp_path / "paper")
    assert status == 0
    # What the pictures show is not committed, for it is thirty times as large as all the rest.
    assert "240 areas, 8 tables, 2 figures" in printed
    assert len(list((tmp_path / "paper").glob("figure_11*.pdf"))) == 2


def test_a_failure_is_a_row_with_its_reason(tmp_path):
    case, counts = Case("circ_flat", 50, "36x24"), (2, 4, 6)
    outcomes = [
        Outcome({"included": 2600.0, "excluded": 2500.0}, "", 1.0),
        Outcome(None, "MemoryError: no room", 1.0),
        Outcome({"included": 4400.0, "excluded": 4000.0}, "", 1.0),
    ]
    write_areas(tmp_path / "areas.csv", area_rows([case], counts, outcomes))
    rows = read_areas(tmp_path / "areas.csv")
    assert rows[1] == Area("circ_flat", 50, "36x24", True, 4, None, "MemoryError: no room")
    assert curve(rows, case, included=False)[0].tolist() == [2, 6]
    table = {spec.number: entries(spec, rows, [case]) for spec in TABLES}
    failed = [row for row in table["A2"] if row.n_cameras == 4]
    assert [(row.ours, row.failure) for row in failed] == [(None, "MemoryError: no room")]
    assert "failed" in markdown(TABLES[1], table["A2"])
    # Without the failed one, its successor has nothing to be compared with.
    assert [row.ours for row in table["5"] if row.quantity == "increase"] == [None, None]
