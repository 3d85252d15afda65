"""The file `rig.toml`: all that a request says beside the mesh. Options of the command line win over it.

Every key stands once, in `SECTIONS`, with its default, unit and meaning: reading, refusing, and the commented file
that `camring rig init` writes follow from there.
"""

import difflib
import inspect
import math
import re
import tomllib
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from types import NoneType
from typing import Any

import numpy as np

import exact
import placement
from experiments.files.errors import InputError
from experiments.request.option_text import parse_angles, parse_arcs, parse_fov, parse_vector, parse_weights


@dataclass(frozen=True)
class Kind:
    """What the value of a key may be.

    Attributes
    ----------
    needs, example : str
        What it must be, in words, and one as TOML.
    checked : callable
        From a value of TOML to ours; ValueError or TypeError if it is of another kind.
    from_words : callable, optional
        From the text of the option and the option's name to our value, where the option is a text.
    """

    needs: str
    example: str
    checked: Callable[[Any], Any]
    from_words: Callable[[str, str], Any] | None = None


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


NUMBER = Kind("a number", "5.0", _number)
WHOLE = Kind("a whole number", "4", _instance_of(int))
FLAG = Kind("true or false", "true", _instance_of(bool))
WORD = Kind("a text in quotes", '"top"', _instance_of(str))
NUMBERS = Kind("a list of numbers", "[0.0, 90.0]", _numbers, parse_angles)
SIZE = Kind("a list of two numbers", "[36.0, 24.0]", lambda value: _numbers(value, 2), parse_fov)
WEIGHTS = Kind("a list of numbers", "[1.0, 2.0]", _numbers, parse_weights)
VECTOR = Kind("a list of three numbers", "[0.0, 0.0, 1.0]", lambda value: _numbers(value, 3), parse_vector)
ARCS = Kind(
    "a list of [start, end]",
    "[[60.0, 90.0], [200.0, 230.0]]",
    lambda value: tuple(_numbers(arc, 2) for arc in _instance_of(list)(value)),
    parse_arcs,
)
OF_TYPE = {int: WHOLE, float: NUMBER, bool: FLAG, str: WORD, tuple[float, ...]: NUMBERS}


@dataclass(frozen=True)
class Key:
    """One key: what it may be, what it is unless said, and what it means. No default: the meaning says what then."""

    kind: Kind
    default: Any
    meaning: str


def _search_keys() -> dict[str, Key]:
    """Every field of `placement.Settings`, with the words of its documentation."""
    documented = inspect.cleandoc(placement.Settings.__doc__ or "").partition("Parameters\n----------\n")[2]
    meanings = {}
    for names, text in re.findall(r"^(\w[^:\n]*) : .*\n((?:    .*(?:\n|\Z))+)", documented, flags=re.M):
        meanings |= {name.strip(): " ".join(text.split()) for name in names.split(",")}
    types = typing.get_type_hints(placement.Settings)
    keys = {}
    for field in fields(placement.Settings):
        options = [kind for kind in typing.get_args(types[field.name]) if kind is not NoneType]
        kind = types[field.name] if NoneType not in typing.get_args(types[field.name]) else options[0]
        keys[field.name] = Key(OF_TYPE[kind], field.default, meanings.get(field.name, ""))
    return keys


