"""camring study --simulated: its tasks, what is made of its rows, and that the committed ones hold what is said."""

import json
from typing import Any

import numpy as np
import pytest

from experiments.study.rows import read_rows, write_rows
from experiments.study.simulated_layouts import KINDS, named
from experiments.study.simulated_report import headline, main_width
from experiments.study.simulated_rows import PREDICTIONS, LimitRow, SimulatedRow, best_limit, rank_correlation
from experiments.study.simulated_tasks import DENSITIES, GRADIENTS, INCIDENCES_DEG, Plan, predicted, reconstructed
from tests.support import ROOT

RESULTS = ROOT / "experiments" / "results" / "simulate"
SITE = named(("circ_artery", 50), "coarse")


@pytest.fixture(scope="module")
def two_cameras():
    """What is found of two opposite cameras, in small images."""
    return reconstructed(SITE, "coarse", [90.0, 270.0], 180, seed=1)


@pytest.mark.parametrize(
    ("kind", "number", "limits"),
    [
        ("incidence", INCIDENCES_DEG.index(80.0), {"max_incidence_deg": 80.0}),
        ("density", 20, {"min_pixel_density": DENSITIES[20]}),
        ("gradient", 30, {"max_disparity_gradient": GRADIENTS[30]}),
        ("incidence and error", INCIDENCES_DEG.index(89.0), {"max_incidence_deg": 89.0, "max_error": 0.15}),
    ],
)
def test_sampled_areas_under_limits_are_the_exact_ones(two_cameras, kind, number, limits):
    none = dict.fromkeys(("max_incidence_deg", "min_pixel_density", "max_disparity_gradient", "max_error"))
    exactly = predicted(SITE, "coarse", [90.0, 270.0], 180, **(none | limits))["area_mm2"]
    assert two_cameras["limits"][kind]["met"][number] == pytest.approx(exactly, rel=0.02)


def test_limits_say_more_the_less_they_ask_for(two_cameras):
    limits = two_cameras["limits"]
    for kind, sign in (("incidence", 1), ("density", -1), ("gradient", 1)):
        met, both = (np.array(limits[kind][name]) for name in ("met", "both"))
        assert (sign * np.diff(met) >= 0).all() and (both <= met + 1e-9).all() and met.max() > met.min()
        assert both.max() <= limits["reconstructed"] + 1e-9
    # All that two cameras see they see as a pair: the gradient leaves out what it is too great for.
    assert limits["gradient"]["met"][-1] == pytest.approx(limits["incidence"]["met"][-1], rel=0.01)


def made_up():
    rows, limits = [], []
    for width in (360, 720):
        for n in (2, 4, 6):
            for number, kind in enumerate(KINDS):
                area = 1000.0 * n + 10 * number
                predicted: dict[str, Any] = {f"{way.replace(' ', '_')}_mm2": area for way in PREDICTIONS}
                within: dict[str, Any] = {f"within_{one}_mm2": area / 2 for one in ("01", "02", "03", "05")}
                row = SimulatedRow(
                    "circ_flat", 50, n, kind, width, n == 6, (0.0, 90.0), **predicted, **within, seen_mm2=area,
                    match_noise_px=0.1, facing_measured_mm=0.05, facing_predicted_mm=0.04,
                )  # fmt: skip
                rows.append(row)
        limits += [LimitRow(width, kind, limit, 100.0 * limit, min(100.0 * limit, 200.0), 200.0, 1000.0)
                   for kind in ("incidence", "density", "gradient") for limit in (1.0, 2.0, 3.0)]  # fmt: skip
    failed = SimulatedRow("circ_flat", 50, 8, "proposed", 720, False, failure="MemoryError: no, really")
    return [*rows, rows[-1], failed], limits


def test_page_and_figure_are_made_from_what_is_on_disk(tmp_path, camring):
    rows, limits = made_up()
    write_rows(tmp_path / "layouts.csv", SimulatedRow, rows)
    write_rows(tmp_path / "limits.csv", LimitRow, limits)
    assert read_rows(tmp_path / "layouts.csv", SimulatedRow) == rows
    (tmp_path / "record.json").write_text(json.dumps({"tasks": [{"name": "one"}]}), encoding="utf-8")
    status, printed, _ = camring("study", "--simulated", "--report-only", "--out", tmp_path)
    assert status == 0
    assert "1.25 to 1.25 times the predicted one" in printed and "least" in printed
    assert "at most 2 of disparity gradient: wrong for 0.0 % of what is seen" in printed
    text = (tmp_path / "simulated.md").read_text(encoding="utf-8")
    assert "MemoryError: no, really" in text and text.count("| circ_flat, 50 mm |") == len(rows)
    assert (tmp_path / "simulated.png").stat().st_size > 10_000
    assert main_width(rows) == 720


def ranks(values):
    """Ranks, ties sharing theirs, by counting."""
    values = np.asarray(values)
    return np.array([(values < one).sum() + ((values == one).sum() - 1) / 2 for one in values])


def test_what_is_committed_holds_what_is_said():
    rows, limits = read_rows(RESULTS / "layouts.csv", SimulatedRow), read_rows(RESULTS / "limits.csv", LimitRow)
    record = json.loads((RESULTS / "record.json").read_text(encoding="utf-8"))
    assert not any("failure" in task for task in record["tasks"]) and not any(row.failure for row in rows)
    width = main_width(rows)
    of = [row for row in rows if row.width_px == width]
    chosen, tested = ([row for row in of if row.tested == one] for one in (False, True))
    assert {(row.site, row.depth_mm) for row in chosen} == set(Plan.of(False).sites) and len(chosen) >= 24
    assert {(row.site, row.depth_mm) for row in tested} == set(Plan.of(False).tested) and len(tested) >= 24
    assert width == Plan.of(False).width
    assert min(rank_correlation(some, "gradient") for some in (chosen, tested)) > 0.9
    for row in rows:
        ratio = row.facing_measured_mm / row.facing_predicted_mm
        assert 1 / 1.5 < ratio < 1.5, row
    for way in PREDICTIONS:
        one, two = ranks([row.predicted(way) for row in of]), ranks([row.within_03_mm2 for row in of])
        assert rank_correlation(of, way) == pytest.approx(np.corrcoef(one, two)[0, 1], abs=1e-9)
    gradient = best_limit(limits, "gradient", width)
    assert gradient == record["settings"]["limits"]["gradient"]["max_disparity_gradient"] and gradient in GRADIENTS
    page = (RESULTS / "simulated.md").read_text(encoding="utf-8")
    assert all(sentence in page for sentence in headline(rows, limits))
