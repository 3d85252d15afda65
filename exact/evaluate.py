"""What a set of cameras reconstructs."""

from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from typing import TYPE_CHECKING, Any

import numpy as np

from exact.cameras import Camera
from exact.demand import Criterion, Demand, every_view
from exact.errors import ExactError
from exact.predicted.reconstructed import area_by_face, piece_areas, reconstructed
from exact.requests import (
    ASKED,
    checked,
    checked_cameras,
    checked_workers,
    shows,
)
from exact.results import Reconstruction
from exact.scene import Scene
from exact.visibility.coverage import Tally, tally
from exact.visibility.pieces.clipping import OVERLAP
from exact.workers import processes

if TYPE_CHECKING:
    import trimesh


@shows(ASKED)
def evaluate(
    mesh: "trimesh.Trimesh | Scene",
    cameras: Sequence[Camera],
    *,
    depth_order: str = "exact",
    workers: int = 1,
    report: Callable[[int], object] | None = None,
    all_views: bool = False,
    **asked: Any,
) -> Reconstruction:
    """Area of `mesh` that at least T of the `cameras` see, exact up to float64 rounding.

    A point of a face is seen by a camera if the face turns its front (its normal) to the camera, the point is inside
    the field of view and in front of the lens, and no other face lies in front of it. Backs are never seen; those of
    an open surface do hide what is behind them. Of faces in the same place neither hides the other: coplanar
    overlapping or duplicate faces that look the same way count once each.

    Parameters
    ----------
    mesh : trimesh.Trimesh or Scene
        Closed or open, in one or several shells, which may intersect each other and themselves.
    cameras : sequence of Camera
    depth_order : {"exact", "vertex"}
        Which of two faces is in front: decided point by point, or, as in Wachter 2021, section 2.3, for the whole of
        their overlap by their nearest vertices, which is wrong for long or slanted faces and here for comparison only.
    workers : int
        Number of processes to share the work, which pays for many cameras or faces; the first call that needs them
        takes a moment to start them. The result does not depend on it.
    report : callable, optional
        Called with the number of further cameras done, from time to time; for progress bars.
    all_views : bool
        Look at every part from all cameras at once, instead of from as many as make it count: for whoever will read
        predicted errors, which need them all and then cost little more. Areas are the same up to rounding.
    exclude, weights, obstacles, lights
        Which faces of `mesh` count, and how much, and what hides and lights it: see `Scene`, which may take the place
        of `mesh`.
    threshold, min_baseline, max_error, error, depth_axis, limits, optics
        What makes a point count: see `Demand`, which may be given as `demand` instead.

    Returns
    -------
    Reconstruction

    Raises
    ------
    ExactError
        If the request is not possible, the mesh has no inside and outside (mixed winding), or a worker process dies.

    Examples
    --------
    >>> import trimesh
    >>> from exact import Ring
    >>> plate = trimesh.Trimesh([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> ring = Ring()
    >>> round(evaluate(plate, ring.cameras(ring.equidistant(4)), threshold=2).area, 9)
    100.0
    >>> evaluate(plate, ring.cameras([0.0, 0.1]), min_baseline=20.0).area  # too close to each other
    0.0
    """
    scene, demand = checked(mesh, asked)
    cameras = checked_cameras(cameras)
    demand.refuse_fewer(len(cameras))
    if depth_order not in ("exact", "vertex"):
        raise ExactError(f'depth_order is {depth_order!r}; it must be "exact" or "vertex"')
    criterion = demand.of(cameras, scene.surface)
    until = every_view(demand, cameras) if all_views else criterion
    seen = tally(scene.surface, cameras, until, scene.counted, checked_workers(workers), report, depth_order, scene.lit)
    return of_tally(scene, demand, cameras, criterion, seen, all_views)


def of_tally(
    scene: Scene,
    demand: Demand,
    cameras: tuple[Camera, ...],
    criterion: Criterion,
    seen: Tally,
    all_views: bool = False,
) -> Reconstruction:
    """What is reconstructed where the cameras see what has been `seen`; `all_views` says that all were asked."""
    met = reconstructed(scene.surface, scene.counted, seen, criterion)
    levels = [
        reconstructed(scene.surface, scene.counted, seen, Criterion(level)) for level in range(1, demand.threshold + 1)
    ]
    by_face, *by_level = (scene.of_mesh(area_by_face(scene.surface, *part)) for part in (met, *levels))
    return Reconstruction(
        scene, demand, by_face, np.stack(by_level), seen.n_repairs + _overlapping(scene, seen), cameras, seen, met,
        all_views,
    )  # fmt: skip


@shows(ASKED)
def areas(
    mesh: "trimesh.Trimesh | Scene",
    layouts: Sequence[Sequence[Camera]],
    *,
    workers: int = 1,
    report: Callable[[int], object] | None = None,
    **asked: Any,
) -> np.ndarray:
    """Area that each of several sets of cameras reconstructs.

    Parameters
    ----------
    mesh : trimesh.Trimesh or Scene
    layouts : sequence of sequences of Camera
    workers : int
        Number of processes among which the layouts are shared. The result does not depend on it.
    report : callable, optional
        Called with 1 for each layout done, in any order; for progress bars.
    **asked
        What counts, and on what, as for `evaluate`.

    Returns
    -------
    (L,) float
        `evaluate(...).area` for each [mm²], to the last bit.

    Raises
    ------
    ExactError
        If one of the requests is not possible, or a worker process dies.

    Examples
    --------
    >>> import trimesh
    >>> from exact import Ring
    >>> plate = trimesh.Trimesh([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> ring = Ring()
    >>> areas(plate, [ring.cameras(ring.equidistant(n)) for n in (2, 3)]).round(9).tolist()
    [100.0, 100.0]
    """
    scene, demand = checked(mesh, asked)
    tasks = []
    for cameras in map(checked_cameras, layouts):
        demand.refuse_fewer(len(cameras))
        tasks.append((cameras, demand.of(cameras, scene.surface)))
    workers = min(checked_workers(workers), len(tasks))
    if workers <= 1:
        found = []
        for task in tasks:
            found.append(_area(scene, *task))
            if report is not None:
                report(1)
        return np.array(found)
    _ = scene.surface.solid  # found once, not by every worker
    with processes(workers) as executor:
        futures = [executor.submit(_area, scene.without_mesh(), *task) for task in tasks]
        for _ in as_completed(futures):
            if report is not None:
                report(1)
        return np.array([future.result() for future in futures])


def _area(scene: Scene, cameras: Sequence[Camera], criterion: Criterion) -> float:
    seen = tally(scene.surface, cameras, criterion, scene.counted, workers=1, lit=scene.lit)
    met = reconstructed(scene.surface, scene.counted, seen, criterion)
    return float(scene.worth(area_by_face(scene.surface, *met)))


def _overlapping(scene: Scene, seen: Tally) -> int:
    """Faces whose pieces overlap by more than rounding, which `area_by_face` cuts short."""
    areas = scene.surface.areas
    filled = np.bincount(seen.pieces.face, piece_areas(scene.surface, seen.pieces), minlength=len(areas))
    return int((filled > areas * (1 + OVERLAP)).sum())
