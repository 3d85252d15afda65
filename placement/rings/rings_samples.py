"""Samples of sites that several rings look at, and which of them a camera on any of the rings sees."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int

import exact
from exact.usable.information import of_camera
from placement.errors import PlacementError
from placement.rings.ring_places import Places, cameras_of
from placement.samples.profiles import Visibility
from placement.samples.sampled_site import samples_in_view
from placement.samples.sampling import SurfaceSamples
from placement.settings import Settings
from placement.sites import Sites


@dataclass(frozen=True, eq=False)
class RingsSamples:
    """Samples of one site or several.

    Attributes
    ----------
    parts : (S,) tuple of (SurfaceSamples, Visibility)
        Of each site.
    rings : (K,) tuple of exact.Ring
    demand : exact.Demand
        Whose optics and axis of depth say what cameras tell about a sample.
    weights : (N,) ndarray
        Of all samples together, shares of the maximum of all rings.
    site : (N,) ndarray of int
        Sum to which each belongs; what a layout is worth is the least of its sums.
    """

    parts: tuple[tuple[SurfaceSamples, Visibility], ...]
    rings: tuple[exact.Ring, ...]
    demand: exact.Demand
    weights: Float[np.ndarray, " N"]
    site: Int[np.ndarray, " N"]

    @staticmethod
    def of(
        sites: Sites, rings: tuple[exact.Ring, ...], demand: exact.Demand, settings: Settings, seed: int
    ) -> "RingsSamples":
        """Sample the sites.

        Raises
        ------
        PlacementError
            If the rings see nothing of a site, or no point of one from places enough.
        """
        n_sites, worst = len(sites.members), sites.objective == "worst"
        few = min(settings.n_samples, max(settings.n_samples // n_sites, settings.least_samples))
        parts, weights = [], []
        for site, share in zip(sites.members, np.ones(n_sites) if worst else sites.shares, strict=True):
            part = samples_in_view(site.scene, rings, demand, few, seed)
            everywhere = _seen((part,), rings, Places.grid(len(rings), max(settings.n_angles, demand.threshold)))
            area = float(part[0].weights[everywhere.sum(axis=0) >= demand.threshold].sum())
            if not area > 0:
                raise PlacementError(
                    f"no point that counts is seen by {demand.threshold} cameras anywhere on these rings; lower the "
                    "threshold"
                )
            parts.append(part)
            weights.append(share / area * part[0].weights)
        site_of = [np.full(len(one), number * worst) for number, one in enumerate(weights)]
        return RingsSamples(tuple(parts), rings, demand, np.concatenate(weights), np.concatenate(site_of))

    def thinned(self, step: int) -> "RingsSamples":
        """Every `step`-th sample alone, each counting `step` times as much."""
        kept = [np.arange(len(samples)) % step == 0 for samples, _ in self.parts]
        parts = tuple((samples.subset(keep), view) for keep, (samples, view) in zip(kept, self.parts, strict=True))
        every = np.concatenate(kept)
        return RingsSamples(parts, self.rings, self.demand, step * self.weights[every], self.site[every])

    def seen(self, places: Places) -> Bool[np.ndarray, "M N"]:
        """(M, N) bool: does the camera at each of the (M,) places see each sample."""
        return _seen(self.parts, self.rings, places)

    def told(self, places: Places) -> Float[np.ndarray, "M 6 N"]:
        """(M, 6, N) information [1/mm²] that the camera at each of the places gives about each sample it may see."""
        points, cameras = self.points.T.copy(), cameras_of(self.rings, places)
        return np.stack([of_camera(points, camera, self.demand.optics) for camera in cameras])

    @cached_property
    def points(self) -> Float[np.ndarray, "N 3"]:
        """(N, 3) [mm]."""
        return np.concatenate([samples.points for samples, _ in self.parts])

    @cached_property
    def normals(self) -> Float[np.ndarray, "N 3"]:
        """(N, 3) unit normals."""
        return np.concatenate([samples.normals for samples, _ in self.parts])

    @property
    def along(self) -> Float[np.ndarray, "N 3"]:
        """(N, 3) unit vectors along which errors are measured."""
        if self.demand.error == "normal":
            return self.normals
        axis = np.asarray(self.demand.depth_axis, dtype=np.float64)
        return np.broadcast_to(axis / np.linalg.norm(axis), self.normals.shape)


def _seen(
    parts: Sequence[tuple[SurfaceSamples, Visibility]], rings: tuple[exact.Ring, ...], places: Places
) -> Bool[np.ndarray, "M N"]:
    found = np.zeros((len(places.ring), sum(len(samples) for samples, _ in parts)), dtype=bool)
    for k in np.unique(places.ring):
        here = places.ring == k
        views = [view.from_angles(samples, rings[k], places.angles[here]) for samples, view in parts]
        found[here] = np.concatenate(views, axis=1)
    return found
