"""Where the cameras of a ring should sit.

Importing this package switches JAX to double precision (`jax_enable_x64`) for the whole process: layouts are
compared to 1e-9 rad, and single precision would move them.
"""

import jax

jax.config.update("jax_enable_x64", True)

from placement.certificate import Certificate, certify  # noqa: E402 - after the switch to double precision
from placement.constraints import Constraints  # noqa: E402
from placement.errors import PlacementError  # noqa: E402
from placement.optimise import optimise  # noqa: E402
from placement.results import Candidate, Placement, SearchRecord  # noqa: E402
from placement.settings import Settings  # noqa: E402
from placement.triangulation import Triangulation, triangulation  # noqa: E402

__all__ = [
    "Candidate",
    "Certificate",
    "Constraints",
    "Placement",
    "PlacementError",
    "SearchRecord",
    "Settings",
    "Triangulation",
    "certify",
    "optimise",
    "triangulation",
]
