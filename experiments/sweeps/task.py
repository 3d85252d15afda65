"""One task of a sweep: a function and its inputs, named by what they are, so that a result on disk is known again."""

import hashlib
import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any

from experiments.files.errors import InputError


@dataclass(frozen=True, eq=False)
class Task:
    """A call that can be made anywhere and gives the same result everywhere.

    Attributes
    ----------
    function : callable
        Defined at the top of a module; gives a dict that JSON can hold.
    inputs : dict
        Its keyword arguments, which JSON can hold.
    cost : float
        How long it takes, compared with others: the long ones start first, and time left is told by it.
    packages : tuple of str
        Packages whose sources make the result. A change in one of them makes another task of it.

    Examples
    --------
    >>> Task(round, {"number": 2.5}).name == Task(round, {"number": 2.5}, cost=9.0).name
    True
    >>> Task(round, {"number": 2.5}).name == Task(round, {"number": 3.5}).name
    False
    """

    function: Callable[..., dict[str, Any]]
    inputs: dict[str, Any]
    cost: float = 1.0
    packages: tuple[str, ...] = field(default=("meshes", "exact", "placement"))

    @property
    def identity(self) -> dict[str, Any]:
        """All that the result depends on."""
        return {
            "function": f"{self.function.__module__}.{self.function.__qualname__}",
            "inputs": self.inputs,
            "sources": sources_digest(self.function.__module__, self.packages),
        }

    @property
    def name(self) -> str:
        """SHA-256 of the identity, the first half of it, in hexadecimal."""
        text = json.dumps(self.identity, sort_keys=True, separators=(",", ":"), allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()[:32]


@dataclass(frozen=True)
class Outcome:
    """What became of a task: its result, or the reason why there is none, and how long it took [s]."""

    result: dict[str, Any] | None
    failure: str
    seconds: float


def perform(task: Task, sources: str) -> Outcome:
    """Do a task where this is called; a failure is an outcome too.

    Parameters
    ----------
    task : Task
    sources : str
        What `sources_digest` gives where the task was asked for.

    Examples
    --------
    >>> task = Task(divmod, {})
    >>> perform(task, task.identity["sources"]).failure[:9]
    'TypeError'
    """
    started = time.perf_counter()
    try:
        if sources_digest(task.function.__module__, task.packages) != sources:
            raise InputError("this worker runs another camring than the one that asks; install the same on both")
        return Outcome(task.function(**task.inputs), "", time.perf_counter() - started)
    except Exception as error:  # noqa: BLE001 - whatever it is, the other tasks go on, and the reason is in the table
        return Outcome(None, f"{type(error).__name__}: {error}", time.perf_counter() - started)


@lru_cache(maxsize=64)
def sources_digest(module: str, packages: tuple[str, ...]) -> str:
    """SHA-256 of the Python sources of a module and of whole packages, in hexadecimal, as they are now.

    A number that was computed before a change to the code must not be taken for one computed after it, and the version
    of a package in development does not tell the two apart.
    """
    digest = hashlib.sha256()
    own = getattr(sys.modules[module], "__file__", None)
    files = [Path(own)] if own else []
    for package in packages:
        files += sorted(Path(str(import_module(package).__file__)).parent.rglob("*.py"))
    for file in files:
        digest.update(file.name.encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()
