"""Moves on samples of cameras that each have a ring angle and a roll: one at a time, and two at once."""

import itertools
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

import exact
from placement.layouts.arcs import LayoutSpace
from placement.samples.rolled_samples import HALF_TURN, RolledSamples, RolledViews
from placement.samples.value import Value, value_of_one
from placement.samples.viewed_samples import ViewedSamples

# Ring angles and rolls a single camera may be moved to, and two at once: steps of 5° and 7.5°, of 15° and 15°.
N_ANGLES, N_ROLLS = 72, 24
N_PAIR_ANGLES, N_PAIR_ROLLS = 24, 12
# A gain smaller than this part of all weight is rounding of single precision.
WORTHWHILE = 1e-6


class RolledLayout(NamedTuple):
    """M cameras of a ring."""

    angles: Float[np.ndarray, " M"]
    """Ring angles [rad]."""
    rolls: Float[np.ndarray, " M"]
    """As `exact.Ring.cameras` takes them [rad]."""


class RolledCoverage:
    """Which part of the samples layouts with rolls reconstruct, and how accurately.

    Parameters
    ----------
    samples : RolledSamples
    demand : exact.Demand
        What makes a point count.
    n_angles, n_rolls : int
        Of the grid that single cameras are moved on.
    """

    def __init__(self, samples: RolledSamples, demand: exact.Demand, n_angles: int = N_ANGLES, n_rolls: int = N_ROLLS):
        self.samples, self.demand = samples, demand
        self._angles, self._rolls = (
            turn * np.arange(n) / n for turn, n in ((2 * np.pi, n_angles), (HALF_TURN, n_rolls))
        )
        self._viewed = ViewedSamples(samples.profiles, demand, samples.ring)
        self._least_gain = WORTHWHILE * float(samples.weights.sum())
        self._at: dict[float, RolledViews] = {}

    @cached_property
    def grid(self) -> RolledViews:
        """Where a single camera may be moved."""
        return self.samples.views(self._angles, self._rolls)

    def at(self, angle: float) -> RolledViews:
        """A camera that stays where it is, at all rolls of the grid."""
        if angle not in self._at:
            self._at[angle] = self.samples.views(np.array([angle]), self._rolls)
        return self._at[angle]

    def worth(self, layout: RolledLayout) -> float:
        """Weight of the samples that a layout reconstructs; of several sums the least and a little of their mean."""
        return self._viewed.worth(self.samples.seen(*layout), layout.angles)

    def fraction(self, layout: RolledLayout) -> float:
        """Weight of the samples that a layout reconstructs; the least of several sums."""
        return self._viewed.fraction(self.samples.seen(*layout), layout.angles)

    def error(self, layout: RolledLayout) -> float:
        """Root mean square of the predicted errors over the samples that a layout reconstructs [mm]; inf for none."""
        return self._viewed.error(self.samples.seen(*layout), layout.angles)

    def improved(
        self,
        space: LayoutSpace,
        layout: RolledLayout,
        max_sweeps: int = 10,
        value: Value | None = None,
        near: tuple[Float[np.ndarray, " A"], Float[np.ndarray, " R"]] | None = None,
    ) -> RolledLayout:
        """Move one camera at a time to its best place and roll until no move gains anything; fixed ones turn only.

        Parameters
        ----------
        space : LayoutSpace
            What is allowed; the layout stays in it.
        layout : RolledLayout
        max_sweeps : int
            Times each camera is tried at most.
        value : callable, optional
            From worths and errors (C,) to what is to be made great; worths alone unless given.
        near : (A,) and (R,) ndarray, optional
            Steps of angle and of roll from where a camera is, instead of the grid [rad].
        """
        theta, rolls = layout.angles.copy(), layout.rolls.copy()
        seen, free = self.samples.seen(theta, rolls), set(space.free_cameras(theta).tolist())
        best = self._value(theta, seen, value)
        least_gain = self._least_gain if value is None else 1e-9
        for _ in range(max_sweeps):
            before = best
            for camera in range(len(theta)):
                others = np.delete(np.arange(len(theta)), camera)
                views = self._places(theta[camera], rolls[camera], camera in free, near)
                found = self._with_one_more(theta[others], seen[others], views, value)
                if camera in free:
                    found[~space.allowed(views.angles, theta[others])] = -np.inf
                at = int(found.argmax())
                if found[at] > best + least_gain:
                    best = float(found[at])
                    theta[camera], rolls[camera], seen[camera] = (
                        views.angles[at],
                        views.rolls[at],
                        views.seen[:, at] > 0,
                    )
            if best <= before + least_gain:
                break
        return RolledLayout(theta, rolls)

    def improved_by_pairs(self, space: LayoutSpace, layout: RolledLayout, max_sweeps: int = 2) -> RolledLayout:
        """Move two free cameras at once, then each alone, until nothing is gained; leaves most local optima.

        With a baseline or a bound on error or disparity only single cameras are moved.
        """
        layout = self.improved(space, layout)
        if not self.demand.is_count:
            return layout
        half_gap = np.sin(space.minimum_gap / 2)
        angles = self._pair_grid.angles
        apart = np.abs(np.sin((angles[:, None] - angles[None, :]) / 2)) >= half_gap
        for _ in range(max_sweeps):
            before = self.worth(layout)
            for pair in itertools.combinations(space.free_cameras(layout.angles).tolist(), 2):
                others = np.delete(np.arange(len(layout.angles)), pair)
                fits = space.allowed(angles, layout.angles[others])
                worths = self._with_two_more(RolledLayout(layout.angles[others], layout.rolls[others]))
                worths = np.where(apart & fits[:, None] & fits[None, :], worths, -np.inf)
                best = np.unravel_index(worths.argmax(), worths.shape)
                if worths[best] > self.worth(layout) + self._least_gain:
                    moved = RolledLayout(layout.angles.copy(), layout.rolls.copy())
                    moved.angles[list(pair)], moved.rolls[list(pair)] = (
                        angles[list(best)],
                        self._pair_grid.rolls[list(best)],
                    )
                    layout = self.improved(space, moved)
            if self.worth(layout) <= before + self._least_gain:
                break
        return layout

    @cached_property
    def _pair_grid(self) -> RolledViews:
        angles, rolls = (
            2 * np.pi * np.arange(N_PAIR_ANGLES) / N_PAIR_ANGLES,
            HALF_TURN * np.arange(N_PAIR_ROLLS) / N_PAIR_ROLLS,
        )
        return self.samples.views(angles, rolls)

    def _places(self, angle: float, roll: float, is_free: bool, near) -> RolledViews:
        if near is not None:
            return self.samples.views(angle + near[0] if is_free else np.array([angle]), roll + near[1])
        return self.grid if is_free else self.at(float(angle))

    def _value(self, theta: np.ndarray, seen: Bool[np.ndarray, "M N"], value: Value | None) -> float:
        worth = self._viewed.worth(seen, theta)
        if value is None:
            return worth
        return value_of_one(value, worth, self._viewed.error(seen, theta))

    def _with_one_more(
        self, theta: np.ndarray, seen: Bool[np.ndarray, "M N"], views: RolledViews, value: Value | None
    ) -> Float[np.ndarray, " C"]:
        """(C,) value of the cameras with one more, at each of the views."""
        if value is not None:
            return value(*self._viewed.measured_with_one_more(seen, theta, views.seen, views.angles))
        return self._viewed.worth_with_one_more(seen, theta, views.seen, views.angles)

    def _with_two_more(self, layout: RolledLayout) -> Float[np.ndarray, "C C"]:
        """(C, C) worth of the cameras and two more at views of the coarse grid."""
        seen = (
            self.samples.seen(*layout) if len(layout.angles) else np.zeros((0, len(self.samples.weights)), dtype=bool)
        )
        return self._viewed.worth_with_two_more(seen, self._pair_grid.seen)
