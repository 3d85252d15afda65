"""The documentation builds without a warning, loads nothing from a network, and leaves out nothing public."""

import json
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

import exact
import meshes
import placement
from tests.support import ROOT

TUTORIAL = ROOT / "docs" / "tutorial.ipynb"
LARGEST_TUTORIAL = 500_000  # bytes, with its pictures: it is kept in the history
# What a browser fetches by itself, element by element. A link that the reader may follow is not among them.
FETCHED = {"script": "src", "link": "href", "img": "src", "iframe": "src", "source": "src", "use": "href"}


class Page(HTMLParser):
    """What one page loads, and where it leads."""

    def __init__(self, file: Path):
        super().__init__()
        self.loaded: list[str] = []
        self.links: list[str] = []
        self.formulas = 0
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        if tag in FETCHED and given.get(FETCHED[tag]):
            self.loaded.append(given[FETCHED[tag]])
        if tag == "a" and given.get("href"):
            self.links.append(given["href"])
        self.formulas += tag == "math"


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The built pages; a warning would have stopped the build."""
    out = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "-d", str(out / "doctrees")]
    built = subprocess.run([*command, str(ROOT / "docs"), str(out / "html")], capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    return {file: Page(file) for file in sorted((out / "html").rglob("*.html"))}, out / "html"


def test_nothing_is_loaded_from_a_network(site):
    pages, folder = site
    for file, page in pages.items():
        for address in page.loaded:
            parts = urlsplit(address)
            assert parts.scheme in ("", "data") and not parts.netloc, (file.name, address)
            if not parts.scheme and parts.path:
                assert (file.parent / unquote(parts.path)).exists(), (file.name, address)
    for sheet in folder.rglob("*.css"):
        assert not re.search(r"(url\(|@import)\s*['\"]?(https?:)?//", sheet.read_text(encoding="utf-8")), sheet.name


def test_links_between_pages_lead_somewhere(site):
    pages, _ = site
    for file, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if not parts.scheme and parts.path:
                assert (file.parent / unquote(parts.path)).exists(), (file.name, link)


def test_formulas_are_there_without_a_program_to_set_them(site):
    pages, folder = site
    assert pages[folder / "mathematics.html"].formulas > 20
    assert "$$" not in (folder / "mathematics.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("package", [meshes, exact, placement])
def test_every_public_name_is_in_the_reference(site, package):
    _, folder = site
    page = (folder / "reference" / f"{package.__name__}.html").read_text(encoding="utf-8")
    for name in package.__all__:
        assert f'id="{package.__name__}.{name}"' in page, name


def test_commands_and_settings_are_those_of_the_program(site):
    _, folder = site
    commands = (folder / "commands.html").read_text(encoding="utf-8")
    for words in ('id="camring-optimise"', 'id="camring-rig-init"', "--forbidden-deg"):
        assert words in commands
    assert "min_separation" in (folder / "rig_file.html").read_text(encoding="utf-8")


def test_tutorial_runs_as_it_is_stored(tmp_path):
    stored = json.loads(TUTORIAL.read_text(encoding="utf-8"))
    assert TUTORIAL.stat().st_size < LARGEST_TUTORIAL
    command = [sys.executable, "-m", "jupyter", "execute", f"--output={tmp_path / 'again.ipynb'}", str(TUTORIAL)]
    run = subprocess.run(command, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    again = json.loads((tmp_path / "again.ipynb").read_text(encoding="utf-8"))
    for then, now in zip(stored["cells"], again["cells"], strict=True):
        assert [output["output_type"] for output in then.get("outputs", ())] == [
            output["output_type"] for output in now.get("outputs", ())
        ]