SECTIONS: dict[str, dict[str, Key]] = {
    "ring": {
        "diameter": Key(NUMBER, exact.Ring.diameter, "Diameter of the ring [mm]."),
        "working_distance": Key(
            NUMBER, exact.Ring.working_distance, "Distance of the ring's plane from the focus [mm]."
        ),
        "fov": Key(
            SIZE, None, "Field of view at the focus, width and height [mm]; unless given 36 x 24, or the site's own."
        ),
        "focus": Key(VECTOR, exact.Ring.focus, "The point that all cameras look at [mm]."),
        "axis": Key(VECTOR, exact.Ring.axis, "Direction from the focus to the ring's centre."),
    },
    "cameras": {
        "count": Key(WHOLE, 4, "Number of cameras."),
        "threshold": Key(WHOLE, 2, "Number of cameras that must see a point for it to count."),
    },
    "constraints": {
        "min_separation": Key(
            NUMBER, placement.Constraints.min_separation, "Least distance between any two cameras, for housings [mm]."
        ),
        "min_baseline": Key(
            NUMBER, placement.Constraints.min_baseline, "Least distance between two cameras that see a point [mm]."
        ),
        "min_angle_deg": Key(
            NUMBER, 0.0, "The same as an angle between two rays at the focus [degrees]; the stricter of both counts."
        ),
        "fixed_deg": Key(NUMBERS, (), "Ring angles of cameras that stay where they are [degrees]."),
        "forbidden_deg": Key(
            ARCS, (), "Arcs without cameras, each from its start counter-clockwise to its end [degrees]."
        ),
    },
    "search": {
        "seed": Key(WHOLE, 0, "Of the search; the same seed gives the same layout."),
        "certify": Key(FLAG, True, "Whether to bound what any layout could reconstruct."),
        **_search_keys(),
    },
    "mesh": {
        "exclude": Key(
            WORD, None, 'Faces that do not count: "top", "none", or a file with one face index per line, looked for '
            "beside this file; unless given top for built-in sites, none for mesh files.",
        ),
        "repair": Key(FLAG, False, "Whether to put right what can be: winding, faces without area."),
        "scale": Key(NUMBER, 1.0, "Factor from the mesh file's unit to millimetres."),
    },
    "sites": {
        "objective": Key(
            WORD, "mean", 'What one layout for several meshes maximises: the "mean" of their fractions of the ring '
            'maximum, or that of the "worst" mesh.',
        ),
        "site_weights": Key(WEIGHTS, None, "How much each mesh counts in the mean; unless given all count equally."),
        "falloff_mm": Key(
            NUMBER, None, "Distance from the focus at which a face counts half, falling off on; unless given all count "
            "fully [mm].",
        ),
    },
    "poses": {
        "jitter": Key(WHOLE, 1, "Poses of each mesh that the layout is to serve; the mesh as it is comes first."),
        "tilt_deg": Key(NUMBER, 2.0, "Greatest tilt of the other poses [degrees]."),
        "shift_mm": Key(NUMBER, 1.0, "Greatest shift of the other poses [mm]."),
    },
}  # fmt: skip
KEYS = {name: key for section in SECTIONS.values() for name, key in section.items()}


@dataclass(frozen=True)
class Rig:
    """All that a request says beside the mesh.

    Attributes
    ----------
    diameter, working_distance : float
        Of the ring [mm].
    fov : (float, float) or None
        Field of view [mm]; None for the one recommended for the site.
    focus, axis : (float, float, float)
        The point all cameras look at [mm], and the direction from it to the ring's centre.
    n_cameras, threshold : int
        Number of cameras, and how many must see a point.
    constraints : placement.Constraints
    seed : int
    certify : bool
    settings : placement.Settings
    exclude : str or None
        "top", "none", or a file of face indices; None for what is usual for the mesh.
    repair : bool
    scale : float
        Factor from the mesh file's unit to millimetres.
    objective : str
        "mean" or "worst", over several meshes.
    site_weights : tuple of float or None
        How much each mesh counts in the mean; None for equally.
    falloff_mm : float or None
        Distance from the focus at which a face counts half [mm]; None for faces that all count fully.
    jitter : int
        Poses of each mesh.
    tilt_deg, shift_mm : float
        Greatest tilt [degrees] and shift [mm] of the poses.
    """

    diameter: float
    working_distance: float
    fov: tuple[float, float] | None
    focus: tuple[float, float, float]
    axis: tuple[float, float, float]
    n_cameras: int
    threshold: int
    constraints: placement.Constraints
    seed: int
    certify: bool
    settings: placement.Settings
    exclude: str | None
    repair: bool
    scale: float
    objective: str
    site_weights: tuple[float, ...] | None
    falloff_mm: float | None
    jitter: int
    tilt_deg: float
    shift_mm: float

    @property
    def demand(self) -> exact.Demand:
        """What makes a point count."""
        return exact.Demand(threshold=self.threshold)

    def ring(self, recommended_fov: tuple[float, float]) -> exact.Ring:
        """The ring; with the recommended field of view [mm] where none was asked for.

        Examples
        --------
        >>> rig(diameter=20.0).ring((36.0, 24.0)).diameter
        20.0
        """
        fov = recommended_fov if self.fov is None else self.fov
        return exact.Ring(self.diameter, self.working_distance, fov, self.focus, self.axis)


