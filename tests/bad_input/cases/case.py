"""What a case of bad input is."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from experiments.files.errors import InputError


@dataclass(frozen=True)
class Case:
    """Arguments to be refused, the words of the refusal, and the library call that refuses the same."""

    arguments: Callable[[Path], Sequence[object]]
    message: str
    library: Callable[[Path], object] | None = None
    error: type[Exception] = InputError
