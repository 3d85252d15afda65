"""The example scripts run, and say what is true."""

import importlib.util

import numpy as np
import pytest
import trimesh

from tests.support import ROOT

EXAMPLES = ROOT / "experiments" / "examples"


def example(name):
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def scan(tmp_path):
    """A file that is not built in: a plate with a step on it."""
    parts = [trimesh.creation.box((30, 30, 2)), trimesh.creation.box((4, 30, 20))]
    path = tmp_path / "my scan.stl"
    trimesh.boolean.union(parts, engine="manifold").export(path)
    return path


def test_propose_layout(scan, capsys):
    result = example("propose_layout").main(str(scan), 3)
    assert result.area >= result.equidistant_area
    assert result.smallest_separation >= 5.0
    assert f"exact area: {result.area:.2f} mm²" in capsys.readouterr().out


def test_compare_layout(capsys):
    yours, equidistant = example("compare_layout").main("circ_flat", [90, 180, 270, 360])
    assert yours == pytest.approx(equidistant, rel=1e-12)
    assert "difference" in capsys.readouterr().out


def test_exact_area(scan, tmp_path):
    out = tmp_path / "seen.ply"
    result = example("exact_area").main(str(scan), str(out))
    written = trimesh.load_mesh(out)
    assert written.area == pytest.approx(result.area, rel=1e-5)  # PLY holds single precision
    assert 0 < result.area < 30 * 30 + 2 * 9 * 30
    assert np.all(np.diff(result.level_areas) <= 0)
