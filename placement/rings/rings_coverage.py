"""Moves on samples of cameras on several rings: one at a time to any place of any ring, and two at once."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float

import exact
from exact.demand import Criterion
from exact.usable.disparity import plane_gradients
from exact.usable.information import variance
from placement.rings.ring_places import Places, RingsSpace, cameras_of
from placement.rings.rings_samples import RingsSamples
from placement.samples.value import Value, value_of_one
from placement.samples.viewed_samples import worth_of

# Ring angles of each ring that a single camera may be moved to, and two at once: steps of 5° and of 15°.
N_ANGLES, N_PAIR_ANGLES = 72, 24
# A gain smaller than this part of all weight is rounding of single precision.
WORTHWHILE = 1e-6


@dataclass(frozen=True, eq=False)
class Views:
    """What cameras at C places see of N samples, and what they tell about them."""

    samples: RingsSamples
    places: Places

    @cached_property
    def seen(self) -> Float[np.ndarray, "N C"]:
        """1 where seen and 0 elsewhere; single, for matrix products."""
        return self.samples.seen(self.places).T.astype(np.float32)

    @cached_property
    def told(self) -> Float[np.ndarray, "6 N C"]:
        """Information [1/mm²], seen or not."""
        return np.moveaxis(self.samples.told(self.places), 0, -1)


class RingsCoverage:
    """Which part of the samples layouts on several rings reconstruct, and how accurately.

    Parameters
    ----------
    samples : RingsSamples
    space : RingsSpace
        What is allowed.
    demand : exact.Demand
        What makes a point count.
    """

    def __init__(self, samples: RingsSamples, space: RingsSpace, demand: exact.Demand):
        self.samples, self.space, self.demand = samples, space, demand
        n_sums = int(samples.site.max()) + 1
        self._weights = (samples.weights * (samples.site == np.arange(n_sums)[:, None])).astype(np.float32)
        self._least_gain = WORTHWHILE * float(samples.weights.sum())

    @cached_property
    def grid(self) -> Views:
        """Where a single camera may be moved."""
        return self._views(N_ANGLES)

    @cached_property
    def _pair_grid(self) -> Views:
        return self._views(N_PAIR_ANGLES)

    def _views(self, n_angles: int) -> Views:
        return Views(self.samples, Places.grid(len(self.space.rings), n_angles))

    def measured(self, places: Places) -> tuple[float, float]:
        """What a layout is worth, and the root mean square of its predicted errors [mm]; inf for nothing."""
        nowhere, seen = Views(self.samples, places.take([])), self.samples.seen(places)
        worth, error = self._with_one_more(places, seen, nowhere, errors=True)
        return float(worth[0]), float(error[0])

    def worth(self, places: Places) -> float:
        """Weight of the samples that a layout reconstructs; of several sums the least and a little of their mean."""
        if not self.demand.has_derivative:
            return self.measured(places)[0]
        met = Criterion(self.demand.threshold, self._far(places, places)).enough(self.samples.seen(places).T)
        return float(worth_of((self._weights @ met.astype(np.float32)).astype(np.float64)))

    def improved(
        self, places: Places, max_sweeps: int = 10, value: Value | None = None, near: np.ndarray | None = None
    ) -> Places:
        """Move one free camera at a time to its best place on any ring until no move gains anything.

        Parameters
        ----------
        places : Places
            A layout of the space; what comes out is one too.
        max_sweeps : int
            Times each camera is tried at most.
        value : callable, optional
            From worths and errors (C,) to what is to be made great; worths alone unless given.
        near : (A,) ndarray, optional
            Steps along its ring from where a camera is, instead of all places [rad].
        """
        seen = self.samples.seen(places)
        best = value_of_one(value, *self.measured(places)) if value else self.worth(places)
        least_gain = self._least_gain if value is None else 1e-9
        for _ in range(max_sweeps):
            before = best
            for camera in self.space.free(places).tolist():
                others = np.delete(np.arange(len(seen)), camera)
                held, views = places.take(others), self._around(places, camera, near)
                found = self._value(*self._with_one_more(held, seen[others], views, errors=value is not None), value)
                found = np.where(self.space.allowed(views.places, held), found, -np.inf)
                at = int(found.argmax())
                if found[at] > best + least_gain:
                    best = float(found[at])
                    ring, angles = places.ring.copy(), places.angles.copy()
                    ring[camera], angles[camera] = (one[at] for one in views.places)
                    places, seen[camera] = Places(ring, angles), views.seen[:, at] > 0
            if best <= before + least_gain:
                break
        return places

    def improved_by_pairs(self, places: Places, max_sweeps: int = 2) -> Places:
        """Move two free cameras at once, from any rings to any, then each alone, until nothing is gained.

        With a baseline or a bound on error or disparity only single cameras are moved.
        """
        places = self.improved(places)
        if not self.demand.is_count:
            return places
        grid = self._pair_grid
        n_rings, ring = len(self.space.rings), grid.places.ring
        apart = self.space.far_enough(grid.places, grid.places)
        for _ in range(max_sweeps):
            before = self.worth(places)
            for pair in itertools.combinations(self.space.free(places).tolist(), 2):
                held = places.take(np.delete(np.arange(len(places.ring)), pair))
                fits = self.space.allowed(grid.places, held)
                # A ring that takes one camera more takes no two.
                two = (np.bincount(held.ring, minlength=n_rings) + 2 <= self.space.most)[ring]
                together = apart & fits[:, None] & fits[None, :] & (two[:, None] | (ring[:, None] != ring[None, :]))
                worths = np.where(together, self._with_two_more(held), -np.inf)
                at = np.unravel_index(worths.argmax(), worths.shape)
                if worths[at] > self.worth(places) + self._least_gain:
                    places = self.improved(Places.joined([held, grid.places.take(list(at))]))
            if self.worth(places) <= before + self._least_gain:
                break
        return places

    def _around(self, places: Places, camera: int, near: np.ndarray | None) -> Views:
        """Where a camera may be moved."""
        if near is None:
            return self.grid
        return Views(self.samples, Places.on(int(places.ring[camera]), places.angles[camera] + near))

    @staticmethod
    def _value(worth: np.ndarray, error: np.ndarray, value: Value | None) -> np.ndarray:
        return worth if value is None else value(worth, error)

    def _far(self, places: Places, others: Places) -> Bool[np.ndarray, "M O"] | None:
        """Pairs that are a baseline apart; None where any two will do."""
        return None if self.demand.baseline == 0 else self.demand.apart(self.space.distances(places, others))

    def _with_one_more(
        self, places: Places, seen: Bool[np.ndarray, "M N"], views: Views, errors: bool
    ) -> tuple[Float[np.ndarray, " C"], Float[np.ndarray, " C"]]:
        """(C,) worth, and error [mm] if it is wanted, with one more camera at each view; of no views, without one."""
        alone = len(views.places.ring) == 0
        columns = np.zeros((len(self.samples.weights), 1), dtype=np.float32) if alone else views.seen
        count, threshold = seen.sum(axis=0), self.demand.threshold
        if self.demand.is_count and not errors:
            base = self._weights @ (count >= threshold).astype(np.float32)
            waiting = np.flatnonzero(count == threshold - 1)
            gained = np.einsum("sn,nc->sc", self._weights[:, waiting], columns[waiting])
            return worth_of((base[:, None] + gained).astype(np.float64)), np.zeros(columns.shape[1])
        which = np.flatnonzero(count >= threshold - 1)
        now = columns[which] > 0
        covered = count[which, None] + now >= threshold
        far = self._far(places, places)
        if far is not None:
            views_of = seen[:, which].T
            covered &= Criterion(1, far).enough(views_of)[:, None] | (
                (False if alone else views_of.astype(np.float32) @ self._far_from(places, views) > 0) & now
            )
        if self.demand.max_disparity_gradient is not None:
            covered &= self._matched(places, seen[:, which], which, views, now)
        weights = self._weights[:, which]
        if not errors and self.demand.max_error is None:
            return worth_of((weights @ covered.astype(np.float32)).astype(np.float64)), np.zeros(columns.shape[1])
        variances = self._variances(places, seen, which, None if alone else views.told[:, which] * now)
        if self.demand.max_error is not None:
            covered &= variances <= self.demand.max_error**2
        worth = worth_of((weights @ covered.astype(np.float32)).astype(np.float64))
        all_weights = self.samples.weights[which, None] * covered
        total, squares = all_weights.sum(axis=0), (all_weights * np.where(covered, variances, 0.0)).sum(axis=0)
        return worth, np.sqrt(np.divide(squares, total, out=np.full(len(total), np.inf), where=total > 0))

    def _matched(
        self, places: Places, seen: Bool[np.ndarray, "M W"], which: np.ndarray, views: Views, now: np.ndarray
    ) -> Bool[np.ndarray, "W C"]:
        """Whether two cameras match the samples `which`, with one more at each view that sees them `now` (W, C)."""
        matched = np.zeros(now.shape, dtype=bool)
        cameras, others = (cameras_of(self.space.rings, one) for one in (places, views.places))
        points, normals = self.samples.points[which], self.samples.normals[which]
        for i, camera in enumerate(cameras):
            known = seen[:i].T & seen[i][:, None]
            matched |= (known & self._alike(points, normals, cameras[:i], camera)).any(axis=1)[:, None]
            if others:
                matched |= now & seen[i][:, None] & self._alike(points, normals, others, camera)
        return matched

    def _alike(
        self, points: np.ndarray, normals: np.ndarray, cameras: Sequence[exact.Camera], other: exact.Camera
    ) -> Bool[np.ndarray, "W C"]:
        """Whether each camera is a baseline apart from the other, and how unlike a point's face looks is bounded."""
        if not cameras:
            return np.zeros((len(points), 0), dtype=bool)
        positions = np.array([one.position for one in cameras])
        far = self.demand.apart(np.linalg.norm(positions - other.position, axis=1))
        return far & (
            plane_gradients(normals, points, cameras, other) <= np.asarray(self.demand.max_disparity_gradient)
        )

    def _far_from(self, places: Places, views: Views) -> Float[np.ndarray, "M C"]:
        far = self._far(places, views.places)
        return (
            np.ones((len(places.ring), len(views.places.ring)), np.float32) if far is None else far.astype(np.float32)
        )

    def _variances(
        self, places: Places, seen: Bool[np.ndarray, "M N"], which: np.ndarray, more: Float[np.ndarray, "6 W C"] | None
    ) -> Float[np.ndarray, "W C"]:
        """(W, C) variances [mm²] of the samples `which`, where one more camera tells so much; (W, 1) without one."""
        told = np.zeros((6, len(which)))
        if len(places.ring):
            told = np.einsum("mjn,mn->jn", self.samples.told(places)[..., which], seen[:, which])
        total = told[..., None] if more is None else told[..., None] + more
        along = np.repeat(self.samples.along[which], total.shape[2], axis=0)
        return np.maximum(variance(total.reshape(6, -1).T, along), 0.0).reshape(total.shape[1:])

    def _with_two_more(self, places: Places) -> Float[np.ndarray, "C C"]:
        """(C, C) worth of the cameras and two more at places of the coarse grid, without baseline or bound."""
        short = np.full(len(self.samples.weights), self.demand.threshold)
        if len(places.ring):
            short = short - self.samples.seen(places).sum(axis=0)
        now, sums = self._pair_grid.seen, []
        for weights in self._weights:
            either, both = now[short == 1], now[short == 2]
            alone = weights[short == 1] @ either
            gained = alone[:, None] + alone[None, :] - (either.T * weights[short == 1]) @ either
            sums.append((gained + (both.T * weights[short == 2]) @ both).astype(float) + weights[short <= 0].sum())
        return worth_of(np.stack(sums))
