"""The file `rig.toml`: all that a request says beside the mesh. Options of the command line win over it.

What may stand in it is said in `experiments.request.options`.
"""

import difflib
import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import exact
import placement
from exact import demand
from experiments.files.errors import InputError
from experiments.request.option_kinds import WHOLE, Kind
from experiments.request.options import PARTS, Option, fields_of, keys, sections
from experiments.request.simulation import Simulation

# What --place auto finds.
PLACED = ("focus", "axis", "zero_towards")
# The key of a table [[ring]] that is no field of a ring.
MOST = "most"

Sections = dict[str, dict[str, Option]]


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
    zero_towards : (float, float, float) or None
        Where ring angle 0 lies.
    roll : str or float
        How sensors are turned about their optical axes: as for `exact.Ring`.
    place : str
        "none" for what focus and axis say, "auto" for one that is found for the mesh.
    n_cameras : int
        Number of cameras.
    demand : exact.Demand
        All that makes a point count.
    constraints : placement.Constraints
    seed : int
    certify : bool
    settings : placement.Settings
    simulation : Simulation
        How images of a simulated reconstruction are made.
    give_up : float
        Fraction of the ring maximum that may be given up for accuracy.
    obstacle : tuple of str or None
        Files of meshes that hide and never count.
    light : tuple of (float, float, float) or None
        Where light comes from [mm]; None for everywhere.
    exclude : str or None
        "top", "none", or a file of face indices; None for what is usual for the mesh.
    repair, two_sided : bool
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
    zero_towards: tuple[float, float, float] | None
    roll: str | float
    place: str
    n_cameras: int
    demand: exact.Demand
    constraints: placement.Constraints
    seed: int
    certify: bool
    settings: placement.Settings
    simulation: Simulation
    give_up: float
    obstacle: tuple[str, ...] | None
    light: tuple[tuple[float, float, float], ...] | None
    exclude: str | None
    repair: bool
    two_sided: bool
    scale: float
    objective: str
    site_weights: tuple[float, ...] | None
    falloff_mm: float | None
    jitter: int
    tilt_deg: float
    shift_mm: float

    def ring(self, recommended_fov: tuple[float, float]) -> exact.Ring:
        """The ring; with the recommended field of view [mm] where none was asked for.

        Examples
        --------
        >>> rig(diameter=20.0).ring((36.0, 24.0)).diameter
        20.0
        """
        fov = recommended_fov if self.fov is None else self.fov
        return exact.Ring(
            self.diameter, self.working_distance, fov, self.focus, self.axis, self.zero_towards, self.roll
        )


