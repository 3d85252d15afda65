"""Every setting of a request: its name, kind, default, unit, meaning and completion, each said once.

The options of the command line, the keys of a rig file, the file that `camring rig init` writes and the pages of the
documentation come from here. A field of `exact.Ring`, `exact.Demand` and its parts, `placement.Constraints` or
`placement.Settings` is described by the class that declares it, and comes by itself; what is no such field stands in
`BESIDE_CLASSES`.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

from experiments.request.declared_fields import Declared, declared
from experiments.request.option_kinds import FILES, FLAG, NUMBER, POINTS, RANGE, WEIGHTS, WHOLE, WORD, Kind, of_type

# Sections of a rig file, as they follow each other in it.
SECTIONS = (
    "ring", "cameras", "optics", "demand", "limits", "constraints", "search", "simulation", "mesh", "sites",
    "poses",
)  # fmt: skip
# Where each class is declared: module and name.
CLASSES = {
    "Ring": ("exact.ring", "Ring"),
    "Constraints": ("placement.layouts.constraints", "Constraints"),
    "Demand": ("exact.demand", "Demand"),
    "Limits": ("exact.usable.limits", "Limits"),
    "Optics": ("exact.usable.optics", "Optics"),
    "Settings": ("placement.settings", "Settings"),
    "Simulation": ("experiments.request.simulation", "Simulation"),
}
# The section of their fields.
SECTION_OF = {
    "Ring": "ring", "Constraints": "constraints", "Demand": "demand", "Limits": "limits", "Optics": "optics",
    "Settings": "search", "Simulation": "simulation",
}  # fmt: skip
# What the fields of a class are that are classes themselves, by name.
PARTS = {"Demand": {"limits": "Limits", "optics": "Optics"}}
# Those whose fields may be options; the numbers of the search may be changed in a rig file alone.
ON_THE_COMMAND_LINE = ("Ring", "Constraints", "Demand", "Limits", "Optics", "Simulation")
# Digits of a default that is an angle in degrees: they hide the rounding of its radians.
DIGITS = 9


@dataclass(frozen=True)
class Option:
    """One setting of a request.

    Attributes
    ----------
    name, section : str
        Its key in a rig file, and the section that holds it.
    kind : Kind
    default : object
        What it is unless given; None where `unless_given` says what holds then.
    meaning : str
        A sentence, with the unit in brackets.
    unless_given : str
    classes : tuple of str
        Classes that have it as a field; none for a setting of the request alone.
    field : str
        Its name there.
    in_degrees : bool
        Whether that field is in radians.
    option : str
        Its name on the command line, where that is another.
    choices : tuple of str
        Words to complete.
    """

    name: str
    section: str
    kind: Kind
    default: Any
    meaning: str
    unless_given: str = ""
    classes: tuple[str, ...] = ()
    field: str = ""
    in_degrees: bool = False
    option: str = ""
    choices: tuple[str, ...] = ()

    @property
    def flag(self) -> str:
        """Its name on the command line.

        Examples
        --------
        >>> keys()["count"].flag, keys()["fixed_deg"].flag
        ('--cameras', '--fixed-deg')
        """
        return f"--{(self.option or self.name).replace('_', '-')}"

    @property
    def shown_default(self) -> str:
        """What holds unless it is given, as it would be written on the command line.

        Examples
        --------
        >>> [keys()[name].shown_default for name in ("diameter", "focus", "fixed_deg", "fov")]
        ['30', '0,0,0', 'none', "36x24, or the site's own"]
        """
        if self.default is None or self.default == ():
            return self.unless_given or "none"
        if isinstance(self.default, bool):
            return (self.option or self.name) if self.default else "no"
        several = self.default if isinstance(self.default, tuple) else (self.default,)
        return ",".join(f"{one:g}" if isinstance(one, float) else str(one) for one in several)

    @property
    def help(self) -> str:
        """What the help of the command line says.

        Examples
        --------
        >>> keys()["site_weights"].help
        'how much each mesh counts in the mean; as in 1,2'
        """
        words = self.meaning.removesuffix(".")
        # A word in capitals stays as it is.
        words = words if words[1:2].isupper() else words[:1].lower() + words[1:]
        return f"{words}; {self.kind.written}" if self.kind.written else words

    def to_library(self, value: Any) -> Any:
        """The value as the library takes it: angles in radians."""
        return _each(math.radians, value) if self.in_degrees else value


# What the command line and the rig file say otherwise of a field than its class does.
SAID_OTHERWISE: dict[str, dict[str, Any]] = {
    "fov": {"default": None, "unless_given": "36x24, or the site's own"},
    "threshold": {"section": "cameras"},
    "min_baseline": {"section": "constraints"},
    "resolution": {"option": "pixels"},
    "depth_axis": {"unless_given": "the axis of the ring"},
    "depth_of_field": {"kind": RANGE},
    "grain": {"unless_given": "two pixels at the focus"},
    "focus_distance": {"unless_given": "that of the focus"},
    "zero_towards": {"unless_given": "+x, turned with the axis"},
    "roll": {
        "choices": ("radial", "tangential", "free"),
        "meaning": "How each sensor is turned about its optical axis: radial, with the height of its image towards the "
        "ring's axis; tangential, a quarter turn from that; or free, each as is best for the layout.",
    },
}  # fmt: skip
BESIDE_CLASSES = (
    Option(
        "roll_deg", "ring", NUMBER, None,
        "Ring angle along which the width of every image lies, one direction in space for all sensors [degrees].",
        "as roll says",
    ),
    Option("count", "cameras", WHOLE, 4, "Number of cameras.", option="cameras"),
    Option(
        "seed", "search", WHOLE, 0,
        "Seed of the search, and of simulated images; the same seed gives the same layout and the same images.",
    ),
    Option(
        "give_up", "search", NUMBER, 0.005,
        "Coverage that may be given up for accuracy, as a fraction of the ring maximum: of layouts within so much of "
        "the greatest area, and with no less than equidistant ones, the one with the least error is proposed.",
    ),
    Option("certify", "search", FLAG, True, "Whether to bound what any layout could reconstruct."),
    Option(
        "certify_on", "search", WORD, "auto",
        "What layouts on a grid of angles are bounded on: surface, by exact areas; samples; or auto, surface where "
        "that takes less than half a minute or so.",
        field="certify_on", choices=("auto", "surface", "samples"),
    ),
    Option(
        "exclude", "mesh", WORD, None,
        "Faces that do not count: top (the top surface), none, or a file with one face index per line (of a rig file: "
        "looked for beside it).",
        "top for built-in sites, none for files", choices=("top", "none"),
    ),
    Option("repair", "mesh", FLAG, False, "Whether to put right what can be: mixed winding, surfaces that look away."),
    Option("two_sided", "mesh", FLAG, False, "Whether each face counts from whichever side it is seen, as of a sheet."),
    Option(
        "place", "mesh", WORD, "none",
        "Where the ring stands: none for where focus and axis say; auto for over the opening of the mesh, or the side "
        "of which most is seen, wherever it lies, which says in numbers what focus, axis and zero_towards that is.",
        choices=("auto", "none"),
    ),
    Option("scale", "mesh", NUMBER, 1.0, "Factor from the mesh file's unit to millimetres: 1000 for metres."),
    Option(
        "obstacle", "mesh", FILES, None,
        "Mesh files of what hides the mesh and never counts, such as an instrument [mm] (of a rig file: looked for "
        "beside it).",
    ),
    Option(
        "light", "mesh", POINTS, None,
        "Where light comes from [mm]; what none of the lights shines on does not count.", "all is lit",
    ),
    Option(
        "objective", "sites", WORD, "mean",
        "What one layout for several meshes maximises: the mean of their fractions of the ring maximum, or that of the "
        "worst mesh.",
        choices=("mean", "worst"),
    ),
    Option("site_weights", "sites", WEIGHTS, None, "How much each mesh counts in the mean.", "all equally"),
    Option(
        "falloff_mm", "sites", NUMBER, None,
        "Distance from the focus at which a face counts half, falling off on [mm].", "all count fully",
    ),
    Option(
        "jitter", "poses", WHOLE, 1,
        "Poses of each mesh that the layout is to serve; the mesh as it is comes first.",
    ),
    Option("tilt_deg", "poses", NUMBER, 2.0, "Greatest tilt of the other poses [degrees]."),
    Option("shift_mm", "poses", NUMBER, 1.0, "Greatest shift of the other poses [mm]."),
)  # fmt: skip


def keys(*classes: str) -> dict[str, Option]:
    """Every setting by its name, in the order of a rig file; of the fields only those of `classes`, if any is named.

    The classes are looked up anew by each call, as they are then.

    Examples
    --------
    >>> [one.name for one in keys("Demand").values() if "Demand" in one.classes][:2]
    ['threshold', 'max_disparity_gradient']
    >>> keys()["min_baseline"].classes
    ('Constraints', 'Demand')
    """
    found = {one.name: one for one in BESIDE_CLASSES}
    for name in classes or CLASSES:
        for field in declared(*CLASSES[name]):
            made = _of_field(name, SECTION_OF[name], field)
            known = found.get(made.name)
            found[made.name] = made if known is None else replace(known, classes=(*known.classes, name))
    found["roll_deg"] = found.pop("roll_deg")  # after the word in whose place it stands
    return {one.name: one for section in SECTIONS for one in found.values() if one.section == section}


def sections() -> dict[str, dict[str, Option]]:
    """Every setting by section and name; without sections that hold none.

    Examples
    --------
    >>> list(sections()["cameras"])
    ['count', 'threshold']
    """
    found: dict[str, dict[str, Option]] = {}
    for one in keys().values():
        found.setdefault(one.section, {})[one.name] = one
    return found


def fields_of(name: str, values: dict[str, Any]) -> dict[str, Any]:
    """The fields of a class as the library takes them, of the values by the names of the keys.

    Examples
    --------
    >>> fields_of("Constraints", {"min_separation": 2.0, "min_angle_deg": 180.0, "seed": 3})
    {'min_separation': 2.0, 'min_angle': 3.141592653589793}
    """
    return {
        one.field: one.to_library(values[one.name])
        for one in keys(name).values()
        if name in one.classes and one.name in values
    }


def _of_field(name: str, section: str, field: Declared) -> Option:
    """What the declaration says; an angle is one in degrees, except for the numbers of the search."""
    kind, choices = of_type(field.type)
    in_degrees = name in ON_THE_COMMAND_LINE and "[rad]" in field.words and kind is not WORD
    made = Option(
        f"{field.name}_deg" if in_degrees else field.name,
        section,
        kind,
        _each(lambda angle: round(math.degrees(angle), DIGITS), field.default) if in_degrees else field.default,
        field.words.replace("[rad]", "[degrees]") if in_degrees else field.words,
        classes=(name,),
        field=field.name,
        in_degrees=in_degrees,
        choices=choices,
    )
    return replace(made, **SAID_OTHERWISE.get(field.name, {}))


def _each(change, value: Any) -> Any:
    """`value` with each number changed, in (nested) tuples too; None stays."""
    if value is None:
        return None
    return tuple(_each(change, one) for one in value) if isinstance(value, list | tuple) else change(value)
