"""Runs `camring` again and again, each time with a fault that strikes once its worker processes are there.

Reads one request a line from standard input, as JSON, and answers each with how it ended. All are forks of one process
that has imported everything already, which takes longer than all the rest.
"""

import hashlib
import importlib
import json
import operator
import os
import pkgutil
import shutil
import signal
import sys
import tempfile
import threading
import time
from pathlib import Path

import loky

import exact
import experiments
import meshes
import placement
from exact.visibility import surface
from exact.workers import background, processes
from experiments.bench import exact_areas as bench_exact
from experiments.cli import app as cli
from placement.samples import profiles

# From a terminal all processes get them.
SIGNALS = {"interrupted": signal.SIGINT, "terminated": signal.SIGTERM, "hung up": signal.SIGHUP}
ERRORS = {
    "refused": exact.ExactError("refused for a reason"),
    "assertion failed": AssertionError("deep in a library"),
    "out of memory": MemoryError("none is left"),
}
# Long enough for any machine; what has not ended by then hangs.
HUNG = 60


def compute() -> None:
    """For minutes, without looking whether anybody wants it to stop."""
    hashlib.pbkdf2_hmac("sha512", b"", b"", 10**9)


class Struck:
    """The fault, and where it strikes: in what the command calls of a library once its workers are there."""

    def __init__(self, command: str, fault: str):
        self.fault = fault
        self.workers_are_there = threading.Event()
        self.has_struck = False
        self.submit = loky.ProcessPoolExecutor.submit
        loky.ProcessPoolExecutor.submit = lambda pool, function, *a: self.submitted(command, pool, function, *a)
        if command in ("optimise", "count", "tradeoff"):  # whose workers start in the background
            profiles.EmbreeScene = self.scene
        elif command not in ("bench", "paper", "ring", "study"):  # which start none
            with processes(1):
                os.replace = self.replace
            if command in ("evaluate", "compare"):  # which take longer until they write
                surface.connected_components = self.components

    def submitted(self, command: str, pool: loky.ProcessPoolExecutor, function, *arguments):
        if function is int or command not in ("bench", "paper", "ring", "study"):
            future = self.submit(pool, function, *arguments)
            if self.fault == "a worker dies at its start" and not self.workers_are_there.is_set():
                os.kill(next(iter(pool._processes)), signal.SIGKILL)
            self.workers_are_there.set()
            return future
        if self.fault == "a worker dies at work":
            return self.submit(pool, signal.raise_signal, signal.SIGKILL)
        if self.fault == "a worker fails":
            return self.submit(pool, operator.truediv, 1, 0)
        self.strike()
        return self.submit(pool, function, *arguments)

    def scene(self):
        assert self.workers_are_there.wait(HUNG / 2)
        self.strike()
        return scene()

    def components(self, *arguments, **named):
        self.strike()
        return components(*arguments, **named)

    def replace(self, *arguments):
        if self.fault != "nobody reads":  # what it prints at its end
            self.strike()
        return replace(*arguments)

    def strike(self) -> None:
        if self.has_struck:
            return
        self.has_struck = True
        sys.stderr.write("struck\n")
        if self.fault == "interrupted while a library computes":
            threading.Timer(0.1, os.killpg, (0, signal.SIGINT)).start()
            compute()
        elif self.fault == "a library computes in a thread":
            background(compute)
            raise ERRORS["refused"]
        elif self.fault == "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        elif self.fault in SIGNALS:
            os.killpg(0, SIGNALS[self.fault])
        elif self.fault == "nobody reads":
            sys.stdout.write("a result\n")
            sys.stdout.flush()
        elif self.fault in ERRORS:
            raise ERRORS[self.fault]


def started(arguments: list[str], fault: str) -> tuple[int, int] | None:
    """Number of the new process and the pipe from its standard error; None in that process."""
    reading, writing = os.pipe()
    pid = os.fork()
    if pid:
        os.close(writing)
        return pid, reading
    os.setsid()
    nobody, closed = os.pipe()
    os.close(nobody)
    nothing = os.open(os.devnull, os.O_RDWR)
    for source, target in ((nothing, 0), (closed if fault == "nobody reads" else nothing, 1), (writing, 2)):
        os.dup2(source, target)
    for name in ("interrupted", "terminated", "hung up"):
        signal.signal(SIGNALS[name], signal.default_int_handler if name == "interrupted" else signal.SIG_DFL)
    Struck(arguments[0], fault)
    sys.argv = ["camring", *arguments]
    return None


def alive(session: int) -> list[str]:
    """What the processes of a session that are not dead yet are running."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            state, _, _, its_session = (folder / "stat").read_text().rpartition(")")[2].split()[:4]
            if int(its_session) == session and state != "Z":
                found.append((folder / "cmdline").read_text().replace("\0", " "))
        except (FileNotFoundError, ProcessLookupError):
            pass
    return found


def ended(pid: int, reading: int) -> dict:
    """How a process ended: what it said, and how long after its first words it and all it started were gone [s]."""
    lines, said = [], []

    def read() -> None:
        with open(reading, encoding="utf-8") as stream:
            for line in stream:
                lines.append(line)
                said.append(time.monotonic())

    reader = threading.Thread(target=read)
    reader.start()
    begun, status, left = time.monotonic(), None, []
    while time.monotonic() < begun + HUNG:
        if status is None:
            gone, code = os.waitpid(pid, os.WNOHANG)
            if gone:
                status, over = os.waitstatus_to_exitcode(code), time.monotonic()
        left = [] if status is None else alive(pid)
        if status is not None and (not left or time.monotonic() > over + HUNG / 2):
            break
        time.sleep(0.02)
    all_gone, left = time.monotonic(), alive(pid)
    semaphores = [path.name for path in Path("/dev/shm").glob(f"sem.loky-{pid}-*")]
    if status is None or left:
        os.killpg(pid, signal.SIGKILL)
    reader.join()
    first = next((i for i, line in enumerate(lines) if line != "struck\n"), 0)  # without any, when it struck
    return {
        "status": status, "seconds": all_gone - said[first] if said else 0.0, "left": left, "semaphores": semaphores,
        "said": "".join(line for line in lines if line != "struck\n"), "struck": "struck\n" in lines,
    }  # fmt: skip


def serve() -> None:
    """Answer until there are no more requests; come back in the processes that are started meanwhile."""
    for line in sys.stdin:
        folder = shutil.copytree(given, Path(tempfile.mkdtemp()) / "work")
        os.chdir(folder)
        # Each remembers for itself: what one before it has found would leave its workers nothing to do.
        os.environ["XDG_CACHE_HOME"] = str(folder.parent / "cache")
        process = started(**json.loads(line))
        if process is None:
            return
        sys.stdout.write(json.dumps(ended(*process)) + "\n")
        sys.stdout.flush()
        shutil.rmtree(folder.parent)
    os._exit(0)


if __name__ == "__main__":
    given = sys.argv[1]  # a folder of files, of which each command gets a copy
    scene, components, replace = profiles.EmbreeScene, surface.connected_components, os.replace
    os.sched_getaffinity, os.cpu_count = lambda _: {0, 1}, lambda: 2  # two workers, whatever the machine
    flat = meshes.site("circ_flat", depth=50, detail="coarse")
    meshes.site = lambda *_, **__: flat
    for package in (exact, placement, experiments):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            importlib.import_module(module.name)
    bench_exact.MEASUREMENTS = (bench_exact._many_cameras,)  # the others start no workers
    serve()
    cli.main()
