"""Public names are imported when they are first used, and hold whatever was imported before."""

import pickle
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

import exact
import placement

HEAVY = {"numpy", "scipy", "shapely", "trimesh", "jax", "meshes"}


def test_a_package_alone_imports_nothing_heavy():
    program = "import sys, exact, placement; print(*{name.partition('.')[0] for name in sys.modules})"
    packages = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True).stdout
    assert "placement" in packages.split()
    assert not HEAVY & set(packages.split())


@pytest.mark.parametrize("package", [exact, placement])
def test_each_public_name_is_there_although_modules_have_the_name_of_what_they_hold(package):
    modules = {file.stem for file in Path(str(package.__file__)).parent.glob("*.py")} - {"__init__"}
    for module in modules:
        import_module(f"{package.__name__}.{module}")
    shared = modules & set(package.__all__)
    assert shared  # or nothing would be tested
    for name in package.__all__:
        assert not isinstance(getattr(package, name), ModuleType), name
        assert name in dir(package)
    for name in shared:
        assert getattr(package, name) is getattr(import_module(f"{package.__name__}.{name}"), name)


def test_a_name_that_is_not_there_is_refused():
    with pytest.raises(AttributeError, match=r"module 'exact' has no attribute 'nothing'"):
        exact.nothing  # noqa: B018


def test_a_package_travels_to_other_processes_by_its_name():
    assert pickle.loads(pickle.dumps(placement)) is placement


def test_what_a_worker_process_imports_leaves_trimesh_out():
    """It takes longer to import than all that a worker needs."""
    program = "import sys, exact.workers, exact.evaluate, exact.view_sets; print('trimesh' in sys.modules)"
    assert (
        subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True).stdout == "False\n"
    )