def rig(path: Path | None = None, **options: Any) -> Rig:
    """What is asked for: by options, else by the rig file, else by default.

    Parameters
    ----------
    path : Path, optional
        A rig file.
    options : dict
        Values by the names of the keys in `SECTIONS`; None for an option that was not given. The text of an option
        stands for what it says: "36x24", "0,90", "60:90,200:230".

    Raises
    ------
    InputError, placement.PlacementError
        If the file or an option is not understood, or makes no sense.

    Examples
    --------
    >>> asked = rig(count=6, min_separation=None, fixed_deg="0,90")
    >>> asked.n_cameras, asked.constraints.min_separation, len(asked.constraints.fixed)
    (6, 5.0, 2)
    """
    values = {name: key.default for name, key in KEYS.items()}
    if path is not None:
        values |= read(path)
    for name, value in options.items():
        words = KEYS[name].kind.from_words
        if value is not None:
            values[name] = words(value, f"--{name.replace('_', '-')}") if words and isinstance(value, str) else value
    return Rig(
        **{name: values[name] for name in SECTIONS["ring"]},
        n_cameras=values["count"],
        threshold=values["threshold"],
        constraints=placement.Constraints(
            min_separation=values["min_separation"],
            min_baseline=values["min_baseline"],
            min_angle=math.radians(values["min_angle_deg"]),
            fixed=tuple(np.radians(values["fixed_deg"]).tolist()),
            forbidden=tuple(map(tuple, np.radians(values["forbidden_deg"]).tolist())),
        ),
        seed=values["seed"],
        certify=values["certify"],
        settings=placement.Settings(**{field.name: values[field.name] for field in fields(placement.Settings)}),
        **{name: values[name] for section in ("mesh", "sites", "poses") for name in SECTIONS[section]},
    )


def read(path: Path) -> dict[str, Any]:
    """Values that a rig file gives, by the names of their keys.

    Raises
    ------
    InputError
        If it is not there or no TOML, if a section or key is not known, or a value is of another kind.
    """
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"cannot read rig file {path}: {error.strerror}; camring rig init writes one") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} is not a rig file: it holds no valid TOML ({error})") from error
    values = {}
    for section, keys in content.items():
        if section not in SECTIONS:
            raise InputError(f"{path}: {_unknown_section(section)}")
        if not isinstance(keys, dict):
            raise InputError(f"{path}: {section} is {keys!r}; needed is a section [{section}] with keys below it")
        for name, value in keys.items():
            if name not in SECTIONS[section]:
                raise InputError(f"{path}: {_unknown_key(section, name)}")
            kind = SECTIONS[section][name].kind
            try:
                values[name] = kind.checked(value)
            except (TypeError, ValueError, OverflowError):
                raise InputError(
                    f"{path}: {name} in [{section}] is {value!r}; it must be {kind.needs}, as in {kind.example}"
                ) from None
    if values.get("exclude") not in (None, "top", "none"):
        values["exclude"] = str(path.parent / values["exclude"])
    return values


def _unknown_section(name: str) -> str:
    known = f"Sections are {', '.join(f'[{section}]' for section in SECTIONS)}"
    if home := _home(name):
        return f"{name} stands in no section; it belongs below [{home}]. {known}"
    return f"there is no section [{name}]{_likely(name, SECTIONS, '[{}]')} {known}"


def _unknown_key(section: str, name: str) -> str:
    known = f"Keys of [{section}] are {', '.join(SECTIONS[section])}"
    if home := _home(name):
        return f"{name} in [{section}] is in the wrong place; it belongs below [{home}]. {known}"
    return f"there is no key {name!r} in [{section}]{_likely(name, SECTIONS[section], '{}')} {known}"


def _home(name: str) -> str | None:
    """The section that has a key of this name."""
    return next((section for section, keys in SECTIONS.items() if name in keys), None)


def _likely(name: str, known: Mapping[str, object], shown: str) -> str:
    """The end of a sentence: the known word that was probably meant, if one is near."""
    near = difflib.get_close_matches(name.lower(), known, n=1, cutoff=0.5)
    return f"; did you mean {shown.format(near[0])}?" if near else "."
