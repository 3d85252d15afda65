"""Exact T-view areas: the part of a triangle mesh that at least T pinhole cameras see, to rounding."""

from exact.cameras import Camera, Ring
from exact.errors import ExactError

__all__ = ["Camera", "ExactError", "Ring"]
