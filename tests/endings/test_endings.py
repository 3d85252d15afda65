"""Whatever ends a command ends it at once, with the documented status, and nothing of it is left.

And so for scripts that use the packages: they end when they are done, whatever was going on in the background.
"""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from experiments.cli.app import main
from tests.support.files import box, put, stl

HERE = Path(__file__).parent
# How long a command may take to be gone, with all that it has started, once it has said why [s].
AT_ONCE = 2.0
COMMANDS = {
    "optimise": "optimise part.stl --rig rig.toml",
    "count": "count part.stl --rig rig.toml --max-cameras 2",
    "tradeoff": "tradeoff part.stl --rig rig.toml --cameras 2",
    "ring": "ring part.stl --rig rig.toml --cameras 2 --diameter 20,30",
    "evaluate": "evaluate part.stl --cameras 2 --out out --json",
    "compare": "compare made/layout.json made/layout.json --mesh part.stl --out out --json",
    "report": "report made/layout.json --mesh part.stl --out out --json",
    "design": "design part.stl --cameras 2 --no-browser --fresh",
    "simulate": "simulate part.stl --layout made/layout.json --pixels 90x60 --rays 1 --out out --json",
    "export": "export made/layout.json --format csv --json",
    "site": "site circ_flat --out site.stl --json",
    "rig init": "rig init new.toml --json",
    "bench exact": "bench exact",
    "bench sites": "bench sites",
    "bench surrogate": "bench surrogate",
    "paper": "paper --quick",
    "study": "study --quick",
}
FAULTS = {
    "refused": (2, "camring: "),
    "assertion failed": (70, "Traceback (most recent call last):"),
    "out of memory": (2, "camring: not enough memory (none is left)"),
    "interrupted": (130, "camring: interrupted; what is written is whole"),
    "terminated": (143, "camring: terminated; what is written is whole"),
    "nobody reads": (141, ""),
}
MORE_FAULTS = {
    "hung up": (129, "camring: terminated; what is written is whole"),
    "a worker dies at its start": (2, "camring: one of 2 processes that shared the work was stopped from outside"),
    "a worker dies at work": (2, "camring: one of 2 processes that shared the work was stopped from outside"),
    "a worker fails": (70, "loky.process_executor._RemoteTraceback:"),
}


@pytest.fixture(scope="module")
def run(tmp_path_factory, quick_search):
    """Run a command with a fault; how it ended."""
    folder = tmp_path_factory.mktemp("endings")
    put(folder, "part.stl", stl(box()))
    put(folder, "unseen.stl", stl(box(at=(500, 0, 0))))
    rig = put(folder, "rig.toml", "[cameras]\ncount = 2\n" + quick_search)
    with pytest.raises(SystemExit):
        main(["optimise", str(folder / "part.stl"), "--rig", str(rig), "--out", str(folder / "made")])
    environment = os.environ | {"XDG_STATE_HOME": str(folder / "state")}  # not that of who runs the tests
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "env": environment}
    with subprocess.Popen([sys.executable, "-W", "ignore", HERE / "struck.py", folder], **pipes) as program:

        def run(arguments, fault):
            print(json.dumps({"arguments": arguments.split(), "fault": fault}), file=program.stdin, flush=True)
            return json.loads(program.stdout.readline())

        yield run
        program.stdin.close()


def assert_ended(ended, status, words):
    assert (ended["status"], ended["left"], ended["semaphores"]) == (status, [], []), ended
    assert ended["said"].startswith(words)
    assert len(ended["said"].splitlines()) == bool(words) or status == 70, ended["said"]
    assert "resource_tracker" not in ended["said"] and "Warning" not in ended["said"]
    assert ended["seconds"] < AT_ONCE


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_ends_at_once(run, command, fault):
    arguments = COMMANDS[command]
    if fault == "refused":
        arguments = arguments.replace("part.stl --rig", "unseen.stl --rig")
    ended = run(arguments, fault)
    assert_ended(ended, *FAULTS[fault])
    assert ended["struck"] or "unseen" in arguments or fault == "nobody reads"


@pytest.mark.parametrize("fault", MORE_FAULTS)
def test_a_command_ends_at_once_whatever_its_workers_do(run, fault):
    assert_ended(run(COMMANDS["bench exact"], fault), *MORE_FAULTS[fault])


