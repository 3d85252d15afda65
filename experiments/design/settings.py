"""What of a request can be changed on the page: its name, unit and range there, and where it stands in a `Design`."""

import math
from dataclasses import dataclass, replace
from typing import Any

from experiments.design.design import MOST_CAMERAS, Design
from experiments.files.errors import InputError

# How far a slider goes to either side of what it stands at in the beginning, as a factor.
REACH = 3.0
# What starts at nothing, or counts: sliders for these always go from end to end.
FROM_NOTHING = ("threshold", "min_separation", "min_baseline", "min_angle")
# What no number of a request is above; the classes that take it refuse what makes no sense below that.
LARGEST = 1e7
# What limits begin with once there is to be one.
LIKELY = {
    "max_error": 0.2, "max_disparity_gradient": 0.5, "max_incidence": 80.0, "min_pixel_density": 200.0, "max_blur": 5.0,
}  # fmt: skip


@dataclass(frozen=True)
class Setting:
    """One number of a request.

    Attributes
    ----------
    name : str
        Of the setting, as messages of the page call it.
    label, unit : str
        For people.
    part : {"ring", "demand", "limits", "constraints"}
        Which part of a design holds it.
    field : str
        Its name there.
    index : int or None
        Its place, where the field is a pair.
    span : (float, float)
        Ends of its slider, where it has no value to begin with.
    step : float
        Of the slider.
    optional : bool
        Whether there may be none.
    factor : float
        From the unit of the page to that of the design.
    """

    name: str
    label: str
    unit: str
    part: str
    field: str
    span: tuple[float, float]
    step: float
    index: int | None = None
    optional: bool = False
    factor: float = 1.0

    def value(self, design: Design) -> float | None:
        """What it is in a design, in the unit of the page."""
        found = getattr(_part(design, self.part), self.field)
        if found is not None and self.index is not None:
            found = found[self.index]
        if found is None or found >= LARGEST or (self.index == 0 and self.optional and found == 0):
            return None
        return found if isinstance(found, int) else round(found / self.factor, 9)

    def put(self, design: Design, value: float | None) -> Design:
        """The design with another value, in the unit of the page; None for none.

        Raises
        ------
        InputError, exact.ExactError, placement.PlacementError
            If it makes no sense, or the cameras do not meet the constraints then.
        """
        if value is None and not self.optional:
            raise InputError(f"{self.label} needs a number [{self.unit or '1'}]")
        if value is not None and not (isinstance(value, int | float) and abs(value) <= LARGEST):
            raise InputError(f"{self.label} is {value!r}; it must be a number, at most {LARGEST:g}")
        if self.field == "threshold":
            value = int(value) if value is not None and float(value).is_integer() else value
        elif value is not None:
            value = value * self.factor
        part = _part(design, self.part)
        new: Any = value if self.index is None else self._pair(getattr(part, self.field), value)
        changed = replace(part, **{self.field: new})
        if self.part == "limits":
            return replace(design, demand=replace(design.demand, limits=changed))
        return replace(design, **{self.part: changed})

    def _pair(self, pair: tuple[float, float] | None, value: float | None) -> tuple[float, float] | None:
        """The pair with another value; without either of its values there is none."""
        ends = list((0.0, LARGEST) if pair is None else pair)
        ends[self.index or 0] = (0.0, LARGEST)[self.index or 0] if value is None else value
        return None if tuple(ends) == (0.0, LARGEST) else (ends[0], ends[1])

    def described(self, first: Design) -> dict[str, Any]:
        """For the page: its slider goes to either side of what it is in the design that it begins with."""
        least, most = self.span
        start = self.value(first)
        needs = ""
        if self.field == "max_blur" and first.demand.optics.pupil is None:
            needs = "the pupil of the optics is not known; start camring design with --pupil, as in --pupil 1.5"
        if start and not self.optional and self.field not in FROM_NOTHING:
            least, most = start / REACH, start * REACH
        return {
            "name": self.name, "label": self.label, "unit": self.unit, "least": _rounded(least, self.step),
            "most": _rounded(most, self.step), "step": self.step, "optional": self.optional, "needs": needs,
            "likely": self._likely(first),
        }  # fmt: skip

    def _likely(self, first: Design) -> float | None:
        """What a limit begins with once there is to be one."""
        if self.field == "depth_of_field":
            return _rounded(first.ring.working_distance * (0.95, 1.05)[self.index or 0], self.step)
        return LIKELY.get(self.field)


SETTINGS = {
    one.name: one
    for one in (
        Setting("diameter", "ring diameter", "mm", "ring", "diameter", (5.0, 120.0), 0.5),
        Setting("working_distance", "working distance", "mm", "ring", "working_distance", (50.0, 1000.0), 1.0),
        Setting("fov_width", "field of view, along the ring", "mm", "ring", "fov", (10.0, 200.0), 0.5, index=0),
        Setting("fov_height", "field of view, towards its axis", "mm", "ring", "fov", (10.0, 200.0), 0.5, index=1),
        Setting("threshold", "views that a point needs", "", "demand", "threshold", (1, min(8, MOST_CAMERAS)), 1),
        Setting("min_separation", "separation of any two cameras", "mm", "constraints", "min_separation", (0, 30), 0.1),
        Setting("min_baseline", "baseline of some two views", "mm", "demand", "min_baseline", (0.0, 30.0), 0.1),
        Setting(
            "min_angle", "angle of some two rays", "°", "constraints", "min_angle", (0.0, 10.0), 0.05,
            factor=math.pi / 180,
        ),
        Setting("max_error", "greatest error", "mm", "demand", "max_error", (0.01, 1.0), 0.005, optional=True),
        Setting(
            "max_disparity_gradient", "disparity gradient of some two views", "", "demand", "max_disparity_gradient",
            (0.05, 5.0), 0.05, optional=True,
        ),
        Setting(
            "max_incidence", "greatest angle from the normal", "°", "limits", "max_incidence", (10.0, 89.0), 0.5,
            optional=True, factor=math.pi / 180,
        ),
        Setting(
            "min_pixel_density", "least pixel density", "px/mm²", "limits", "min_pixel_density", (10.0, 20000.0), 10.0,
            optional=True,
        ),
        Setting("max_blur", "greatest blur", "px", "limits", "max_blur", (0.5, 20.0), 0.5, optional=True),
        Setting(
            "depth_near", "sharp from a depth of", "mm", "limits", "depth_of_field", (50.0, 1000.0), 1.0, index=0,
            optional=True,
        ),
        Setting(
            "depth_far", "sharp to a depth of", "mm", "limits", "depth_of_field", (50.0, 1000.0), 1.0, index=1,
            optional=True,
        ),
    )
}  # fmt: skip


def _part(design: Design, name: str) -> Any:
    return design.demand.limits if name == "limits" else getattr(design, name)


def _rounded(value: float, step: float) -> float:
    return round(round(value / step) * step, 6)
