"""A further field of a demand has an option and a key without another line: its class alone declares it."""

import json
import os
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
from tests.support import ROOT

# Another program, whose demands have a field more.
PROGRAM = """
import json
import sys

import exact.demand
from tests.support.further_demand import Demand

exact.demand.Demand = Demand

from experiments.cli.app import main

for line in sys.stdin:
    try:
        main(json.loads(line))
    except SystemExit as end:
        assert not end.code, line
    sys.stdout.write("\\0")
"""
# The subcommands that ask how many views count.
TAKERS = {"optimise", "count", "tradeoff", "ring", "design", "evaluate", "compare", "simulate"}
ANGLES = "20,60,200,240"  # neighbours are 10.3 mm apart, others more than 28 mm


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    """A wall on a plate: cameras to one side see that side of it."""
    path = tmp_path_factory.mktemp("scans") / "scan.stl"
    parts = [trimesh.creation.box((30, 30, 2)), trimesh.creation.box((4, 30, 20))]
    trimesh.boolean.union(parts, engine="manifold").export(path)
    return path


def area(scan, min_baseline):
    cameras = exact.Ring().cameras(np.radians([float(angle) for angle in ANGLES.split(",")]))
    return exact.evaluate(meshes.load(scan), cameras, threshold=2, min_baseline=min_baseline).area


@pytest.fixture(scope="module")
def said(tmp_path_factory, scan):
    """What each command says in that program: all in one process, which has to import everything."""
    folder = tmp_path_factory.mktemp("wider")
    (folder / "rig.toml").write_text("[demand]\nmin_chord_cm = 2\n", encoding="utf-8")
    ring = {"diameter_mm": 30, "working_distance_mm": 400, "fov_mm": [36, 24]}
    layout = {"format": "camring layout", "version": 1, "ring": ring, "angles_deg": json.loads(f"[{ANGLES}]")}
    (folder / "layout.json").write_text(json.dumps(layout), encoding="utf-8")
    evaluate = ("evaluate", str(scan), "--angles-deg", ANGLES, "--json")
    commands = {
        "option": (*evaluate, "--min-chord-cm", "2"),
        "key": (*evaluate, "--rig", "rig.toml"),
        "compare": ("compare", *["layout.json"] * 2, "--mesh", str(scan), "--min-chord-cm", "2", "--json"),
        **{f"{name} --help": (name, "--help") for name in TAKERS},
        "rig init": ("rig", "init", "new.toml"),
    }
    lines = "".join(json.dumps(arguments) + "\n" for arguments in commands.values())
    program = [sys.executable, "-c", PROGRAM]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(program, input=lines, check=True, capture_output=True, text=True, cwd=folder, env=environment)
    return dict(zip(commands, done.stdout.split("\0"), strict=False)) | {"folder": folder}


@pytest.mark.parametrize("way", ["option", "key", "compare"])
def test_a_further_field_of_a_demand_works(scan, said, way):
    assert area(scan, 20.0) < 0.9 * area(scan, 0.0)
    found = json.loads(said[way])
    found = found["layouts"][0]["area_mm2"] if way == "compare" else found["area_mm2"]
    assert found == pytest.approx(area(scan, 20.0), rel=1e-12)


def test_a_further_field_of_a_demand_is_told_of(said):
    for command in TAKERS:
        words = " ".join(said[f"{command} --help"].split())
        assert "--min-chord-cm <float>" in words
        assert "least chord between some two of the cameras that see a point [cm]" in words
    rig = (said["folder"] / "new.toml").read_text(encoding="utf-8")
    assert tomllib.loads(rig)["demand"]["min_chord_cm"] == 0.0


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
    assert takers == TAKERS


def test_a_type_that_no_option_can_have_is_refused():
    with pytest.raises(TypeError, match=r"no option is read as dict\[str, int\]; add a kind for it to experiments/"):
        of_type("dict[str, int]")
