"""Exact areas and errors of layouts with rolls, and the last tenths of a degree of both."""

from collections.abc import Sequence

import numpy as np

import exact
from placement.layouts.arcs import LayoutSpace
from placement.samples.rolled_samples import canonical_rolled
from placement.search.polish import WORTHWHILE
from placement.search.rolled_coverage import RolledLayout
from placement.search.scoring import ExactScorer


class RolledScorer:
    """Exact areas of layouts with rolls on the ring of a scorer; each is evaluated once.

    Parameters
    ----------
    scorer : ExactScorer
        Of the same ring without rolls.
    workers : int
        Processes that share the work; the areas do not depend on it.
    """

    def __init__(self, scorer: ExactScorer, workers: int = 1):
        self._scorer, self._workers = scorer, workers
        self._areas: dict[bytes, tuple[float, ...]] = {}

    def many(self, layouts: Sequence[RolledLayout]) -> list[tuple[float, ...]]:
        """(S,) exact areas of the sites [mm²] for each layout."""
        keyed = {_key(layout): layout for layout in layouts}
        new = {key: layout for key, layout in keyed.items() if key not in self._areas}
        if new:
            cameras = [self._scorer.ring.cameras(*canonical_rolled(*layout)) for layout in new.values()]
            found = [
                exact.areas(site.scene, cameras, demand=self._scorer.demand, workers=self._workers)
                for site in self._scorer.sites.members
            ]
            for key, of_sites in zip(new, np.stack(found, axis=1).tolist(), strict=True):
                self._areas[key] = tuple(of_sites)
        return [self._areas[_key(layout)] for layout in layouts]

    def fraction(self, layout: RolledLayout) -> float:
        """Exact fraction of the ring maximum, over all sites as their objective says."""
        return self._scorer.combined(self.many([layout])[0])

    def error(self, layout: RolledLayout) -> float:
        """Root mean square of the predicted errors [mm] over all that a layout reconstructs; infinite for nothing."""
        cameras = self._scorer.ring.cameras(*canonical_rolled(*layout))
        return self._scorer.error_of(cameras)

    def polished(
        self, space: LayoutSpace, layout: RolledLayout, steps: tuple[float, ...], max_sweeps: int
    ) -> tuple[RolledLayout, int]:
        """Move and turn one camera at a time, by falling steps [rad], as long as the exact fraction grows.

        Returns
        -------
        RolledLayout
            Whose exact fraction is at least that of the start; fixed cameras are turned only.
        int
            Number of moves tried.
        """
        angles, rolls = (values.copy() for values in layout)
        best, n_moves = self.fraction(layout), 0
        for _ in range(max_sweeps):
            before = best
            free = set(space.free_cameras(angles).tolist())
            for camera in range(len(angles)):
                others = np.delete(np.arange(len(angles)), camera)
                fixed = self._scorer.ring.cameras(angles[others], rolls[others]) if len(others) else ()
                alone = [
                    exact.OneMore(site.scene, fixed, demand=self._scorer.demand) for site in self._scorer.sites.members
                ]
                for step in steps:
                    ways = [(step, 0.0), (-step, 0.0)] * (camera in free) + [(0.0, step), (0.0, -step)]
                    for along, about in ways:
                        while True:
                            angle, roll = angles[camera] + along, rolls[camera] + about
                            if along and not space.allowed(np.array([angle]), angles[others])[0]:
                                break
                            (moved,) = self._scorer.ring.cameras([angle], [roll])
                            found = self._scorer.combined([one.area(moved) for one in alone])
                            n_moves += 1
                            if found <= best + WORTHWHILE:
                                break
                            angles[camera], rolls[camera], best = angle, roll, found
            if best <= before + WORTHWHILE:
                break
        return RolledLayout(angles, rolls), n_moves


def _key(layout: RolledLayout) -> bytes:
    return b"".join(values.tobytes() for values in canonical_rolled(*layout))
