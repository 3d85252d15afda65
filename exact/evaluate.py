"""The two questions: what does one camera see, and what can a set of cameras reconstruct."""

from collections.abc import Callable, Sequence
from concurrent.futures import as_completed

import numpy as np
import shapely
import trimesh

from exact.cameras import Camera
from exact.clipping import OVERLAP, unite, whole_faces
from exact.coverage import Demand, Tally, processes, tally
from exact.errors import ExactError
from exact.projection import image_polygons
from exact.requests import (
    checked_cameras,
    checked_mask,
    checked_threshold,
    checked_weights,
    checked_workers,
    far_apart,
)
from exact.results import Reconstruction, View
from exact.surface import Surface, prepare


def view(mesh: trimesh.Trimesh, camera: Camera) -> View:
    """What `camera` sees of `mesh`, exactly.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        See `evaluate` for what counts.
    camera : Camera

    Returns
    -------
    View

    Examples
    --------
    >>> import trimesh
    >>> plate = trimesh.Trimesh([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> camera = Camera.look_at((0, 0, 400), target=(0, 0, 0), up=(0, 1, 0))
    >>> round(view(plate, camera).area, 9)
    100.0
    >>> view(plate, Camera.look_at((0, 0, -400), (0, 0, 0), up=(0, 1, 0))).area  # from behind
    0.0
    """
    surface = prepare(mesh)
    every_face = np.ones(len(surface.faces), dtype=bool)
    seen = tally(surface, checked_cameras([camera]), Demand(1, None), every_face, workers=1)
    whole = seen.whole_seen[:, 0] & ~seen.is_cut
    visible = seen.pieces.seen[:, 0]
    face, first = np.unique(seen.pieces.face[visible], return_index=True)
    group = np.repeat(np.arange(len(face)), np.diff(np.append(first, visible.sum())))
    piece, _, repairs = unite(group, seen.pieces.polygon[visible])
    areas = np.where(whole, surface.areas, 0.0)
    areas[face] = 2 * surface.areas[face] * shapely.area(piece)

    polygons = np.full(len(surface.faces), shapely.Polygon(), dtype=object)
    shown = np.flatnonzero(whole)
    polygons[shown] = image_polygons(surface, camera, shown, whole_faces(len(shown)))
    polygons[face] = image_polygons(surface, camera, face, piece)
    return View(camera, areas, polygons, seen.n_repairs + repairs, mesh, (shown, face, piece))


