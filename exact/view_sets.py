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
from exact.demand import Criterion, Demand, every_view
from exact.errors import ExactError
from exact.predicted.errors import Errors, errors_over
from exact.predicted.reconstructed import area_by_face, reconstructed
from exact.requests import (
    ASKED,
    checked,
    checked_cameras,
    checked_demand,
    checked_workers,
    demand_keywords,
    refuse_unknown,
    shows,
)
from exact.scene import Scene
from exact.visibility.coverage import Tally, tally
from exact.visibility.pieces.pieces import Pieces
from exact.visibility.pieces.triangulated import triangulated

if TYPE_CHECKING:
    import trimesh

# Bytes of a whole number, with a bit for each camera.
NUMBER_BYTES = 8


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
    demand : Demand
        With the limits and optics that views were counted with; what `area` asks for by default.
    """

    seen: np.ndarray
    areas: np.ndarray
    repairs: int
    demand: Demand
    _scene: Scene = field(repr=False)
    _cameras: tuple[Camera, ...] = field(repr=False)
    _whole: np.ndarray = field(repr=False)
    _whole_seen: np.ndarray = field(repr=False)
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
            What counts: the keywords of `Demand`, or one as `demand`; by default what the sets were made for. Other
            limits than theirs make other sets.

        Raises
        ------
        ExactError
            If limits or optics are others.
        """
        criterion, chosen = self._asked(asked)
        if not criterion.by_face:
            return float(self.areas[self.met(**asked)].sum())
        met = self._reconstructed(criterion, chosen)
        return float(self._scene.worth(area_by_face(self._scene.surface, *met)))

    @shows({"cameras": None, "far": None, **demand_keywords(), "demand": None})
    def met(self, **asked: Any) -> np.ndarray:
        """(S,) bool: the sets of cameras that reconstruct what they see, arguments as for `area`.

        If an error or a disparity gradient is bounded, it says which of them may: those depend on the place too.
        """
        criterion, chosen = self._asked(asked)
        return criterion.enough(self.seen & chosen)

    @shows({"cameras": None, "far": None, **demand_keywords(), "demand": None})
    def paired(self, pairs: Sequence[tuple[int, int]], **asked: Any) -> tuple[np.ndarray, np.ndarray]:
        """What may be reconstructed, in parts: their areas (N,) [mm²], and which of K pairs match each, (N, K) bool.

        Parameters
        ----------
        pairs : (K,) sequence of (int, int)
            Cameras, by index.
        **asked
            As for `area`.
        """
        criterion, chosen = self._asked(asked)
        if criterion.disparity is None:
            face, areas, seen = None, self.areas, self.seen & chosen
        else:
            face = np.concatenate([self._whole, self._pieces.face])
            areas = _part_areas(self._scene, self._whole, self._pieces)
            seen = np.concatenate([self._whole_seen, self._pieces.seen]) & chosen
        met = criterion.enough(seen, face)
        both = np.stack([seen[met, i] & seen[met, j] for i, j in pairs], axis=1) if pairs else np.zeros((met.sum(), 0))
        if criterion.disparity is not None and face is not None:
            for k, pair in enumerate(pairs):
                alone = np.zeros(seen.shape[1], dtype=bool)
                alone[list(pair)] = True
                both[:, k] = criterion.disparity.matched(face[met], both[:, [k]] & alone, criterion.far)
        return areas[met], both.astype(bool)

    def _demand(self, asked: dict[str, Any]) -> Demand:
        refuse_unknown(asked, {"cameras", "far", *demand_keywords(), "demand"})
        of_demand = {name: value for name, value in asked.items() if name not in ("cameras", "far")}
        given = {name: getattr(self.demand, name) for name in ("depth_axis", "limits", "optics")}
        return checked_demand(of_demand if "demand" in asked else given | of_demand) if of_demand else self.demand

    def _asked(self, asked: dict[str, Any]) -> tuple[Criterion, np.ndarray]:
        demand = self._demand(asked)
        if demand.limits != self.demand.limits or (demand.limits.is_any and demand.optics != self.demand.optics):
            raise ExactError("these sets of cameras were made with other limits; make new ones with those")
        criterion, chosen = demand.of(self._cameras, self._scene.surface), asked.get("cameras")
        if asked.get("far") is not None:
            criterion = replace(criterion, far=np.asarray(asked["far"], dtype=bool))
        everyone = np.ones(len(self._cameras), dtype=bool)
        return criterion, everyone if chosen is None else np.asarray(chosen, dtype=bool)

    @shows({"cameras": None, "far": None, **demand_keywords(), "demand": None})
    def errors(self, *, pairs: np.ndarray | None = None, **asked: Any) -> Errors:
        """Predicted errors over what the chosen cameras reconstruct.

        Parameters
        ----------
        pairs : (M, M) bool, optional
            Symmetric: pairs of cameras whose images are matched. A point is then triangulated from the cameras that see
            it together with a partner, and points that no pair sees are left out. By default all cameras count that see
            a point.
        **asked
            As for `area`.
        """
        criterion, chosen = self._asked(asked)
        whole, parts = self._reconstructed(criterion, chosen)
        index, whole_seen = self._whole[whole[self._whole]], (self._whole_seen & chosen)[whole[self._whole]]
        seen = parts.seen
        if pairs is not None:
            matched = np.asarray(pairs, dtype=np.float32)
            whole_seen = whole_seen & (whole_seen.astype(np.float32) @ matched > 0)
            seen = seen & (seen.astype(np.float32) @ matched > 0)
            index, whole_seen = index[whole_seen.any(axis=1)], whole_seen[whole_seen.any(axis=1)]
            parts = Pieces(parts.face, parts.polygon, seen).take(np.any(seen, axis=1))
        predictor = self._demand(asked).predictor(self._cameras, self._scene.surface)
        return errors_over(predictor, index, whole_seen, parts, self._scene.weights)

    def _reconstructed(self, criterion: Criterion, chosen: np.ndarray) -> tuple[np.ndarray, Pieces]:
        """Faces, (F,) bool, and pieces that meet the criterion with the chosen cameras."""
        surface, pieces = self._scene.surface, self._pieces
        everything = np.zeros(len(surface.areas), dtype=bool)
        everything[self._whole] = True
        whole_seen = np.zeros((len(surface.areas), len(self._cameras)), dtype=bool)
        whole_seen[self._whole] = self._whole_seen & chosen
        seen = Tally(whole_seen, ~everything, Pieces(pieces.face, pieces.polygon, pieces.seen & chosen), 0)
        return reconstructed(surface, everything, seen, criterion)

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


