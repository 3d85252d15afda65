"""A page that is served, and a window on it."""

import re

import pytest
import trimesh

from tests.experiments.design.served import SEPARATION, Looked, browsing, served


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


@pytest.fixture
def server(tmp_path, scan, rig):
    with served(tmp_path, scan, "--rig", rig, "--cameras", 3) as running:
        yield running


@pytest.fixture
def window(chromium, server):
    looked = Looked(chromium, server.address)
    yield looked
    looked.page.close()
    assert looked.faults == []
    asked = {re.match(r"\w+://[^/]+/[^/]+/", url)[0].replace("ws:", "http:") for url in looked.requests}
    assert asked == {server.address}
