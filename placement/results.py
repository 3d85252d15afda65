"""What came out: the layout proposed, everything it was compared with, and all that is needed to repeat it."""

from dataclasses import dataclass, field
from importlib.metadata import version
from typing import TYPE_CHECKING

import numpy as np

import exact
from placement.layouts.constraints import Constraints
from placement.proof.certificate import Certificate
from placement.settings import Settings
from placement.sites import Objective

if TYPE_CHECKING:  # drawing alone needs matplotlib
    from matplotlib.axes import Axes

LIBRARIES = ("camring", "numpy", "scipy", "shapely", "trimesh", "embreex", "jax", "jaxlib", "equinox", "optimistix")


@dataclass(frozen=True)
class Candidate:
    """One layout that was scored exactly.

    Attributes
    ----------
    angles : tuple of float
        Ring angles [rad], increasing in [0, 2 pi).
    origin : str
        "equidistant", "search", "accuracy", "certificate" or "polish": where it comes from.
    soft_coverage : float
        What the optimiser sees at its last temperature, as a fraction of the sampled ring maximum.
    sampled_fraction : float
        Fraction of the sampled ring maximum that the samples say it reconstructs; an estimate of `fraction`.
    fraction : float
        Exact fraction of the ring maximum, over all sites as their objective says.
    areas : (S,) tuple of float
        Exact reconstructable area of each site [mm²].
    rolls : tuple of float or None
        Of the cameras [rad], as `exact.Ring.cameras` takes them, where they were free; else None. `soft_coverage` is
        then `sampled_fraction`, as rolls are searched for on the samples themselves.
    """

    angles: tuple[float, ...]
    origin: str
    soft_coverage: float
    sampled_fraction: float
    fraction: float
    areas: tuple[float, ...]
    rolls: tuple[float, ...] | None = None

    @property
    def area(self) -> float:
        """Exact reconstructable area [mm²], summed over the sites."""
        return float(sum(self.areas))


@dataclass(frozen=True)
class SearchRecord:
    """What the search went through.

    Attributes
    ----------
    n_starts, n_failed, n_flat : int
        Starts; those whose search ended in a value that is not finite; those that never moved. The latter two were
        tried once more from elsewhere.
    n_distinct : int
        Distinct layouts at the end.
    n_exact : int
        Layouts evaluated exactly for this request, the ring maximum not counted.
    n_moves : int
        Moves of one camera tried on the exact area.
    seconds : dict
        Time for each part [s].
    """

    n_starts: int
    n_failed: int
    n_flat: int
    n_distinct: int
    n_exact: int
    n_moves: int
    seconds: dict[str, float] = field(compare=False)


@dataclass(frozen=True)
class SiteResult:
    """Exact areas of one site.

    Attributes
    ----------
    area : float
        Reconstructable area with the layout proposed [mm²].
    equidistant_area, best_equidistant_area : float
        With the equidistant layout at phase 0 (Wachter 2021), and at the best phase tried [mm²].
    ring_area : float
        Ring maximum: with `settings.ring_cameras` equidistant cameras, whatever the baseline [mm²]; see `RingMaximum`.
    share : float
        Part of the site in the mean over all sites.
    mesh_hash : str
        Fingerprint of the mesh: SHA-256 of the corners of its faces (`meshes.fingerprint`).
    n_excluded : int
        Number of faces that do not count.
    is_weighted : bool
        Whether faces counted with weights of their own; areas are weighted then.
    """

    area: float
    equidistant_area: float
    best_equidistant_area: float
    ring_area: float
    share: float
    mesh_hash: str
    n_excluded: int
    is_weighted: bool

    @property
    def fraction(self) -> float:
        """Area over ring maximum."""
        return self.area / self.ring_area


