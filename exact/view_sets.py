"""Which cameras see which area: the surface divided by the set of cameras that see each point.

From it follows by arithmetic what any threshold gives, what the failure of any camera costs, and which pairs of
cameras do the work.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
import trimesh

from exact.cameras import Camera
from exact.coverage import Demand, Pieces, tally
from exact.requests import checked_cameras, checked_mask, checked_weights, checked_workers
from exact.results import triangulated
from exact.surface import prepare


@dataclass(frozen=True, eq=False)
class ViewSets:
    """Area by the set of cameras that see it, from `exact.view_sets`.

    Attributes
    ----------
    seen : (S, M) bool
        Distinct sets of cameras; the empty set is not among them.
    areas : (S,) float
        Area that exactly those cameras see [mm²], weighted if weights were given.
    repairs : int
        How often rounding made a step fail its own check so that it was done again in a robust way.
    """

    seen: np.ndarray
    areas: np.ndarray
    repairs: int
    _mesh: trimesh.Trimesh = field(repr=False)
    _whole: np.ndarray = field(repr=False)
    _pieces: Pieces = field(repr=False)
    _set: np.ndarray = field(repr=False)

    def area(self, threshold: int = 2, cameras: np.ndarray | None = None, far: np.ndarray | None = None) -> float:
        """Area [mm²] that at least `threshold` of the chosen cameras see.

        Parameters
        ----------
        threshold : int
        cameras : (M,) bool, optional
            Which cameras there are; all of them by default.
        far : (M, M) bool, optional
            Pairs of cameras of which at least one must see a point.
        """
        return float(self.areas[self.met(threshold, cameras, far)].sum())

    def met(self, threshold: int = 2, cameras: np.ndarray | None = None, far: np.ndarray | None = None) -> np.ndarray:
        """(S,) bool: the sets in which at least `threshold` of the chosen cameras are, arguments as for `area`."""
        seen = self.seen if cameras is None else self.seen & np.asarray(cameras, dtype=bool)
        return Demand(threshold, far).met(seen)

    def to_mesh(self) -> trimesh.Trimesh:
        """The counted surface, cut where the set of cameras changes.

        Returns
        -------
        trimesh.Trimesh
            With the face each triangle comes from as `face_attributes["parent"]`, and its row of `seen` as
            `face_attributes["set"]`, -1 where no camera sees it.
        """
        mesh, piece = triangulated(self._mesh, self._whole, self._pieces.face, self._pieces.polygon)
        n_whole = len(self._whole)
        mesh.face_attributes["set"] = np.concatenate([self._set[:n_whole], self._set[n_whole:][piece]])
        return mesh


def view_sets(
    mesh: trimesh.Trimesh,
    cameras: Sequence[Camera],
    exclude: np.ndarray | None = None,
    weights: np.ndarray | None = None,
    workers: int = 1,
) -> ViewSets:
    """Divide the surface by the set of cameras that see it, exact up to float64 rounding.

    Takes longer than `evaluate`, since no part is finished before every camera has been asked, and is meant for up to
    some dozen cameras.

    Parameters
    ----------
    mesh, cameras, exclude, weights, workers
        As for `evaluate`.

    Raises
    ------
    ExactError
        If the request is not possible.

    Examples
    --------
    >>> from exact import Ring
    >>> plate = trimesh.Trimesh([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> sets = view_sets(plate, Ring().cameras([0.0, 1.0, 2.0]))
    >>> sets.seen.tolist(), sets.areas.round(9).tolist()
    ([[True, True, True]], [100.0])
    >>> round(sets.area(threshold=2, cameras=[True, True, False]), 9)
    100.0
    """
    cameras = checked_cameras(cameras)
    surface = prepare(mesh)
    counted = ~checked_mask(exclude, len(surface.faces))
    weights = checked_weights(weights, len(surface.faces))
    # One view more than there are: no part is ever finished.
    found = tally(surface, cameras, Demand(len(cameras) + 1, None, sets=True), counted, checked_workers(workers))
    whole = np.flatnonzero(counted & ~found.is_cut & (surface.areas > 0))
    face = np.concatenate([whole, found.pieces.face])
    area = surface.areas[face]
    area[len(whole) :] *= 2 * shapely.area(found.pieces.polygon)
    area = area if weights is None else area * weights[face]
    seen = np.concatenate([found.whole_seen[whole], found.pieces.seen])
    sets, group = np.unique(seen, axis=0, return_inverse=True)
    areas = np.bincount(group.reshape(-1), weights=area, minlength=len(sets))
    some = sets.any(axis=1)
    number = np.where(some, np.cumsum(some) - 1, -1)
    return ViewSets(sets[some], areas[some], found.n_repairs, mesh, whole, found.pieces, number[group.reshape(-1)])
