"""What came out for several rings: the layout proposed, each ring alone, and all that is needed to repeat it."""

from dataclasses import dataclass

import numpy as np

import exact
from placement.layouts.constraints import Constraints
from placement.results import Placement, SearchRecord
from placement.rings.ring_places import Places, cameras_of
from placement.rings.rings_bound import RingsBound
from placement.settings import Settings
from placement.sites import Objective


@dataclass(frozen=True)
class RingsCandidate:
    """One layout that was scored exactly.

    Attributes
    ----------
    ring_of : (M,) tuple of int
        Which ring each camera sits on, from 0, not decreasing.
    angles : (M,) tuple of float
        Ring angles [rad], on each ring increasing in [0, 2 pi).
    origin : str
        "alone", "search", "accuracy", "certificate" or "polish": where it comes from; "alone" is a layout of one ring.
    fraction : float
        Exact fraction of the maximum of all rings together, over all sites as their objective says.
    areas : (S,) tuple of float
        Exact reconstructable area of each site [mm²].
    """

    ring_of: tuple[int, ...]
    angles: tuple[float, ...]
    origin: str
    fraction: float
    areas: tuple[float, ...]

    @property
    def area(self) -> float:
        """Exact reconstructable area [mm²], summed over the sites."""
        return float(sum(self.areas))

    @property
    def places(self) -> Places:
        """The same as arrays."""
        return Places(np.array(self.ring_of), np.array(self.angles))


@dataclass(frozen=True)
class OneRing:
    """What one of the rings does alone, with as many cameras.

    Attributes
    ----------
    placement : Placement or None
        As `placement.optimise` finds it; its own fractions are of the maximum of that ring alone. None if there is
        none.
    fraction : float or None
        Exact area of the layout proposed over the maximum of all rings together.
    equidistant_fraction : float or None
        The same of the equidistant layout at phase 0.
    best_equidistant_fraction : float or None
        The same of the best equidistant layout tried.
    refused : str
        Why there is none; empty if there is one.
    """

    placement: Placement | None
    fraction: float | None
    equidistant_fraction: float | None
    best_equidistant_fraction: float | None
    refused: str = ""


@dataclass(frozen=True)
class RingsPlacement:
    """A layout on several rings, what each of them does alone, and how to get it again.

    Attributes
    ----------
    ring_of : (M,) tuple of int
        Which ring each camera of the layout proposed sits on, from 0, not decreasing.
    angles : (M,) tuple of float
        Their ring angles [rad], on each ring increasing in [0, 2 pi).
    areas : (S,) tuple of float
        Exact reconstructable area of each site [mm²].
    fraction : float
        Exact area over that of all rings together, of which the site sees `settings.ring_cameras` equidistant cameras
        on each, and one on a ring that is a single place; of several sites the mean, or the worst, as `objective` says.
    error_rms : float
        Root mean square of the predicted errors over all that the layout reconstructs [mm].
    most_area_error_rms : float
        The same of `most_area`.
    alone : (K,) tuple of OneRing
        Each ring with all cameras on it.
    maximum_areas : (S,) tuple of float
        What all rings together reconstruct of each site [mm²].
    objective : "mean" or "worst"
        Over several sites.
    candidates : tuple of RingsCandidate
        All layouts scored exactly that meet the constraints, the one with the greatest area first.
    certificate : RingsBound or None
        Bound for layouts on a grid; None if it was not asked for, or would have taken long.
    search : SearchRecord
        Starts, evaluations, times; those of the rings alone stand in their own.
    rings, n_cameras, most, demand, give_up, constraints, settings, seed, mesh_hashes, versions
        The request and the libraries; `constraints` are those of each ring. `demand` is what made a point count, with
        the greatest baseline that the constraints ask for.
    """

    ring_of: tuple[int, ...]
    angles: tuple[float, ...]
    areas: tuple[float, ...]
    fraction: float
    error_rms: float
    most_area_error_rms: float
    alone: tuple[OneRing, ...]
    maximum_areas: tuple[float, ...]
    objective: Objective
    candidates: tuple[RingsCandidate, ...]
    certificate: RingsBound | None
    search: SearchRecord
    rings: tuple[exact.Ring, ...]
    n_cameras: int
    most: tuple[int | None, ...]
    demand: exact.Demand
    give_up: float
    constraints: tuple[Constraints, ...]
    settings: Settings
    seed: int
    mesh_hashes: tuple[str, ...]
    versions: dict[str, str]

    @property
    def area(self) -> float:
        """Exact reconstructable area [mm²]; of several sites the sum."""
        return float(sum(self.areas))

    @property
    def maximum_area(self) -> float:
        """What all rings together reconstruct [mm²]; of several sites the sum."""
        return float(sum(self.maximum_areas))

    @property
    def most_area(self) -> RingsCandidate:
        """The layout with the greatest exact area found, whatever its error."""
        return self.candidates[0]

    @property
    def cameras(self) -> tuple[exact.Camera, ...]:
        """(M,) the cameras of the layout proposed."""
        return cameras_of(self.rings, Places(np.array(self.ring_of), np.array(self.angles)))

    @property
    def separations(self) -> np.ndarray:
        """(M, M) distances between the camera centres [mm]."""
        centres = np.array([camera.position for camera in self.cameras])
        return np.linalg.norm(centres[:, None] - centres[None, :], axis=2)

    @property
    def smallest_separation(self) -> float:
        """Least distance between two camera centres [mm]; infinite for one camera."""
        apart = self.separations
        return float(np.min(apart[~np.eye(len(apart), dtype=bool)], initial=np.inf))
