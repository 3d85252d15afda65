"""The part of every face that at least T cameras see: views added one block at a time, finished parts never again.

Wachter 2021 unites the intersections of all C(M, T) combinations of views. Here each face starts whole; the cameras
that cut it add their segments, and each resulting cell is asked for every camera. Parts that T cameras have seen are
set aside, parts in the same state are merged, and the next block of cameras meets only what is left.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import shapely

from exact.cameras import Camera
from exact.clipping import cut_pieces, whole_faces
from exact.occlusion import CUT, WHOLE, Cuts, Sight, look
from exact.projection import project
from exact.surface import Surface

# Cameras per block: enough to finish most faces before anything is cut, few enough to keep the drawings small.
BLOCK = 8


@dataclass(frozen=True, eq=False)
class Tally:
    """Which cameras see which part of which face.

    A face is either whole, with one row in `whole_seen`, or in pieces.

    Attributes
    ----------
    whole_seen : (F, M) bool
        Cameras that see the face, for faces not in pieces. Cameras that came after a face was finished stay False.
    is_cut : (F,) bool
        Whether the face is in pieces.
    piece_face : (P,) int
    piece : (P,) polygons or multipolygons in the face's own coordinates; together they fill the face
    piece_seen : (P, M) bool
        Cameras that see each piece, up to when it was finished. For merged pieces, one of several equivalent sets.
    n_repairs : int
    """

    whole_seen: np.ndarray
    is_cut: np.ndarray
    piece_face: np.ndarray
    piece: np.ndarray
    piece_seen: np.ndarray
    n_repairs: int


@dataclass(frozen=True, eq=False)
class Demand:
    """When a point counts as reconstructable: seen by `threshold` cameras, two of them far enough apart.

    `far` is (M, M) bool, or None if no baseline is asked for.
    """

    threshold: int
    far: np.ndarray | None

    def met(self, seen: np.ndarray) -> np.ndarray:
        """(N,) whether each row of `seen` (N, M) meets it."""
        enough = np.asarray(seen.sum(axis=1) >= self.threshold)
        if self.far is None:
            return enough
        paired = (seen & (seen.astype(np.float32) @ self.far.astype(np.float32) > 0)).any(axis=1)
        return enough & paired

    def state(self, seen: np.ndarray, coming: np.ndarray) -> np.ndarray:
        """(N, K) rows that are equal for parts that will meet the demand by the same future views `coming` (M,)."""
        count = np.minimum(seen.sum(axis=1), self.threshold)[:, None]
        if self.far is None:
            return count
        reach = seen.astype(np.float32) @ self.far.astype(np.float32) > 0
        paired = np.asarray((seen & reach).any(axis=1))
        return np.concatenate([count, paired[:, None], reach[:, coming] & ~paired[:, None]], axis=1)


def spread_order(cameras: Sequence[Camera]) -> np.ndarray:
    """(M,) order in which each camera is as far as possible from those before it."""
    position = np.array([camera.position for camera in cameras])
    order = [0]
    nearest = np.linalg.norm(position - position[0], axis=1)
    for _ in range(len(position) - 1):
        nearest[order[-1]] = -1.0
        order.append(int(np.argmax(nearest)))
        nearest = np.minimum(nearest, np.linalg.norm(position - position[order[-1]], axis=1))
    return np.array(order)


def tally(
    surface: Surface, cameras: Sequence[Camera], demand: Demand, active: np.ndarray, workers: int, report=None
) -> Tally:
    """Count the views of every part of the `active` faces, (F,) bool, until it meets `demand`."""
    n_faces, n_cameras = len(surface.faces), len(cameras)
    whole_seen = np.zeros((n_faces, n_cameras), dtype=bool)
    is_cut = np.zeros(n_faces, dtype=bool)
    active = active & (surface.areas > 0)
    done: list[tuple] = []
    face, piece, seen = np.zeros(0, dtype=int), np.zeros(0, dtype=object), np.zeros((0, n_cameras), dtype=bool)
    n_repairs = 0
    order = spread_order(cameras)
    coming = np.ones(n_cameras, dtype=bool)
    _ = surface.intersections  # found once, before several threads ask for them
    with ThreadPoolExecutor(max_workers=workers) as pool:
        for block in np.split(order, range(BLOCK, n_cameras, BLOCK)):

            def sight_of(i, active=active):
                return look(project(surface, cameras[i]), active)

            sights = list(pool.map(sight_of, block))
            coming[block] = False
            status = np.stack([sight.status for sight in sights], axis=1)
            n_repairs += sum(sight.n_repairs for sight in sights)
            untouched = active & ~is_cut
            whole_seen[np.ix_(untouched, block)] = status[untouched] == WHOLE
            finished = untouched & demand.met(whole_seen)
            begins = untouched & ~finished & (status == CUT).any(axis=1)
            is_cut |= begins
            new = np.flatnonzero(begins)
            face = np.concatenate([face, new])
            piece = np.concatenate([piece, whole_faces(len(new))])
            seen = np.concatenate([seen, whole_seen[new]])
            whole_seen[new] = False
            face, piece, seen, repairs = _cut_and_ask(face, piece, seen, sights, status, block, pool, workers)
            n_repairs += repairs
            met = demand.met(seen)
            done.append((face[met], piece[met], seen[met]))
            face, piece, seen = face[~met], piece[~met], seen[~met]
            if coming.any():
                face, piece, seen = _merge(face, piece, seen, demand.state(seen, coming))
            active = active & ~finished
            active[is_cut] = False
            active[face] = True
            if report is not None:
                report(len(block))
            if not active.any():
                break
    done.append((face, piece, seen))
    face, piece, seen = (np.concatenate([part[k] for part in done]) for k in range(3))
    by_face = np.argsort(face, kind="stable")
    return Tally(whole_seen, is_cut, face[by_face], piece[by_face], seen[by_face], n_repairs)


def _cut_and_ask(face, piece, seen, sights: list[Sight], status, block, pool, workers):
    """Cut pieces by the segments of a block of cameras and record which of the cameras see each cell."""
    if not len(face):
        return face, piece, seen, 0
    cuts = Cuts.joined([sight.cuts for sight in sights])
    shares = [share for share in np.array_split(np.arange(len(face)), 4 * workers) if len(share)]
    results = list(pool.map(lambda share: cut_pieces(face[share], piece[share], cuts), shares))
    origin = np.concatenate([share[result[0]] for share, result in zip(shares, results, strict=True)])
    cell = np.concatenate([result[1] for result in results])
    face, seen = face[origin], seen[origin]
    at = shapely.get_coordinates(shapely.point_on_surface(cell))
    seen[:, block] = status[face] == WHOLE

    def ask(k):
        asked = np.flatnonzero(status[face, k] == CUT)
        return asked, sights[k].sees(face[asked], at[asked])

    for k, (asked, answer) in enumerate(pool.map(ask, range(len(block)))):
        seen[asked, block[k]] = answer
    return face, cell, seen, sum(result[2] for result in results)


def _merge(face, piece, seen, state):
    """Unite the pieces of each face that are in the same state."""
    if not len(face):
        return face, piece, seen
    key = np.concatenate([face[:, None], state], axis=1)
    _, first, group = np.unique(key, axis=0, return_index=True, return_inverse=True)
    group = group.reshape(-1)
    order = np.argsort(group, kind="stable")
    parts, owner = shapely.get_parts(piece[order], return_index=True)
    together = np.asarray(shapely.multipolygons(parts, indices=group[order][owner]))
    return face[first], np.asarray(shapely.union_all(together[:, None], axis=1)), seen[first]
