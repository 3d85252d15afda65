"""Layouts that differ in one camera: the views of the others are counted once.

Where one camera after another may move, `in_turn` counts the views of most of them for several turns at once.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from exact.cameras import Camera
from exact.demand import Criterion, Demand, every_view
from exact.derivative.derivative import Derivative, MovingBorders, refuse_without_derivative
from exact.predicted.errors import Errors, errors_over
from exact.predicted.reconstructed import divided, reconstructed
from exact.requests import ASKED, checked, checked_cameras, shows
from exact.scene import Scene
from exact.view_sets import ViewSets, sets_of
from exact.visibility.coverage import BLOCK, Count, Tally, add_views, spread_order
from exact.visibility.pieces.pieces import Pieces
from exact.visibility.pieces.triangulated import triangulated

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
        criterion = self._so_far()
        self._begin(len(others), _of_others(scene, others, criterion), criterion)

    @classmethod
    def _of(
        cls, scene: Scene, demand: Demand, cameras: Sequence[Camera], place: int, count: Count, criterion: Criterion
    ) -> "OneMore":
        """With the views of all of some cameras but that at `place` counted already."""
        made = cls.__new__(cls)
        made._scene, made._demand = scene, demand
        made._others = (*cameras[:place], *cameras[place + 1 :])
        made._begin(place, count, criterion)
        return made

    def _begin(self, place: int, count: Count, criterion: Criterion) -> None:
        """What the others decide, and what is left for the one more, which has its `place` among all of them."""
        scene, demand, surface = self._scene, self._demand, self._scene.surface
        self._place = place
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
        every = MovingBorders.of(self._scene, self._demand, self._all(camera), found).derivative(criterion)
        return area, every.of_camera(self._place)

    def _all(self, camera: Camera) -> tuple[Camera, ...]:
        """(M,) the others and one more, in its place."""
        return (*self._others[: self._place], *checked_cameras([camera]), *self._others[self._place :])

    def _with(self, camera: Camera, count: Count) -> tuple[float, Tally, Criterion]:
        """The area with one more camera, what all of them see of what it can decide, and by what that is decided."""
        cameras, surface = self._all(camera), self._scene.surface
        criterion = self._demand.of(cameras, surface)
        one = np.array([self._place])
        found = add_views(count, surface, cameras, one, np.zeros(len(cameras), dtype=bool), criterion).tally()
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


Turn = Callable[[int, list[OneMore]], Camera | None]


def in_turn(
    scenes: Sequence[Scene], cameras: Sequence[Camera], demand: Demand, which: Sequence[int], turn: Turn
) -> tuple[Camera, ...]:
    """Let one camera after another move, the others held.

    To count the views of M - 1 others anew for each of M cameras takes M (M - 1) views. Here one half of those that may
    move is counted, then each of the other half gets its turn in the same way, and the other way about, which takes
    some M log M views.

    Parameters
    ----------
    scenes : (S,) sequence of Scene
    cameras : (M,) sequence of Camera
    demand : Demand
        Without a bound on the error.
    which : sequence of int
        Those that may move, in the order of their turns.
    turn : callable
        Takes the index of a camera and a `OneMore` of the others for each scene, and gives the camera that takes its
        place; None leaves it.

    Returns
    -------
    (M,) tuple of Camera
        All of them, where they are now.

    Examples
    --------
    >>> import trimesh
    >>> from exact import Ring
    >>> scene, ring = Scene(trimesh.creation.box((10, 10, 1))), Ring(fov=(6, 6))
    >>> told = []
    >>> def turn(index, layouts):
    ...     told.append((index, round(layouts[0].area(ring.cameras([2.0])[0]), 6)))
    >>> _ = in_turn([scene], ring.cameras([0.0, 1.0, 1.5]), Demand(), [0, 2], turn)
    >>> [index for index, _ in told], all(area > 0 for _, area in told)
    ([0, 2], True)
    """
    cameras = list(cameras)
    counted = np.zeros(len(cameras), dtype=bool)

    def criterion(scene: Scene) -> Criterion:
        # Cameras that are still to move see nothing yet, so that it does not matter where they are.
        known = demand.of(cameras, scene.surface)
        return known if known.far is None else replace(known, sets=True)

    def added(counts: list[Count], more: Sequence[int], others: np.ndarray) -> list[Count]:
        """With the views of `more` cameras beside the `others`, (M,) bool, which are counted already."""
        if not len(more):
            return counts
        order = np.asarray(more)[spread_order([cameras[k] for k in more])]
        found = []
        for scene, count in zip(scenes, counts, strict=True):
            coming = ~others
            for block in np.split(order, range(BLOCK, len(order), BLOCK)):
                coming[block] = False
                count = add_views(count, scene.surface, cameras, block, coming, criterion(scene))
            found.append(count)
        return found

    def turns(counts: list[Count], others: np.ndarray, inside: list[int]) -> None:
        """The turns of the cameras `inside`, where the views of all `others` are counted."""
        if len(inside) == 1:
            (k,) = inside
            layouts = [
                OneMore._of(scene, demand, cameras, k, count, criterion(scene))
                for scene, count in zip(scenes, counts, strict=True)
            ]
            cameras[k] = turn(k, layouts) or cameras[k]
            return
        half = (len(inside) + 1) // 2
        for own, rest in ((inside[:half], inside[half:]), (inside[half:], inside[:half])):
            with_rest = others.copy()
            with_rest[rest] = True
            turns(added(counts, rest, others), with_rest, own)

    if which:
        rest = np.delete(np.arange(len(cameras)), which)
        start = [
            Count.start(scene.counted & (scene.surface.areas > 0), len(cameras), scene.lit) for scene in scenes
        ]  # fmt: skip
        first = added(start, rest.tolist(), counted)
        counted[rest] = True
        turns(first, counted, list(which))
    return tuple(cameras)


def _of_others(scene: Scene, others: Sequence[Camera], criterion: Criterion) -> Count:
    """The views of cameras before the one more is known."""
    count = Count.start(scene.counted & (scene.surface.areas > 0), len(others) + 1, scene.lit)
    coming = np.ones(len(others) + 1, dtype=bool)
    for block in np.split(spread_order(others), range(BLOCK, len(others), BLOCK)) if others else []:
        coming[block] = False
        count = add_views(count, scene.surface, others, block, coming, criterion)
    return count
