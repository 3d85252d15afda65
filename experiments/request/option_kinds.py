"""What the value of an option may be: how it is read from an option's text and from TOML, and what it must be."""

import ast
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from experiments.request.option_text import (
    parse_angles,
    parse_arcs,
    parse_fov,
    parse_pixels,
    parse_points,
    parse_range,
    parse_vector,
    parse_weights,
)


@dataclass(frozen=True)
class Kind:
    """What the value of an option or a key may be.

    Attributes
    ----------
    needs, example : str
        What it must be in a rig file, in words, and one as TOML.
    checked : callable
        From a value of TOML to ours; ValueError, TypeError or OverflowError if it is of another kind.
    given_as : type
        What the command line makes of the text of an option.
    from_words : callable, optional
        From that text and the option's name to our value, where `given_as` is str and the text stands for more.
    written : str
        How that text is written.
    """

    needs: str
    example: str
    checked: Callable[[Any], Any]
    given_as: type = str
    from_words: Callable[[str, str], Any] | None = None
    written: str = ""


def _instance_of(*types: type) -> Callable[[Any], Any]:
    def checked(value):
        if not isinstance(value, types) or (isinstance(value, bool) and bool not in types):
            raise TypeError
        return value

    return checked


def _number(value) -> float:
    number = float(_instance_of(int, float)(value))
    if not math.isfinite(number):
        raise ValueError
    return number


def _numbers(value, length: int | None = None) -> tuple[float, ...]:
    numbers = tuple(_number(one) for one in _instance_of(list)(value))
    if length not in (None, len(numbers)):
        raise ValueError
    return numbers


def _pair(value) -> list:
    if len(_instance_of(list)(value)) != 2:
        raise ValueError
    return value


NUMBER = Kind("a number", "5.0", _number, float)
WHOLE = Kind("a whole number", "4", _instance_of(int), int)
FLAG = Kind("true or false", "true", _instance_of(bool), bool)
WORD = Kind("a text in quotes", '"top"', _instance_of(str))
NUMBERS = Kind("a list of numbers", "[0.0, 90.0]", _numbers, from_words=parse_angles, written="as in 0,90")
SIZE = Kind(
    "a list of two numbers",
    "[36.0, 24.0]",
    lambda value: _numbers(value, 2),
    from_words=parse_fov,
    written="written width x height, as in 36x24",
)
WEIGHTS = Kind("a list of numbers", "[1.0, 2.0]", _numbers, from_words=parse_weights, written="as in 1,2")
VECTOR = Kind(
    "a list of three numbers",
    "[0.0, 0.0, 1.0]",
    lambda value: _numbers(value, 3),
    from_words=parse_vector,
    written="written x,y,z",
)
ARCS = Kind(
    "a list of [start, end]",
    "[[60.0, 90.0], [200.0, 230.0]]",
    lambda value: tuple(_numbers(arc, 2) for arc in _instance_of(list)(value)),
    from_words=parse_arcs,
    written="written start:end, as in 60:90,200:230",
)
PIXELS = Kind(
    "a list of two whole numbers",
    "[3600, 2400]",
    lambda value: tuple(_instance_of(int)(one) for one in _pair(value)),
    from_words=parse_pixels,
    written="written width x height, as in 3600x2400",
)
RANGE = Kind(
    "a list of two numbers",
    "[380.0, 420.0]",
    lambda value: _numbers(value, 2),
    from_words=parse_range,
    written="written near:far, as in 380:420",
)
POINTS = Kind(
    "a list of [x, y, z]",
    "[[0.0, 0.0, 400.0]]",
    lambda value: tuple(_numbers(point, 3) for point in _instance_of(list)(value)),
    from_words=parse_points,
    written="written x,y,z, several separated by semicolons",
)
FILES = Kind(
    "a list of texts in quotes",
    '["instrument.stl"]',
    lambda value: tuple(_instance_of(str)(one) for one in _instance_of(list)(value)),
    from_words=lambda text, option: tuple(part.strip() for part in text.split(",")),
    written="several separated by commas",
)
# A field of a dataclass with this type, as it is written there, is of this kind.
OF_TYPE = {
    "int": WHOLE,
    "float": NUMBER,
    "bool": FLAG,
    "str": WORD,
    "str | float": WORD,
    "tuple[float, ...]": NUMBERS,
    "tuple[float, float]": SIZE,
    "tuple[int, int]": PIXELS,
    "tuple[float, float, float]": VECTOR,
    "tuple[tuple[float, float], ...]": ARCS,
}


def of_type(written: str) -> tuple[Kind, tuple[str, ...]]:
    """Kind of a field, and the words it may be if its type lists them.

    Raises
    ------
    TypeError
        If no kind reads such a type.

    Examples
    --------
    >>> of_type("float | None")[0] is NUMBER, of_type("Literal['depth', 'normal']")[1]
    (True, ('depth', 'normal'))
    """
    plain = written.removesuffix(" | None")
    if plain.startswith("Literal["):
        words = ast.literal_eval(f"({plain.removeprefix('Literal[').removesuffix(']')},)")
        return replace(WORD, example=f'"{words[0]}"'), words
    if plain not in OF_TYPE:
        raise TypeError(f"no option is read as {written}; add a kind for it to experiments/request/option_kinds.py")
    return OF_TYPE[plain], ()
