"""Layout files, rig files and constraints made up at random, and files of any bytes: read, or refused in words."""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import exact
import placement
from experiments.files.errors import InputError
from experiments.layouts import layout_file
from experiments.request import options as request_options
from experiments.request import rig as rig_file
from placement.layouts.arcs import LayoutSpace
from tests.support.files import LAYOUT

FUZZER = Path(__file__).parent / "fuzz_readers.py"
QUICK = settings(max_examples=300, deadline=None)

NUMBERS = (
    st.floats(width=64)
    | st.integers()
    | st.sampled_from([0, 1, 2, 3, -1, 0.5, 1e-320, 1e300, 10**400, True, float("nan"), float("inf")])
)
JSON = st.recursive(
    st.none() | st.booleans() | NUMBERS | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)
RING = st.fixed_dictionaries(
    {"diameter_mm": NUMBERS | JSON, "working_distance_mm": NUMBERS | JSON, "fov_mm": st.lists(NUMBERS) | JSON},
    optional={"focus_mm": st.lists(NUMBERS, min_size=3, max_size=3) | JSON, "axis": st.lists(NUMBERS) | JSON},
)
CONSTRAINTS = st.dictionaries(st.sampled_from([*layout_file.CONSTRAINTS, "typo"]), NUMBERS | JSON, max_size=3)
MESH = st.dictionaries(st.sampled_from(["name", "sha256", "scale"]), JSON, max_size=3)
CHANGES = st.fixed_dictionaries(
    {},
    optional={
        "ring": RING | JSON,
        "angles_deg": st.lists(NUMBERS, max_size=4) | JSON,
        "angles_rad": st.lists(NUMBERS, max_size=4) | JSON,
        "threshold": NUMBERS | JSON,
        "n_cameras": NUMBERS | JSON,
        "constraints": CONSTRAINTS | JSON,
        "mesh": MESH | JSON,
        "meshes": st.lists(MESH | JSON, max_size=2) | JSON,
        "version": st.just(1) | JSON,
    },
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("random")


@QUICK
@given(changes=CHANGES, without=st.sets(st.sampled_from(sorted(LAYOUT)), max_size=1))
def test_a_layout_file_is_read_or_refused(folder, changes, without):
    path = folder / "layout.json"
    path.write_text(json.dumps({name: value for name, value in (LAYOUT | changes).items() if name not in without}))
    try:
        found = layout_file.read(path)
    except InputError as error:
        assert "layout.json" in str(error)
        return
    assert 1 <= found.demand.threshold <= len(found.angles)
    assert 0 <= found.demand.min_baseline <= found.ring.diameter
    assert all(isinstance(name, str) and isinstance(key, str) for key, name in found.made_for.items())
    try:
        cameras = found.ring.cameras(found.angles)
    except exact.ExactError as error:  # a ring so small or so far from its focus that its cameras have no direction
        assert "camera" in str(error)
        return
    assert all(np.isfinite(camera.projection).all() for camera in cameras)


def toml(value):
    """A value as TOML; None where it has none."""
    if isinstance(value, list):
        return f"[{', '.join(filter(None, map(toml, value)))}]"
    if isinstance(value, dict) or value is None:
        return "{}"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value)


KEYS = [(section, name) for section, keys in request_options.sections().items() for name in keys]
VALUES = NUMBERS | st.lists(NUMBERS, max_size=4) | st.lists(st.lists(NUMBERS, max_size=3), max_size=2) | JSON


@QUICK
@given(values=st.dictionaries(st.sampled_from(KEYS), VALUES, max_size=4))
def test_a_rig_file_is_read_or_refused(folder, values):
    path = folder / "rig.toml"
    lines = [f"[{section}]\n{name} = {toml(value)}" for (section, name), value in sorted(values.items(), key=str)]
    merged = {}
    for line in lines:
        head, _, rest = line.partition("\n")
        merged.setdefault(head, []).append(rest)
    text = "\n".join(f"{head}\n" + "\n".join(rest) for head, rest in merged.items())
    path.write_text(text, encoding="utf-8", errors="replace")
    try:
        asked = rig_file.rig(path)
        ring = asked.ring((36.0, 24.0))
    except (InputError, exact.ExactError, placement.PlacementError) as error:
        assert len(str(error)) > 20
        return
    assert ring.diameter > 0
    assert np.isfinite(asked.constraints.fixed).all()


@QUICK
@given(
    kept=st.fixed_dictionaries(
        {},
        optional={
            "min_separation": st.floats(0, 40) | NUMBERS,
            "min_baseline": st.floats(0, 40) | NUMBERS,
            "min_angle": st.floats(0, 4) | NUMBERS,
            "fixed": st.lists(st.floats(-10, 10) | NUMBERS, max_size=4),
            "forbidden": st.lists(st.tuples(st.floats(-10, 10), st.floats(-10, 10) | NUMBERS), max_size=3),
        },
    ),
    n_cameras=st.integers(0, 12) | NUMBERS,
)
def test_constraints_are_understood_or_refused(kept, n_cameras):
    ring = exact.Ring()
    try:
        constraints = placement.Constraints(**kept)
        constraints.baseline(ring)
        gap = constraints.minimum_gap(ring)
        space = LayoutSpace(ring, n_cameras, constraints)
    except placement.PlacementError as error:
        assert len(str(error)) > 20
        return
    assert space.n_cameras == n_cameras >= 1
    assert constraints.violations(ring, ring.equidistant(n_cameras)) is not None
    assert n_cameras == 1 or 0 <= gap * n_cameras <= 2 * np.pi + 1e-6


@pytest.mark.parametrize("reader", ["mesh", "layout", "rig"])
def test_files_of_any_bytes_are_read_or_refused(reader):
    with tempfile.TemporaryDirectory() as found:
        options = ("-max_total_time=4", "-seed=1", f"-artifact_prefix={found}/")
        run = subprocess.run(
            [sys.executable, FUZZER, reader, *options], capture_output=True, text=True, errors="replace", check=False
        )
        assert run.returncode == 0, run.stderr[-3000:]
        assert not list(Path(found).iterdir())
    assert "DONE" in run.stderr
