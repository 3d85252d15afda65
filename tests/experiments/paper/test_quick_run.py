"""camring paper: the quick run; a killed run and a cluster that loses a worker change nothing."""

import csv
import json
import os
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import time

import matplotlib.image
import pytest

import exact
import meshes
from experiments.paper.areas import read_areas
from experiments.paper.published import published_areas
from tests.support import ROOT

QUICK = (sys.executable, "-m", "camring", "paper", "--quick", "--out")
# 3 cases (two sites, one of them with both fields of view), 5 numbers of cameras; a picture for each case.
N_TASKS = 3 * 5 + 3
PATIENCE = 120  # seconds until a test gives up waiting, on a machine that is busy with others


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """The folder of a quick run that nothing disturbed; beside it, what the run said of itself."""
    out = tmp_path_factory.mktemp("paper")
    done = subprocess.run([*QUICK, out, "--json"], cwd=ROOT, check=True, capture_output=True)
    out.with_suffix(".json").write_bytes(done.stdout)
    return out


def lines(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def tables(folder):
    """Content of all CSV files."""
    return {file.name: file.read_bytes() for file in folder.glob("*.csv")}


def wait_until(condition, process=None):
    end = time.monotonic() + PATIENCE
    while not (found := condition()):
        assert time.monotonic() < end, "nothing happened"
        assert process is None or process.poll() is None, process.stderr.read().decode()
        time.sleep(0.02)
    return found


def n_done(out):
    return len([file for file in (out / "tasks").glob("*.json") if not file.name.startswith(".")])


def test_quick_run_writes_everything(quick):
    assert {file.name for file in quick.glob("table*")} == {
        f"table_{number}.{kind}" for number in (2, 3, 4, 5, 6, "A1", "A2", "A3") for kind in ("csv", "md", "tex")
    }
    assert {file.name for file in quick.glob("figure*")} == {
        f"figure_{number}.{kind}" for number in (8, 9, 10, 11, 12) for kind in ("png", "pdf")
    }
    assert len(read_areas(quick / "areas.csv")) == 2 * 3 * 5
    record = json.loads((quick / "record.json").read_text())
    assert record["settings"]["quick"] is True
    assert len(record["tasks"]) == N_TASKS
    assert record["mesh_hashes"]["circ_artery 50 coarse"] == meshes.fingerprint(meshes.site("circ_artery", 50))
    assert {"camring", "numpy", "shapely", "geos", "python"} <= set(record["versions"])
    assert record["wall_seconds"] > 0


def test_quick_run_says_what_came_out(quick):
    said = json.loads(quick.with_suffix(".json").read_text(encoding="utf-8"))
    written = {str(file) for file in quick.iterdir() if file.is_file() and not file.name.startswith(".")}
    assert set(said["files"]) == written
    assert said["tasks"] == {"done": N_TASKS, "failed": 0, "failures": []}
    assert (said["n_areas"], said["n_tables"], said["n_figures"]) == (30, 8, 5)
    of_circular = next(one for one in said["differences_from_published"] if one["what"] == "areas, circular sites")
    rows = [row for row in lines(quick / "table_A2.csv") if row["site"] == "circ_artery"]
    off = [100 * abs(float(row["difference"])) / float(row["published"]) for row in rows]
    assert of_circular["greatest_percent"] == pytest.approx(max(off))
    assert of_circular["mean_percent"] == pytest.approx(sum(off) / len(off))


def test_areas_are_those_of_the_evaluator(quick):
    found = {
        (a.site, a.fov_mm, a.top_surface_included, a.n_cameras): a.area_mm2 for a in read_areas(quick / "areas.csv")
    }
    for site, fov, size in (("circ_artery", "36x24", (36.0, 24.0)), ("elliptical", "60x60", (60.0, 60.0))):
        mesh, ring = meshes.site(site, 50), exact.Ring(fov=size)
        cameras = ring.cameras(ring.equidistant(6))
        assert found[site, fov, True, 6] == pytest.approx(exact.evaluate(mesh, cameras).area, rel=1e-9)
        without = exact.evaluate(mesh, cameras, exclude=meshes.top_surface(mesh)).area
        assert found[site, fov, False, 6] == pytest.approx(without, rel=1e-9)


def test_tables_set_ours_beside_the_published(quick):
    rows = lines(quick / "table_A2.csv")
    published = published_areas()
    assert len(rows) == 10
    for row in rows:
        assert float(row["published"]) == published[row["site"], 50, "36x24", False, int(row["n_cameras"])]
        assert float(row["difference"]) == pytest.approx(float(row["ours"]) - float(row["published"]))
    ours = {(row["site"], int(row["n_cameras"])): float(row["ours"]) for row in rows}
    steps = lines(quick / "table_5.csv")
    for row in steps:
        n, before = int(row["n_cameras"]), {4: 2, 6: 4, 8: 6, 16: 8}[int(row["n_cameras"])]
        step = ours[row["site"], n] - ours[row["site"], before]
        percent = 100 * step / ours[row["site"], before]
        assert float(row["ours"]) == pytest.approx(step if row["quantity"] == "increase" else percent)
    text = (quick / "table_A2.md").read_text(encoding="utf-8")
    assert f"| {ours['circ_artery', 4]:.2f} |" in text.replace("  ", " ").replace("  ", " ")
    assert r"\begin{tabular}" in (quick / "table_A2.tex").read_text(encoding="utf-8")


def test_figures_are_pictures(quick):
    for file in quick.glob("figure*.png"):
        picture = matplotlib.image.imread(file)[..., :3]
        assert min(picture.shape[:2]) > 400
        for edge in (picture[0], picture[-1], picture[:, 0], picture[:, -1]):
            assert edge.min() == 1.0, f"something is cut off in {file.name}"
    assert all(file.read_bytes().startswith(b"%PDF") for file in quick.glob("figure*.pdf"))


def test_report_only_draws_what_is_on_disk(quick, tmp_path, camring):
    out = tmp_path / "copy"
    shutil.copytree(quick, out, ignore=shutil.ignore_patterns("tasks", "figure*", "table*", "paper.md"))
    status, printed, _ = camring("paper", "--report-only", "--out", out)
    assert status == 0
    assert re.search(r"30 areas, 8 tables, 5 figures; read .*paper\.md", printed)
    assert not (out / "tasks").exists()
    assert tables(out) == tables(quick)
    assert (out / "paper.md").read_text() == (quick / "paper.md").read_text()


def test_a_killed_run_goes_on_and_redoes_nothing(quick, tmp_path):
    stop = random.SystemRandom().randint(1, N_TASKS - 1)
    run = subprocess.Popen([*QUICK, tmp_path], cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    wait_until(lambda: n_done(tmp_path) >= stop, run)
    run.send_signal(signal.SIGKILL)
    run.communicate()
    done = {file.name: file.stat().st_mtime_ns for file in (tmp_path / "tasks").glob("*.json")}
    assert not (tmp_path / "record.json").exists(), f"stopped too late, after {stop} tasks"
    subprocess.run([*QUICK, tmp_path], cwd=ROOT, check=True, capture_output=True)
    assert tables(tmp_path) == tables(quick), f"stopped after {stop} tasks"
    after = {file.name: file.stat().st_mtime_ns for file in (tmp_path / "tasks").glob("*.json")}
    assert len(after) == N_TASKS
    assert {name: after[name] for name in done} == done
    assert json.loads((tmp_path / "record.json").read_text())["tasks_found_done"] == len(done)


def test_a_cluster_that_loses_a_worker_gives_the_same(quick, tmp_path):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "cwd": ROOT}
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    dask = (sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", address, "--no-dashboard")
    worker = (sys.executable, "-m", "distributed.cli.dask_worker", address, "--no-nanny", "--nthreads", "1",
              "--no-dashboard", "--local-directory", str(tmp_path))  # fmt: skip
    processes = [subprocess.Popen(dask, **quiet)]
    try:
        processes += [subprocess.Popen(worker, env=environment, **quiet) for _ in range(2)]
        run = subprocess.Popen([*QUICK, tmp_path / "out", "--scheduler", address], **quiet)
        processes.append(run)
        wait_until(lambda: n_done(tmp_path / "out") >= 2, run)
        processes[1].send_signal(signal.SIGKILL)
        _, said = run.communicate(timeout=PATIENCE)
        assert run.returncode == 0, said.decode()
    finally:
        for process in processes:
            process.kill()
            process.communicate()
    assert tables(tmp_path / "out") == tables(quick)
    assert json.loads((tmp_path / "out" / "record.json").read_text())["pool"] == "Dask cluster"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--report-only"], r"holds no finished run; run `camring paper --out .*` first"),
        (["--report-only", "--quick"], r"--report-only draws what is on disk; leave out --quick"),
        (["--detail", "huge"], r"--detail is 'huge'; choose one of coarse, middle, fine"),
    ],
)
def test_refusals(arguments, message, tmp_path, camring):
    status, _, said = camring("paper", *arguments, "--out", tmp_path / "new")
    assert status == 2
    assert re.search(message, said)


def test_a_finished_run_is_not_replaced(quick, camring):
    status, _, said = camring("paper", "--quick", "--out", quick)
    assert status == 2
    assert re.search(r"already holds record\.json; .*--force", said)
