"""Every command and snippet of docs/exports.md runs, and what they write is what the page says."""

import os
import re
import shlex
from pathlib import Path

import pytest
import trimesh

from experiments.cli import app as cli
from experiments.cli import options
from experiments.exports import coverage_mesh
from experiments.exports.formats import FORMATS
from tests.support import ROOT

PAGE = (ROOT / "docs" / "exports.md").read_text(encoding="utf-8")
SNIPPETS = re.findall(r"```python\n(.*?)```", PAGE, flags=re.S)
COMMANDS = [line for block in re.findall(r"```sh\n(.*?)```", PAGE, flags=re.S) for line in block.splitlines()]


@pytest.fixture(scope="module")
def desk(tmp_path_factory, quick_search):
    """A folder with a file scan.stl, which the page takes for granted, and all that its commands write."""
    folder, before = tmp_path_factory.mktemp("desk"), Path.cwd()
    parts = [trimesh.creation.box((30, 30, 2)), trimesh.creation.box((4, 30, 20))]
    trimesh.boolean.union(parts, engine="manifold").export(folder / "scan.stl")
    (folder / "rig.toml").write_text(quick_search, encoding="utf-8")
    os.chdir(folder)
    try:
        for command in COMMANDS:
            arguments = shlex.split(command)[1:]
            # The search takes most of the time, and no export shows how good it is.
            arguments += ["--rig", "rig.toml"] if arguments[0] == "optimise" else []
            with pytest.raises(SystemExit) as end:
                cli.main(arguments)
            assert not end.value.code, command
    finally:
        os.chdir(before)
    return folder


@pytest.mark.parametrize("number", range(len(SNIPPETS)))
def test_snippet(desk, monkeypatch, capsys, number):
    monkeypatch.chdir(desk)
    exec(compile(SNIPPETS[number], f"docs/exports.md, snippet {number}", "exec"), {})
    assert capsys.readouterr().out.count("\n") >= 2  # each prints a line per camera or per number of views


def test_optimise_writes_what_export_and_evaluate_write(desk):
    exported = {name for chosen in FORMATS.values() for name in chosen.files}
    assert {str(file.relative_to(desk / "out")) for file in (desk / "out").rglob("*") if file.is_file()} == {
        "layout.json", "layouts.csv", "coverage.png", *exported, *coverage_mesh.FILES,
    }  # fmt: skip
    same = "site_and_cameras.glb"
    assert (desk / "out" / same).read_bytes() == (desk / "blender" / same).read_bytes()
    for name in coverage_mesh.FILES:
        assert (desk / "out" / name).read_bytes() == (desk / "areas" / name).read_bytes()
    assert "PINHOLE 1920 1280" in (desk / "small" / "colmap" / "cameras.txt").read_text(encoding="utf-8")


def test_the_page_names_every_format_and_file():
    rows = re.findall(r"^\| `(\w+)`.*?\| (.*?) \|", PAGE, flags=re.M)
    assert [name for name, _ in rows] == [*FORMATS, "mesh"]
    for name, files in rows[:-1]:
        for file in FORMATS[name].files:
            assert Path(file).name in files
    assert tuple(FORMATS) == options.FORMATS
