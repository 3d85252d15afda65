"""Where the cameras of a ring should sit.

A search switches JAX to double precision (`jax_enable_x64`) for the whole process: layouts are compared to 1e-9 rad,
and single precision would move them. What does not search does not import JAX.
"""

from typing import TYPE_CHECKING

from exact.on_demand import import_on_demand

if TYPE_CHECKING:
    from placement.errors import PlacementError
    from placement.exact_area import exact_area
    from placement.jitter import jitter
    from placement.layouts.constraints import Constraints
    from placement.optimise import certify, optimise, place, recommend_count, tradeoff
    from placement.pairs import Pair
    from placement.problem import Problem
    from placement.proof.certificate import Certificate
    from placement.proof.surface_bound import SurfaceBound
    from placement.recommend import CountResult, Recommendation, recommend
    from placement.results import Candidate, Placement, SearchRecord, SiteResult
    from placement.rings.optimise_rings import optimise_rings
    from placement.rings.rings_bound import RingsBound
    from placement.rings.rings_placement import OneRing, RingsCandidate, RingsPlacement
    from placement.robustness import Consensus, Robustness, consensus, robustness
    from placement.search.equidistant import best_equidistant_phase
    from placement.search.refined_ring import RefinedRing, refine_ring
    from placement.settings import Settings
    from placement.sites import falloff
    from placement.surrogate.surrogate import soft_coverage
    from placement.trade_off import TradedLayout, TradeOff
    from placement.triangulation import Triangulation, triangulation

__all__ = [
    "Candidate",
    "Certificate",
    "Consensus",
    "Constraints",
    "CountResult",
    "OneRing",
    "Pair",
    "Placement",
    "PlacementError",
    "Problem",
    "Recommendation",
    "RefinedRing",
    "RingsBound",
    "RingsCandidate",
    "RingsPlacement",
    "Robustness",
    "SearchRecord",
    "Settings",
    "SiteResult",
    "SurfaceBound",
    "TradeOff",
    "TradedLayout",
    "Triangulation",
    "best_equidistant_phase",
    "certify",
    "consensus",
    "exact_area",
    "falloff",
    "jitter",
    "optimise",
    "optimise_rings",
    "place",
    "recommend",
    "recommend_count",
    "refine_ring",
    "robustness",
    "soft_coverage",
    "tradeoff",
    "triangulation",
]

import_on_demand(__name__)
