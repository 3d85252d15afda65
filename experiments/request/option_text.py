"""From the words of an option to numbers, angles still in degrees."""

import math
import re
from typing import NamedTuple

from experiments.files.errors import InputError

# Options of three numbers that are directions, whose length says nothing.
DIRECTIONS = ("--axis", "--zero-towards", "--depth-axis")
# Of a range of lengths; more are a slip of the step.
MOST_STEPS = 100


def parse_fov(text: str, option: str = "--fov") -> tuple[float, float]:
    """Width x height in millimetres.

    Raises
    ------
    InputError
        If it is something else, or one of them is not positive.

    Examples
    --------
    >>> parse_fov("36x24")
    (36.0, 24.0)
    """
    match = re.fullmatch(r"\s*([0-9.]+)\s*[x×]\s*([0-9.]+)\s*", text)
    try:
        width, height = (float(part) for part in match.groups()) if match else (0.0, 0.0)
    except ValueError:
        width = height = 0.0
    if not (0 < width < math.inf and 0 < height < math.inf):
        raise InputError(
            f"{option} is {text[:40]!r}; it must be width x height in millimetres, both positive, as in 36x24"
        )
    return width, height


def parse_angles(text: str, option: str = "--angles-deg") -> tuple[float, ...]:
    """Angles separated by commas; none for an empty text.

    Raises
    ------
    InputError
        If one of them is no number, or not finite.

    Examples
    --------
    >>> parse_angles("0, 90,180"), parse_angles("")
    ((0.0, 90.0, 180.0), ())
    """
    try:
        degrees = tuple(float(part) for part in text.split(",")) if text.strip() else ()
    except ValueError as error:
        raise InputError(f"{option} is {text!r}; it must be numbers separated by commas, as in 0,90,180") from error
    if not all(math.isfinite(angle) for angle in degrees):
        raise InputError(f"{option} is {text!r}; every angle must be finite")
    return degrees


class RingText(NamedTuple):
    """One of several rings, as an option gives it."""

    diameter: float
    working_distance: float
    fov: tuple[float, float] | None
    """Its own; None for that of all."""
    most: int | None
    """The most cameras that it takes; None for as many as there is room for."""


def parse_ring(text: str, option: str = "--ring") -> RingText:
    """Diameter x working distance [mm], then @ and a field of view of its own, then a colon and the most cameras.

    Raises
    ------
    InputError
        If it is something else.

    Examples
    --------
    >>> parse_ring("30x400")
    RingText(diameter=30.0, working_distance=400.0, fov=None, most=None)
    >>> parse_ring("16x380@40x30:1")
    RingText(diameter=16.0, working_distance=380.0, fov=(40.0, 30.0), most=1)
    """
    sizes, _, most = text.partition(":")
    ring, _, fov = sizes.partition("@")
    try:
        if (":" in text and not re.fullmatch(r"\s*[0-9]{1,6}\s*", most)) or ("@" in text and not fov.strip()):
            raise InputError("")
        diameter, distance = parse_fov(ring, option)
        return RingText(diameter, distance, parse_fov(fov, option) if fov else None, int(most) if most else None)
    except InputError:
        raise InputError(
            f"{option} is {text[:40]!r}; it must be diameter x working distance [mm], as in 30x400, with a field of "
            "view of its own after @ and the most cameras that it takes after a colon, as in 16x380@40x30:1"
        ) from None


def parse_vector(text: str, option: str = "--focus") -> tuple[float, float, float]:
    """Three coordinates separated by commas.

    Raises
    ------
    InputError
        If they are not three finite numbers.

    Examples
    --------
    >>> parse_vector("310, -120,8.5")
    (310.0, -120.0, 8.5)
    """
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        x = y = z = math.nan
    if not all(math.isfinite(number) for number in (x, y, z)):
        unit, example = ("", "0,-0.2,1") if option in DIRECTIONS else (" in millimetres", "310,-120,8.5")
        raise InputError(f"{option} is {text!r}; it must be three numbers x,y,z{unit}, as in {example}")
    return x, y, z


