"""camring bench surrogate: its statistics on made-up data, and one small run of all of it."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

import exact
from experiments.bench import surrogate as bench_surrogate
from experiments.bench import surrogate_accuracy
from experiments.bench.surrogate import Plan, check
from experiments.bench.surrogate_accuracy import Accuracy
from experiments.bench.surrogate_statistics import error_sizes, gradient_error, rank_correlation, standard_error
from experiments.cli import app as cli
from placement.samples.profiles import RingProfiles
from placement.settings import Settings
from placement.surrogate.surrogate import Surrogate

TINY = Plan(
    cases=(("circ_flat", 50),),
    camera_counts=(2, 3),
    layouts_each=6,
    settings=replace(Settings(), n_samples=600, n_angles=36, bisections=4, temperatures=(0.3, 0.05), ring_cameras=12),
    more_temperatures=(0.01,),
    n_samples=(300,),
    sample_seeds=(0, 1),
    n_angles=(12,),
    bisections=(0,),
    sequences=((0.1,),),
    n_starts=2,
    workers=1,
)


def rows_of(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def camring(*words):
    with pytest.raises(SystemExit) as end:
        cli.main([str(word) for word in words])
    return end.value.code or 0


@pytest.fixture(scope="module")
def small_run(tmp_path_factory):
    folder, kept, measure = tmp_path_factory.mktemp("bench"), [], bench_surrogate.measure

    def keeping(*arguments):
        kept.append(measure(*arguments))
        return kept[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bench_surrogate, "PLAN", TINY)
        patch.setattr(bench_surrogate, "measure", keeping)
        patch.setattr(surrogate_accuracy, "RAY_STRIDE", 1)
        patch.setattr(bench_surrogate, "GREATEST_MEAN_ERROR", 0.2)
        patch.setattr(bench_surrogate, "LEAST_RANK_CORRELATION", 0.5)
        status = camring("bench", "surrogate", "--out", folder)
    return folder, status, kept[0]


def test_a_small_run_meets_wide_bounds_and_writes_everything(small_run):
    folder, status, _ = small_run
    assert status == 0
    assert sorted(path.name for path in folder.iterdir()) == sorted(bench_surrogate.OUTPUTS)
    assert (folder / "bench_surrogate.png").read_bytes().startswith(b"\x89PNG")
    assert (folder / "bench_surrogate.md").read_text(encoding="utf-8").count("circ_flat 50") == 3


def test_each_temperature_and_number_of_cameras_has_its_row(small_run):
    rows = rows_of(small_run[0] / "bench_surrogate.csv")
    found = {(row["n_cameras"], float(row["temperature_rad"])): row for row in rows}
    assert set(found) == {(n, t) for n in ("all", "2", "3") for t in (0.3, 0.05, 0.01, 0.0)}
    assert {row["n_layouts"] for row in rows} == {"12", "6"}
    for (n, temperature), row in found.items():
        assert float(row["mean_error"]) <= float(row["greatest_error"])
        assert (row["gradient_error"] != "") == (n == "all" and temperature > 0)
        if row["gradient_error"]:
            assert float(row["gradient_error"]) < 1e-5
    # The colder, the nearer to hard coverage.
    bias = [float(found["all", t]["bias"]) for t in (0.3, 0.05, 0.01, 0.0)]
    assert abs(bias[0] - bias[3]) > abs(bias[1] - bias[3]) > abs(bias[2] - bias[3])


def test_more_angles_and_bisections_lower_the_error_of_the_profiles(small_run):
    rows = rows_of(small_run[0] / "bench_surrogate_sampling.csv")
    by_choice = {tuple(int(row[n]) for n in ("n_samples", "n_angles", "bisections", "seed")): row for row in rows}
    assert set(by_choice) == {
        (300, 36, 4, 0), (300, 36, 4, 1), (600, 36, 4, 0), (600, 36, 4, 1), (600, 12, 4, 0), (600, 36, 0, 0),
    }  # fmt: skip
    error = {choice: float(row["profile_error"]) for choice, row in by_choice.items()}
    assert error[600, 36, 4, 0] < error[600, 12, 4, 0]
    assert error[600, 36, 4, 0] < error[600, 36, 0, 0]
    assert all(float(row["tracing_s"]) > 0 and float(row["gradient_s"]) > 0 for row in rows)


def test_sequences_of_temperatures_start_from_the_same_layouts(small_run):
    rows = rows_of(small_run[0] / "bench_surrogate_stages.csv")
    assert [row["temperatures_rad"] for row in rows] == ["0.3 0.05", "0.1"]
    assert all(0 < float(row["mean_end"]) <= float(row["best_end"]) <= 1 for row in rows)


def test_a_bound_that_does_not_hold_is_told_by_the_exit_status(small_run, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(bench_surrogate, "PLAN", TINY)
    monkeypatch.setattr(bench_surrogate, "true_areas", lambda *arguments: small_run[2].truth)
    monkeypatch.setattr(bench_surrogate, "measure", lambda *arguments: small_run[2])
    monkeypatch.setattr(bench_surrogate, "GREATEST_MEAN_ERROR", 1e-9)
    assert camring("bench", "surrogate", "--json", "--out", tmp_path) == 1
    out, err = capsys.readouterr()
    bounds = json.loads(out)["bounds"]
    assert not [bound for bound in bounds if "hard" in bound["what"]][0]["holds"]
    assert "mean error of hard coverage, circ_flat 50 is" in err
    assert all((tmp_path / name).exists() for name in bench_surrogate.OUTPUTS)


def accuracy_row(**changes):
    row = Accuracy("site", 50, "all", 10, 0.03, 0.995, 0.0, 0.001, 0.002, 0.003, 1e-9)
    return replace(row, **changes)


@pytest.mark.parametrize(
    ("changes", "holds"),
    [
        ({}, True),
        ({"rank_correlation": 0.9899}, False),
        ({"rank_correlation": None}, False),
        ({"temperature_rad": 0.0, "mean_error": 0.003}, True),
        ({"temperature_rad": 0.0, "mean_error": 0.0031}, False),
    ],
)
def test_bounds(changes, holds):
    assert [bound.holds for bound in check([accuracy_row(**changes)], 0.03)] == [holds]


def test_only_all_layouts_at_the_final_temperature_are_bounded():
    rows = [accuracy_row(n_cameras="4"), accuracy_row(temperature_rad=0.5), accuracy_row(temperature_rad=0.03)]
    assert len(check(rows, 0.03)) == 1


def test_rank_correlation_sees_only_order():
    rng = np.random.default_rng(0)
    areas = rng.random(50)
    assert rank_correlation(np.exp(9 * areas), areas) == pytest.approx(1.0)
    assert rank_correlation(-areas, areas) == pytest.approx(-1.0)
    assert abs(rank_correlation(rng.permutation(areas), areas)) < 0.5
    assert rank_correlation(areas, np.ones(50)) is None


def test_sizes_of_errors():
    mean, most, greatest = error_sizes(np.linspace(-1, 1, 201))
    assert (mean, most, greatest) == pytest.approx((0.5025, 0.95, 1.0), abs=0.01)


def test_standard_error_is_that_of_repeated_stratified_samples():
    # Probability rises along the strata, as it does where a shadow ends.
    rng, chance = np.random.default_rng(0), np.linspace(0, 1, 400)
    weights = np.full(400, 2.5)
    draws = rng.random((2000, 400)) < chance
    spread = np.std((draws * weights).sum(axis=1))
    predicted = np.sqrt(np.mean([standard_error(covered, weights) ** 2 for covered in draws[:200]]))
    assert predicted == pytest.approx(spread, rel=0.1)
    assert standard_error(np.ones(7, dtype=bool), np.ones(7)) == 0.0


def test_a_gradient_that_does_not_belong_to_the_values_is_found():
    rng = np.random.default_rng(0)
    profiles = RingProfiles.of(rng.normal(size=(12, 30)), np.ones(30))
    surrogate = Surrogate(profiles, exact.Demand(), exact.Ring())
    layouts = [rng.random(4) * 6 for _ in range(3)]
    assert gradient_error(surrogate, layouts, 0.1) < 1e-6

    class Tilted:
        points, demand = surrogate.points, surrogate.demand

        def at(self, angles, temperature):
            return surrogate.at(angles, temperature) + 0.1 * float(angles[0])

    assert gradient_error(Tilted(), layouts, 0.1) > 1e-3