@pytest.mark.parametrize(
    ("fault", "end"),
    [
        ("interrupted while a library computes", FAULTS["interrupted"]),
        ("a library computes in a thread", FAULTS["refused"]),
    ],
)
def test_a_command_ends_at_once_whatever_its_libraries_do(run, fault, end):
    assert_ended(run(COMMANDS["optimise"], fault), *end)


def test_workers_leave_with_a_command_that_is_killed(run):
    ended = run(COMMANDS["bench exact"], "killed")
    assert (ended["status"], ended["left"]) == (-signal.SIGKILL, [])


SCRIPTS = {
    "refused": ("placement.optimise(unseen, ring, 4, workers=2)", 1, "placement.errors.PlacementError: no camera"),
    "refused and caught": (
        "try:\n    placement.optimise(unseen, ring, 4, workers=2)\n"
        "except placement.PlacementError:\n    print('refused', file=sys.stderr)",
        0,
        "refused",
    ),
    # What begins before the main thread is done, and goes on when it is.
    "work in a thread": (
        "threading.Thread(target=lambda: print(exact.areas(seen, layouts, workers=2), file=sys.stderr)).start()",
        0,
        "[110. 100.]",
    ),
    "work in a thread, later": (
        "def later():\n    time.sleep(0.5)\n    print(exact.areas(seen, layouts, workers=2), file=sys.stderr)\n"
        "threading.Thread(target=later).start()",
        0,
        "[110. 100.]",
    ),
    "work in the background": (
        "ball = checked_sites(trimesh.creation.icosphere(subdivisions=5, radius=12))\n"
        "begun = RingMaximum(ball, ring, demand, workers=2)\n"
        "start_processes(2)\nbegun.begin()\ntime.sleep(1)\nraise ValueError('of the script')",
        1,
        "ValueError: of the script",
    ),
    "interrupted while processes are at work": (
        "ball = trimesh.creation.icosphere(subdivisions=5, radius=12)\n"
        "interrupt_soon()\nexact.evaluate(ball, ring.cameras(ring.equidistant(360)), workers=2)",
        -signal.SIGINT,
        "KeyboardInterrupt",
    ),
    "interrupted while a program is solved": (
        "draw = np.random.default_rng(0)\nsizes = draw.integers(1, 1000, (20, 60)).astype(float)\n"
        "program, worth = LinearProgram(), 50 + 100 * draw.random(60)\n"
        "program.columns(-worth, np.zeros(60), np.ones(60), whole=True)\n"
        "program.rows(sizes, -np.inf, sizes.sum(axis=1) / 3)\ninterrupt_soon()\nprogram.solve_within(1000.0)",
        -signal.SIGINT,
        "KeyboardInterrupt",
    ),
    "work in a process of multiprocessing": (
        "child = multiprocessing.get_context('fork').Process(\n"
        "    target=lambda: print(exact.areas(seen, layouts, workers=2), file=sys.stderr))\n"
        "child.start()\nchild.join()",
        0,
        "[110. 100.]",
    ),
}
PROLOGUE = """
import multiprocessing, os, signal, sys, threading, time
import numpy as np
import trimesh
import exact, placement
from exact.workers import start_processes
from placement.proof.linear_program import LinearProgram
from placement.search.ring_maximum import RingMaximum
from placement.sites import checked_sites
signal.signal(signal.SIGINT, signal.default_int_handler)  # what runs in the background ignores it
def interrupt_soon():
    threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()
seen, unseen, ring = trimesh.creation.box((10, 10, 1)), trimesh.creation.box((10, 10, 10)), exact.Ring()
unseen.apply_translation((500, 0, 0))
demand = exact.Demand()
layouts = [ring.cameras([0.0, angle]) for angle in (1.0, 2.0)]
"""


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_script_ends(name):
    code, status, words = SCRIPTS[name]
    script = [sys.executable, "-W", "ignore", "-c", PROLOGUE + code]
    ended = subprocess.run(script, capture_output=True, text=True, check=False, timeout=60)
    assert ended.returncode == status, ended.stderr
    assert words in ended.stderr.splitlines()[-1]
    assert "resource_tracker" not in ended.stderr
