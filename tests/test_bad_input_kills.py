"""A run that is stopped at any moment leaves files absent or whole, and the next one gives the same bytes."""

import os
import random
import signal
import subprocess
import sys
import time

import pytest
from bad_input_cases import part

# More moments, of a search, by hand: CAMRING_KILLS=50 pytest tests/test_bad_input_kills.py
KILLS = int(os.environ.get("CAMRING_KILLS", "0"))


@pytest.fixture(scope="module")
def command(tmp_path_factory, quick_search):
    """A command that lacks only its output folder, what it writes, and how long it takes [s]."""
    folder = tmp_path_factory.mktemp("kills")
    (folder / "rig.toml").write_text("[cameras]\ncount = 3\n" + quick_search, encoding="utf-8")
    name = "optimise" if KILLS else "evaluate"
    arguments = [name, str(part(folder)), "--rig", str(folder / "rig.toml"), "--out"]
    begin = time.monotonic()
    assert _start([*arguments, str(folder / "whole")]).wait() == 0
    seconds = time.monotonic() - begin
    return arguments, {path.name: path.read_bytes() for path in (folder / "whole").iterdir()}, seconds


def _start(arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "experiments.cli", *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )


@pytest.mark.parametrize("kill", range(KILLS or 2))
def test_a_killed_run_leaves_nothing_half_written(command, tmp_path, kill):
    arguments, whole, seconds = command
    how = signal.SIGKILL if kill % 2 else signal.SIGINT
    # The files are written at the end: half of the moments are there.
    moment = random.Random(kill).uniform(0.1 if kill % 4 in (0, 3) else 0.8, 1.0) * seconds
    program = _start([*arguments, str(tmp_path / "out")])
    try:
        program.wait(moment)
    except subprocess.TimeoutExpired:
        program.send_signal(how)
    program.wait()
    assert program.returncode in (0, 130, -how)
    found = {path.name: path.read_bytes() for path in tmp_path.glob("out/*")}
    assert {name: data for name, data in found.items() if not name.startswith(".")}.items() <= whole.items()
    assert _start([*arguments, str(tmp_path / "out"), "--force"]).wait() == 0
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()} == whole
    assert len(whole) >= 3
