"""Every command and snippet of the README and of the pages in docs runs, and every link leads somewhere."""

import re
import shlex
import tomllib
from pathlib import Path

import pytest
import trimesh
import typer

from experiments.cli.app import app
from tests.support import ROOT

# Written by a build of the documentation, from what is tested elsewhere.
GENERATED = {"docs/commands.md", "docs/rig_file.md"}
PAGES = sorted(
    page
    for page in ("README.md", "CONTRIBUTING.md", *(str(file.relative_to(ROOT)) for file in ROOT.glob("docs/**/*.md")))
    if page not in GENERATED
)
# Its commands write what its own tests look at: tests/experiments/exports/test_page.py.
ELSEWHERE = {"docs/exports.md"}
# Take minutes, or a cluster, or until somebody stops them: the parser is asked whether it knows them. Their parts are
# tested elsewhere.
SLOW = ("camring design", "camring bench", "camring paper", "camring simulate", "camring study",
        "camring site --gallery", "camring optimise circ_artery", "camring count circ_artery",
        "camring ring circ_artery")  # fmt: skip


def text(page: str) -> str:
    return (ROOT / page).read_text(encoding="utf-8")


def blocks(page: str) -> list[tuple[str, str]]:
    """Language and text of each block that runs, in order."""
    return re.findall(r"^```(python|sh|toml)\n(.*?)^```", text(page), flags=re.S | re.M)


WITH_BLOCKS = [page for page in PAGES if blocks(page) and page not in ELSEWHERE]


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """An empty folder with a file scan.stl, and a list of faces, which the pages take for granted."""
    parts = [trimesh.creation.box((30, 30, 2)), trimesh.creation.box((4, 30, 20))]
    trimesh.boolean.union(parts, engine="manifold").export(tmp_path / "scan.stl")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def quick(rig: str, quick_search: str) -> str:
    """A rig file with its search made short."""
    short = tomllib.loads(quick_search)["search"]
    known = "\n".join(line for line in rig.splitlines() if line.split(" = ")[0] not in short)
    return known.replace("[search]", quick_search) if "[search]" in known else known + quick_search


def run_command(line: str, desk: Path, camring, quick_search: str) -> None:
    arguments = shlex.split(line, comments=True)[1:]
    if line.startswith(SLOW):
        known = typer.main.get_command(app).commands[arguments[0]]
        known.make_context(arguments[0], arguments[1:])
        return
    if arguments[0] in ("optimise", "count", "tradeoff", "ring"):
        if "--rig" not in arguments:
            (desk / "quick.toml").write_text(quick_search, encoding="utf-8")
            arguments += ["--rig", "quick.toml"]
        else:
            rig = desk / arguments[arguments.index("--rig") + 1]
            rig.write_text(quick(rig.read_text(encoding="utf-8"), quick_search), encoding="utf-8")
    status, _, said = camring(*arguments)
    # A count may end below its target when its search is short.
    assert status == 0 or (status == 1 and arguments[0] == "count"), (line, said)


def test_there_is_something_to_test():
    assert {"README.md", "docs/start.md", "docs/how-to/own_ring.md"} <= set(WITH_BLOCKS)
    assert all((ROOT / page).exists() for page in ELSEWHERE)
    for target in re.findall(r"\bmake (\w+)`|^make (\w+)$", text("README.md"), flags=re.M):
        assert re.search(rf"^{''.join(target)}:", text("Makefile"), flags=re.M)


@pytest.mark.parametrize("page", WITH_BLOCKS)
def test_page(page, desk, camring, quick_search):
    for number, (language, code) in enumerate(blocks(page)):
        if language == "python":
            exec(compile(code, f"{page}, block {number}", "exec"), {})
        elif language == "toml":
            (desk / "rig.toml").write_text(code, encoding="utf-8")
        else:
            for line in code.splitlines():
                assert line.startswith("camring "), f"{page}: only commands of camring are tested, not {line!r}"
                run_command(line, desk, camring, quick_search)


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page):
    for link in re.findall(r"\]\((?!https?:)([^)\s]+)\)", text(page)):
        file, _, heading = link.partition("#")
        target = (ROOT / page).parent / file if file else ROOT / page
        known = {str((ROOT / name).resolve()) for name in GENERATED}
        assert target.exists() or str(target.resolve()) in known, link
        if heading:
            names = re.findall(r"^#+ (.+)$", target.read_text(encoding="utf-8"), flags=re.M)
            assert heading in {re.sub(r"[^\w\- ]", "", name.lower()).replace(" ", "-") for name in names}, link
