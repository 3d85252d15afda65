"""Faults of files, disks, memory and processes: a clear answer each time, and results absent or whole."""

import ctypes
import json
import os
import resource
import signal
import subprocess
import sys
import threading
import tracemalloc
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import matplotlib.image
import pytest

import exact
import meshes
from exact.workers import processes
from tests.support.files import LAYOUT, box, part, put, stl
from tests.support.scenes import AWKWARD

# Linux: the capability sets of one thread, and the two with which root may read and write what modes forbid.
CAPABILITIES_VERSION_3, DAC_OVERRIDE, DAC_READ_SEARCH = 0x20080522, 1, 2


@pytest.fixture
def modes_count():
    """Let file modes hold for root too, until the test is over."""
    libc = ctypes.CDLL(None, use_errno=True)
    header, sets = (ctypes.c_uint32 * 2)(CAPABILITIES_VERSION_3, 0), (ctypes.c_uint32 * 6)()
    assert libc.capget(header, sets) == 0
    effective = sets[0]
    sets[0] = effective & ~(1 << DAC_OVERRIDE | 1 << DAC_READ_SEARCH)
    assert libc.capset(header, sets) == 0
    yield
    sets[0] = effective
    assert libc.capset(header, sets) == 0


def test_a_file_nobody_may_read(camring, tmp_path, modes_count):
    path = part(tmp_path)
    path.chmod(0)
    status, out, err = camring("evaluate", path, "--cameras", 2)
    assert (status, out) == (2, "")
    assert "part.stl: cannot be read (Permission denied); check its permissions and the disk" in err
    layout = put(tmp_path, "layout.json", json.dumps(LAYOUT))
    layout.chmod(0)
    status, _, err = camring("export", layout, "--format", "csv")
    assert status == 2
    assert "cannot read layout" in err and "Permission denied" in err


@pytest.mark.parametrize("command", [("evaluate", "--cameras", 2), ("optimise",)])
def test_a_folder_nobody_may_write_to(camring, tmp_path, modes_count, command):
    path, out = part(tmp_path), tmp_path / "out"
    out.mkdir(mode=0o555)
    status, printed, err = camring(command[0], path, *command[1:], "--out", out)
    assert (status, printed) == (2, "")
    assert f"cannot write to output folder {out}: Permission denied; give another one" in " ".join(err.split())
    status, _, err = camring("rig", "init", out / "rig.toml")
    assert status == 2
    assert "Permission denied" in err
    assert not list(out.iterdir())


