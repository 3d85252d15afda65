"""camring count: what it computes, prints, leaves behind, and refuses."""

import csv
import json
import sys
from types import SimpleNamespace
from typing import Any

import matplotlib.image
import numpy as np
import pytest
import trimesh
from jaxtyping import config

import exact
import meshes
import placement
from experiments.cli.commands.count import in_words

RING = exact.Ring()


@pytest.fixture(scope="module")
def bars(tmp_path_factory, quick_search):
    """A floor under two bars, and a rig file that makes the search quick."""
    folder = tmp_path_factory.mktemp("bars")
    beams = [trimesh.creation.box((40, 3, 3)), trimesh.creation.box((3, 30, 3)).apply_translation((-6, 0, 4))]
    beams = [beam.apply_translation((0, 2, 32)) for beam in beams]
    trimesh.util.concatenate([trimesh.creation.box((40, 40, 2)), *beams]).export(folder / "bars.stl")
    (folder / "rig.toml").write_text(quick_search + "certificate_step = 0.5\n", encoding="utf-8")
    return folder


def count(bars, *more):
    return ("count", bars / "bars.stl", "--rig", bars / "rig.toml", *more)


def rows_of(folder):
    with (folder / "count.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_the_fewest_cameras_that_reach_the_target(camring, bars, tmp_path):
    out = tmp_path / "out"
    status, printed, err = camring(
        *count(bars, "--target", 0.6, "--max-cameras", 3, "--certify", "--out", out, "--json")
    )
    found = json.loads(printed)
    assert status == 0, err
    mesh = meshes.load(bars / "bars.stl")
    area = {n: exact.evaluate(mesh, RING.cameras(RING.equidistant(n))).area for n in (2, 3, 8)}
    even = {n: area[n] / area[8] for n in (2, 3)}
    counts = {row["n_cameras"]: row for row in found["counts"]}
    for n, row in counts.items():
        assert row["equidistant_fraction"] == pytest.approx(even[n], rel=1e-12)
        ours = exact.evaluate(mesh, RING.cameras(np.radians(row["ring_angles_deg"]))).area
        assert row["optimised_fraction"] == pytest.approx(ours / area[8], rel=1e-12)
        assert row["optimised_fraction"] >= row["best_equidistant_fraction"] >= row["equidistant_fraction"]
        assert row["proven"] and row["bound_fraction"] >= row["grid_bound_fraction"] - 1e-9
    assert found["n_cameras"] == min(n for n, row in counts.items() if row["optimised_fraction"] >= 0.6)
    reached = [n for n in even if even[n] >= 0.6]
    assert found["n_equidistant"] == (reached[0] if reached else None)

    kept = json.loads((out / "layout.json").read_text(encoding="utf-8"))
    assert kept == found["layout"]
    assert kept["n_cameras"] == found["n_cameras"]
    assert kept["angles_deg"] == pytest.approx(counts[kept["n_cameras"]]["ring_angles_deg"])
    for row, written in zip(found["counts"], rows_of(out), strict=True):
        assert list(row) == list(written)
        assert float(written["optimised_fraction"]) == row["optimised_fraction"]
        assert [float(word) for word in written["ring_angles_deg"].split()] == row["ring_angles_deg"]
    picture = matplotlib.image.imread(out / "count.png")
    assert picture.shape[:2] == (840, 1260)
    assert len(np.unique((picture[..., :3] * 255).astype(int).reshape(-1, 3), axis=0)) > 30
    # The layout goes on to the other commands.
    status, printed, _ = camring("evaluate", bars / "bars.stl", "--layout", out / "layout.json", "--json")
    assert json.loads(printed)["area_mm2"] == pytest.approx(kept["areas_mm2"]["optimised"], rel=1e-12)


def test_what_is_known_stays_when_it_is_stopped(camring, bars, tmp_path, monkeypatch):
    module = sys.modules["placement.recommend"]
    propose = module.propose_layout

    def stopped(problem, space, *more, **named):
        if space.n_cameras == 3:
            raise KeyboardInterrupt
        return propose(problem, space, *more, **named)

    monkeypatch.setattr(module, "propose_layout", stopped)
    (tmp_path / "layout.json").write_text("of an earlier run", encoding="utf-8")
    status, out, err = camring(*count(bars, "--out", tmp_path, "--force"))
    assert (status, out) == (130, "")
    assert [row["n_cameras"] for row in rows_of(tmp_path)] == ["2"]
    assert rows_of(tmp_path)[0]["bound_fraction"] == ""
    assert not (tmp_path / "layout.json").exists()  # nothing reached the target yet


def test_a_target_out_of_reach_is_told_by_the_exit_status(camring, bars, tmp_path):
    status, out, err = camring(
        *count(bars, "--target", 1, "--max-cameras", 3, "--min-separation", 27, "--out", tmp_path)
    )
    words = " ".join(out.split())
    assert status == 1
    assert "2 well-placed cameras do not reach 100 % of the ring maximum; more than 2 do not fit" in words
    assert "an equidistant ring does not with up to 3." in words
    assert "do not fit" in words
    assert "target missed: the optimised 2 cameras reach 0." in " ".join(err.split())
    assert sorted(file.name for file in tmp_path.iterdir()) == ["count.csv", "count.png"]
    assert [row["optimised_fraction"] == "" for row in rows_of(tmp_path)] == [False, True]


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (("--max-cameras", 1), "--max-cameras is 1; it must be at least 2"),
        (("--fixed-deg", "0,90,180", "--max-cameras", 2), "it must be at least 3"),
        (("--target", 99), "--target is 99"),
        (("--min-separation", 31), "a separation of 31 mm"),
    ],
)
def test_what_makes_no_sense_is_refused_before_anything_is_computed(camring, bars, tmp_path, more, message):
    status, out, err = camring(*count(bars, *more, "--out", tmp_path / "out"))
    assert (status, out) == (2, "")
    assert message in " ".join(err.split())
    assert not list(tmp_path.rglob("*.csv"))