def rig(path: Path | None = None, several: bool = False, **options: Any) -> Rig:
    """What is asked for: by options, else by the rig file, else by default.

    Parameters
    ----------
    path : Path, optional
        A rig file.
    several : bool
        Whether it may have tables [[ring]], of which `ring_tables` tells; they are left out here.
    options : dict
        Values by the names of their keys; None for an option that was not given. The text of an option
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
    known = keys()
    values = {name: key.default for name, key in known.items()}
    if path is not None:
        values |= read(path, several)
    given = _understood(options)
    values |= given
    values["roll"] = _roll(values, given)
    values["place"] = checked_place(options, values["place"])
    constraints = placement.Constraints(**fields_of("Constraints", values))
    return Rig(
        **fields_of("Ring", values),
        n_cameras=values["count"],
        demand=overridden(demand.Demand(), values),
        constraints=constraints,
        settings=placement.Settings(**fields_of("Settings", values)),
        simulation=Simulation(**fields_of("Simulation", values)),
        **{
            name: values[name]
            for name, key in known.items()
            if not key.classes and key.section in ("search", "mesh", "sites", "poses")
        },
    )


def _roll(values: Mapping[str, Any], given: Mapping[str, Any]) -> str | float:
    """How sensors are turned, of a word and an angle: what options give goes before what a file says."""
    if "roll" in given and "roll_deg" in given:
        raise InputError("--roll and --roll-deg both say how sensors are turned; leave one of them out")
    along = None if "roll" in given else values["roll_deg"]
    if along is None:
        return values["roll"]
    if values["roll"] != keys()["roll"].default and "roll_deg" not in given:
        raise InputError("roll and roll_deg in [ring] both say how sensors are turned; leave one of them out")
    return math.radians(along)


def checked_place(options: Mapping[str, Any], otherwise: str = "none") -> str:
    """Whether a place is to be looked for, "auto" or "none"; refused if it is no such word, or options give one too.

    Raises
    ------
    InputError

    Examples
    --------
    >>> checked_place({"place": None, "focus": "1,2,3"}), checked_place({"place": "auto"})
    ('none', 'auto')
    """
    known, place = keys(), options.get("place")
    place = otherwise if place is None else place
    if place not in known["place"].choices:
        raise InputError(f"--place is {place!r}; it must be {' or '.join(known['place'].choices)}")
    given = [known[name].flag for name in PLACED if options.get(name) is not None]
    if place == "auto" and given:
        raise InputError(f"--place auto finds what {given[0]} gives; leave one of them out, or give --place none")
    return place


def overridden(asked: exact.Demand, options: Mapping[str, Any]) -> exact.Demand:
    """What makes a point count, where options change what a file says.

    Parameters
    ----------
    asked : exact.Demand
    options : mapping
        Values or the texts of options by the names of their keys, those of other classes too; None for an option that
        was not given.

    Raises
    ------
    InputError, ExactError

    Examples
    --------
    >>> overridden(exact.Demand(3, 1.0), {"threshold": None, "min_baseline": 5.0, "repair": None}).words
    'seen by at least 3 cameras, two of them at least 5 mm apart'
    """
    given = _understood(options)
    parts = {name: replace(getattr(asked, name), **fields_of(kind, given)) for name, kind in PARTS["Demand"].items()}
    return replace(asked, **fields_of("Demand", given), **parts)


def _understood(options: Mapping[str, Any]) -> dict[str, Any]:
    """The options that were given, with what their texts stand for."""
    known, values = keys(), {}
    for name, value in options.items():
        if value is not None:
            words = known[name].kind.from_words
            values[name] = words(value, known[name].flag) if words and isinstance(value, str) else value
    return values


def read(path: Path, several: bool = False) -> dict[str, Any]:
    """Values that a rig file gives, by the names of their keys; with `several`, but for tables [[ring]].

    Raises
    ------
    InputError
        If it is not there or no TOML, if a section or key is not known, or a value is of another kind.
    """
    known, values = sections(), {}
    for section, given in _content(path).items():
        if section not in known:
            raise InputError(f"{path}: {_unknown_section(section, known)}")
        if section == "ring" and _is_several(given):
            if several:
                continue
            raise InputError(
                f"{path} has {len(given)} rings, tables [[ring]], of which camring optimise alone takes several; give "
                "one section [ring]"
            )
        if not isinstance(given, dict):
            raise InputError(f"{path}: {section} is {given!r}; needed is a section [{section}] with keys below it")
        for name, value in given.items():
            if name not in known[section]:
                raise InputError(f"{path}: {_unknown_key(section, name, known)}")
            values[name] = _checked(path, section, name, known[section][name].kind, value)
    if values.get("exclude") not in (None, "top", "none"):
        values["exclude"] = str(path.parent / values["exclude"])
    if values.get("obstacle") is not None:
        values["obstacle"] = tuple(str(path.parent / name) for name in values["obstacle"])
    return values


def ring_tables(path: Path | None) -> list[dict[str, Any]]:
    """What each table [[ring]] of a rig file gives: fields of `exact.Ring`, and "most", the most cameras it takes.

    None of them if the file has a section [ring], or none.

    Raises
    ------
    InputError
        As by `read`.
    """
    if path is None or not _is_several(tables := _content(path).get("ring", [])):
        return []
    known, found = sections(), []
    keys_of_ring = {name: one for name, one in known["ring"].items() if "Ring" in one.classes}
    for table in tables:
        for name in table:
            if name not in keys_of_ring and name != MOST:
                near = _likely(name, (*keys_of_ring, MOST), "{}")
                raise InputError(f"{path}: there is no key {name!r} in [[ring]]{near}")
        values = {
            name: _checked(path, "[ring]", name, WHOLE if name == MOST else keys_of_ring[name].kind, value)
            for name, value in table.items()
        }
        most = {MOST: values.pop(MOST)} if MOST in values else {}
        found.append(fields_of("Ring", values) | most)
    return found


def _content(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"cannot read rig file {path}: {error.strerror}; camring rig init writes one") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} is not a rig file: it holds no valid TOML ({error})") from error


def _is_several(given: Any) -> bool:
    """Whether a section is a list of tables."""
    return isinstance(given, list) and len(given) > 0 and all(isinstance(one, dict) for one in given)


def _checked(path: Path, section: str, name: str, kind: Kind, value: Any) -> Any:
    try:
        return kind.checked(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(
            f"{path}: {name} in [{section}] is {value!r}; it must be {kind.needs}, as in {kind.example}"
        ) from None


def _unknown_section(name: str, known: Sections) -> str:
    all_of_them = f"Sections are {', '.join(f'[{section}]' for section in known)}"
    if home := _home(name, known):
        return f"{name} stands in no section; it belongs below [{home}]. {all_of_them}"
    return f"there is no section [{name}]{_likely(name, known, '[{}]')} {all_of_them}"


def _unknown_key(section: str, name: str, known: Sections) -> str:
    all_of_them = f"Keys of [{section}] are {', '.join(known[section])}"
    if home := _home(name, known):
        return f"{name} in [{section}] is in the wrong place; it belongs below [{home}]. {all_of_them}"
    return f"there is no key {name!r} in [{section}]{_likely(name, known[section], '{}')} {all_of_them}"


def _home(name: str, known: Sections) -> str | None:
    """The section that has a key of this name."""
    return next((section for section, keys in known.items() if name in keys), None)


def _likely(name: str, known: Iterable[str], shown: str) -> str:
    """The end of a sentence: the known word that was probably meant, if one is near."""
    near = difflib.get_close_matches(name.lower(), known, n=1, cutoff=0.5)
    return f"; did you mean {shown.format(near[0])}?" if near else "."
