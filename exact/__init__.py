"""Exact T-view areas: the part of a triangle mesh that at least T pinhole cameras see, to rounding."""

from typing import TYPE_CHECKING

from exact.on_demand import import_on_demand

if TYPE_CHECKING:
    from exact.cameras import Camera
    from exact.demand import Demand
    from exact.derivative.derivative import Derivative
    from exact.derivative.gradient import Gradient, gradient
    from exact.derivative.on_ring import RingDerivative
    from exact.drawing import NOT_COUNTED, seen_from
    from exact.errors import ExactError
    from exact.evaluate import areas, evaluate
    from exact.one_more import OneMore, OneMoreView
    from exact.results import Reconstruction
    from exact.ring import Ring
    from exact.scene import Scene
    from exact.usable.limits import Limits
    from exact.usable.optics import Optics
    from exact.view_sets import ViewSets, view_sets
    from exact.visibility.view import View, view

__all__ = [
    "NOT_COUNTED",
    "Camera",
    "Demand",
    "Derivative",
    "ExactError",
    "Gradient",
    "Limits",
    "OneMore",
    "OneMoreView",
    "Optics",
    "Reconstruction",
    "Ring",
    "RingDerivative",
    "Scene",
    "View",
    "ViewSets",
    "areas",
    "evaluate",
    "gradient",
    "seen_from",
    "view",
    "view_sets",
]

import_on_demand(__name__)
