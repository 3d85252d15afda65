"""camring bench meshes: a small run of it, and what it refuses."""

import csv
import json

import pytest

import exact
from experiments.bench import any_size
from experiments.bench.any_size import BRAIN, CYLINDERS, SITE, SPHERE, Case, Cost, targets
from experiments.bench.generated_meshes import KINDS
from experiments.cli import app as cli

SMALL = (Case("sphere", 500), Case("channel", 600, n_cameras=3), Case("brain", 900))


def camring(capsys, *words):
    with pytest.raises(SystemExit) as ended:
        cli.main([str(word) for word in words])
    shown = capsys.readouterr()
    return ended.value.code or 0, shown.out, shown.err


def test_a_small_run_measures_the_areas_that_evaluate_gives(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(any_size, "CASES", SMALL)
    status, out, _ = camring(capsys, "bench", "meshes", "--json", "--most-faces", 600, "--out", tmp_path)
    assert status == 0
    costs = json.loads(out)["costs"]
    assert [cost["kind"] for cost in costs] == ["sphere", "channel"]
    ring = exact.Ring()
    for case, cost in zip(SMALL, costs, strict=False):
        mesh = KINDS[case.kind](case.n_faces)
        assert cost["n_faces"] == len(mesh.faces)
        assert cost["area_mm2"] == exact.evaluate(mesh, ring.cameras(ring.equidistant(case.n_cameras))).area
        assert 0 < cost["cpu_us_per_face"] < 1e7
        assert 0.01 < cost["peak_gb"] < 4
    with (tmp_path / "bench_meshes.csv").open(encoding="utf-8") as file:
        assert [row["kind"] for row in csv.DictReader(file)] == ["sphere", "channel"]
    assert "memory [GB]" in camring(capsys, "bench", "meshes", "--most-faces", 500, "--out", tmp_path, "--force")[1]


def test_targets_compare_time_a_face():
    costs = {
        case: Cost(case.kind, case.task, case.n_faces, case.n_cameras, 1.0, cpu, 0.5, 1.0)
        for case, cpu in ((SPHERE, 1.64), (SITE, 1.0), (BRAIN, 4.0), (CYLINDERS, 4.8))
    }
    many = Case("site", SITE.n_faces, n_cameras=360)
    costs[many] = Cost("site", "evaluate", SITE.n_faces, 360, 1.0, 15.0, 0.5, 1.0)
    found = {what: value for what, value, _ in targets(costs)}
    assert found["CPU a face, cylinders over sphere"] == pytest.approx(60 / 20)
    assert found["CPU a face, brain over site"] == pytest.approx(100 / (1e6 / 20_980))
    assert found["360 over 8 cameras, site"] == pytest.approx(15.0)


def test_what_cannot_be_limited_is_refused(tmp_path, capsys):
    status, _, err = camring(capsys, "bench", "meshes", "--most-faces", 10, "--out", tmp_path)
    assert status == 2
    assert "smallest mesh of this benchmark has 20980 faces" in " ".join(err.split())
    status, _, err = camring(capsys, "bench", "sites", "--most-faces", 10, "--out", tmp_path)
    assert status == 2
    assert "for the benchmark meshes" in err
