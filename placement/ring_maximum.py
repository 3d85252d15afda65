"""The most that any layout of a ring could reconstruct: exact areas of very many equidistant cameras."""

import hashlib
from concurrent.futures import Future, ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
import shapely

import exact
from placement.sites import Site, Sites


@runtime_checkable
class Memory(Protocol):
    """Areas that were evaluated before, by all that they depend on; a dict will do."""

    def get(self, key: str, /) -> float | None:
        """The area, or None if it is not known."""
        ...

    def __setitem__(self, key: str, area: float, /) -> None: ...


class RingMaximum:
    """What all the ring sees of each site, whatever the baseline asked of a layout.

    Parameters
    ----------
    sites : Sites
        What is to be reconstructed.
    ring : exact.Ring
        The ring.
    threshold : int
        How many cameras must see a point.
    n_cameras : int
        Number of equidistant cameras.
    workers : int
        Processes that share the work; the areas do not depend on it.
    memory : Memory, optional
        Where areas are looked up first, and kept. They are found again only by the same code and libraries.

    Examples
    --------
    >>> import trimesh
    >>> from placement.sites import checked_sites
    >>> plate, memory = checked_sites(trimesh.creation.box((10, 10, 1))), {}
    >>> bool(100.0 < RingMaximum(plate, exact.Ring(), n_cameras=8, memory=memory).areas[0] <= 140.0 + 1e-9)
    True
    >>> RingMaximum(plate, exact.Ring(), n_cameras=8, memory=memory).areas == tuple(memory.values())
    True
    """

    def __init__(
        self,
        sites: Sites,
        ring: exact.Ring,
        threshold: int = 2,
        n_cameras: int = 360,
        workers: int = 1,
        memory: Memory | None = None,
    ):
        self._sites, self._threshold, self._workers, self._memory = sites, threshold, workers, memory
        self._ring, self._n_cameras = ring, n_cameras
        self._areas: tuple[float, ...] | None = None
        self._begun: Future | None = None

    def begin(self) -> None:
        """Let other processes evaluate it while this one goes on; with one worker nothing happens."""
        if self._workers > 1 and self._areas is None and self._begun is None:
            thread = ThreadPoolExecutor(1)
            self._begun = thread.submit(self._evaluate)
            thread.shutdown(wait=False)

    @property
    def areas(self) -> tuple[float, ...]:
        """(S,) exact area of each site [mm²]."""
        if self._areas is None:
            begun, self._begun = self._begun, None
            self._areas = self._evaluate() if begun is None else begun.result()
        return self._areas

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
        cameras = self._ring.cameras(self._ring.equidistant(self._n_cameras))
        return exact.evaluate(**evaluation(site, self._threshold), cameras=cameras, workers=self._workers).area

    def _key(self, site: Site) -> str:
        content = hashlib.sha256(repr((_evaluator(), self._ring, self._threshold, self._n_cameras)).encode())
        content.update(site.mesh_hash.encode() + site.excluded.tobytes())
        content.update(b"" if site.face_weights is None else site.face_weights.astype(np.float64).tobytes())
        return content.hexdigest()


@cache
def _evaluator() -> tuple[str, ...]:
    """What computes an area: this very code, and the libraries under it."""
    code = hashlib.sha256()
    for file in sorted(Path(exact.__file__).parent.glob("*.py")):
        code.update(file.read_bytes())
    return code.hexdigest(), np.__version__, shapely.__version__, shapely.geos_version_string


def evaluation(site: Site, threshold: int, min_baseline: float = 0.0) -> dict:
    """Keyword arguments of the evaluator that do not depend on the cameras."""
    return dict(
        mesh=site.mesh,
        threshold=threshold,
        exclude=site.excluded,
        min_baseline=min_baseline,
        weights=site.face_weights,
    )
