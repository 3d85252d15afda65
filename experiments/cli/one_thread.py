"""Linear algebra in one thread: its products are small here, and threads of it wait for each other and for workers."""

import os
from collections.abc import MutableMapping


def calculate_in_one_thread(environment: MutableMapping[str, str] = os.environ) -> None:
    """Tell numpy's linear algebra, which must not be imported yet; whoever has set a number of threads decides instead.

    Examples
    --------
    >>> environment = {"OMP_NUM_THREADS": "4"}
    >>> calculate_in_one_thread(environment)
    >>> environment["OPENBLAS_NUM_THREADS"], environment["OMP_NUM_THREADS"]
    ('1', '4')
    """
    for library in ("OPENBLAS", "OMP", "MKL"):
        environment.setdefault(f"{library}_NUM_THREADS", "1")
