"""A page that is served, and a window on it."""

import json
import re
from contextlib import contextmanager

import pytest
import trimesh

from tests.experiments.design.served import SEPARATION, Looked, browsing, heard, is_known, served


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    """A wall on a plate: cameras to one side see that side of it."""
    path = tmp_path_factory.mktemp("design") / "<b>scán & wall.stl"
    parts = [trimesh.creation.box((30, 30, 2)), trimesh.creation.box((4, 30, 20))]
    trimesh.boolean.union(parts, engine="manifold").export(path)
    return path


@pytest.fixture(scope="module")
def rig(tmp_path_factory, quick_search):
    path = tmp_path_factory.mktemp("rig") / "rig.toml"
    path.write_text(quick_search + f"[constraints]\nmin_separation = {SEPARATION}\n", encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def chromium():
    with browsing() as browser:
        yield browser


@pytest.fixture(scope="module")
def running(tmp_path_factory, scan, rig):
    with served(tmp_path_factory.mktemp("served"), scan, "--rig", rig, "--cameras", 3) as server:
        yield server


@pytest.fixture
def server(running):
    """One that shows the layout that it began with, whatever others have tried."""
    with running.socket() as live:
        live.send(json.dumps({"do": "go", "number": 1}))
        heard(live, "state", lambda message: message["at"] == 1 and is_known(message))
    return running


@contextmanager
def looking(chromium, server):
    looked = Looked(chromium, server.address)
    yield looked
    looked.page.close()
    assert looked.faults == []
    asked = {re.match(r"\w+://[^/]+/[^/]+/", url)[0].replace("ws:", "http:") for url in looked.requests}
    assert asked == {server.address}


@pytest.fixture
def window(chromium, server):
    with looking(chromium, server) as looked:
        yield looked


@pytest.fixture
def fresh_window(tmp_path, chromium, scan, rig):
    """A window on which nothing was tried yet."""
    with served(tmp_path, scan, "--rig", rig, "--cameras", 3) as server, looking(chromium, server) as looked:
        yield looked
