"""Every command and snippet of the README runs."""

import re
import shlex
from pathlib import Path

import pytest
import trimesh

from experiments.cli import main

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
SNIPPETS = re.findall(r"```python\n(.*?)```", README, flags=re.S)
COMMANDS = [
    line
    for block in re.findall(r"```sh\n(.*?)```", README, flags=re.S)
    for line in block.splitlines()
    if line.startswith("camring")
]
# Long: their parts are tested elsewhere, and the command is known to the parser.
SLOW = ("camring bench", "camring paper", "camring site --gallery", "camring count", "camring optimise circ_artery")


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """An empty folder with a file scan.stl, which the README takes for granted."""
    step = trimesh.boolean.union(
        [trimesh.creation.box((30, 30, 2)), trimesh.creation.box((4, 30, 20))], engine="manifold"
    )
    step.export(tmp_path / "scan.stl")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_there_is_something_to_test():
    assert len(SNIPPETS) >= 1
    assert len(COMMANDS) >= 6
    for target in re.findall(r"^make (\w+)", README, flags=re.M):
        assert re.search(rf"^{target}:", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.M)


@pytest.mark.parametrize("number", range(len(SNIPPETS)))
def test_snippet(desk, number):
    exec(compile(SNIPPETS[number], f"README snippet {number}", "exec"), {})


def test_commands(desk, capsys, quick_search):
    (desk / "quick.toml").write_text(quick_search, encoding="utf-8")
    for command in COMMANDS:
        arguments = shlex.split(command, comments=True)[1:]
        if command.startswith(SLOW):
            arguments = [arguments[0], "--help"]
        elif arguments[0] == "optimise" and "--rig" not in arguments:
            arguments += ["--rig", "quick.toml"]
        with pytest.raises(SystemExit) as end:
            main(arguments)
        assert not end.value.code, (command, capsys.readouterr().err)


@pytest.mark.parametrize("link", re.findall(r"\]\(((?!http)[^)#]+)\)", README))
def test_links_lead_somewhere(link):
    assert (ROOT / link).exists()
