"""One state of what is designed: a ring, what makes a point count, and where the cameras sit."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

import exact
import placement
from exact.demand import SAME_LENGTH
from experiments.files.errors import InputError
from experiments.layouts import layout_content, layout_file
from placement.layouts.constraints import GAP_MARGIN, demanded, on_ring
from placement.layouts.open_arcs import TURN, open_arcs

# The colours of the page tell that many views apart, and its drawing has a bit for each camera.
MOST_CAMERAS = 24
# Of an angle in degrees, as it is shown.
DIGITS = 3
# A camera of a file is a fixed one if it is this close to the angle given for that [rad].
SAME_ANGLE = 1e-9


@dataclass(frozen=True)
class Design:
    """A ring with its cameras, and what is asked of them.

    Parameters
    ----------
    ring : exact.Ring
    demand : exact.Demand
        What makes a point count, beside what the constraints ask for.
    constraints : placement.Constraints
        Without fixed cameras, which `fixed` tells.
    angles : tuple of float
        Ring angles in [0, 2 pi) [rad].
    fixed : tuple of bool
        Whether each camera stays where it is.

    Raises
    ------
    InputError, placement.PlacementError, exact.ExactError
        If the cameras break the constraints, or nothing can count.

    Examples
    --------
    >>> design = Design.of(exact.Ring(), exact.Demand(), placement.Constraints(), [0.0, 1.0, 3.0])
    >>> round(design.moved(1, 0.1).angles[1], 3)  # 5 mm from the first is as near as it gets
    0.335
    >>> len(design.with_one_more().angles), design.without(0).angles
    (4, (1.0, 3.0))
    """

    ring: exact.Ring
    demand: exact.Demand
    constraints: placement.Constraints
    angles: tuple[float, ...]
    fixed: tuple[bool, ...]

    def __post_init__(self):
        if self.ring.roll == "free":
            raise InputError("the designer turns sensors as the ring says; give them --roll radial or tangential")
        if len(self.angles) > MOST_CAMERAS:
            raise InputError(f"there are {len(self.angles)} cameras; the designer takes at most {MOST_CAMERAS}")
        broken = self.limits.violations(self.ring, self.angles)
        if broken:
            raise InputError(f"the cameras do not meet the constraints: {broken[0]}; move them, or ask for less")
        self.whole.refuse_fewer(len(self.angles))

    @staticmethod
    def of(
        ring: exact.Ring, demand: exact.Demand, constraints: placement.Constraints, angles: Sequence[float]
    ) -> "Design":
        """A design whose fixed cameras are those that the constraints name [rad]."""
        theta = np.mod(np.asarray(angles, dtype=np.float64), TURN)
        away = np.abs(np.sin((theta[:, None] - np.array(constraints.fixed)[None, :]) / 2))
        fixed, there = (np.any(away < SAME_ANGLE, axis=axis) for axis in (1, 0))
        missing = np.degrees(np.array(constraints.fixed)[~there])
        if len(missing):
            raise InputError(f"no camera sits at the fixed angle of {missing[0]:g} degrees; put one there")
        # A baseline may be asked for in two places; where the page changes it, there must be one.
        demand = replace(demand, min_baseline=max(demand.min_baseline, constraints.min_baseline))
        free = replace(constraints, fixed=(), min_baseline=0.0)
        return Design(ring, on_ring(demand, ring), free, tuple(theta.tolist()), tuple(fixed.tolist()))

    @cached_property
    def limits(self) -> placement.Constraints:
        """The constraints with the fixed cameras at their angles."""
        fixed = tuple(angle for angle, stays in zip(self.angles, self.fixed, strict=True) if stays)
        return replace(self.constraints, fixed=fixed)

    @cached_property
    def whole(self) -> exact.Demand:
        """What makes a point count, with the baseline that the constraints ask for."""
        return on_ring(demanded(self.demand, self.constraints, self.ring), self.ring)

    @property
    def equidistant(self) -> tuple[float, ...]:
        """The equidistant layout of as many cameras [rad], which may break the constraints."""
        return tuple(self.ring.equidistant(len(self.angles)).tolist())

    def room(self, without: int | None = None) -> np.ndarray:
        """Arcs (A, 2) [rad] in which one camera more may sit, or the one `without` which there is room."""
        gap = self.constraints.minimum_gap(self.ring) + GAP_MARGIN
        others = tuple(angle for number, angle in enumerate(self.angles) if number != without)
        if not others and not self.constraints.forbidden:
            return np.array([[0.0, TURN]])
        return open_arcs(replace(self.constraints, fixed=others), gap)

    def moved(self, camera: int, angle: float) -> "Design":
        """The same with one camera as near to an angle [rad] as the others let it."""
        if self.fixed[camera]:
            raise InputError(f"camera {camera + 1} is fixed; let it go first")
        place = _nearest(self.room(camera), angle)
        return replace(self, angles=(*self.angles[:camera], place, *self.angles[camera + 1 :]))

    def with_one_more(self, angle: float | None = None) -> "Design":
        """The same with one camera more, as near to an angle [rad] as may be, or in the middle of the widest gap."""
        arcs = self.room()
        if not len(arcs):
            raise InputError(
                f"there is no room for another camera at {self.constraints.min_separation:g} mm; take a wider ring, "
                "or a smaller separation"
            )
        widest = arcs[np.argmax(arcs[:, 1] - arcs[:, 0])]
        place = _nearest(arcs, float(widest.mean()) if angle is None else angle)
        return replace(self, angles=(*self.angles, place), fixed=(*self.fixed, False))

    def without(self, camera: int) -> "Design":
        """The same without one camera."""
        if self.fixed[camera]:
            raise InputError(f"camera {camera + 1} is fixed; let it go first")
        kept = [number for number in range(len(self.angles)) if number != camera]
        if not kept:
            raise InputError("one camera must be left")
        return replace(
            self, angles=tuple(self.angles[i] for i in kept), fixed=tuple(self.fixed[i] for i in kept)
        )  # fmt: skip

    def holding(self, camera: int, is_fixed: bool) -> "Design":
        """The same with one camera fixed, or let go."""
        return replace(self, fixed=(*self.fixed[:camera], is_fixed, *self.fixed[camera + 1 :]))

    def at(self, angles: Sequence[float]) -> "Design":
        """The same request with cameras elsewhere; those at fixed angles stay fixed."""
        return Design.of(self.ring, self.demand, self.limits, angles)

    def content(self, mesh: dict[str, Any]) -> dict[str, Any]:
        """As it stands in a layout file, which `from_content` and `camring evaluate --layout` read; areas apart."""
        return {
            "format": layout_content.FORMAT,
            "version": layout_content.VERSION,
            "ring": layout_content.ring_content(self.ring),
            "n_cameras": len(self.angles),
            "threshold": self.demand.threshold,
            "demand": asdict(self.demand),
            "angles_deg": np.degrees(self.angles).tolist(),
            "angles_rad": list(self.angles),
            "mesh": mesh,
            "constraints": asdict(self.limits),
        }

    @staticmethod
    def from_layout(made: layout_file.LayoutFile, otherwise: placement.Constraints) -> "Design":
        """The design of a layout file, under constraints of its own or, where it has none, of `otherwise`."""
        if made.rolls is not None:
            raise InputError(
                f"{made.path} gives each camera a roll of its own, which the designer does not know; leave "
                "rolls_deg and rolls_rad out of it"
            )
        kept = made.content.get("constraints") or {}
        known = asdict(otherwise) | {"fixed": (), "min_baseline": 0.0, "min_angle": 0.0} | kept
        constraints = layout_file.constraints_of(known)
        # What the angle asks for is asked by the angle; a file's demand may have it too.
        said = (made.content.get("demand") or {}).get("min_baseline", made.demand.min_baseline)
        implied = replace(constraints, min_baseline=0.0).baseline(made.ring)
        demand = replace(made.demand, min_baseline=0.0 if abs(said - implied) < SAME_LENGTH else said)
        return Design.of(made.ring, demand, constraints, made.angles.tolist())


def _nearest(arcs: np.ndarray, angle: float) -> float:
    """The point of some arcs (A, 2) that is nearest to an angle, in [0, 2 pi) [rad].

    At a whole number of `DIGITS`, so that the angle that is shown is the angle that is meant, where an arc holds one.

    Examples
    --------
    >>> float(np.degrees(_nearest(np.radians([[10.0, 20.0], [40.0, 70.0]]), np.radians(9.0))).round(9))
    10.0
    >>> float(np.degrees(_nearest(np.radians([[10.00025, 20.0]]), np.radians(-30.0))).round(9))
    10.001
    """
    if not len(arcs):
        raise InputError("there is no place on the ring where it may sit; take a wider ring, or a smaller separation")
    low, high = np.degrees(arcs).T
    low, high = _up(low), -_up(-high)
    if (low <= high).any():
        low, high = low[low <= high], high[low <= high]
    else:
        low, high = np.degrees(arcs).T
    wanted = round(float(np.degrees(angle)), DIGITS)
    inside = np.mod(wanted - low, 360.0) <= high - low
    ends = np.concatenate([low, high])
    nearest = ends[np.argmin(np.abs(np.sin(np.radians(ends - wanted) / 2)))]
    return float(np.radians(np.mod(wanted if inside.any() else nearest, 360.0).round(9)))


def _up(degrees: np.ndarray) -> np.ndarray:
    """The next angles of `DIGITS` that are not less [degrees]."""
    scale = 10**DIGITS
    return np.ceil(degrees * scale - 1e-6) / scale
