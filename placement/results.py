"""What came out: the layout proposed, everything it was compared with, and all that is needed to repeat it."""

from dataclasses import dataclass, field
from importlib.metadata import version

import numpy as np

import exact
from placement.certificate import Certificate
from placement.constraints import Constraints
from placement.settings import Settings

LIBRARIES = ("camring", "numpy", "scipy", "shapely", "trimesh", "embreex", "jax", "jaxlib", "equinox", "optimistix")


@dataclass(frozen=True)
class Candidate:
    """One layout that was scored exactly.

    Attributes
    ----------
    angles : tuple of float
        Ring angles [rad], increasing in [0, 2 pi).
    origin : str
        "equidistant", "search", "polish" or "certificate": where it comes from.
    soft_coverage : float or None
        What the optimiser saw at its last temperature, as a fraction of the sampled ring maximum; None where it
        was not asked.
    sampled_area : float
        Area of the samples it reconstructs [mm²]; an estimate of `area`.
    area : float
        Exact reconstructable area [mm²].
    """

    angles: tuple[float, ...]
    origin: str
    soft_coverage: float | None
    sampled_area: float
    area: float


@dataclass(frozen=True)
class SearchRecord:
    """What the search went through.

    Attributes
    ----------
    n_starts, n_failed, n_flat : int
        Starts; those whose search ended in a value that is not finite; those that never moved.
    n_distinct : int
        Distinct layouts at the end.
    n_exact : int
        Exact evaluations, the ring maximum among them.
    seconds : dict
        Time for each part [s].
    """

    n_starts: int
    n_failed: int
    n_flat: int
    n_distinct: int
    n_exact: int
    seconds: dict[str, float] = field(compare=False)


@dataclass(frozen=True)
class Placement:
    """A layout for a site, the layouts it was compared with, and how to get it again.

    Attributes
    ----------
    angles : (M,) tuple of float
        Ring angles of the best layout found [rad], increasing in [0, 2 pi).
    area : float
        Its exact reconstructable area [mm²].
    equidistant_area : float
        Exact area of the equidistant layout at phase 0 [mm²] (Wachter 2021).
    best_equidistant_area, best_equidistant_phase : float
        Exact area [mm²] and phase [rad] of the best equidistant layout tried, whether or not it meets the
        constraints.
    ring_area : float
        Ring maximum: exact area of `settings.ring_cameras` equidistant cameras [mm²].
    candidates : tuple of Candidate
        All layouts scored exactly that meet the constraints, best first; `candidates[0].angles` is `angles`.
    certificate : Certificate or None
        Bound for any layout; None if it was not asked for.
    search : SearchRecord
        Starts, failures, evaluations, times.
    mesh_hash : str
        Fingerprint of the mesh: SHA-256 of the corners of its faces (`meshes.fingerprint`).
    n_excluded : int
        Number of faces that do not count.
    """

    angles: tuple[float, ...]
    area: float
    equidistant_area: float
    best_equidistant_area: float
    best_equidistant_phase: float
    ring_area: float
    candidates: tuple[Candidate, ...]
    certificate: Certificate | None
    search: SearchRecord
    mesh_hash: str
    n_excluded: int
    ring: exact.Ring
    n_cameras: int
    threshold: int
    constraints: Constraints
    settings: Settings
    seed: int
    versions: dict[str, str]

    @property
    def fraction(self) -> float:
        """Area over ring maximum."""
        return self.area / self.ring_area

    @property
    def gain(self) -> float:
        """What the layout gains over the equidistant one at phase 0, as a fraction of the ring maximum."""
        return (self.area - self.equidistant_area) / self.ring_area

    @property
    def smallest_separation(self) -> float:
        """Least chord between two cameras [mm]; infinite for one camera."""
        separations = self.ring.separations(self.angles)
        return float(np.min(separations[~np.eye(len(separations), dtype=bool)], initial=np.inf))


def library_versions() -> dict[str, str]:
    """Versions of what a layout depends on, by name of the distribution.

    Examples
    --------
    >>> sorted(library_versions())[:3]
    ['camring', 'embreex', 'equinox']
    """
    return {name: version(name) for name in LIBRARIES}
