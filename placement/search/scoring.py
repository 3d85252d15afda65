"""The one place that turns layouts into exact areas, each of them once."""

from collections.abc import Callable, Sequence

import numpy as np

import exact
from exact.workers import processes
from placement.layouts.distinct import canonical
from placement.progress import Progress
from placement.search.ring_maximum import RingMaximum
from placement.sites import Sites


class ExactScorer:
    """Exact areas of layouts on one ring over one site or several; each layout is evaluated once.

    Parameters
    ----------
    sites : Sites
        What is to be reconstructed.
    ring : exact.Ring
        The ring.
    demand : exact.Demand
        What makes a point count.
    ring_maximum : RingMaximum
        Of these sites and this ring.
    workers : int
        Processes that share the work; the areas do not depend on it.

    Examples
    --------
    >>> import trimesh
    >>> from placement.sites import checked_sites
    >>> plate = checked_sites(trimesh.creation.box((10, 10, 1)))
    >>> demand, ring = exact.Demand(threshold=1), exact.Ring()
    >>> scorer = ExactScorer(plate, ring, demand, RingMaximum(plate, ring, demand, n_cameras=8))
    >>> bool(100.0 <= scorer.areas([0.0])[0] < 120.0), bool(0.5 < scorer.fraction([0.0]) < 1.0)
    (True, True)
    """

    def __init__(
        self,
        sites: Sites,
        ring: exact.Ring,
        demand: exact.Demand,
        ring_maximum: RingMaximum,
        workers: int = 1,
    ):
        self.sites, self.ring, self.demand = sites, ring, demand
        self._workers = workers
        self._areas: dict[bytes, tuple[float, ...]] = {}
        self._errors: dict[bytes, float] = {}
        self._ring_maximum = ring_maximum

    @property
    def ring_areas(self) -> tuple[float, ...]:
        """(S,) exact area [mm²] of the ring maximum of each site."""
        return self._ring_maximum.areas

    def areas(self, angles) -> tuple[float, ...]:
        """Exact reconstructable area [mm²] of each site for a layout of (M,) ring angles [rad]."""
        return self.many([angles])[0]

    def many(self, layouts: Sequence, report: Callable[[int], object] | None = None) -> list[tuple[float, ...]]:
        """`areas` of several layouts; `report` is told 1 for each evaluation."""
        turned = [canonical(layout) for layout in layouts]
        new = list({theta.tobytes(): theta for theta in turned if theta.tobytes() not in self._areas}.values())
        if new:
            cameras = [self.ring.cameras(theta) for theta in new]
            found = [
                exact.areas(site.scene, cameras, demand=self.demand, workers=self._workers, report=report)
                for site in self.sites.members
            ]
            for theta, of_sites in zip(new, np.stack(found, axis=1).tolist(), strict=True):
                self._areas[theta.tobytes()] = tuple(of_sites)
        return [self._areas[theta.tobytes()] for theta in turned]

    def with_progress(self, layouts: Sequence, progress: Progress) -> list[tuple[float, ...]]:
        """`many`, saying how far it is."""
        done, total = 0, len(self.sites.members) * len({canonical(layout).tobytes() for layout in layouts})

        def on_evaluation(steps: int) -> None:
            nonlocal done
            done += steps
            progress("scoring exactly", min(done, total), total)

        found = self.many(layouts, on_evaluation)
        progress("scoring exactly", total, total)
        return found

    def fraction(self, angles) -> float:
        """Exact fraction of the ring maximum for a layout, over all sites as their objective says."""
        return self.combined(self.areas(angles))

    def combined(self, areas: Sequence[float]) -> float:
        """Fraction of the ring maximum, over all sites, from their (S,) areas [mm²]."""
        return self.sites.combined(np.array(areas) / np.array(self.ring_areas))

    def errors(self, layouts: Sequence) -> list[float]:
        """Root mean square of the predicted errors [mm] over all that each layout reconstructs of all sites.

        Infinite where single cameras count, and for a layout that reconstructs nothing.
        """
        turned = [canonical(layout) for layout in layouts]
        new = list({theta.tobytes(): theta for theta in turned if theta.tobytes() not in self._errors}.values())
        tasks = [(site.scene.without_mesh(), self.ring.cameras(theta)) for theta in new for site in self.sites.members]
        if self._workers <= 1 or len(tasks) == 1:
            found = [squared_errors(*task, self.demand) for task in tasks]
        else:
            with processes(self._workers) as executor:
                futures = [executor.submit(squared_errors, *task, self.demand) for task in tasks]
                found = [future.result() for future in futures]
        sums = np.reshape(found, (len(new), len(self.sites.members), 2)).sum(axis=1)
        for theta, (squares, total) in zip(new, sums.tolist(), strict=True):
            self._errors[theta.tobytes()] = float(np.sqrt(squares / total)) if total > 0 else np.inf
        return [self._errors[theta.tobytes()] for theta in turned]

    def error_of(self, cameras: Sequence[exact.Camera]) -> float:
        """Root mean square of the predicted errors [mm] over all that these cameras reconstruct of all sites."""
        found = [squared_errors(site.scene, cameras, self.demand) for site in self.sites.members]
        squares, total = (float(sum(values)) for values in zip(*found, strict=True))
        return float(np.sqrt(squares / total)) if total > 0 else np.inf

    def moving(self, angles, camera: int) -> Callable[[float], float]:
        """`fraction` of a layout as a function of the ring angle [rad] of one of its cameras, the others held."""
        others = self.ring.cameras(np.delete(angles, camera)) if len(angles) > 1 else ()
        layouts = [exact.OneMore(site.scene, others, demand=self.demand) for site in self.sites.members]
        return lambda angle: self.combined([one.area(self.ring.cameras([angle])[0]) for one in layouts])


def squared_errors(scene: exact.Scene, cameras: Sequence[exact.Camera], demand: exact.Demand) -> tuple[float, float]:
    """Integral of the squared errors over what the cameras reconstruct [mm⁴], and its area [mm²]."""
    errors = exact.evaluate(scene, cameras, demand=demand, all_views=True).errors
    return float(errors.weights @ getattr(errors, demand.error) ** 2), float(errors.weights.sum())
