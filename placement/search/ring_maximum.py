"""The most that any layout of a ring could reconstruct: exact areas of very many equidistant cameras."""

import hashlib
from collections.abc import Callable
from concurrent.futures import Future
from functools import cache
from pathlib import Path
from threading import Lock
from typing import Protocol, runtime_checkable

import numpy as np
import shapely

import exact
from exact.workers import background
from placement.sites import Site, Sites

# Cameras of a ring no wider than this [mm] are all in one place: of them together nothing is triangulated.
ON_AXIS = 1e-2


@runtime_checkable
class Memory(Protocol):
    """Areas that were evaluated before, by all that they depend on; a dict will do."""

    def get(self, key: str, /) -> float | None:
        """The area, or None if it is not known."""
        ...

    def __setitem__(self, key: str, area: float, /) -> None: ...


class RingMaximum:
    """What all the ring sees of each site, whatever the baseline that a layout must keep.

    It is what very many equidistant cameras reconstruct, and no bound: a layout that looks through slits between
    them can reconstruct a little more, a fraction above 1. For bounds see `placement.certify`.

    Parameters
    ----------
    sites : Sites
        What is to be reconstructed.
    ring : exact.Ring or tuple of exact.Ring
        The ring, or several that are taken together.
    demand : exact.Demand
        What makes a point count; its baseline is left out, so that fractions under different baselines compare.
    n_cameras : int
        Number of equidistant cameras, on each ring; beside wider rings, one on a ring that is one place, to `ON_AXIS`.
    workers : int
        Processes that share the work; the areas do not depend on it.
    memory : Memory, optional
        Where areas are looked up first, and kept. They are found again only by the same code and libraries.
    report : callable, optional
        Called with the number of further cameras done, from time to time.

    Examples
    --------
    >>> import trimesh
    >>> from placement.sites import checked_sites
    >>> plate, memory = checked_sites(trimesh.creation.box((10, 10, 1))), {}
    >>> seen = exact.Demand()
    >>> bool(100.0 < RingMaximum(plate, exact.Ring(), seen, n_cameras=8, memory=memory).areas[0] <= 140.0 + 1e-9)
    True
    >>> RingMaximum(plate, exact.Ring(), seen, n_cameras=8, memory=memory).areas == tuple(memory.values())
    True
    """

    def __init__(
        self,
        sites: Sites,
        ring: exact.Ring | tuple[exact.Ring, ...],
        demand: exact.Demand,
        *,
        n_cameras: int = 360,
        workers: int = 1,
        memory: Memory | None = None,
        report: Callable[[int], object] | None = None,
    ):
        self._sites, self._demand, self._workers, self._memory = sites, unbased(demand), workers, memory
        self._report = report
        self._ring, self._n_cameras = ring, n_cameras
        self._found: Future[tuple[float, ...]] | None = None
        self._once = Lock()

    def begin(self) -> None:
        """Let other processes evaluate it while this one goes on; with one worker nothing happens."""
        if self._workers > 1:
            self._result()

    @property
    def areas(self) -> tuple[float, ...]:
        """(S,) exact area of each site [mm²]."""
        return self._result().result()

    def _result(self) -> "Future[tuple[float, ...]]":
        """The areas, evaluated once for all that want them; where processes do the work, in a thread of its own."""
        with self._once:
            if self._found is None and self._workers > 1:
                self._found = background(self._evaluate)
            elif self._found is None:
                found: Future[tuple[float, ...]] = Future()
                found.set_result(self._evaluate())
                self._found = found
            return self._found

    def _evaluate(self) -> tuple[float, ...]:
        return tuple(self._area(site) for site in self._sites.members)

    def _area(self, site: Site) -> float:
        if self._memory is None:
            return self._evaluated(site)
        key = self._key(site)
        found = self._memory.get(key)
        if found is None:
            found = self._memory[key] = self._evaluated(site)
        return found

    def _evaluated(self, site: Site) -> float:
        rings = (self._ring,) if isinstance(self._ring, exact.Ring) else self._ring
        one_place = [ring.diameter <= ON_AXIS for ring in rings]
        numbers = [1 if at_one and not all(one_place) else self._n_cameras for at_one in one_place]
        cameras = [one for ring, n in zip(rings, numbers, strict=True) for one in ring.cameras(ring.equidistant(n))]
        return exact.evaluate(site.scene, cameras, demand=self._demand, workers=self._workers, report=self._report).area

    def _key(self, site: Site) -> str:
        content = hashlib.sha256(repr((_evaluator(), self._ring, self._demand, self._n_cameras)).encode())
        content.update(site.scene.content_hash.encode())
        return content.hexdigest()


def unbased(demand: exact.Demand) -> exact.Demand:
    """The same without baseline and bound on the error: what the ring maximum is asked for."""
    limits = demand.limits
    return exact.Demand(demand.threshold, limits=limits, optics=demand.optics if limits.is_any else exact.Optics())


@cache
def _evaluator() -> tuple[str, ...]:
    """What computes an area: this very code, and the libraries under it."""
    code = hashlib.sha256()
    for file in sorted(Path(exact.__file__).parent.rglob("*.py")):
        code.update(file.read_bytes())
    return code.hexdigest(), np.__version__, shapely.__version__, shapely.geos_version_string
