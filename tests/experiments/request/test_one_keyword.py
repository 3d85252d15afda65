"""A further field of a demand has an option and a key without another line: its class alone declares it."""

import json
import subprocess
import sys
import tomllib

import numpy as np
import pytest
import trimesh
import typer

import exact
import meshes
from experiments.cli import app as cli
from experiments.request import options as request_options
from experiments.request.option_kinds import of_type

# A demand of another program, with a field more: a baseline in centimetres.
PROGRAM = '''
import sys
from dataclasses import dataclass

import exact.demand


@dataclass(frozen=True)
class Demand(exact.demand.Demand):
    """What makes a point count, with a chord in another unit.

    Parameters
    ----------
    min_chord_cm : float
        Least chord between some two of the cameras that see a point [cm].
    """

    min_chord_cm: float = 0.0

    @property
    def baseline(self):
        return max(self.min_baseline, 10 * self.min_chord_cm)


exact.demand.Demand = Demand

from experiments.cli.app import main

main(sys.argv[1:])
'''
ANGLES = "20,60,200,240"  # neighbours are 10.3 mm apart, others more than 28 mm


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    """A wall on a plate: cameras to one side see that side of it."""
    path = tmp_path_factory.mktemp("scans") / "scan.stl"
    parts = [trimesh.creation.box((30, 30, 2)), trimesh.creation.box((4, 30, 20))]
    trimesh.boolean.union(parts, engine="manifold").export(path)
    return path


def run(*arguments):
    command = [sys.executable, "-c", PROGRAM, *map(str, arguments)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def area(scan, min_baseline):
    cameras = exact.Ring().cameras(np.radians([float(angle) for angle in ANGLES.split(",")]))
    return exact.evaluate(meshes.load(scan), cameras, threshold=2, min_baseline=min_baseline).area


@pytest.mark.parametrize("way", ["option", "key", "compare"])
def test_a_further_field_of_a_demand_works(scan, tmp_path, way):
    assert area(scan, 20.0) < 0.9 * area(scan, 0.0)
    evaluate = ("evaluate", scan, "--angles-deg", ANGLES, "--json")
    if way == "option":
        found = json.loads(run(*evaluate, "--min-chord-cm", "2"))["area_mm2"]
    elif way == "key":
        (tmp_path / "rig.toml").write_text("[demand]\nmin_chord_cm = 2\n", encoding="utf-8")
        found = json.loads(run(*evaluate, "--rig", tmp_path / "rig.toml"))["area_mm2"]
    else:
        ring = {"diameter_mm": 30, "working_distance_mm": 400, "fov_mm": [36, 24]}
        layout = {"format": "camring layout", "version": 1, "ring": ring, "angles_deg": json.loads(f"[{ANGLES}]")}
        (tmp_path / "layout.json").write_text(json.dumps(layout), encoding="utf-8")
        twice = (tmp_path / "layout.json",) * 2
        compared = json.loads(run("compare", *twice, "--mesh", scan, "--min-chord-cm", "2", "--json"))
        found = compared["layouts"][0]["area_mm2"]
    assert found == pytest.approx(area(scan, 20.0), rel=1e-12)


def test_a_further_field_of_a_demand_is_told_of(tmp_path):
    for command in ("evaluate", "optimise", "count", "compare"):
        said = " ".join(run(command, "--help").split())
        assert "--min-chord-cm <float>" in said
        assert "least chord between some two of the cameras that see a point [cm]" in said
    run("rig", "init", tmp_path / "rig.toml")
    assert tomllib.loads((tmp_path / "rig.toml").read_text(encoding="utf-8"))["demand"] == {"min_chord_cm": 0.0}


def test_what_is_read_from_the_sources_is_what_the_classes_declare():
    program = """
import sys
from experiments.request.options import ON_THE_COMMAND_LINE, keys
print([(one.name, one.section, one.kind.needs, one.default, one.meaning, one.classes) for one in
       keys(*ON_THE_COMMAND_LINE).values()])
assert not {"numpy", "exact", "placement"} & set(sys.modules)
"""
    unread = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True).stdout
    here = request_options.keys(*request_options.ON_THE_COMMAND_LINE).values()
    assert unread.strip() == str(
        [(one.name, one.section, one.kind.needs, one.default, one.meaning, one.classes) for one in here]
    )


def test_whoever_takes_a_threshold_takes_all_of_a_demand():
    demanded = {one.name for one in request_options.keys("Demand").values() if "Demand" in one.classes}
    takers = set()
    for name, command in typer.main.get_command(cli.app).commands.items():
        options = {parameter.name for parameter in command.params}
        if "threshold" in options:
            takers.add(name)
            assert demanded <= options, name
    assert takers == {"optimise", "count", "evaluate", "compare"}


def test_a_type_that_no_option_can_have_is_refused():
    with pytest.raises(TypeError, match=r"no option is read as dict\[str, int\]; add a kind for it to experiments/"):
        of_type("dict[str, int]")
