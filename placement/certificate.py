"""A proven upper bound for any layout, and the gap to it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Certificate:
    """Placeholder filled in below."""
