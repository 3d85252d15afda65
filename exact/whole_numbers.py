"""What counts as a whole number wherever a request gives one."""

import math

import numpy as np


def is_whole(number) -> bool:
    """Whether it is a whole number: of any type, and neither nan nor infinite.

    Examples
    --------
    >>> is_whole(2), is_whole(2.0), is_whole(2.5), is_whole(float("nan")), is_whole("2")
    (True, True, False, False, False)
    """
    return bool(isinstance(number, int | float | np.number) and -math.inf < number < math.inf and number == int(number))
