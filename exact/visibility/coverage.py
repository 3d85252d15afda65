"""The part of every face that at least T cameras see: views added one at a time, finished parts never again.

Wachter 2021 unites the intersections of all C(M, T) combinations of views. Here each face starts whole, and a camera
that sees only part of it cuts it. Parts that T cameras have seen are set aside, parts in the same state are merged,
and the next camera meets only what is left. Late in a long row that is many pieces, hidden but for a few: a camera is
first asked about the convex hull of all that is left of a face, and of the pieces only about those it may see.
"""

import gc
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import as_completed
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from exact.cameras import Camera
from exact.demand import Criterion
from exact.visibility.limits import Usable
from exact.visibility.occlusion import CUT, HIDDEN, WHOLE, Prospect, Sight, look, prospect
from exact.visibility.pieces.clipping import whole_faces
from exact.visibility.pieces.pieces import HullsSeen, Pieces, cells_of, look_at_hulls, merged
from exact.visibility.projection import project
from exact.visibility.silhouettes import Cuts
from exact.visibility.surface import Part, Surface
from exact.workers import processes, shares

# Cameras per block. Within a block no face is cut before all its cameras have been looked through, since most faces
# are seen whole often enough and never need to be.
BLOCK = 8
# If as many cameras are still to come, those near each other are first looked at together.
MANY = 48


@dataclass(frozen=True, eq=False)
class Tally:
    """Which cameras see which part of which face: a face is either whole or in pieces that fill it.

    Attributes
    ----------
    whole_seen : (F, M) bool
        Cameras that see the face. Those that came after a face was finished stay False; so do faces in pieces.
    is_cut : (F,) bool
        Whether the face is in pieces.
    pieces : Pieces
    n_repairs : int
    cuts : tuple of (int, Cuts)
        Cameras and the segments along which each cut faces in pieces, if they were to be kept.
    """

    whole_seen: np.ndarray
    is_cut: np.ndarray
    pieces: Pieces
    n_repairs: int
    cuts: tuple[tuple[int, Cuts], ...] = ()


