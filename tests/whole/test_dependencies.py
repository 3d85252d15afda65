"""The pinned releases are those that pyproject.toml allows; and all libraries at work together, the oldest ones too."""

import json
import re
import tomllib

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

import exact
from tests.support import ROOT
from tests.support.files import box, part

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]


def pinned(name):
    """Releases by package, as `make lock` wrote them: several where they depend on Python or the system."""
    found = {}
    for line in (ROOT / name).read_text(encoding="utf-8").splitlines():
        if line and not line.lstrip().startswith("#"):
            needed = Requirement(line)  # which knows no index and no option, so that none is in the file
            (exactly,) = needed.specifier
            assert exactly.operator == "=="
            found.setdefault(canonicalize_name(needed.name), []).append(Version(exactly.version))
    return found


def asked(*groups):
    needed = [Requirement(line) for group in groups for line in group]
    return {canonicalize_name(one.name): one.specifier for one in needed if one.name != PROJECT["name"]}


def test_newest_releases_are_allowed():
    found = pinned("requirements.lock")
    for name, allowed in asked(PROJECT["dependencies"], *EXTRAS.values()).items():
        assert all(version in allowed for version in found[name]), name


def test_oldest_releases_are_the_lower_bounds():
    found = pinned("requirements-oldest.lock")
    for name, allowed in asked(PROJECT["dependencies"], EXTRAS["cluster"]).items():
        bounds = [Version(one.version) for one in allowed if one.operator == ">="]
        assert found[name] == bounds, f"{name}: renew with `make lock`"


def test_all_libraries_work_together(camring, tmp_path, quick_search):
    (tmp_path / "rig.toml").write_text("[cameras]\ncount = 3\n" + quick_search, encoding="utf-8")
    mesh, out = part(tmp_path), tmp_path / "out"
    options = ("--rig", tmp_path / "rig.toml", "--certify", "--report", "--export", "mesh")
    status, printed, err = camring("optimise", mesh, *options, "--out", out)
    assert status == 0, err
    assert "no layout with cameras at multiples of 5 degrees" in " ".join(printed.split())
    written = {path.name for path in out.iterdir()}
    assert {"layout.json", "layouts.csv", "coverage.png", "report.html", "coverage.glb", "coverage.ply"} <= written
    layout = json.loads((out / "layout.json").read_text(encoding="utf-8"))
    cameras = exact.Ring().cameras(layout["angles_rad"])
    assert exact.evaluate(box(), cameras).area == pytest.approx(layout["areas_mm2"]["optimised"], rel=1e-12)
    assert re.search(r"<svg|plotly", (out / "report.html").read_text(encoding="utf-8"))
