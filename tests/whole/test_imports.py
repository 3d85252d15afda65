"""Imports go one way: meshes <- exact <- placement <- experiments, from room to room, and from file to file."""

import ast
from collections.abc import Iterable
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from tests.support import ROOT

ALLOWED = {
    "meshes": set(),
    "exact": {"meshes"},
    "placement": {"meshes", "exact"},
    "experiments": {"meshes", "exact", "placement"},
}
# jax is heavy and float32 by default: the ground truth must not depend on it.
FORBIDDEN = {"meshes": {"jax", "equinox", "optimistix"}, "exact": {"jax", "equinox", "optimistix"}}
# Each room may import those before it.
ROOMS = {
    "experiments": (
        "files", "terminal", "request", "layouts", "sweeps", "tables", "figures", "exports", "simulate", "paper",
        "study", "report", "rings", "design", "bench", "cli",
    ),
}  # fmt: skip
# More than a reader takes in at a glance.
MOST_FILES, MOST_LINES = 16, 400


def imported(source: str) -> set[str]:
    """Every absolute import in `source`, also those inside functions, but not those for type checkers alone."""
    names = set()

    def visit(node: ast.AST) -> None:
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            return
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
        for child in ast.iter_child_nodes(node):
            visit(child)

    visit(ast.parse(source))
    return names


def modules(packages: Iterable[str]) -> dict[str, Path]:
    """All modules of the packages by their dotted names."""
    found = {}
    for package in packages:
        files = sorted((ROOT / package).rglob("*.py"))
        assert files, f"package {package} has no sources"
        for file in files:
            found[".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")] = file
    return found


MODULES = modules(ALLOWED)


def imports_of(module: str) -> set[str]:
    """The modules of ours that a module imports."""
    names = imported(MODULES[module].read_text(encoding="utf-8"))
    return {name if name in MODULES else name.rpartition(".")[0] for name in names} & set(MODULES)


@pytest.mark.parametrize("package", ALLOWED)
def test_packages_import_one_way(package):
    for module, file in MODULES.items():
        if module.split(".")[0] != package:
            continue
        roots = {name.split(".")[0] for name in imported(file.read_text(encoding="utf-8"))}
        wrong = (roots & set(ALLOWED)) - ALLOWED[package] - {package}
        assert not wrong, f"{module} imports {wrong}"
        assert not roots & FORBIDDEN.get(package, set()), f"{module} imports jax"


@pytest.mark.parametrize("package", ROOMS)
def test_rooms_import_one_way(package):
    rooms = ROOMS[package]
    assert {path.parent.name for path in (ROOT / package).glob("*/__init__.py")} == set(rooms)
    for module in MODULES:
        own = module.split(".")[1:2]
        if module.split(".")[0] != package or own not in [[room] for room in rooms]:
            continue
        for name in imports_of(module):
            other = name.split(".")[1] if name.startswith(f"{package}.") else None
            if other in rooms:
                assert rooms.index(other) <= rooms.index(own[0]), f"{module} imports {name}, which is a later room"


def test_no_circles_between_files():
    # A package's __init__ collects what its files hold, and is no part of any of them.
    files = {module for module, file in MODULES.items() if file.name != "__init__.py"}
    graph = {module: imports_of(module) & files - {module} for module in files}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        raise AssertionError(f"a circle of imports: {' <- '.join(error.args[1])}") from error


def test_every_room_says_what_it_is_for_and_is_small():
    for module, file in (MODULES | modules(("tests",))).items():
        lines = file.read_text(encoding="utf-8").splitlines()
        assert len(lines) <= MOST_LINES, f"{module} has {len(lines)} lines: which second job crept in?"
        if file.name == "__init__.py":
            assert ast.get_docstring(ast.parse("\n".join(lines))), f"{module} does not say what it is for"
        n_files = len(list(file.parent.glob("*.py")))
        assert n_files <= MOST_FILES, f"{file.parent} has {n_files} files"
        assert (file.parent / "__init__.py").exists() or file.parent.name == "examples", f"{file.parent} is no room"


def test_the_check_sees_imports_inside_functions():
    source = "def f():\n    import jax.numpy as jnp\n    from placement import x\nif TYPE_CHECKING:\n    import y"
    assert imported(source) == {"jax.numpy", "placement.x"}