def test_nothing_is_replaced_without_force(camring, bars, tmp_path):
    (tmp_path / "count.csv").write_text("precious", encoding="utf-8")
    status, _, err = camring(*count(bars, "--out", tmp_path))
    assert status == 2
    assert "--force" in err
    assert (tmp_path / "count.csv").read_text(encoding="utf-8") == "precious"


def counted(n, even, best, bound=None):
    """A result with as much of a layout and its certificate as the words need."""
    certificate = None if bound is None else SimpleNamespace(bound_fraction=bound, sampling_error=0.001)
    layout: Any = SimpleNamespace(fraction=best, certificate=certificate)
    config.update("jaxtyping_disable", True)  # stand-ins are of no type that a result has
    found = placement.CountResult(n, even, even, layout)
    config.update("jaxtyping_disable", False)
    return found


@pytest.mark.parametrize(
    ("counts", "fewest", "even", "words"),
    [
        (
            [counted(2, 0.5, 0.6, 0.65), counted(3, 0.96, 0.98, 0.99)], 3, None,
            "3 cameras reach 97 % of the site; an equidistant ring does not with up to 3. No layout of 2 cameras does: "
            "on the samples none exceeds 65 % (standard error 0.10 %).",
        ),
        ([counted(2, 0.5, 0.6, 0.98), counted(3, 0.97, 0.98)], 3, 3, "3 cameras reach 97 % of the site; an equidistant "
         "ring needs 3."),
        ([counted(1, 0.97, 0.98)], 1, 1, "1 camera reaches 97 % of the site; an equidistant ring needs 1."),
        ([counted(2, 0.5, 0.6)], None, None, "2 well-placed cameras do not reach 97 % of the site; an equidistant ring "
         "does not with up to 2."),
    ],
)  # fmt: skip
def test_words(counts, fewest, even, words):
    assert in_words(placement.Recommendation(0.97, fewest, even, tuple(counts)), "the site") == words
