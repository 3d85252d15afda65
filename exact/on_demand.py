"""A package that imports its public names when they are first used: what is not used costs nothing."""

import ast
import inspect
import sys
from functools import cached_property
from importlib import import_module
from types import ModuleType
from typing import Any


class OnDemand(ModuleType):
    """A package whose `__init__` imports its public names under `if TYPE_CHECKING:`, for readers and type checkers.

    Each of them is imported from there when it is first used. Some modules have the name of what they hold, as
    `exact.evaluate` has: of the two, the package shows what it holds.

    Examples
    --------
    >>> import exact
    >>> exact.evaluate is import_module("exact.evaluate").evaluate
    True
    """

    @cached_property
    def _homes(self) -> dict[str, str]:
        """The module of each public name."""
        return {
            name.asname or name.name: str(line.module)
            for block in ast.parse(inspect.getsource(self)).body
            if isinstance(block, ast.If) and ast.unparse(block.test) == "TYPE_CHECKING"
            for line in block.body
            if isinstance(line, ast.ImportFrom)
            for name in line.names
        }

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in self._homes:
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        value = getattr(import_module(self._homes[name]), name)
        setattr(self, name, value)
        return value

    def __setattr__(self, name: str, value: Any) -> None:
        # Python makes each module an attribute of its package once it is imported.
        if not (isinstance(value, ModuleType) and name in self._homes):
            super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self._homes})

    def __reduce__(self) -> tuple[Any, ...]:
        # Programs that send functions to other processes send the packages these use by name.
        return import_module, (self.__name__,)


def import_on_demand(package: str) -> None:
    """Let the package of this name, which is being imported, be an `OnDemand`."""
    sys.modules[package].__class__ = OnDemand
