"""A rig as JSON holds it, for tasks that are done elsewhere."""

from dataclasses import asdict
from typing import Any

import exact
import placement
from experiments.request.rig import Rig
from experiments.request.simulation import Simulation


def rig_content(rig: Rig) -> dict[str, Any]:
    """All of a rig in numbers, words, lists and dicts, which `rig_of` understands."""
    return asdict(rig)


def rig_of(content: dict[str, Any]) -> Rig:
    """The rig that `rig_content` has described, whether or not that went through JSON.

    Examples
    --------
    >>> import json
    >>> from experiments.request.rig import rig
    >>> asked = rig(fixed_deg="0,90", depth_of_field="380:420", light="0,0,400", roll_deg=5.0)
    >>> rig_of(json.loads(json.dumps(rig_content(asked)))) == asked
    True
    """
    values = {name: _tuples(value) for name, value in content.items()}
    demand = values["demand"] | {
        "limits": exact.Limits(**values["demand"]["limits"]), "optics": exact.Optics(**values["demand"]["optics"])
    }  # fmt: skip
    parts = {
        "demand": exact.Demand(**demand),
        "constraints": placement.Constraints(**values["constraints"]),
        "settings": placement.Settings(**values["settings"]),
        "simulation": Simulation(**values["simulation"]),
    }
    return Rig(**values | parts)


def _tuples(value: Any) -> Any:
    """Lists as tuples, inside dicts and tuples too."""
    if isinstance(value, dict):
        return {name: _tuples(one) for name, one in value.items()}
    return tuple(_tuples(one) for one in value) if isinstance(value, list | tuple) else value
