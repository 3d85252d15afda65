"""The packages import each other one way only: meshes <- exact <- placement <- experiments."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
ALLOWED = {
    "meshes": set(),
    "exact": {"meshes"},
    "placement": {"meshes", "exact"},
    "experiments": {"meshes", "exact", "placement"},
}
# jax is heavy and float32 by default: the ground truth must not depend on it.
FORBIDDEN = {"meshes": {"jax", "equinox", "optimistix"}, "exact": {"jax", "equinox", "optimistix"}}


def imported_roots(source: str) -> set[str]:
    """Top-level names of every absolute import in `source`, also those inside functions."""
    roots = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            roots |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            roots.add(node.module.split(".")[0])
    return roots


@pytest.mark.parametrize("package", ALLOWED)
def test_import_direction(package):
    files = sorted((ROOT / package).rglob("*.py"))
    assert files, f"package {package} has no sources"
    for file in files:
        roots = imported_roots(file.read_text(encoding="utf-8"))
        wrong = (roots & set(ALLOWED)) - ALLOWED[package] - {package}
        assert not wrong, f"{file.relative_to(ROOT)} imports {wrong}"
        assert not roots & FORBIDDEN.get(package, set()), f"{file.relative_to(ROOT)} imports jax"


def test_the_check_sees_imports_inside_functions():
    assert imported_roots("def f():\n    import jax.numpy as jnp\n    from placement import x") == {
        "jax",
        "placement",
    }