@dataclass(frozen=True, eq=False)
class Count:
    """How far the counting has come.

    Attributes
    ----------
    active : (F,) bool
        Faces of which some part still waits for views.
    whole_seen : (F, M) bool
    is_cut : (F,) bool
    waiting : Pieces
        Those that do not meet the criterion yet.
    done : tuple of Pieces
    n_repairs : int
    prospect : Prospect or None
        Of which active faces each camera may see something, if that is known.
    cuts : tuple of (int, Cuts) or None
        As of a `Tally`; None if they are not kept.
    """

    active: np.ndarray
    whole_seen: np.ndarray
    is_cut: np.ndarray
    waiting: Pieces
    done: tuple[Pieces, ...]
    n_repairs: int
    prospect: Prospect | None = None
    cuts: tuple[tuple[int, Cuts], ...] | None = None

    def possible(self, face: np.ndarray, seen: np.ndarray, coming: np.ndarray) -> np.ndarray:
        """(N, M) cameras that may see parts of faces (N,), seen by `seen` (N, M), once all `coming` (M,) are added."""
        return seen | coming if self.prospect is None else seen | coming & self.prospect.possible[face]

    @staticmethod
    def start(active: np.ndarray, n_cameras: int, lit: Tally | None = None) -> "Count":
        """No camera has been added yet. With `lit`, what is not lit is done with: no view of it counts."""
        none = Pieces(np.zeros(0, dtype=int), np.zeros(0, dtype=object), np.zeros((0, n_cameras), dtype=bool))
        seen = np.zeros((len(active), n_cameras), dtype=bool)
        if lit is None:
            return Count(active, seen, np.zeros(len(active), dtype=bool), none, (none,), 0)
        is_cut = active & lit.is_cut
        parts = lit.pieces.take(is_cut[lit.pieces.face])
        bright = np.asarray(parts.seen.any(axis=1))
        unseen = np.zeros((len(parts.face), n_cameras), dtype=bool)
        waiting, dark = (Pieces(parts.face, parts.polygon, unseen).take(chosen) for chosen in (bright, ~bright))
        active = active & ~lit.is_cut & lit.whole_seen.any(axis=1)
        active[waiting.face] = True
        return Count(active, seen, is_cut, waiting, (dark,), 0)

    def tally(self) -> Tally:
        """What has been counted."""
        pieces = Pieces.joined([*self.done, self.waiting])
        return Tally(self.whole_seen, self.is_cut, pieces, self.n_repairs, self.cuts or ())


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
    surface: Surface,
    cameras: Sequence[Camera],
    criterion: Criterion,
    active: np.ndarray,
    workers: int,
    report: Callable[[int], object] | None = None,
    depth_order: str = "exact",
    lit: Tally | None = None,
    keep_cuts: bool = False,
) -> Tally:
    """Count the views of every part of the `active` faces, (F,) bool, until it meets `criterion`.

    Of parts that are not `lit`, where that matters, no view counts. What cut faces is kept if that is asked for.
    """
    active = active & (surface.areas > 0)
    _ = surface.solid  # found once, not by every worker
    if workers == 1 or active.sum() < workers:
        return _tally(surface, cameras, criterion, active, depth_order, lit, keep_cuts, report)
    parts = shares(surface, cameras[0], active, workers)
    with processes(workers) as executor:
        asked = (depth_order, lit, keep_cuts)
        futures = [executor.submit(_tally, surface, cameras, criterion, part, *asked) for part in parts]
        for done, _ in enumerate(as_completed(futures)):
            if report is not None:
                report(len(cameras) * (done + 1) // workers - len(cameras) * done // workers)
        found = [future.result() for future in futures]
    return Tally(
        np.any([part.whole_seen for part in found], axis=0),
        np.any([part.is_cut for part in found], axis=0),
        Pieces.joined([part.pieces for part in found]),
        sum(part.n_repairs for part in found),
        tuple(cut for part in found for cut in part.cuts),
    )


def _tally(
    surface: Surface,
    cameras: Sequence[Camera],
    criterion: Criterion,
    active: np.ndarray,
    depth_order: str,
    lit: Tally | None,
    keep_cuts: bool,
    report: Callable[[int], object] | None = None,
) -> Tally:
    count = Count.start(active, len(cameras), lit)
    if criterion.bound is not None and len(cameras) > BLOCK:
        count = _looked_through(count, surface, cameras, criterion, depth_order)
    if keep_cuts:
        count = replace(count, cuts=())
    coming = np.ones(len(cameras), dtype=bool)
    order = spread_order(cameras)
    for block in np.split(order, range(BLOCK, len(cameras), BLOCK)):
        coming[block] = False
        count = add_views(count, surface, cameras, block, coming, criterion, depth_order)
        if report is not None:
            report(len(block))
        if not count.active.any():
            break
        if coming.sum() >= MANY and count.prospect is None and depth_order == "exact":
            count = replace(count, prospect=prospect(surface, cameras, order, coming, count.active))
    return count.tally()


def _looked_through(
    count: Count, surface: Surface, cameras: Sequence[Camera], criterion: Criterion, depth_order: str
) -> Count:
    """Count the views of whole faces by all cameras, and find out which cameras see some of the others.

    Where errors are bounded, parts that different cameras see are not merged, and of many cameras each cuts off another
    strip of what lies in half shadow. So faces that some cameras see whole often enough are not cut first, and what
    those that see anything of it cannot make accurate enough is left alone.
    """
    active, whole_seen = count.active, count.whole_seen.copy()
    within_sight = np.zeros_like(whole_seen)
    n_repairs = count.n_repairs
    for i in spread_order(cameras):
        sight = _look(surface, cameras[i], active, criterion, depth_order)
        n_repairs += sight.n_repairs
        within_sight[:, i] = sight.status != HIDDEN
        active = _counted_whole(active & ~count.is_cut, whole_seen, sight, i, criterion) | active & count.is_cut
    uncut = np.flatnonzero(active & ~count.is_cut)
    settled = criterion.settled(whole_seen[uncut], whole_seen[uncut] | within_sight[uncut], uncut)
    active[uncut[settled]] = False
    known = Prospect(within_sight, {})
    return Count(active, whole_seen, count.is_cut, count.waiting, count.done, n_repairs, known)


def _look(
    surface: Surface,
    camera: Camera,
    active: np.ndarray,
    criterion: Criterion,
    depth_order: str,
    part: Part | None = None,
) -> Sight:
    """What a camera sees of the `active` faces, (F,) bool, where no more than a `part` of the surface matters."""
    if part is not None:
        return _look(part.surface, camera, active[part.face], criterion, depth_order).of_whole(part)
    image = project(surface, camera)
    usable = Usable(image, criterion.limits, criterion.optics) if criterion.limits.is_any else None
    return look(image, active, depth_order, usable)


def _counted_whole(
    active: np.ndarray, whole_seen: np.ndarray, sight: Sight, camera: int, criterion: Criterion
) -> np.ndarray:
    """Note which of the `active` faces, all uncut, a camera sees whole; which still wait for views, (F,) bool."""
    more = np.flatnonzero(active & (sight.status == WHOLE) & ~whole_seen[:, camera])
    whole_seen[more, camera] = True
    active = active.copy()
    active[more] = ~criterion.met(whole_seen[more], more)
    return active


@contextmanager
def _no_garbage_collection() -> Iterator[None]:
    """Pause Python's search for cycles.

    Nothing here makes any, but so many objects come and go that it would look through all modules again and again,
    which takes a fifth of the time.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


@_no_garbage_collection()
def add_views(
    count: Count,
    surface: Surface,
    cameras: Sequence[Camera],
    block: np.ndarray,
    coming: np.ndarray,
    criterion: Criterion,
    depth_order: str = "exact",
) -> Count:
    """Count the views of the cameras with the indices `block` too; `coming`, (M,) bool, are those after them."""
    active, whole_seen, is_cut = count.active, count.whole_seen.copy(), count.is_cut.copy()
    sights: list[Sight] = []
    known = count.prospect
    for i in block:
        part, asked = (None, active) if known is None else (known.parts.get(int(i)), active & known.possible[:, i])
        sights.append(_look(surface, cameras[i], asked, criterion, depth_order, part))
        # Faces that need no further view are not asked about again.
        active = _counted_whole(active & ~is_cut, whole_seen, sights[-1], i, criterion) | active & is_cut
    n_repairs = count.n_repairs + sum(sight.n_repairs for sight in sights)
    status = np.stack([sight.status for sight in sights], axis=1)
    hulls_seen = None
    if known is not None and len(count.waiting.face) and not criterion.by_set:  # in a long row it pays
        status, hulls_seen = look_at_hulls(count.waiting, sights, status)
    new = np.flatnonzero(active & ~is_cut & (status == CUT).any(axis=1))
    if criterion.bound is not None:
        possible = count.possible(new, whole_seen[new], coming)
        possible[:, block] |= status[new] == CUT
        settled = criterion.settled(whole_seen[new], possible, new)
        active[new[settled]] = False
        new = new[~settled]
    pieces = Pieces.joined([count.waiting, Pieces(new, whole_faces(len(new)), whole_seen[new])])
    is_cut[new] = True
    whole_seen[new] = False
    finished, pieces, repairs = _refine(count, pieces, sights, status, hulls_seen, block, criterion, coming)
    active = active & ~is_cut
    active[pieces.face] = True
    cuts = count.cuts
    if cuts is not None:
        new_cuts = ((int(i), sight.cuts.of_faces(is_cut)) for i, sight in zip(block, sights, strict=True))
        cuts = (*cuts, *new_cuts)
    done = (*count.done, finished)
    return Count(active, whole_seen, is_cut, pieces, done, n_repairs + repairs, count.prospect, cuts)


def _refine(
    count: Count,
    pieces: Pieces,
    sights: list[Sight],
    status: np.ndarray,
    hulls_seen: list[HullsSeen] | None,
    block: np.ndarray,
    criterion: Criterion,
    coming: np.ndarray,
):
    """Cut pieces along what each camera of a block sees of them; finished pieces, the others, number of repairs."""
    pieces.seen[:, block] |= status[pieces.face] == WHOLE

    def settled(some: Pieces, after: int) -> np.ndarray:
        """Of pieces that cameras of the block `after` this one may still cut."""
        possible = count.possible(some.face, some.seen, coming)
        possible[:, block[after:]] |= status[some.face, after:] != HIDDEN
        return criterion.settled(some.seen, possible, some.face)

    met = settled(pieces, 0)
    done, pieces, n_repairs = [pieces.take(met)], pieces.take(~met), 0
    parted = np.zeros(len(status), dtype=bool)
    for k, camera in enumerate(block):
        crossed = status[pieces.face, k] == CUT
        if not crossed.any():
            continue
        rest, cut = pieces.take(~crossed), pieces.take(crossed)
        hull_seen = None if hulls_seen is None else hulls_seen[k]
        origin, cell, answer, repairs = cells_of(cut, sights[k], hull_seen, criterion.by_set)
        n_repairs += repairs
        # A piece all of whose cells got the same answer need not be cut.
        n_cells, n_seen = np.bincount(origin, minlength=len(cut.face)), np.bincount(origin, answer, len(cut.face))
        divided = (n_seen > 0) & (n_seen < n_cells)
        cut.seen[:, camera] = n_seen > 0
        of_divided = divided[origin]
        cells = Pieces(cut.face[origin[of_divided]], cell[of_divided], cut.seen[origin[of_divided]])
        cells.seen[:, camera] = answer[of_divided]
        cut = cut.take(~divided)
        met, cells_met = settled(cut, k + 1), settled(cells, k + 1)
        done += [cut.take(met), cells.take(cells_met)]
        cells = cells.take(~cells_met)
        parted[cells.face] = True
        pieces = Pieces.joined([rest, cut.take(~met), cells])
    if coming.any() and not criterion.by_set:
        again = parted[pieces.face]
        united, repairs = merged(pieces.take(again), criterion.state(pieces.seen[again], coming))
        n_repairs += repairs
        pieces = Pieces.joined([pieces.take(~again), united])
    return Pieces.joined(done), pieces, n_repairs
