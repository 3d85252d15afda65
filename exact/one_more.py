"""Layouts that differ in one camera: the views of the others are counted once."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from exact.cameras import Camera
from exact.demand import Criterion, every_view
from exact.derivative.derivative import Derivative, MovingBorders, refuse_without_derivative
from exact.predicted.errors import Errors, errors_over
from exact.predicted.reconstructed import divided, reconstructed
from exact.requests import ASKED, checked, checked_cameras, shows
from exact.scene import Scene
from exact.view_sets import ViewSets, sets_of
from exact.visibility.coverage import BLOCK, Count, Pieces, Tally, add_views, spread_order
from exact.visibility.triangulated import triangulated

if TYPE_CHECKING:
    import trimesh


@shows(ASKED)
class OneMore:
    """The reconstructable area of given cameras and one more, for as many choices of that one as are tried.

    Most of the surface is decided by the others. Each choice computes one view, of the parts that it can decide.

    Parameters
    ----------
    mesh : trimesh.Trimesh or Scene
    others : sequence of Camera
        Cameras that stay; may be empty.
    **asked
        What counts and how much, as for `evaluate`; the threshold is at most the number of cameras with the one more.

    Raises
    ------
    ExactError
        If the request is not possible.

    Examples
    --------
    >>> import trimesh
    >>> from exact import Ring
    >>> plate = trimesh.Trimesh([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> one, two, three = Ring().cameras([0.0, 1.0, 2.0])
    >>> layouts = OneMore(plate, [one], threshold=2)
    >>> round(layouts.area(two), 9), round(layouts.area(three), 9)
    (100.0, 100.0)
    """

    def __init__(self, mesh: "trimesh.Trimesh | Scene", others: Sequence[Camera], **asked: Any):
        self._scene, self._demand = scene, demand = checked(mesh, asked)
        self._others = others = checked_cameras(others) if len(others) else ()
        demand.refuse_fewer(len(others) + 1)
        surface, criterion = scene.surface, self._so_far()
        count = _of_others(scene, others, criterion)
        uncut = np.flatnonzero(scene.counted & ~count.is_cut & (surface.areas > 0))
        decided = np.zeros(len(surface.areas), dtype=bool)
        decided[uncut[criterion.met(count.whole_seen[uncut], uncut)]] = True
        done = Pieces.joined(count.done)
        done = done.take(criterion.met(done.seen, done.face))  # what is not lit never does
        self._base = self._worth(decided, done)
        # What one view more cannot bring to the threshold is not asked about.
        least = demand.threshold - 1
        within_reach = count.waiting.take(count.waiting.seen.sum(axis=1) >= least)
        active = count.active & ~count.is_cut & (count.whole_seen.sum(axis=1) >= least)
        self._open = active.copy()
        active[within_reach.face] = True
        self._count = Count(active, count.whole_seen, count.is_cut, within_reach, (), 0)

    def area(self, camera: Camera) -> float:
        """Reconstructable area [mm²] of the others and `camera`, as `evaluate` gives it up to rounding."""
        return self._with(camera, self._count)[0]

    def gradient(self, camera: Camera) -> tuple[float, Derivative]:
        """The same area, and its derivative by this one camera, as `exact.gradient` gives it up to rounding.

        Raises
        ------
        ExactError
            If the demand bounds the predicted error, with which no derivative is known.

        Examples
        --------
        >>> import trimesh
        >>> from exact import Ring
        >>> ring, box = Ring(fov=(6, 6)), trimesh.creation.box((10, 10, 1))
        >>> one, two = ring.cameras([0.0, 1.0])
        >>> area, derivative = OneMore(box, [one]).gradient(two)
        >>> derivative.on_ring(ring).angle.shape
        (1,)
        """
        refuse_without_derivative(self._demand)
        area, found, criterion = self._with(camera, replace(self._count, cuts=()))
        cameras = (*self._others, camera)
        every = MovingBorders.of(self._scene, self._demand, cameras, found).derivative(criterion)
        return area, every.of_camera(len(self._others))

    def _with(self, camera: Camera, count: Count) -> tuple[float, Tally, Criterion]:
        """The area with one more camera, what all of them see of what it can decide, and by what that is decided."""
        cameras = (*self._others, *checked_cameras([camera]))
        surface = self._scene.surface
        criterion = self._demand.of(cameras, surface)
        last = np.array([len(self._others)])
        found = add_views(count, surface, cameras, last, np.zeros(len(cameras), dtype=bool), criterion).tally()
        whole, pieces = reconstructed(surface, self._open, found, criterion)
        return self._base + self._worth(whole, pieces), found, criterion

    def _so_far(self) -> Criterion:
        """The criterion before the one more is known: it may be anywhere, and no pair with it counts yet."""
        surface = self._scene.surface
        if not self._others:
            return Criterion(self._demand.threshold)
        known = self._demand.of(self._others, surface)
        if known.bound is not None and self._demand.depth_axis is None:
            # Its axis is the mean of all cameras': nothing is decided before the last is there.
            known = replace(known, bound=replace(known.bound, largest=0.0))
        if known.far is None:
            return known
        # With a baseline it matters which cameras see a part, not only how many.
        return replace(known, far=np.pad(known.far, (0, 1)), sets=True)

    def _worth(self, whole: np.ndarray, pieces: Pieces) -> float:
        areas = self._scene.surface.areas
        weight = areas if self._scene.weights is None else areas * self._scene.weights
        of_pieces = 2 * weight[pieces.face] * shapely.area(pieces.polygon)
        return float(weight[whole].sum()) + float(of_pieces.sum())


@shows(ASKED)
class OneMoreView:
    """View sets and predicted errors of given cameras and one more, for as many choices of that one as are tried.

    Each choice computes one view. It takes longer than the area alone, which `OneMore` gives.

    Parameters
    ----------
    mesh : trimesh.Trimesh or Scene
    others : sequence of Camera
        Cameras that stay; may be empty.
    **asked
        What counts and how much, as for `evaluate`; the threshold is at most the number of cameras with the one more.

    Raises
    ------
    ExactError
        If the request is not possible.

    Examples
    --------
    >>> import trimesh
    >>> from exact import Ring
    >>> plate = trimesh.Trimesh([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> one, two, three = Ring().cameras([0.0, 1.0, 3.0])
    >>> layouts = OneMoreView(plate, [one], threshold=2)
    >>> near, far = layouts.seen(two), layouts.seen(three)
    >>> near.sets.area().__round__(9), bool(far.errors.rms() < near.errors.rms())
    (100.0, True)
    """

    def __init__(self, mesh: "trimesh.Trimesh | Scene", others: Sequence[Camera], **asked: Any):
        self._scene, self._demand = scene, demand = checked(mesh, asked)
        self._others = others = checked_cameras(others) if len(others) else ()
        demand.refuse_fewer(len(others) + 1)
        criterion = every_view(demand, (*others, others[0])) if others else Criterion(demand.threshold)
        self._count = _of_others(scene, others, criterion)

    def seen(self, camera: Camera) -> "SeenWithOneMore":
        """What the others and `camera` see."""
        cameras, scene = (*self._others, *checked_cameras([camera])), self._scene
        last, none = np.array([len(self._others)]), np.zeros(len(cameras), dtype=bool)
        criterion = every_view(self._demand, cameras)
        tally = add_views(self._count, scene.surface, cameras, last, none, criterion).tally()
        return SeenWithOneMore(self, cameras, tally)


class SeenWithOneMore:
    """What the cameras of a `OneMoreView` see, with one choice of the one more.

    Attributes
    ----------
    sets : ViewSets
        As `view_sets` gives them for all the cameras, the one more last.
    """

    def __init__(self, layouts: OneMoreView, cameras: tuple[Camera, ...], tally: Tally):
        self._layouts, self._cameras, self._tally = layouts, cameras, tally
        self.sets: ViewSets = sets_of(layouts._scene, layouts._demand, cameras, tally)

    @cached_property
    def errors(self) -> Errors:
        """Predicted errors over what all of them reconstruct, as `Reconstruction.errors` has them up to rounding."""
        layouts = self._layouts
        scene, demand = layouts._scene, layouts._demand
        criterion = demand.of(self._cameras, scene.surface)
        whole, pieces = reconstructed(scene.surface, scene.counted, self._tally, criterion)
        predictor = demand.predictor(self._cameras, scene.surface)
        index = np.flatnonzero(whole)
        return errors_over(predictor, index, self._tally.whole_seen[index], pieces, scene.weights)

    def to_mesh(self) -> "trimesh.Trimesh":
        """The counted surface, cut where who sees it, or whether it is reconstructed, changes.

        Returns
        -------
        trimesh.Trimesh
            `face_attributes` of each triangle: "parent", the face it comes from; "seen", (N, M) bool, which cameras see
            it; "met", whether it is reconstructed; "error", at its centre, along what the demand says [mm].
        """
        scene, demand = self._layouts._scene, self._layouts._demand
        surface, criterion = scene.surface, demand.of(self._cameras, scene.surface)
        tally, whole_met, piece_met = divided(surface, scene.counted, self._tally, criterion)
        whole = np.flatnonzero(scene.counted & ~tally.is_cut & (surface.areas > 0))
        mesh, piece = triangulated(scene.mesh, whole, tally.pieces.face, tally.pieces.polygon)
        attributes, predictor = mesh.face_attributes, demand.predictor(self._cameras, surface)
        attributes["seen"] = np.concatenate([tally.whole_seen[whole], tally.pieces.seen[piece]])
        attributes["met"] = np.concatenate([whole_met[whole], piece_met[piece]])
        total = predictor.totals(np.asarray(mesh.triangles_center), attributes["seen"])
        attributes["error"] = predictor.deviations(demand.error, attributes["parent"], total)
        return mesh


def _of_others(scene: Scene, others: Sequence[Camera], criterion: Criterion) -> Count:
    """The views of cameras before the one more is known."""
    count = Count.start(scene.counted & (scene.surface.areas > 0), len(others) + 1, scene.lit)
    coming = np.ones(len(others) + 1, dtype=bool)
    for block in np.split(spread_order(others), range(BLOCK, len(others), BLOCK)) if others else []:
        coming[block] = False
        count = add_views(count, scene.surface, others, block, coming, criterion)
    return count
