"""Exact T-view areas: the part of a triangle mesh that at least T pinhole cameras see, to rounding."""

from exact.cameras import Camera, Ring
from exact.drawing import NOT_COUNTED, seen_from
from exact.errors import ExactError
from exact.evaluate import evaluate, view
from exact.results import Reconstruction, View

__all__ = ["NOT_COUNTED", "Camera", "ExactError", "Reconstruction", "Ring", "View", "evaluate", "seen_from", "view"]
