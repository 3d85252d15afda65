"""A run that is stopped at any moment leaves files absent or whole, and the next one gives the same bytes."""

import logging
import os
import random
import re
import signal
import subprocess
import sys
import time
from functools import cache
from pathlib import Path

import pytest

from tests.support import ROOT
from tests.support.files import part

# More moments, shared among what takes long, by hand: CAMRING_KILLS=50 pytest tests/endings/test_kills.py
# which tells with --log-cli-level=info how each run was met.
KILLS = int(os.environ.get("CAMRING_KILLS", "0"))
COMMANDS = ("optimise", "paper", "study") if KILLS else ("evaluate",)
# The study with one site and one number of cameras: what `--quick` takes minutes for is more of the same.
SMALL_STUDY = (
    "from experiments.cli.app import main\n"
    "from experiments.study.tasks import Plan\n"
    "plan = Plan((('circ_flat', 50),), (2,), (), (), (2, 3, 4), 'coarse')\n"
    "Plan.of = staticmethod(lambda quick, detail: plan)\n"
    "main()\n"
)
# The only figures of a sweep that differ from run to run.
TIMES = re.compile(rb'"(wall_|task_)?seconds": [\d.e-]+|"tasks_found_done": \d+')


def _start(arguments):
    return subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=ROOT)


def _files(out):
    """What is below a folder, by name: bytes, without the times of tasks and records."""
    found = {str(path.relative_to(out)): path.read_bytes() for path in out.rglob("*") if path.is_file()}
    return {name: TIMES.sub(b"", data) if name.endswith(".json") else data for name, data in found.items()}


def _results(out):
    """The files that are written when all is computed."""
    return [path for path in out.glob("*") if path.is_file() and not path.name.startswith(".")]


@pytest.fixture(scope="module", autouse=True)
def interruptible():
    """What a shell starts in the background ignores SIGINT, and so would all that it starts."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory, quick_search):
    """By command: its arguments but for the output folder, what it writes, how long that and all of it take [s]."""
    folder = tmp_path_factory.mktemp("kills")
    (folder / "rig.toml").write_text("[cameras]\ncount = 3\n" + quick_search, encoding="utf-8")
    mesh, camring = str(part(folder)), (sys.executable, "-m", "camring")
    of = {
        "paper": (*camring, "paper", "--quick", "--out"),
        "study": (sys.executable, "-c", SMALL_STUDY, "study", "--quick", "--out"),
    } | {name: (*camring, name, mesh, "--rig", str(folder / "rig.toml"), "--out") for name in ("evaluate", "optimise")}

    @cache
    def run(name):
        out, begin = folder / name, time.monotonic()
        assert _start([*of[name], str(out)]).wait() == 0
        seconds = time.monotonic() - begin
        written = [path.stat().st_mtime for path in _results(out)]
        return of[name], _files(out), max(written) - min(written), seconds

    return run


def _wait_for_moment(program, out, chance, late, writing, seconds):
    """Until some time of the run; or, as most files are written at its end, of what follows the first of them."""
    if not late:
        time.sleep(chance * seconds)
        return
    while not _results(out) and program.poll() is None:
        time.sleep(0.002)
    time.sleep(chance * writing)


@pytest.mark.parametrize("kill", range(KILLS or 2))
def test_a_killed_run_leaves_nothing_half_written(undisturbed, tmp_path, kill):
    name = COMMANDS[kill % len(COMMANDS)]
    arguments, whole, *times = undisturbed(name)
    chance = random.Random(kill)
    how = chance.choice((signal.SIGKILL, signal.SIGINT))
    out = tmp_path / "out"
    program = _start([*arguments, str(out)])
    _wait_for_moment(program, out, chance.random(), chance.random() < 0.5, *times)
    program.send_signal(how)
    program.wait()
    logging.info("%s ended with %d after %d results", name, program.returncode, len(_results(out)))
    assert program.returncode in (0, 130, -how)
    found = {file: data for file, data in _files(out).items() if not Path(file).name.startswith(".")}
    assert found.items() <= whole.items()
    assert _start([*arguments, str(out), "--force"]).wait() == 0
    assert _files(out) == whole
    assert len(whole) >= 3
