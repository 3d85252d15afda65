"""Without any extra, every kind of mesh file is read, or refused in the same words, and the first commands work."""

import json
import subprocess
import sys

import pytest

import meshes
from tests.meshes.file_variants import VARIANTS
from tests.support import ROOT
from tests.support.files import part

SCRIPT = ROOT / "tests" / "whole" / "base_installation.py"


def test_files_are_read_without_extras(tmp_path):
    folder = tmp_path / "files"
    folder.mkdir()
    paths = {}
    for number, variant in enumerate(VARIANTS.values()):
        path = folder / f"{number:03d}_{variant.name}"
        path.write_bytes(variant.content)
        paths[path.name] = (path, variant)
    mesh, out = str(part(tmp_path)), str(tmp_path / "out")
    commands = [
        ["check", mesh, "--out", str(tmp_path / "check.png")],
        ["evaluate", mesh, "--cameras", "2", "--place", "auto", "--out", out, "--images", out],
    ]
    ran = subprocess.run(
        [sys.executable, "-W", "ignore", str(SCRIPT), str(folder), json.dumps(commands)],
        capture_output=True, text=True, cwd=ROOT, timeout=300, check=False,
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    found = json.loads(ran.stdout.splitlines()[-1])
    # What only tests need is really out of reach, and what is declared is not.
    assert {"pytest", "hypothesis", "plyfile", "cv2"} <= set(found["refused"])
    assert not {"numpy", "trimesh", "scipy", "matplotlib"} & set(found["refused"])
    assert found["statuses"] == [0, 0] and set(found["found"]) == set(paths)
    for name, (path, variant) in paths.items():
        got = found["found"][name]
        if variant.refused is None:
            assert got == pytest.approx(variant.area, rel=1e-6), name
        else:
            with pytest.raises(meshes.MeshError) as caught:
                meshes.load(path)
            assert got == str(caught.value), name
