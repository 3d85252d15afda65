"""Which cameras see which area: the surface divided by the set of cameras that see each point.

From it follows by arithmetic what any threshold gives, what the failure of any camera costs, and which pairs of
cameras do the work.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from exact.cameras import Camera
from exact.demand import Criterion
from exact.requests import (
    checked_cameras,
    checked_demand,
    checked_scene,
    checked_workers,
    demand_keywords,
    refuse_unknown,
    scene_keywords,
    shows,
)
from exact.scene import Scene
from exact.visibility.coverage import Pieces, tally
from exact.visibility.triangulated import triangulated

if TYPE_CHECKING:
    import trimesh


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
    _scene: Scene = field(repr=False)
    _cameras: tuple[Camera, ...] = field(repr=False)
    _whole: np.ndarray = field(repr=False)
    _pieces: Pieces = field(repr=False)
    _set: np.ndarray = field(repr=False)

    @shows({"cameras": None, "far": None, **demand_keywords(), "demand": None})
    def area(self, **asked: Any) -> float:
        """Area [mm²] that the chosen cameras reconstruct.

        Parameters
        ----------
        cameras : (M,) bool, optional
            Which cameras there are; all of them by default.
        far : (M, M) bool, optional
            Pairs of cameras of which at least one must see a point, instead of those that a baseline leaves.
        **asked
            What counts: the keywords of `Demand`, or one as `demand`.
        """
        return float(self.areas[self.met(**asked)].sum())

    @shows({"cameras": None, "far": None, **demand_keywords(), "demand": None})
    def met(self, **asked: Any) -> np.ndarray:
        """(S,) bool: the sets of cameras that reconstruct what they see, arguments as for `area`."""
        refuse_unknown(asked, {"cameras", "far", *demand_keywords(), "demand"})
        criterion, chosen = checked_demand(asked).of(self._cameras), asked.get("cameras")
        if asked.get("far") is not None:
            criterion = replace(criterion, far=np.asarray(asked["far"], dtype=bool))
        return criterion.met(self.seen if chosen is None else self.seen & np.asarray(chosen, dtype=bool))

    def to_mesh(self) -> "trimesh.Trimesh":
        """The counted surface, cut where the set of cameras changes.

        Returns
        -------
        trimesh.Trimesh
            With the face each triangle comes from as `face_attributes["parent"]`, and its row of `seen` as
            `face_attributes["set"]`, -1 where no camera sees it.
        """
        mesh, piece = triangulated(self._scene.mesh, self._whole, self._pieces.face, self._pieces.polygon)
        n_whole = len(self._whole)
        mesh.face_attributes["set"] = np.concatenate([self._set[:n_whole], self._set[n_whole:][piece]])
        return mesh


@shows(scene_keywords())
def view_sets(
    mesh: "trimesh.Trimesh | Scene", cameras: Sequence[Camera], *, workers: int = 1, **asked: Any
) -> ViewSets:
    """Divide the surface by the set of cameras that see it, exact up to float64 rounding.

    Takes longer than `evaluate`, since no part is finished before every camera has been asked, and is meant for up to
    some dozen cameras.

    Parameters
    ----------
    mesh : trimesh.Trimesh or Scene
    cameras, workers
        As for `evaluate`.
    **asked
        What of the mesh counts and how much: the keywords of `Scene`.

    Raises
    ------
    ExactError
        If the request is not possible.

    Examples
    --------
    >>> import trimesh
    >>> from exact import Ring
    >>> plate = trimesh.Trimesh([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> sets = view_sets(plate, Ring().cameras([0.0, 1.0, 2.0]))
    >>> sets.seen.tolist(), sets.areas.round(9).tolist()
    ([[True, True, True]], [100.0])
    >>> round(sets.area(threshold=2, cameras=[True, True, False]), 9)
    100.0
    """
    refuse_unknown(asked, scene_keywords())
    cameras, scene = checked_cameras(cameras), checked_scene(mesh, asked)
    surface, counted = scene.surface, scene.counted
    # One view more than there are: no part is ever finished.
    criterion = Criterion(len(cameras) + 1, sets=True)
    found = tally(surface, cameras, criterion, counted, checked_workers(workers))
    whole = np.flatnonzero(counted & ~found.is_cut & (surface.areas > 0))
    face = np.concatenate([whole, found.pieces.face])
    area = surface.areas[face]
    area[len(whole) :] *= 2 * shapely.area(found.pieces.polygon)
    area = area if scene.weights is None else area * scene.weights[face]
    seen = np.concatenate([found.whole_seen[whole], found.pieces.seen])
    sets, group = np.unique(seen, axis=0, return_inverse=True)
    areas = np.bincount(group.reshape(-1), weights=area, minlength=len(sets))
    some = sets.any(axis=1)
    number = np.where(some, np.cumsum(some) - 1, -1)
    return ViewSets(
        sets[some], areas[some], found.n_repairs, scene, cameras, whole, found.pieces, number[group.reshape(-1)]
    )