@dataclass(frozen=True)
class Placement:
    """A layout for one site or several, the layouts it was compared with, and how to get it again.

    Attributes
    ----------
    angles : (M,) tuple of float
        Ring angles of the layout proposed [rad], increasing in [0, 2 pi): of those that give up no more than
        `give_up` of the greatest area found, the one with the least error.
    fraction : float
        Exact area over ring maximum; of several sites the mean, or the worst, as `objective` says.
    equidistant_fraction : float
        The same for the equidistant layout at phase 0.
    best_equidistant_fraction, best_equidistant_phase : float
        The same for the best equidistant layout tried, and its phase [rad], whether or not it meets the constraints.
    error_rms, most_area_error_rms, equidistant_error_rms, best_equidistant_error_rms : float
        Root mean square of the predicted errors [mm], along depth or the normal as `demand.error` says, over all that
        the layout proposed, `most_area`, and the two equidistant ones reconstruct; infinite where single cameras count.
    sites : (S,) tuple of SiteResult
        Exact areas site by site.
    objective : "mean" or "worst"
        Over several sites.
    candidates : tuple of Candidate
        All layouts scored exactly that meet the constraints, the one with the greatest area first.
    certificate : Certificate or None
        Bound for any layout; None if it was not asked for.
    search : SearchRecord
        Starts, failures, evaluations, times.
    ring, n_cameras, demand, give_up, constraints, starts, settings, seed, versions
        The request and the libraries: all that is needed to repeat it, with the meshes of `sites`. `demand` is what
        made a point count, with the baseline that the constraints ask for.
    rolls : (M,) tuple of float or None
        Of the layout proposed [rad], as `exact.Ring.cameras` takes them, where they were free; None where they are the
        ring's.
    """

    angles: tuple[float, ...]
    fraction: float
    equidistant_fraction: float
    best_equidistant_fraction: float
    best_equidistant_phase: float
    error_rms: float
    most_area_error_rms: float
    equidistant_error_rms: float
    best_equidistant_error_rms: float
    sites: tuple[SiteResult, ...]
    objective: Objective
    candidates: tuple[Candidate, ...]
    certificate: Certificate | None
    search: SearchRecord
    ring: exact.Ring
    n_cameras: int
    demand: exact.Demand
    give_up: float
    constraints: Constraints
    starts: tuple[tuple[float, ...], ...]
    settings: Settings
    seed: int
    versions: dict[str, str]
    rolls: tuple[float, ...] | None = None

    @property
    def threshold(self) -> int:
        """How many cameras must see a point."""
        return self.demand.threshold

    @property
    def area(self) -> float:
        """Exact reconstructable area [mm²]; of several sites the sum."""
        return sum(site.area for site in self.sites)

    @property
    def most_area(self) -> Candidate:
        """The layout with the greatest exact area found, whatever its error."""
        return self.candidates[0]

    @property
    def equidistant_area(self) -> float:
        """Exact area of the equidistant layout at phase 0 [mm²] (Wachter 2021); of several sites the sum."""
        return sum(site.equidistant_area for site in self.sites)

    @property
    def best_equidistant_area(self) -> float:
        """Exact area of the best equidistant layout tried [mm²]; of several sites the sum."""
        return sum(site.best_equidistant_area for site in self.sites)

    @property
    def ring_area(self) -> float:
        """Ring maximum [mm²]; of several sites the sum."""
        return sum(site.ring_area for site in self.sites)

    @property
    def mesh_hash(self) -> str:
        """Fingerprints of the meshes, joined by +."""
        return "+".join(site.mesh_hash for site in self.sites)

    @property
    def n_excluded(self) -> int:
        """Number of faces that do not count, over all sites."""
        return sum(site.n_excluded for site in self.sites)

    @property
    def gain(self) -> float:
        """What the layout gains over the equidistant one at phase 0, in fractions of the ring maximum."""
        return self.fraction - self.equidistant_fraction

    @property
    def smallest_separation(self) -> float:
        """Least chord between two cameras [mm]; infinite for one camera."""
        separations = self.ring.separations(self.angles)
        return float(np.min(separations[~np.eye(len(separations), dtype=bool)], initial=np.inf))

    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the ring from above, with this layout and the equidistant one; into `ax`, or axes of its own."""
        from placement import show

        return show.plot(self, ax)

    def _repr_html_(self) -> str:
        from placement import show

        return show.html(self)


def library_versions() -> dict[str, str]:
    """Versions of what a layout depends on, by name of the distribution.

    Examples
    --------
    >>> sorted(library_versions())[:3]
    ['camring', 'embreex', 'equinox']
    """
    return {name: version(name) for name in LIBRARIES}