@shows(ASKED)
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
        What counts, and on what, as for `evaluate`. Of what makes a point count only limits and optics matter to the
        sets themselves; the rest is what their `area` asks for by default.

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
    scene, demand = checked(mesh, asked)
    cameras, surface, counted = checked_cameras(cameras), scene.surface, scene.counted
    found = tally(surface, cameras, every_view(demand, cameras), counted, checked_workers(workers), lit=scene.lit)
    return sets_of(scene, demand, cameras, found)


def sets_of(scene: Scene, demand: Demand, cameras: tuple[Camera, ...], found: Tally) -> ViewSets:
    """The view sets of cameras whose views have all been counted, as `every_view` has it."""
    surface, counted = scene.surface, scene.counted
    whole = np.flatnonzero(counted & ~found.is_cut & (surface.areas > 0))
    area = _part_areas(scene, whole, found.pieces)
    seen = np.concatenate([found.whole_seen[whole], found.pieces.seen])
    sets, group = _distinct(seen)
    areas = np.bincount(group, weights=area, minlength=len(sets))
    some = sets.any(axis=1)
    number = np.where(some, np.cumsum(some) - 1, -1)
    return ViewSets(
        sets[some], areas[some], found.n_repairs, demand, scene, cameras, whole, found.whole_seen[whole], found.pieces,
        number[group],
    )  # fmt: skip


def _part_areas(scene: Scene, whole: np.ndarray, pieces: Pieces) -> np.ndarray:
    """(N,) areas of whole faces and then of pieces [mm²], weighted if weights were given."""
    face = np.concatenate([whole, pieces.face])
    area = scene.surface.areas[face]
    area[len(whole) :] *= 2 * shapely.area(pieces.polygon)
    return area if scene.weights is None else area * scene.weights[face]


def _distinct(seen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The distinct rows of (N, M) bool in order, and which of them each row is, (N,).

    Examples
    --------
    >>> rows, which = _distinct(np.array([[True, False], [False, True], [True, False]]))
    >>> rows.tolist(), which.tolist()
    ([[False, True], [True, False]], [1, 0, 1])
    """
    packed = np.packbits(seen, axis=1)
    n_bytes = packed.shape[1]
    if n_bytes > NUMBER_BYTES:
        sets, which = np.unique(seen, axis=0, return_inverse=True)
        return sets, which.reshape(-1)
    # As whole numbers they are sorted in a tenth of the time.
    number = np.zeros((len(seen), NUMBER_BYTES), dtype=np.uint8)
    number[:, :n_bytes] = packed
    whole = number.view(">u8")[:, 0].astype(np.uint64)
    _, first, which = np.unique(whole, return_index=True, return_inverse=True)
    return seen[first], which
