"""What the page asks for, done: the layouts that are tried, what the hand holds, and what is told of both."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import exact
import placement
from experiments.design.design import MOST_CAMERAS, SAME_ANGLE, Design
from experiments.design.history import History, Numbers, Tried
from experiments.design.settings import SETTINGS
from experiments.files.errors import InputError
from experiments.layouts import layout_file
from experiments.request.rig import Rig
from placement.layouts.arcs import LayoutSpace

# What a message of the page may hold.
LARGEST_ANGLE = 1e4
# Of angles that are shown, half the last digit [rad], and some rounding.
SHOWN = 1e-5
# A layout file has some ten kilobytes.
MOST_TEXT = 500_000


@dataclass(frozen=True)
class Reader:
    """Makes designs of layout files, if they were made for this mesh.

    Attributes
    ----------
    name : str
        Of the mesh.
    mesh : dict
        What a layout file says of the mesh.
    otherwise : placement.Constraints
        Of layout files that have none.
    """

    name: str
    mesh: dict[str, Any]
    otherwise: placement.Constraints

    def design(self, made: layout_file.LayoutFile) -> Design:
        """Of one that is read.

        Raises
        ------
        InputError, placement.PlacementError, exact.ExactError
        """
        if made.made_for and self.mesh["sha256"] not in made.made_for:
            meant = " or ".join(repr(known) for known in dict.fromkeys(made.made_for.values()))
            raise InputError(f"{made.path} was made for {meant}, and this is {self.name}; open it with that mesh")
        return Design.from_layout(made, self.otherwise)


@dataclass
class Session:
    """The state of the page, the same in every window.

    Attributes
    ----------
    reader : Reader
    history : History
    hand : Design or None
        What is dragged, and not tried before it is let go.
    moved : int or None
        The camera that was moved last, and is likely to be moved next.
    why : str
        What to call what the hand holds once it is let go.
    remark : str
        What to say of what was done last, if it is not quite what was asked for.
    """

    reader: Reader
    history: History
    hand: Design | None = None
    moved: int | None = None
    why: str = ""
    remark: str = ""

    @property
    def shown(self) -> Design:
        """What is looked at."""
        return self.history.now.design if self.hand is None else self.hand

    def act(self, message: Any) -> bool:
        """Do what a message of the page asks for; whether layouts that were tried are other ones now.

        Raises
        ------
        InputError, placement.PlacementError, exact.ExactError
            If it is no such message, or what it asks for cannot be; nothing has changed then.
        """
        kind = message.get("do") if isinstance(message, dict) else None
        if not isinstance(kind, str) or kind not in ACTIONS:
            raise InputError("this message is not understood")
        fields, action = ACTIONS[kind]
        if set(message) != {"do", *fields}:
            raise InputError(f"a message {kind!r} has {', '.join(fields) or 'nothing'} beside")
        self.remark = ""
        action(self, *[_checked(self, name, message[name]) for name in fields])
        return kind not in ("drag", "nudge", "turn")

    def try_out(self, design: Design, why: str) -> None:
        """Try a design; what the hand held is let go."""
        self.hand = None
        self.history.add(design, why)

    def state(self) -> dict[str, Any]:
        """What the page shows of the layout that is looked at, in radians and millimetres."""
        design = self.shown
        apart = design.ring.separations(design.angles) + np.where(np.eye(len(design.angles)), np.inf, 0.0)
        return {
            "angles": list(design.angles),
            "fixed": list(design.fixed),
            "forbidden": [list(arc) for arc in design.constraints.forbidden],
            "gap": design.constraints.minimum_gap(design.ring),
            "separation": float(apart.min()) if len(design.angles) > 1 else None,
            "even": list(design.equidistant),
            "even_breaks": design.constraints.violations(design.ring, design.equidistant),
            "positions": design.ring.positions(design.angles).tolist(),
            "settings": {name: setting.value(design) for name, setting in SETTINGS.items()},
            "words": design.whole.words,
            "error_words": error_words(design.whole),
            "held": self.hand is not None,
            "at": self.history.at,
        }

    def tried(self) -> dict[str, Any]:
        """What the page shows of the history."""
        return {
            "tried": [_told(one) for one in self.history.tried.values()],
            "at": self.history.at,
            "can_undo": self.history.can_undo,
            "can_redo": self.history.can_redo,
        }

    def know(self, design: Design, numbers: Numbers) -> bool:
        """Note the exact numbers of a design; whether they are news."""
        return self.history.know(design, numbers)


def nothing_seen(scene: exact.Scene, ring: exact.Ring) -> str:
    """What to do about a mesh of which no camera sees anything that counts."""
    vertices = scene.surface.vertices
    spans = ", ".join(
        f"{axis} from {low:.4g} to {high:.4g}"
        for axis, low, high in zip("xyz", vertices.min(axis=0), vertices.max(axis=0), strict=True)
    )
    focus = ", ".join(f"{part:g}" for part in ring.focus)
    return (
        f"no camera sees any of the surface that counts: it reaches {spans} mm, and the ring looks at ({focus}) from "
        f"{ring.working_distance:g} mm; put the ring over the surface, as --place auto does, or start camring design "
        "with --focus, --axis, --scale or --repair"
    )


def error_words(demand: exact.Demand) -> str:
    """What predicted errors are based on.

    Examples
    --------
    >>> error_words(exact.Demand())
    'Errors are one standard deviation along depth, for matches to 0.5 px on images of 3600 x 2400 px'
    """
    (width, height), noise = demand.optics.resolution, demand.optics.match_noise
    along = "depth" if demand.error == "depth" else "the normal"
    return (
        f"Errors are one standard deviation along {along}, for matches to {noise:g} px on images of {width:g} x "
        f"{height:g} px"
    )


def _told(one: Tried) -> dict[str, Any]:
    numbers = one.numbers
    return {
        "number": one.number, "why": one.why, "angles": list(one.design.angles),
        "fixed": list(one.design.fixed), "diameter": one.design.ring.diameter, "words": one.design.whole.words,
        "area": numbers and numbers.area, "error": numbers and numbers.error,
        "even_area": numbers and numbers.equidistant_area, "even_error": numbers and numbers.equidistant_error,
    }  # fmt: skip


def _drag(session: Session, camera: int, angle: float) -> None:
    if abs(np.sin((angle - session.shown.angles[camera]) / 2)) < SAME_ANGLE:  # a hand on it that has not moved it yet
        session.moved = camera
        return
    session.hand, session.moved = session.shown.moved(camera, angle), camera
    session.why = f"camera {camera + 1} moved"


def _put(session: Session, camera: int, angle: float) -> None:
    design = session.shown.moved(camera, angle)
    there = design.angles[camera]
    if abs(np.sin((there - angle) / 2)) > SHOWN:
        session.remark = (
            f"camera {camera + 1} cannot sit at {np.degrees(angle):g}°: another camera or a forbidden arc is too near; "
            f"the nearest place is {np.degrees(there):.3f}°"
        )
    session.moved = camera
    session.try_out(design, f"camera {camera + 1} moved")


def _nudge(session: Session, camera: int, by: float) -> None:
    _drag(session, camera, session.shown.angles[camera] + by)


def _turn(session: Session, name: str, value: float | None) -> None:
    setting = SETTINGS[name]
    session.hand = setting.put(session.shown, value)
    shown = "none" if value is None else f"{value:g} {setting.unit}".strip()
    session.why = f"{setting.label}: {shown}"


def _drop(session: Session) -> None:
    if session.hand is not None:
        session.try_out(session.hand, session.why)


def _let_go(session: Session) -> None:
    session.hand = None


def _add(session: Session, angle: float | None) -> None:
    design = session.shown.with_one_more(angle)
    session.moved = len(design.angles) - 1
    session.try_out(design, f"camera {len(design.angles)} added")


def _remove(session: Session, camera: int) -> None:
    session.try_out(session.shown.without(camera), f"camera {camera + 1} removed")
    session.moved = None


def _fix(session: Session, camera: int, fixed: bool) -> None:
    session.try_out(session.shown.holding(camera, fixed), f"camera {camera + 1} {'fixed' if fixed else 'let go'}")


def _forbid(session: Session, start: float, end: float) -> None:
    design = session.shown
    arcs = (*design.constraints.forbidden, (start, end))
    words = f"no camera from {np.degrees(start):.1f}° to {np.degrees(end):.1f}°"
    session.try_out(replace(design, constraints=replace(design.constraints, forbidden=arcs)), words)


def _allow(session: Session, arc: int) -> None:
    design = session.shown
    arcs = design.constraints.forbidden
    if arc >= len(arcs):
        raise InputError(f"there is no forbidden arc {arc + 1}")
    kept = (*arcs[:arc], *arcs[arc + 1 :])
    session.try_out(
        replace(design, constraints=replace(design.constraints, forbidden=kept)), "a forbidden arc opened"
    )  # fmt: skip


def _spread(session: Session) -> None:
    design = session.shown
    session.try_out(design.at(design.equidistant), "equidistant")


def _place(session: Session, angles: list[float]) -> None:
    n = len(angles)
    session.try_out(session.shown.at(angles), f"{n} camera{'' if n == 1 else 's'} from a curve")
    session.moved = None


def _step(forward: bool) -> Callable[[Session], None]:
    def step(session: Session) -> None:
        session.hand = None
        _ = session.history.redo() if forward else session.history.undo()

    return step


def _go(session: Session, number: int) -> None:
    session.history.go(number)
    session.hand = None


def _open(session: Session, text: str) -> None:
    made = layout_file.understood(text, Path("the file"))
    session.try_out(session.reader.design(made), "opened from a file")


# What each message asks for: the names of what it holds, and what is done.
ACTIONS: dict[str, tuple[tuple[str, ...], Callable[..., None]]] = {
    "drag": (("camera", "angle"), _drag),
    "put": (("camera", "angle"), _put),
    "nudge": (("camera", "by"), _nudge),
    "turn": (("name", "value"), _turn),
    "drop": ((), _drop),
    "let go": ((), _let_go),
    "add": (("place",), _add),
    "remove": (("camera",), _remove),
    "fix": (("camera", "fixed"), _fix),
    "forbid": (("start", "end"), _forbid),
    "allow": (("arc",), _allow),
    "equidistant": ((), _spread),
    "place": (("angles",), _place),
    "undo": ((), _step(False)),
    "redo": ((), _step(True)),
    "go": (("number",), _go),
    "open": (("text",), _open),
}


def _checked(session: Session, name: str, value: Any) -> Any:
    """A value of a message, if it is what its name says."""
    is_number, is_angle = _is_number(value), _is_angle(value)
    is_count = isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= 10**9
    fits = {
        "camera": is_count and value < len(session.shown.angles),
        "angle": is_angle,
        "by": is_angle,
        "start": is_angle,
        "end": is_angle,
        "place": is_angle or value is None,
        "fixed": isinstance(value, bool),
        "arc": is_count,
        "number": is_count,
        "name": isinstance(value, str) and value in SETTINGS,
        "value": is_number or value is None,
        "angles": isinstance(value, list) and 0 < len(value) <= MOST_CAMERAS and all(map(_is_angle, value)),
        "text": isinstance(value, str) and len(value) <= MOST_TEXT,
    }[name]
    if not fits:
        raise InputError(f"{name} is {repr(value)[:40]}, which it cannot be")
    return value


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _is_angle(value: Any) -> bool:
    return _is_number(value) and abs(value) <= LARGEST_ANGLE  # false of what is not finite


def first_design(ring: exact.Ring, rig: Rig) -> Design:
    """The equidistant layout of a request, or, where it breaks the constraints, one that does not."""
    constraints = rig.constraints
    space = LayoutSpace(ring, rig.n_cameras, constraints)
    even = ring.equidistant(rig.n_cameras)
    angles = even if space.allows(even) else space.random(np.random.default_rng(rig.seed))
    return Design.of(ring, rig.demand, constraints, angles.tolist())
