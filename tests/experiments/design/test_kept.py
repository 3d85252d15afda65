"""What was tried is kept: after a kill, after an end, and by nobody else."""

import json
import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.experiments.design.served import heard, is_known, served


@pytest.fixture
def plate(tmp_path):
    trimesh.creation.box((20, 20, 2)).export(tmp_path / "plate.stl")
    return tmp_path / "plate.stl"


def children(pid):
    """Processes that a process has started."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if int((folder / "stat").read_text().rpartition(")")[2].split()[1]) == pid:
                found.append(int(folder.name))
        except (FileNotFoundError, ProcessLookupError):
            pass
    return found


def alive(pid):
    try:
        return (Path("/proc") / str(pid) / "stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def tried(live, number):
    """The history once a layout of that number is in it, with its numbers."""
    return heard(live, "history", lambda one: any(t["number"] == number and t["area"] for t in one["tried"]))


def test_killed_in_the_middle_it_is_all_there_again(tmp_path, plate):
    with served(tmp_path, plate, "--cameras", 3) as server:
        with server.socket() as live:
            heard(live, "state", is_known)
            for message in (
                {"do": "drag", "camera": 0, "angle": 1.0}, {"do": "drop"}, {"do": "add", "place": None},
                {"do": "fix", "camera": 1, "fixed": True}, {"do": "undo"}, {"do": "optimise"},
            ):  # fmt: skip
                live.send(json.dumps(message))
            before = tried(live, 3)
            assert [one["why"] for one in before["tried"]][1:] == ["camera 1 moved", "camera 4 added", "camera 2 fixed"]
            heard(live, "job", lambda one: one["job"] is not None and one["job"]["stage"] != "starting")
            # What the hand holds is not tried yet.
            live.send(json.dumps({"do": "drag", "camera": 0, "angle": 2.9}))
            heard(live, "state", lambda one: one["held"])
            workers = children(server.process.pid)
            assert len(workers) >= 2
            time.sleep(0.3)
            os.kill(server.process.pid, signal.SIGKILL)
            server.process.wait()
        end = time.monotonic() + 10
        while any(map(alive, workers)) and time.monotonic() < end:
            time.sleep(0.1)
        assert not any(map(alive, workers))
    with served(tmp_path, plate) as server, server.socket() as live:
        after = tried(live, 3)
        assert after == before
        live.send(json.dumps({"do": "redo"}))
        state = heard(live, "state", lambda one: one["at"] == 4)
        assert state["fixed"] == [False, True, False, False]
        status, said = server.end()
        assert status == 143
        assert "restored 4 layouts tried before" in said
        assert "Traceback" not in said and "Warning" not in said


def test_what_is_asked_for_goes_before_what_was_kept(tmp_path, plate):
    with served(tmp_path, plate, "--cameras", 3) as server:
        assert server.end()[0] == 143
    with served(tmp_path, plate, "--cameras", 5) as server, server.socket() as live:
        state = heard(live, "state", is_known)
        assert len(state["angles"]) == 5 and state["at"] == 2
    with served(tmp_path, plate, "--fresh") as server, server.socket() as live:
        state = heard(live, "state", is_known)
        assert len(state["angles"]) == 4 and state["at"] == 1


def test_it_begins_with_a_layout(tmp_path, plate, camring):
    content = {
        "format": "camring layout", "version": 1, "angles_deg": [10, 100, 200, 300],
        "ring": {"diameter_mm": 25, "working_distance_mm": 300, "fov_mm": [30, 20]},
        "constraints": {"min_separation": 4.0, "fixed": [float(np.radians(100))]},
    }  # fmt: skip
    path = tmp_path / "made.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    with served(tmp_path, plate, "--layout", path, "--threshold", 3, "--json") as server, server.socket() as live:
        state = heard(live, "state", is_known)
        assert np.degrees(state["angles"]) == pytest.approx([10, 100, 200, 300])
        assert state["fixed"] == [False, True, False, False]
        names = ("diameter", "working_distance", "fov_height", "threshold", "min_separation")
        assert [state["settings"][name] for name in names] == [25, 300, 20, 3, 4]
        assert state["words"] == "seen by at least 3 cameras"
    for more in (("--min-separation", 3), ("--cameras", 4), ("--diameter", 20)):
        status, _, said = camring("design", plate, "--layout", path, *more, "--no-browser")
        assert status == 2 and f"leave {more[0]} out" in said


def test_two_runs_do_not_write_into_one_session(tmp_path, plate, camring, monkeypatch):
    with served(tmp_path, plate, "--cameras", 3):
        monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
        status, _, said = camring("design", plate, "--no-browser")
        assert status == 2 and "another run of camring is writing into" in said


def test_a_damaged_session_is_refused_and_not_touched(tmp_path, plate, camring, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    with served(tmp_path, plate) as server:
        server.end()
    (path,) = tmp_path.glob("camring/designs/*/session.json")
    whole = json.loads(path.read_text(encoding="utf-8"))
    wrong = [whole | {"at": 7}, whole | {"version": 2}, whole | {"tried": [{}]}]
    for damaged in ("{", "[]", *map(json.dumps, wrong)):
        path.write_text(damaged, encoding="utf-8")
        status, _, said = camring("design", plate, "--no-browser")
        assert status == 2 and "is damaged" in said and "--fresh" in said
        assert path.read_text(encoding="utf-8") == damaged


def test_without_the_extra_it_says_which(plate, camring, monkeypatch):
    import importlib.util

    found = importlib.util.find_spec
    monkeypatch.setattr("experiments.cli.extras.find_spec", lambda name: None if name == "uvicorn" else found(name))
    status, _, said = camring("design", plate, "--no-browser")
    assert status == 2
    words = "camring design needs uvicorn, which is not installed; pip install 'camring[design]'"
    assert words in " ".join(said.split())


def test_a_port_that_is_taken(tmp_path, plate, camring, monkeypatch):
    with served(tmp_path, plate) as server:
        monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "other"))
        status, _, said = camring("design", plate, "--no-browser", "--port", server.parts.port)
        assert status == 2 and f"--port {server.parts.port} cannot be used" in said
