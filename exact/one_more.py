"""Exact areas of layouts that differ in one camera: the views of the others are counted once."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from exact.cameras import Camera
from exact.demand import Criterion
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
        scene, self._demand = checked(mesh, asked)
        self._others = others = checked_cameras(others) if len(others) else ()
        self._demand.refuse_fewer(len(others) + 1)
        self._surface = scene.surface
        self._weight = self._surface.areas if scene.weights is None else self._surface.areas * scene.weights
        count = Count.start(scene.counted & (self._surface.areas > 0), len(others) + 1)
        criterion = self._so_far()
        coming = np.ones(len(others) + 1, dtype=bool)
        for block in np.split(spread_order(others), range(BLOCK, len(others), BLOCK)) if others else []:
            coming[block] = False
            count = add_views(count, self._surface, others, block, coming, criterion)
        whole = np.flatnonzero(scene.counted & ~count.is_cut & (self._surface.areas > 0))
        met = whole[criterion.met(count.whole_seen[whole])]
        self._base = float(self._weight[met].sum()) + sum(self._area(pieces) for pieces in count.done)
        # What one view more cannot bring to the threshold is not asked about.
        within_reach = count.waiting.take(count.waiting.seen.sum(axis=1) >= self._demand.threshold - 1)
        active = count.active & ~count.is_cut & (count.whole_seen.sum(axis=1) >= self._demand.threshold - 1)
        self._whole = np.flatnonzero(active)
        active[within_reach.face] = True
        self._count = Count(active, count.whole_seen, count.is_cut, within_reach, (), 0)

    def area(self, camera: Camera) -> float:
        """Reconstructable area [mm²] of the others and `camera`, as `evaluate` gives it up to rounding."""
        cameras = (*self._others, *checked_cameras([camera]))
        criterion = self._demand.of(cameras)
        last = np.array([len(self._others)])
        found = add_views(self._count, self._surface, cameras, last, np.zeros(len(cameras), dtype=bool), criterion)
        whole = self._whole[~found.is_cut[self._whole]]
        met = whole[criterion.met(found.whole_seen[whole])]
        return self._base + float(self._weight[met].sum()) + sum(self._area(pieces) for pieces in found.done)

    def _so_far(self) -> Criterion:
        """The criterion before the one more is known: it may be anywhere, and no pair with it counts yet."""
        known = self._demand.of(self._others)
        if known.far is None:
            return known
        # With a baseline it matters which cameras see a part, not only how many.
        return replace(known, far=np.pad(known.far, (0, 1)), sets=True)

    def _area(self, pieces: Pieces) -> float:
        return float((2 * self._weight[pieces.face] * shapely.area(pieces.polygon)).sum())
