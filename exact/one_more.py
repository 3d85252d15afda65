"""Exact areas of layouts that differ in one camera: the views of the others are counted once."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from exact.cameras import Camera
from exact.demand import Criterion
from exact.predicted.reconstructed import reconstructed
from exact.requests import ASKED, checked, checked_cameras, shows
from exact.scene import Scene
from exact.visibility.coverage import BLOCK, Count, Pieces, add_views, spread_order

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
        surface = scene.surface
        count = Count.start(scene.counted & (surface.areas > 0), len(others) + 1, scene.lit)
        criterion = self._so_far()
        coming = np.ones(len(others) + 1, dtype=bool)
        for block in np.split(spread_order(others), range(BLOCK, len(others), BLOCK)) if others else []:
            coming[block] = False
            count = add_views(count, surface, others, block, coming, criterion)
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
        cameras = (*self._others, *checked_cameras([camera]))
        surface = self._scene.surface
        criterion = self._demand.of(cameras, surface)
        last = np.array([len(self._others)])
        found = add_views(self._count, surface, cameras, last, np.zeros(len(cameras), dtype=bool), criterion)
        whole, pieces = reconstructed(surface, self._open, found.tally(), criterion)
        return self._base + self._worth(whole, pieces)

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