def parse_weights(text: str, option: str = "--site-weights") -> tuple[float, ...]:
    """Weights separated by commas.

    Raises
    ------
    InputError
        If one of them is no number, not finite or negative, or all of them are 0.

    Examples
    --------
    >>> parse_weights("1, 2.5")
    (1.0, 2.5)
    """
    try:
        weights = tuple(float(part) for part in text.split(","))
    except ValueError:
        weights = ()
    if not weights or not all(0 <= weight < math.inf for weight in weights) or not any(weights):
        raise InputError(f"{option} is {text!r}; it must be numbers, at least 0 and not all 0, as in 1,2.5")
    return weights


def parse_arcs(text: str, option: str = "--forbidden-deg") -> tuple[tuple[float, float], ...]:
    """Arcs start:end separated by commas, each counter-clockwise from its start to its end; none for an empty text.

    Raises
    ------
    InputError
        If one of them is something else, or not finite.

    Examples
    --------
    >>> parse_arcs("60:90, 350:10")
    ((60.0, 90.0), (350.0, 10.0))
    """
    arcs = []
    for part in text.split(",") if text.strip() else ():
        try:
            start, end = (float(word) for word in part.split(":"))
        except ValueError:
            start = end = math.nan
        if not (math.isfinite(start) and math.isfinite(end)):
            raise InputError(
                f"{option} is {text!r}; it must be arcs start:end in degrees, separated by commas, as in 60:90,200:230"
            )
        arcs.append((start, end))
    return tuple(arcs)


def parse_pixels(text: str, option: str = "--pixels") -> tuple[int, int]:
    """Width x height in pixels.

    Raises
    ------
    InputError
        If it is something else, or one of them is 0.

    Examples
    --------
    >>> parse_pixels("3600x2400")
    (3600, 2400)
    """
    match = re.fullmatch(r"\s*0*([1-9][0-9]{0,8})\s*[x×]\s*0*([1-9][0-9]{0,8})\s*", text)
    if match is None:
        raise InputError(f"{option} is {text[:40]!r}; it must be width x height in pixels, as in 3600x2400")
    return int(match[1]), int(match[2])


def parse_range(text: str, option: str = "--depth-of-field") -> tuple[float, float]:
    """Two numbers separated by a colon.

    Raises
    ------
    InputError
        If it is something else.

    Examples
    --------
    >>> parse_range("380:420.5")
    (380.0, 420.5)
    """
    try:
        near, far = (float(part) for part in text.split(":"))
    except ValueError as error:
        raise InputError(
            f"{option} is {text[:40]!r}; it must be two numbers in millimetres, near:far, as in 380:420"
        ) from error
    return near, far


def parse_points(text: str, option: str = "--light") -> tuple[tuple[float, float, float], ...]:
    """Points, each written x,y,z, separated by semicolons.

    Raises
    ------
    InputError
        If one of them is not three finite numbers.

    Examples
    --------
    >>> parse_points("0,0,400; 10,0,390")
    ((0.0, 0.0, 400.0), (10.0, 0.0, 390.0))
    """
    return tuple(parse_vector(part, option) for part in text.split(";"))


def parse_steps(text: str, option: str) -> tuple[float, ...]:
    """Lengths: one, several separated by commas, or first:last:step, with the last if a step ends there.

    Raises
    ------
    InputError
        If it is something else, or gives more than `MOST_STEPS`.

    Examples
    --------
    >>> parse_steps("20:30:5", "--diameter"), parse_steps("30, 45", "--diameter")
    ((20.0, 25.0, 30.0), (30.0, 45.0))
    """
    try:
        numbers = [float(part) for part in re.split("[:,]", text)]
        is_range = ":" in text
        if not all(map(math.isfinite, numbers)) or (is_range and ("," in text or len(numbers) != 3)):
            raise ValueError
        if not is_range:
            return tuple(dict.fromkeys(numbers))
        first, last, step = numbers
        if not (step > 0 and last >= first and (last - first) / step < MOST_STEPS):
            raise ValueError
    except ValueError as error:
        raise InputError(
            f"{option} is {text[:40]!r}; it must be lengths in millimetres, separated by commas, as in 20,30, or "
            f"first:last:step, as in 20:40:5, with at most {MOST_STEPS} of them"
        ) from error
    # A few digits more than anybody writes take the rounding of the steps away.
    return tuple(round(first + step * number, 9) for number in range(math.floor((last - first) / step + 1e-6) + 1))
