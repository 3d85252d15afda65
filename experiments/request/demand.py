"""What makes a point count, where options change what a file says."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import exact
from exact.requests import demand_keywords


def overridden(demand: exact.Demand, options: Mapping[str, Any]) -> exact.Demand:
    """The same with what options give; None for one that was not given.

    Raises
    ------
    ExactError
        If a value makes no sense.

    Examples
    --------
    >>> overridden(exact.Demand(2, 8.0), {"threshold": 3, "min_baseline": None, "fov": "36x24"})
    Demand(threshold=3, min_baseline=8.0)
    """
    given = {name: options[name] for name in demand_keywords() if options.get(name) is not None}
    return replace(demand, **given)
