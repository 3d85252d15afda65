"""Samples of sites, and which of them cameras see whose sensors may be turned in any way."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

import exact
from exact.ring import poses
from placement.layouts.distinct import canonical
from placement.samples.profiles import N_PARTS, RingProfiles, Visibility
from placement.samples.sampled_site import SampledSite, heights_of, noise_of
from placement.samples.sampling import SurfaceSamples
from placement.sites import Sites

# Half a turn of a rectangle about its middle changes nothing.
HALF_TURN = np.pi


class RolledViews(NamedTuple):
    """What cameras at some ring angles and rolls see of N samples."""

    angles: Float[np.ndarray, " C"]
    """Ring angles [rad]."""
    rolls: Float[np.ndarray, " C"]
    """As `exact.Ring.cameras` takes them [rad]."""
    seen: Float[np.ndarray, "N C"]
    """1 where seen and 0 elsewhere; single, for matrix products."""


@dataclass(frozen=True, eq=False)
class RolledSamples:
    """Samples of one site or several on a ring whose cameras each have a roll of their own.

    Attributes
    ----------
    parts : (S,) tuple of (SurfaceSamples, Visibility)
        Of each site.
    ring : exact.Ring
    weights : (N,) ndarray
        Of all samples together, shares of the ring maximum.
    site : (N,) ndarray of int
        Sum to which each belongs; what a layout is worth is the least of its sums.
    noise, heights : (N,) and (3, N) ndarray
        As of `RingProfiles`.
    """

    parts: tuple[tuple[SurfaceSamples, Visibility], ...]
    ring: exact.Ring
    weights: Float[np.ndarray, " N"]
    site: Int[np.ndarray, " N"]
    noise: Float[np.ndarray, " N"]
    heights: Float[np.ndarray, "3 N"]

    @staticmethod
    def of(sampled: Sequence[SampledSite], sites: Sites, ring: exact.Ring, demand: exact.Demand) -> "RolledSamples":
        """Samples of all sites, weighted as their objective says."""
        worst = sites.objective == "worst"
        shares = np.ones(len(sampled)) if worst else sites.shares
        return RolledSamples(
            tuple((one.samples, one.visibility) for one in sampled),
            ring,
            np.concatenate(
                [share / one.ring_area * one.samples.weights for share, one in zip(shares, sampled, strict=True)]
            ),
            np.concatenate([np.full(len(one.samples), i * worst) for i, one in enumerate(sampled)]),
            np.concatenate([noise_of(one.samples, ring, demand) for one in sampled]),
            np.concatenate([heights_of(one.samples, ring, demand) for one in sampled], axis=1),
        )

    def thinned(self, step: int) -> "RolledSamples":
        """Every `step`-th sample alone, each counting `step` times as much."""
        kept = [np.arange(len(samples)) % step == 0 for samples, _ in self.parts]
        parts = tuple((samples.subset(keep), view) for keep, (samples, view) in zip(kept, self.parts, strict=True))
        every = np.concatenate(kept)
        return RolledSamples(
            parts, self.ring, step * self.weights[every], self.site[every], self.noise[every], self.heights[:, every]
        )

    @property
    def profiles(self) -> RingProfiles:
        """Weights, noises and heights alone, as what judges layouts by given views takes; its views are of no use."""
        nowhere = np.zeros((1, len(self.weights)))
        part = np.arange(len(self.weights)) % N_PARTS == np.arange(N_PARTS)[:, None]
        parts = np.where(part, self.weights, 0.0)
        return RingProfiles(nowhere, nowhere, self.weights, self.site, parts, self.noise, self.heights)

    def seen(self, angles, rolls) -> Bool[np.ndarray, "M N"]:
        """(M, N) bool: does the camera at each of the (M,) ring angles and rolls [rad] see each sample."""
        views = [visibility.from_angles(samples, self.ring, angles, rolls) for samples, visibility in self.parts]
        return np.concatenate(views, axis=1)

    def views(self, angles: Float[np.ndarray, " A"], rolls: Float[np.ndarray, " R"]) -> RolledViews:
        """From each of the ring angles with each of the rolls [rad], the rolls fastest.

        What lies between a sample and a camera does not depend on its roll, so that one ray serves all rolls.
        """
        cameras, half = poses(self.ring, angles, np.zeros(len(angles))), np.array(self.ring.fov) / 2
        cosine, sine = np.cos(rolls)[:, None], np.sin(rolls)[:, None]
        seen = np.empty((len(self.weights), len(angles), len(rolls)), dtype=np.float32)
        first = 0
        for samples, visibility in self.parts:
            open_to = visibility.at_any_roll().from_angles(samples, self.ring, angles)
            here = slice(first, first + len(samples))
            for k, (position, rotation, distance) in enumerate(zip(*cameras, strict=True)):
                right, down, depth = rotation @ (samples.points - position).T
                across = np.abs(cosine * right + sine * down) <= half[0] * depth / distance
                upright = np.abs(cosine * down - sine * right) <= half[1] * depth / distance
                seen[here, k] = (across & upright & open_to[k]).T
            first += len(samples)
        return RolledViews(
            np.repeat(angles, len(rolls)), np.tile(rolls, len(angles)), seen.reshape(len(self.weights), -1)
        )


def canonical_rolled(angles, rolls) -> tuple[Float[np.ndarray, " M"], Float[np.ndarray, " M"]]:
    """The same layout with ring angles increasing in [0, 2 pi), rolls in (-pi/2, pi/2].

    Examples
    --------
    >>> [values.round(3).tolist() for values in canonical_rolled([7.0, 0.2], [3.0, -2.0])]
    [[0.2, 0.717], [1.142, -0.142]]
    """
    order = np.argsort(np.mod(angles, 2 * np.pi), kind="stable")
    rolled = HALF_TURN / 2 - np.mod(HALF_TURN / 2 - np.asarray(rolls, dtype=np.float64)[order], HALF_TURN)
    return canonical(angles), rolled
