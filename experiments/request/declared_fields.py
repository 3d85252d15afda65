"""What a dataclass declares: names, types, defaults and words of its fields.

A field that is a dataclass itself is left out: its own fields are declared there.

The help of the command line shows them and must not wait for numpy. So they are read from the source of a module that
is not imported yet; of one that is, from the class that it holds now.
"""

import ast
import dataclasses
import importlib
import importlib.util
import inspect
import re
import sys
from dataclasses import dataclass
from functools import cache
from importlib.machinery import PathFinder
from typing import Any


@dataclass(frozen=True)
class Declared:
    """One field: its name, its type as written, its default (None if it has none), and what the docstring says."""

    name: str
    type: str
    default: Any
    words: str


def declared(module: str, name: str) -> tuple[Declared, ...]:
    """Fields of the dataclass `name` of `module` that its caller may give.

    Examples
    --------
    >>> [(one.name, one.type, one.default) for one in declared("exact.demand", "Demand")][:2]
    [('threshold', 'int', 2), ('min_baseline', 'float', 0.0)]
    """
    found = None if module in sys.modules else _of_source(module, name)
    return _of_class(getattr(importlib.import_module(module), name)) if found is None else found


def parameters(docstring: str) -> dict[str, str]:
    r"""What the section "Parameters" of a docstring says of each name, on one line.

    Examples
    --------
    >>> parameters('''A plate.
    ...
    ...     Parameters
    ...     ----------
    ...     width, height : float
    ...         Sizes of
    ...         its sides [mm].
    ...     ''')
    {'width': 'Sizes of its sides [mm].', 'height': 'Sizes of its sides [mm].'}
    """
    section = inspect.cleandoc(docstring).partition("Parameters\n----------\n")[2]
    words = {}
    for names, text in re.findall(r"^(\w[^:\n]*) : .*\n((?:    .*(?:\n|\Z))+)", section, flags=re.M):
        words |= {name.strip(): " ".join(text.split()) for name in names.split(",")}
    return words


def _of_class(kind: type) -> tuple[Declared, ...]:
    """Of a class that is imported; what it inherits is described where it was declared."""
    words: dict[str, str] = {}
    for base in reversed(kind.__mro__):
        words |= parameters(vars(base).get("__doc__") or "")
    return tuple(
        Declared(
            field.name,
            field.type if isinstance(field.type, str) else inspect.formatannotation(field.type),
            None if field.default is dataclasses.MISSING else field.default,
            words.get(field.name, ""),
        )
        for field in dataclasses.fields(kind)
        if field.init and not dataclasses.is_dataclass(field.default)
    )


@cache
def _of_source(module: str, name: str) -> tuple[Declared, ...] | None:
    """Of a class whose source says it all; None if a base or a computed default takes more than reading."""
    first, *parts = module.split(".")
    spec, path = importlib.util.find_spec(first), first
    for part in parts:  # `importlib.util.find_spec` would import each package on the way
        path += f".{part}"
        spec = spec and PathFinder.find_spec(path, spec.submodule_search_locations)
    source = spec and spec.loader and spec.loader.get_source(module)  # type: ignore[attr-defined]
    kind = next(
        (one for one in ast.parse(source or "").body if isinstance(one, ast.ClassDef) and one.name == name), None
    )
    if kind is None or kind.bases:
        return None
    words, found = parameters(ast.get_docstring(kind) or ""), []
    for one in kind.body:
        if not isinstance(one, ast.AnnAssign) or not isinstance(one.target, ast.Name) or one.target.id.startswith("_"):
            continue
        if isinstance(one.value, ast.Call) and ast.unparse(one.value) == f"{ast.unparse(one.annotation)}()":
            continue
        try:
            default = None if one.value is None else ast.literal_eval(one.value)
        except ValueError:
            return None
        found.append(Declared(one.target.id, ast.unparse(one.annotation), default, words.get(one.target.id, "")))
    return tuple(found)