def evaluate(
    mesh: trimesh.Trimesh,
    cameras: Sequence[Camera],
    threshold: int = 2,
    exclude: np.ndarray | None = None,
    min_baseline: float = 0.0,
    depth_order: str = "exact",
    weights: np.ndarray | None = None,
    workers: int = 1,
    report: Callable[[int], object] | None = None,
) -> Reconstruction:
    """Area of `mesh` that at least `threshold` of the `cameras` see, exact up to float64 rounding.

    A point of a face is seen by a camera if the face turns its front (its normal) to the camera, the point is inside
    the field of view and in front of the lens, and no other face lies in front of it. Backs are never seen; those of
    an open surface do hide what is behind them. Of faces in the same place neither hides the other: coplanar
    overlapping or duplicate faces that look the same way count once each.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        Closed or open, in one or several shells, which may intersect each other and themselves.
    cameras : sequence of Camera
    threshold : int
        T, from 1 to the number of cameras.
    exclude : (F,) bool array, optional
        Faces that are not counted. They hide what is behind them all the same.
    min_baseline : float
        Count a point only if two of the cameras that see it are at least this far apart [mm].
    depth_order : {"exact", "vertex"}
        Which of two faces is in front: decided point by point, or, as in Wachter 2021, section 2.3, for the whole of
        their overlap by their nearest vertices, which is wrong for long or slanted faces and here for comparison only.
    weights : (F,) float array, optional
        Factor by which the area of each face counts, at least 0.
    workers : int
        Number of processes to share the work, which pays for many cameras or faces; the first call that needs them
        takes a moment to start them. The result does not depend on it.
    report : callable, optional
        Called with the number of further cameras done, from time to time; for progress bars.

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
    cameras = checked_cameras(cameras)
    threshold = checked_threshold(threshold, len(cameras))
    if depth_order not in ("exact", "vertex"):
        raise ExactError(f'depth_order is {depth_order!r}; it must be "exact" or "vertex"')
    workers = checked_workers(workers)
    surface = prepare(mesh)
    counted = ~checked_mask(exclude, len(surface.faces))
    weights = checked_weights(weights, len(surface.faces))
    demand = Demand(threshold, far_apart(cameras, min_baseline))
    seen = tally(surface, cameras, demand, counted, workers, report, depth_order)
    return _reconstruction(mesh, cameras, surface, seen, demand, counted, weights, float(min_baseline))


def areas(
    mesh: trimesh.Trimesh,
    layouts: Sequence[Sequence[Camera]],
    threshold: int = 2,
    exclude: np.ndarray | None = None,
    min_baseline: float = 0.0,
    weights: np.ndarray | None = None,
    workers: int = 1,
    report: Callable[[int], object] | None = None,
) -> np.ndarray:
    """Area that each of several sets of cameras reconstructs.

    Parameters
    ----------
    mesh, threshold, exclude, min_baseline, weights
        As for `evaluate`.
    layouts : sequence of sequences of Camera
    workers : int
        Number of processes among which the layouts are shared. The result does not depend on it.
    report : callable, optional
        Called with 1 for each layout done, in any order; for progress bars.

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
    surface = prepare(mesh)
    counted = ~checked_mask(exclude, len(surface.faces))
    weights = checked_weights(weights, len(surface.faces))
    tasks = []
    for cameras in layouts:
        cameras = checked_cameras(cameras)
        demand = Demand(checked_threshold(threshold, len(cameras)), far_apart(cameras, min_baseline))
        tasks.append((surface, cameras, demand, counted, weights))
    workers = min(checked_workers(workers), len(tasks))
    if workers <= 1:
        found = []
        for task in tasks:
            found.append(_area(*task))
            if report is not None:
                report(1)
        return np.array(found)
    _ = surface.solid  # found once, not by every worker
    with processes(workers) as executor:
        futures = [executor.submit(_area, *task) for task in tasks]
        for _ in as_completed(futures):
            if report is not None:
                report(1)
        return np.array([future.result() for future in futures])


def _area(surface: Surface, cameras: Sequence[Camera], demand: Demand, counted: np.ndarray, weights) -> float:
    seen = tally(surface, cameras, demand, counted, workers=1)
    nothing = trimesh.Trimesh()  # only the number goes back
    return _reconstruction(nothing, cameras, surface, seen, demand, counted, weights).area


def _reconstruction(
    mesh: trimesh.Trimesh, cameras: Sequence[Camera], surface: Surface, seen: Tally, demand: Demand, counted, weights,
    min_baseline=0.0,
) -> Reconstruction:  # fmt: skip
    """What a tally of views means."""
    whole = counted & ~seen.is_cut & (surface.areas > 0)
    whole_count, piece_count = seen.whole_seen.sum(axis=1), seen.pieces.seen.sum(axis=1)
    piece_area = 2 * surface.areas[seen.pieces.face] * shapely.area(seen.pieces.polygon)
    whole_met, piece_met = whole & demand.met(seen.whole_seen), demand.met(seen.pieces.seen)

    def face_areas(faces: np.ndarray, pieces: np.ndarray) -> np.ndarray:
        in_pieces = np.bincount(seen.pieces.face[pieces], weights=piece_area[pieces], minlength=len(surface.faces))
        return np.where(faces, surface.areas, 0.0) + np.minimum(in_pieces, surface.areas)

    filled = np.bincount(seen.pieces.face, weights=piece_area, minlength=len(surface.faces))
    overlapping = int((filled > surface.areas * (1 + OVERLAP)).sum())  # which `face_areas` cuts short
    levels = [
        face_areas(whole & (whole_count >= level), piece_count >= level) for level in range(1, demand.threshold + 1)
    ]
    return Reconstruction(
        demand.threshold, min_baseline, face_areas(whole_met, piece_met), np.stack(levels), weights,
        seen.n_repairs + overlapping, mesh, tuple(cameras), surface, seen, counted, whole_met, piece_met,
    )  # fmt: skip
