"""Sweeps: every task is done once, on disk at once, and whatever happens to one, the others go on."""

import json
import os
import signal
import threading
import time
from pathlib import Path

import pytest

from experiments.files.errors import InputError
from experiments.sweeps.pool import LocalPool
from experiments.sweeps.sweep import ATTEMPTS, on_disk, pool_for, sweep
from experiments.sweeps.task import Outcome, Task, perform


def square(number):
    return {"square": number * number}


def note(number, log):
    """Leave a trace of every call."""
    with Path(log).open("a") as file:
        file.write(f"{number}\n")
    return square(number)


def refuse(number):
    raise ValueError(f"{number} is odd")


def die(flag=None):
    """End the process it runs in: always, or until the file `flag` is there."""
    if flag is not None and Path(flag).exists():
        return {"lived": True}
    if flag is not None:
        Path(flag).touch()
    os.kill(os.getpid(), signal.SIGKILL)


def linger(folder, seconds):
    (Path(folder) / f"{os.getpid()}").touch()
    time.sleep(seconds)
    return {}


def task(function, packages=("meshes",), cost=1.0, **inputs):
    return Task(function, inputs, cost, packages)


@pytest.fixture(scope="module")
def pool():
    opened = LocalPool(2)
    yield opened
    opened.close(at_once=True)


def test_outcomes_come_in_the_order_of_the_tasks(pool, tmp_path):
    tasks = [task(square, number=n, cost=c) for n, c in ((1, 0.1), (2, 9.0), (3, 1.0), (2, 1.0))]
    seen = []
    outcomes = sweep(tasks, tmp_path, pool, lambda done, outcome: seen.append(done.inputs["number"]))
    assert [outcome.result for outcome in outcomes] == [{"square": n * n} for n in (1, 2, 3, 2)]
    assert sorted(seen) == [1, 2, 3]  # equal tasks are one task
    assert all(outcome.failure == "" and outcome.seconds >= 0 for outcome in outcomes)


def test_a_second_run_does_only_what_is_missing(pool, tmp_path):
    log = tmp_path / "log"
    folder = tmp_path / "tasks"
    first = sweep([task(note, number=n, log=str(log)) for n in (1, 2)], folder, pool)
    again = sweep([task(note, number=n, log=str(log)) for n in (1, 2, 3)], folder, pool)
    assert again[:2] == first
    assert sorted(log.read_text().split()) == ["1", "2", "3"]


def test_every_task_is_on_disk_when_it_is_reported(pool, tmp_path):
    counts = []
    tasks = [task(square, number=n) for n in range(5)]
    sweep(tasks, tmp_path, pool, lambda done, outcome: counts.append(len(on_disk(tasks, tmp_path))))
    assert counts == [1, 2, 3, 4, 5]
    content = json.loads((tmp_path / f"{tasks[3].name}.json").read_text())
    assert content["task"]["inputs"] == {"number": 3}
    assert content["result"] == {"square": 9}


def test_a_failed_task_has_its_reason_and_is_tried_again_in_the_next_run(pool, tmp_path):
    tasks = [task(refuse, number=3), task(square, number=4)]
    for _ in range(2):
        failed, done = sweep(tasks, tmp_path, pool)
        assert failed == Outcome(None, "ValueError: 3 is odd", failed.seconds)
        assert done.result == {"square": 16}
        assert set(on_disk(tasks, tmp_path)) == {tasks[1].name}


def test_a_task_whose_worker_dies_is_tried_again(pool, tmp_path):
    tasks = [task(square, number=n) for n in range(6)]
    tasks.insert(2, task(die, flag=str(tmp_path / "died")))
    outcomes = sweep(tasks, tmp_path / "tasks", pool)
    assert outcomes.pop(2).result == {"lived": True}
    assert [outcome.result["square"] for outcome in outcomes] == [n * n for n in range(6)]


def test_a_task_that_always_ends_its_worker_is_given_up_and_takes_no_other_with_it(pool, tmp_path):
    tasks = [task(die, cost=2.0), *(task(square, number=n) for n in range(4))]
    first, *others = sweep(tasks, tmp_path, pool)
    assert first.failure == f"its worker died, {ATTEMPTS} times in a row"
    assert [outcome.result["square"] for outcome in others] == [0, 1, 4, 9]


def test_a_worker_killed_from_outside_costs_nothing(pool, tmp_path):
    tasks = [task(linger, folder=str(tmp_path), seconds=0.2 + 0.001 * n) for n in range(4)]
    killed = []

    def kill():
        while not (workers := [file.name for file in tmp_path.iterdir() if file.name.isdigit()]):
            time.sleep(0.01)
        os.kill(int(workers[0]), signal.SIGKILL)
        killed.append(workers[0])

    thread = threading.Thread(target=kill)
    thread.start()
    outcomes = sweep(tasks, tmp_path / "tasks", pool)
    thread.join()
    assert killed
    assert all(outcome.result == {} for outcome in outcomes)


def test_the_name_tells_inputs_and_functions_apart():
    names = {
        task(square, number=1).name,
        task(square, number=2).name,
        task(refuse, number=1).name,
        task(square, number=1, packages=("meshes", "exact")).name,
    }
    assert len(names) == 4
    assert task(square, number=1).name == task(square, number=1, cost=7.0).name


def test_a_worker_with_other_sources_refuses():
    outcome = perform(task(square, number=2), sources="of another day")
    assert outcome.result is None
    assert "runs another camring" in outcome.failure


def test_inputs_that_json_cannot_hold_are_no_task():
    with pytest.raises(ValueError, match="not JSON compliant"):
        _ = task(square, number=float("nan")).name


def test_without_a_scheduler_or_without_dask(monkeypatch):
    monkeypatch.setattr("experiments.sweeps.pool.PATIENCE", 0.5)
    with pytest.raises(InputError, match=r"no Dask scheduler answers at tcp://127\.0\.0\.1:9; start one"):
        pool_for("tcp://127.0.0.1:9")
    with pytest.raises(InputError, match=r"no Dask scheduler answers at nowhere://1"):
        pool_for("nowhere://1")
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(InputError, match=r"--scheduler needs Dask.*camring\[cluster\]"):
        pool_for("tcp://127.0.0.1:9")
