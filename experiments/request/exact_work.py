"""Exact areas of one mesh: by how many processes, and of all the ring."""

from collections.abc import Callable

import exact
from exact.workers import available_cores
from experiments.files.ring_maximum_cache import RememberedAreas
from placement.search.ring_maximum import RingMaximum
from placement.sites import checked_sites

# Faces times cameras beyond which it pays to start further processes: some seconds of work.
WORTH_SHARING = 400_000


def workers_for(scene: exact.Scene, n_cameras: int) -> int:
    """Processes that share the work on so many cameras: all cores, or this one alone.

    Examples
    --------
    >>> import trimesh
    >>> workers_for(exact.Scene(trimesh.creation.box()), 8)
    1
    """
    return available_cores() if scene.n_faces * n_cameras > WORTH_SHARING else 1


def ring_maximum(
    scene: exact.Scene,
    rings: tuple[exact.Ring, ...],
    demand: exact.Demand,
    n_cameras: int,
    report: Callable[[int], object] | None = None,
    workers: int | None = None,
) -> float:
    """Area [mm²] that so many cameras on each ring reconstruct, evaluated or remembered.

    `report` is told the number of further cameras done. By default as many `workers` as the work is worth.

    Examples
    --------
    >>> import trimesh
    >>> scene, ring = exact.Scene(trimesh.creation.box((10, 10, 1))), exact.Ring()
    >>> bool(100.0 < ring_maximum(scene, (ring,), exact.Demand(), 8) <= 140.0 + 1e-9)
    True
    """
    whole = RingMaximum(
        checked_sites(scene), rings[0] if len(rings) == 1 else rings, demand, n_cameras=n_cameras,
        workers=workers_for(scene, n_cameras * len(rings)) if workers is None else workers,
        memory=RememberedAreas(), report=report,
    )  # fmt: skip
    return whole.areas[0]