@pytest.fixture
def fill_disk():
    """Let no file grow beyond a few bytes. Python ignores the signal, so that writing fails as on a full disk."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100, limits[1]))
    resource.setrlimit(resource.RLIMIT_FSIZE, limits)


@pytest.mark.parametrize(
    ("file", "command"),
    [
        ("evaluation.json", ("evaluate", "part.stl", "--cameras", 2, "--out", "out")),
        ("camera_01.png", ("evaluate", "part.stl", "--cameras", 2, "--images", "out")),
        ("cameras.csv", ("export", "layout.json", "--format", "csv", "--out", "out")),
        ("flat.stl", ("site", "circ_flat", "--detail", "coarse", "--out", "out/flat.stl")),
        ("flat.obj", ("site", "circ_flat", "--detail", "coarse", "--out", "out/flat.obj")),
        ("rig.toml", ("rig", "init", "out/rig.toml")),
    ],
)
def test_a_full_disk(camring, tmp_path, monkeypatch, fill_disk, file, command):
    monkeypatch.chdir(tmp_path)
    part(tmp_path)
    put(tmp_path, "layout.json", json.dumps(LAYOUT))
    (tmp_path / "out").mkdir()
    fill_disk()
    status, _, err = camring(*command)
    assert status == 2
    assert f"cannot write out/{file}: File too large; make room" in " ".join(err.split())
    assert "Traceback" not in err
    assert not list((tmp_path / "out").iterdir())


def test_what_a_killed_run_left_is_removed_by_the_next(camring, tmp_path):
    out, mine = tmp_path / "out", tmp_path / "out" / ".my-settings.toml"
    code = (
        "import os, signal, sys\nfrom pathlib import Path\nfrom experiments.files.whole import written_whole\n"
        "with written_whole(Path(sys.argv[1]) / 'of another command.csv'):\n    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    out.mkdir()
    mine.touch()
    assert subprocess.run([sys.executable, "-c", code, out], check=False).returncode == -signal.SIGKILL
    assert len(list(out.iterdir())) == 2
    assert camring("evaluate", part(tmp_path), "--cameras", 2, "--out", out)[0] == 0
    assert [path for path in out.iterdir() if path.name.startswith(".")] == [mine]


def test_a_header_of_four_billion_triangles_takes_no_memory(tmp_path):
    announced = put(tmp_path, "a.stl", stl(box())[:80] + b"\xff\xff\xff\xff" + stl(box())[84:])
    tracemalloc.start()
    with pytest.raises(meshes.MeshError, match="announces 4294967295 triangles"):
        meshes.load(announced)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1e6


NAMES = [
    'my scan\'s "new".stl',
    "手术 скан é.stl",
    "<b>x<script>alert(1)<script>.stl",
    "3 $_x to 4 $^.stl",
    "[red]a[/].stl".replace("/", ""),
    os.fsdecode(b"no\xfftext.stl"),
    "two\nlines.stl",
    "%s{0}.stl",
]


@pytest.mark.parametrize("name", NAMES)
def test_a_file_may_have_any_name(camring, tmp_path, name):
    (tmp_path / name).write_bytes(stl(box()))
    arguments = (
        "evaluate",
        tmp_path / name,
        "--cameras",
        2,
        "--images",
        tmp_path / "images",
        "--out",
        tmp_path / "out",
    )
    status, out, err = camring(*arguments)
    assert status == 0, err
    assert "reconstructable area: " in out
    assert "warning" not in err.lower()
    assert json.loads((tmp_path / "out" / "evaluation.json").read_text(encoding="utf-8"))["mesh"]["name"].isprintable()
    assert matplotlib.image.imread(tmp_path / "images" / "camera_01.png").shape[0] > 100


def test_a_mesh_in_metres_is_warned_of(camring, tmp_path):
    path = put(tmp_path, "a.stl", stl(box(0.01)))
    status, out, err = camring("evaluate", path, "--cameras", 2)
    assert (status, "reconstructable area: 0.000" in out) == (0, True)
    said = " ".join(err.split())
    assert "warning: " in said and "0.01 mm, so its unit is probably metres" in said and "--scale 1000" in said


def test_two_cameras_in_one_place_are_warned_of(camring, tmp_path):
    path = part(tmp_path)
    status, _, err = camring("evaluate", path, "--angles-deg", "30,120,390")
    assert status == 0
    assert "warning: cameras 1 and 3 sit in the same place" in err
    assert "warning" not in camring("evaluate", path, "--angles-deg", "30,120,390", "--min-baseline", 1)[2]
    assert "warning" not in camring("evaluate", path, "--angles-deg", "30,120,150")[2]


def test_a_layout_serves_another_mesh_by_force(camring, tmp_path):
    made_for = {"mesh": {"name": "other.stl", "sha256": "0" * 64}}
    layout = put(tmp_path, "layout.json", json.dumps(LAYOUT | made_for))
    arguments = ("evaluate", part(tmp_path), "--layout", layout, "--json")
    assert camring(*arguments)[0] == 2
    status, out, _ = camring(*arguments, "--force")
    cameras = exact.Ring().cameras([0, 3.141592653589793])
    assert status == 0
    assert json.loads(out)["area_mm2"] == pytest.approx(exact.evaluate(box(), cameras).area)
    right = made_for | {"meshes": [{"sha256": "1" * 64}, {"sha256": meshes.fingerprint(meshes.load(part(tmp_path)))}]}
    put(tmp_path, "layout.json", json.dumps(LAYOUT | right))
    assert camring(*arguments)[0] == 0


RUN = (sys.executable, "-m", "camring")


def started(*arguments, **options):
    environment = os.environ | options.pop("env", {})
    return subprocess.Popen([*RUN, *map(str, arguments)], stderr=subprocess.PIPE, text=True, env=environment, **options)


def test_standard_output_that_takes_nothing(tmp_path):
    with open("/dev/full", "w") as full:
        program = started("site", "--list", stdout=full)
        err = program.communicate()[1]
    assert program.returncode == 2
    assert err.startswith("camring: cannot write") and "No space left on device; " in err
    assert len(err.splitlines()) == 1
    reading, writing = os.pipe()
    os.close(reading)
    program = started("site", "--list", stdout=writing)
    os.close(writing)
    assert (program.communicate()[1], program.returncode) == ("", 141)


def test_a_terminal_of_few_letters():
    program = started("site", "--list", stdout=subprocess.PIPE, env={"PYTHONIOENCODING": "ascii"})
    out, err = program.communicate()
    assert (program.returncode, err) == (0, "")
    assert "circ_flat" in out


def test_too_little_memory(tmp_path):
    """Ten thousand cameras before a fine mesh, in a process that may take no more than it has after its start."""
    code = (
        "import resource, sys\n"
        "from experiments.cli.app import main\n"
        "from experiments.cli.commands import evaluate\nfrom experiments.exports import coverage_mesh\n"
        "used = int(open('/proc/self/statm').read().split()[0]) * resource.getpagesize()\n"
        "resource.setrlimit(resource.RLIMIT_AS, (used + 200_000_000,) * 2)\n"
        "main(sys.argv[1:])\n"
    )
    arguments = ("evaluate", "circ_flat", "--detail", "coarse", "--cameras", 10_000, "--out", tmp_path)
    program = subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True, check=False
    )
    assert (program.returncode, program.stdout) == (2, ""), program.stderr
    assert program.stderr.startswith("camring: not enough memory (")
    assert "take a coarser mesh, fewer cameras or fewer samples" in program.stderr
    assert len(program.stderr.splitlines()) == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("command", "allowed", "needed"), [("evaluate", 300_000_000, "0.7 GB"), ("optimise", 1_200_000_000, "2.5 GB")]
)
def test_too_little_memory_to_start_with(tmp_path, command, allowed, needed):
    code = (
        "import resource, sys\n"
        "from experiments.cli.app import main\n"
        f"resource.setrlimit(resource.RLIMIT_AS, ({allowed},) * 2)\n"
        "main(sys.argv[1:])\n"
    )
    arguments = (command, "circ_flat", "--detail", "coarse", "--cameras", "4", "--out", str(tmp_path / "out"))
    program = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=False)
    assert (program.returncode, program.stdout, list(tmp_path.iterdir())) == (2, "", [])
    assert program.stderr.startswith("camring: not enough memory: ")
    assert f"`camring {command}` needs {needed} to start" in program.stderr
    assert len(program.stderr.splitlines()) == 1


def test_a_worker_that_is_killed(camring):
    mesh, ring = box(), exact.Ring()
    layouts = [ring.cameras([0.0, 3.0 + number / 1000]) for number in range(400)]
    expected = exact.areas(mesh, layouts[:3])
    assert (exact.areas(mesh, layouts[:3], workers=2) == expected).all()
    with processes(2) as executor:
        workers = list(executor._processes.values())

    def kill(_):
        while workers:
            os.kill(workers.pop().pid, signal.SIGKILL)

    with pytest.raises(exact.ExactError, match="one of 2 processes .* was stopped .* ask for fewer workers"):
        exact.areas(mesh, layouts, workers=2, report=kill)
    assert (exact.areas(mesh, layouts[:3], workers=2) == expected).all()  # others take their place


def test_two_runs_do_not_write_into_one_folder(camring, tmp_path):
    code = (
        "import sys\nfrom pathlib import Path\nfrom experiments.files.whole import output_folder\n"
        "output_folder(Path(sys.argv[1]), ['a.txt'], False)\nprint('held', flush=True)\nsys.stdin.read()\n"
    )
    first = subprocess.Popen(
        [sys.executable, "-c", code, tmp_path / "out"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert first.stdout is not None
    assert first.stdout.readline() == "held\n"
    arguments = ("evaluate", part(tmp_path), "--cameras", 2, "--out", tmp_path / "out")
    status, _, err = camring(*arguments)
    assert status == 2
    assert f"another run of camring is writing into {tmp_path / 'out'}; wait until it is done" in " ".join(err.split())
    assert not list((tmp_path / "out").iterdir())
    first.kill()  # which frees the folder
    first.communicate()
    assert camring(*arguments)[0] == 0
    assert camring(*arguments, "--force")[0] == 0


def _bits(mesh):
    ring = exact.Ring()
    found = exact.evaluate(mesh, ring.cameras(ring.equidistant(5)), threshold=3)
    return found.area.hex(), found.face_areas.tobytes(), found.level_areas.tobytes()


def test_threads_and_processes_give_the_same_bits():
    mesh = AWKWARD["intersecting shells"]()
    expected = _bits(mesh)
    gate = threading.Barrier(4)

    def together(_):
        gate.wait()
        return _bits(mesh.copy())

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(together, range(4))) == [expected] * 4
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        assert list(pool.map(_bits, [mesh] * 2)) == [expected] * 2
