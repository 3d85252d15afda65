"""Exact areas of layouts that differ in one camera: the views of the others are counted once."""

from collections.abc import Sequence

import numpy as np
import shapely
import trimesh

from exact.cameras import Camera
from exact.coverage import BLOCK, Count, Demand, Pieces, add_views, spread_order
from exact.requests import checked_cameras, checked_mask, checked_threshold, checked_weights, far_apart
from exact.surface import prepare


class OneMore:
    """The reconstructable area of given cameras and one more, for as many choices of that one as are tried.

    Most of the surface is decided by the others. Each choice computes one view, of the parts that it can decide.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        See `evaluate`.
    others : sequence of Camera
        Cameras that stay; may be empty.
    threshold : int
        T, from 1 to the number of cameras with the one more.
    exclude, min_baseline, weights
        As for `evaluate`.

    Raises
    ------
    ExactError
        If the request is not possible.

    Examples
    --------
    >>> from exact import Ring
    >>> plate = trimesh.Trimesh([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> one, two, three = Ring().cameras([0.0, 1.0, 2.0])
    >>> layouts = OneMore(plate, [one], threshold=2)
    >>> round(layouts.area(two), 9), round(layouts.area(three), 9)
    (100.0, 100.0)
    """

    def __init__(
        self,
        mesh: trimesh.Trimesh,
        others: Sequence[Camera],
        threshold: int = 2,
        exclude: np.ndarray | None = None,
        min_baseline: float = 0.0,
        weights: np.ndarray | None = None,
    ):
        others = checked_cameras(others) if len(others) else ()
        self._threshold = checked_threshold(threshold, len(others) + 1)
        self._others, self._min_baseline = others, min_baseline
        self._surface = prepare(mesh)
        n_faces = len(self._surface.faces)
        counted = ~checked_mask(exclude, n_faces)
        weights = checked_weights(weights, n_faces)
        self._weight = self._surface.areas if weights is None else self._surface.areas * weights
        count = Count.start(counted & (self._surface.areas > 0), len(others) + 1)
        apart = far_apart(others, min_baseline)
        far = None if apart is None else np.pad(apart, (0, 1))
        # With a baseline it matters which cameras see a part, not only how many: the one more may be anywhere.
        demand = Demand(self._threshold, far, sets=far is not None)
        coming = np.ones(len(others) + 1, dtype=bool)
        for block in np.split(spread_order(others), range(BLOCK, len(others), BLOCK)) if others else []:
            coming[block] = False
            count = add_views(count, self._surface, others, block, coming, demand)
        whole = np.flatnonzero(counted & ~count.is_cut & (self._surface.areas > 0))
        met = whole[demand.met(count.whole_seen[whole])]
        self._base = float(self._weight[met].sum()) + sum(self._area(pieces) for pieces in count.done)
        # What one view more cannot bring to the threshold is not asked about.
        within_reach = count.waiting.take(count.waiting.seen.sum(axis=1) >= self._threshold - 1)
        active = count.active & ~count.is_cut & (count.whole_seen.sum(axis=1) >= self._threshold - 1)
        self._whole = np.flatnonzero(active)
        active[within_reach.face] = True
        self._count = Count(active, count.whole_seen, count.is_cut, within_reach, (), 0)

    def area(self, camera: Camera) -> float:
        """Reconstructable area [mm²] of the others and `camera`, as `evaluate` gives it up to rounding."""
        cameras = (*self._others, *checked_cameras([camera]))
        demand = Demand(self._threshold, far_apart(cameras, self._min_baseline))
        last = np.array([len(self._others)])
        found = add_views(self._count, self._surface, cameras, last, np.zeros(len(cameras), dtype=bool), demand)
        whole = self._whole[~found.is_cut[self._whole]]
        met = whole[demand.met(found.whole_seen[whole])]
        return self._base + float(self._weight[met].sum()) + sum(self._area(pieces) for pieces in found.done)

    def _area(self, pieces: Pieces) -> float:
        return float((2 * self._weight[pieces.face] * shapely.area(pieces.polygon)).sum())
