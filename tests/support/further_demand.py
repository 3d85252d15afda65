"""A demand of another program, with a field more: a baseline in centimetres."""

from dataclasses import dataclass

import exact.demand


@dataclass(frozen=True)
class Demand(exact.demand.Demand):
    """What makes a point count, with a chord in another unit.

    Parameters
    ----------
    min_chord_cm : float
        Least chord between some two of the cameras that see a point [cm].
    """

    min_chord_cm: float = 0.0

    @property
    def baseline(self):
        """The stricter of both."""
        return max(self.min_baseline, 10 * self.min_chord_cm)
