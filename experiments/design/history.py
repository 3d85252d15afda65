"""The layouts that were tried, with their numbers: undo, redo, and back to any of them; kept in a file."""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from experiments.design.design import Design
from experiments.files.errors import InputError
from experiments.layouts import layout_file

FORMAT, VERSION = "camring designer session", 1
# Layouts that are kept; the oldest go first.
MOST_TRIED = 500


@dataclass(frozen=True)
class Numbers:
    """What is known exactly of a layout.

    Attributes
    ----------
    area, equidistant_area : float
        Reconstructable area of it, and of the equidistant layout of as many cameras [mm²].
    error, equidistant_error : float or None
        Root mean square of their predicted errors [mm]; None where there is none.
    """

    area: float
    error: float | None
    equidistant_area: float
    equidistant_error: float | None


@dataclass(frozen=True)
class Tried:
    """One layout that was tried.

    Attributes
    ----------
    number : int
        From 1, in the order in which they were tried.
    why : str
        How it came about.
    design : Design
    numbers : Numbers or None
        None while nothing is known of it.
    """

    number: int
    why: str
    design: Design
    numbers: Numbers | None = None


class History:
    """All that was tried, and which of it is looked at.

    Examples
    --------
    >>> import exact, placement
    >>> first = Design.of(exact.Ring(), exact.Demand(), placement.Constraints(), [0.0, 3.0])
    >>> history = History(first, "start")
    >>> history.add(first.with_one_more(), "camera 3 added")
    2
    >>> history.undo(), len(history.now.design.angles), history.redo(), len(history.now.design.angles)
    (True, 2, True, 3)
    """

    def __init__(self, first: Design, why: str):
        self.tried: dict[int, Tried] = {1: Tried(1, why, first)}
        self.at = 1
        self._before: list[int] = []
        self._after: list[int] = []

    @property
    def now(self) -> Tried:
        """What is looked at."""
        return self.tried[self.at]

    @property
    def can_undo(self) -> bool:
        """Whether there is something before it."""
        return bool(self._before)

    @property
    def can_redo(self) -> bool:
        """Whether something was undone."""
        return bool(self._after)

    def add(self, design: Design, why: str, look: bool = True) -> int:
        """Try another design, and look at it; its number. The one that is looked at is not added again."""
        if design == self.now.design:
            return self.at
        number = max(self.tried) + 1
        self.tried[number] = Tried(number, why, design)
        if look:
            self.go(number)
        while len(self.tried) > MOST_TRIED:
            self._forget(min(set(self.tried) - {self.at}))
        return number

    def change(self, number: int, design: Design) -> None:
        """Put another design in the place of one that was tried: a search has got farther."""
        self.tried[number] = replace(self.tried[number], design=design, numbers=None)

    def go(self, number: int) -> None:
        """Look at one that was tried before.

        Raises
        ------
        InputError
            If there is none of that number.
        """
        if number not in self.tried:
            raise InputError(f"no layout {number} was tried, or it is forgotten")
        if number != self.at:
            self._before.append(self.at)
            self.at, self._after = number, []

    def undo(self) -> bool:
        """Go back to what was looked at before; whether there was something."""
        return self._step(self._before, self._after)

    def redo(self) -> bool:
        """Take back an undo; whether there was one."""
        return self._step(self._after, self._before)

    def know(self, design: Design, numbers: Numbers) -> bool:
        """Note what is known of a design, wherever it was tried; whether anything is new."""
        news = [one for one in self.tried.values() if one.design == design and one.numbers != numbers]
        self.tried |= {one.number: replace(one, numbers=numbers) for one in news}
        return bool(news)

    def _step(self, source: list[int], other: list[int]) -> bool:
        if not source:
            return False
        other.append(self.at)
        self.at = source.pop()
        return True

    def _forget(self, number: int) -> None:
        del self.tried[number]
        self._before = [one for one in self._before if one != number]
        self._after = [one for one in self._after if one != number]

    def text(self, mesh: dict[str, Any]) -> str:
        """As it is kept in a file; `mesh` is what a layout file says of the mesh."""
        content = {
            "format": FORMAT,
            "version": VERSION,
            "at": self.at,
            "before": self._before,
            "after": self._after,
            "tried": [
                {
                    "number": one.number,
                    "why": one.why,
                    "layout": one.design.content(mesh),
                    "numbers": None if one.numbers is None else asdict(one.numbers),
                }
                for one in self.tried.values()
            ],
        }
        return json.dumps(content, allow_nan=False)

    @staticmethod
    def read(path: Path, understood: Callable[[layout_file.LayoutFile], Design]) -> "History | None":
        """What `text` gave, from a file; None if there is no such file.

        Parameters
        ----------
        path : Path
        understood : callable
            Makes a design of a layout file.

        Raises
        ------
        InputError
            If it is damaged.
        """
        if not path.exists():
            return None
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
            if (content["format"], content["version"]) != (FORMAT, VERSION):
                raise ValueError(f"it is {content['format']!r}, version {content['version']!r}")
            found = object.__new__(History)
            found.tried = {
                int(one["number"]): Tried(
                    int(one["number"]), str(one["why"]),
                    understood(layout_file.understood(json.dumps(one["layout"]), path)),
                    None if one["numbers"] is None else Numbers(**one["numbers"]),
                )
                for one in content["tried"]
            }  # fmt: skip
            found.at, found._before, found._after = content["at"], list(content["before"]), list(content["after"])
            if not {found.at, *found._before, *found._after} <= set(found.tried):
                raise ValueError("it names layouts that it does not hold")
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise InputError(
                f"the session kept in {path} is damaged ({error}); move it away, or start anew with --fresh"
            ) from error
        return found
