"""How a layout is searched for: every number of the method, in one place."""

from dataclasses import dataclass, fields, replace
from typing import Literal

import numpy as np

from placement.errors import PlacementError

# On large meshes: leading candidates that are scored exactly, and cameras of the ring maximum.
FEW = 2
FEW_ON_RING = 72


@dataclass(frozen=True)
class Settings:
    """How a layout is searched for and scored.

    Loosen with `dataclasses.replace`, for a test, say. Angles in radians.

    Parameters
    ----------
    n_samples : int
        Sample points where the ring may see a site; several sites share them.
    least_samples : int
        Sample points that each of several sites gets all the same.
    n_angles, bisections : int
        Grid angles of the ring profiles, and further rays that locate each change of visibility between them.
    temperatures : tuple of float
        Falling widths of the soft step [rad]. The last one is as narrow as a move that the samples still feel.
    max_steps : int
        BFGS steps per temperature at most.
    n_starts : int
        Starts of the search; the equidistant layout at `n_start_phases` phases is among them.
    n_start_phases : int
        Phases of the equidistant layout that start a search.
    n_grid : int
        Angles for moving one camera at a time on the samples.
    n_pair_searches : int
        Leading layouts that are improved further by moving two cameras at once on the samples.
    n_phases : int
        Phases of the equidistant layout to compare with; all are covered on the samples.
    exact_phases, exact_candidates : int
        How many of the leading phases and of the leading distinct candidates are scored exactly.
    distinct_tolerance : float
        Two candidates are the same if no camera differs by more than this [rad].
    polish_candidates : int
        How many of the leading layouts are moved to local optima of the exact area, by its derivative.
    polish_steps : tuple of float
        Falling steps of moving one camera of the first at a time, where the area has no derivative that is known, with
        a bound on the error [rad]; empty if no layout is to be moved.
    polish_sweeps : int
        Times that each camera gets its turn at either, on average, at most.
    certificate_step : float
        Step of the grid on which the best layout is proven [rad].
    certificate_seconds : float
        Time limit of the certificate [s].
    certify_on : "auto", "surface" or "samples"
        What layouts on the grid are bounded on: the surface itself, by exact areas, or samples alone, as layouts at any
        angles are; auto is the surface where that takes less than half a minute or so.
    ring_cameras : int
        Equidistant cameras whose exact area is the ring maximum.
    most_faces : int
        Beyond so many faces, of all sites together, `FEW` of the leading candidates and one phase are scored exactly,
        none is moved to a local optimum, and the ring maximum is that of `FEW_ON_RING` cameras at most: each exact
        area takes many seconds there, and each camera seconds.

    Examples
    --------
    >>> import dataclasses
    >>> quick = dataclasses.replace(Settings(), n_samples=500, n_starts=8, ring_cameras=32, polish_steps=())
    >>> quick.n_starts
    8
    """

    n_samples: int = 8192
    least_samples: int = 2048
    n_angles: int = 120
    bisections: int = 5
    temperatures: tuple[float, ...] = (0.5, 0.2, 0.08, 0.03)
    max_steps: int = 20
    n_starts: int = 24
    n_start_phases: int = 6
    n_grid: int = 360
    n_pair_searches: int = 3
    n_phases: int = 36
    exact_phases: int = 3
    exact_candidates: int = 8
    distinct_tolerance: float = float(np.radians(1.0))
    polish_candidates: int = 2
    polish_steps: tuple[float, ...] = (0.02, 0.005)
    polish_sweeps: int = 8
    certificate_step: float = float(np.radians(5.0))
    certificate_seconds: float = 60.0
    certify_on: Literal["auto", "surface", "samples"] = "auto"
    ring_cameras: int = 360
    most_faces: int = 200_000

    def __post_init__(self):
        least = {
            "n_angles": 4,
            "n_grid": 4,
            "bisections": 0,
            "polish_sweeps": 0,
            "n_start_phases": 0,
            "n_pair_searches": 0,
        }
        for field in fields(self):
            value = getattr(self, field.name)
            if field.type is int or field.type == "int":
                bound = least.get(field.name, 1)
                if not isinstance(value, int | np.integer) or isinstance(value, bool) or value < bound:
                    raise PlacementError(f"settings: {field.name} is {value!r}; it must be a whole number >= {bound}")
        if not (self.temperatures and min(self.temperatures) > 0):
            raise PlacementError(f"settings: temperatures are {self.temperatures!r}; at least one, all positive [rad]")
        if self.certify_on not in ("auto", "surface", "samples"):
            raise PlacementError(
                f"settings: certify_on is {self.certify_on!r}; it must be 'auto', 'surface' or 'samples'"
            )
        if not (0 < self.certificate_step <= np.pi / 2 and self.certificate_seconds > 0):
            raise PlacementError(
                "settings: certificate_step must be within (0, pi / 2] and certificate_seconds positive"
            )
        if not (all(0 < step < np.inf for step in self.polish_steps) and 0 <= self.distinct_tolerance < np.inf):
            raise PlacementError("settings: polish_steps must be positive and distinct_tolerance not negative [rad]")

    def for_faces(self, n_faces: int) -> "Settings":
        """The same, or with fewer exact areas, and of fewer cameras, if there are more than `most_faces`.

        Examples
        --------
        >>> Settings().for_faces(100_000) == Settings(), Settings().for_faces(1_000_000).ring_cameras
        (True, 72)
        """
        if n_faces <= self.most_faces:
            return self
        few, on_ring = min(FEW, self.exact_candidates), min(FEW_ON_RING, self.ring_cameras)
        return replace(self, exact_candidates=few, exact_phases=1, polish_steps=(), ring_cameras=on_ring)
