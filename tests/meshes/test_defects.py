"""No defect of a mesh gives a wrong area without a word: it is right, or warned of, or refused."""

import os

import pytest
import trimesh

import exact
import meshes
from experiments.files.errors import InputError
from experiments.request.request import request
from experiments.request.rig import rig
from tests.meshes.defects import cases

# Of each defect in each shape; 10 make 210 cases, which take minutes.
EACH = int(os.environ.get("CAMRING_DEFECTS", "2"))
CASES = dict(cases(EACH))
RING = exact.Ring()
CAMERAS = RING.cameras(RING.equidistant(2))


def area(mesh: trimesh.Trimesh) -> float:
    return exact.evaluate(mesh, CAMERAS).area


def asked(path, **options):
    """Area and warnings, as the command line would have them; None for what is refused."""
    try:
        about = request([str(path)], None, None, rig(**options)).subjects[0]
    except (meshes.MeshError, InputError) as error:
        assert str(path) in str(error)
        return None, ()
    return area(about.mesh), about.warnings


@pytest.mark.parametrize("name", CASES)
def test_defect(tmp_path, name):
    defect = CASES[name]
    path = tmp_path / "scan.ply"
    path.write_bytes(defect.broken.export(file_type="ply", encoding="binary"))
    defect.right.export(tmp_path / "right.ply")
    right = area(meshes.load(tmp_path / "right.ply"))
    for repair in (False, True):
        found, warnings = asked(path, repair=repair)
        assert found is None or warnings or found == pytest.approx(right, rel=1e-6), (repair, found, right)
    both, _ = asked(path, two_sided=True)
    assert both == pytest.approx(area(meshes.load(tmp_path / "right.ply", two_sided=True)), rel=1e-6)


def test_there_are_many():
    assert len(CASES) == 21 * EACH
