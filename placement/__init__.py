"""Where the cameras of a ring should sit.

Importing this package switches JAX to double precision (`jax_enable_x64`) for the whole process: layouts are
compared to 1e-9 rad, and single precision would move them.
"""

import jax

jax.config.update("jax_enable_x64", True)

from placement.certificate import Certificate  # noqa: E402 - after the switch to double precision
from placement.constraints import Constraints  # noqa: E402
from placement.errors import PlacementError  # noqa: E402
from placement.jitter import jitter  # noqa: E402
from placement.optimise import certify, optimise, place  # noqa: E402
from placement.problem import Problem  # noqa: E402
from placement.recommend import CountResult, Recommendation, recommend, recommend_count  # noqa: E402
from placement.results import Candidate, Placement, SearchRecord, SiteResult  # noqa: E402
from placement.robustness import Consensus, Pair, Robustness, consensus, robustness  # noqa: E402
from placement.settings import Settings  # noqa: E402
from placement.sites import falloff  # noqa: E402
from placement.triangulation import Triangulation, triangulation  # noqa: E402

__all__ = [
    "Candidate",
    "Certificate",
    "Consensus",
    "Constraints",
    "CountResult",
    "Pair",
    "Placement",
    "PlacementError",
    "Problem",
    "Recommendation",
    "Robustness",
    "SearchRecord",
    "Settings",
    "SiteResult",
    "Triangulation",
    "certify",
    "consensus",
    "falloff",
    "jitter",
    "optimise",
    "place",
    "recommend",
    "recommend_count",
    "robustness",
    "triangulation",
]
