"""Which faces one camera sees whole, which not at all, and along which segments the rest has to be cut.

Walking over a face, what hides it changes only where the image of a silhouette passes in front of it, where another
face cuts through it, or at the border of the field of view. So a face that none of these crosses is seen whole or not
at all, and so is a whole patch of such faces joined by their edges: one point decides. A face that is crossed is cut
along the segments, and each piece is asked for itself, so a segment too many does no harm.

Unlike in Wachter 2021, section 2.3, which orders faces by their nearest vertices, depths are compared at the point
itself, which is right for long, slanted and intersecting faces too. The paper's rule is there for comparison
(`depth_order="vertex"`): then any edge of a face can be where visibility changes.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from exact.visibility.grid import counting
from exact.visibility.limits import Usable
from exact.visibility.projection import Image
from exact.visibility.screen import Screen
from exact.visibility.silhouettes import Cuts, crossings

HIDDEN, WHOLE, CUT = 0, 1, 2

# How many faces of a patch are asked. They must agree; if rounding makes them differ, all are asked.
PROBES = 3


@dataclass(frozen=True, eq=False)
class Sight:
    """What one camera sees of the faces it was asked about.

    Attributes
    ----------
    screen : Screen
        Answers for single points.
    status : (F,) int8
        `HIDDEN`, `WHOLE`, or `CUT` for a face that has to be cut before it can be asked.
    cuts : Cuts
        The segments that cut the faces of status `CUT`.
    on_grid : (F,) bool
        Faces whose segments may continue each other with ends that are equal only up to rounding.
    n_repairs : int
        Patches whose faces did not agree and were asked one by one.
    usable : Usable or None
        What limits leave of its views.
    """

    screen: Screen
    status: np.ndarray
    cuts: Cuts
    on_grid: np.ndarray
    n_repairs: int
    usable: Usable | None = None

    def sees(self, face: np.ndarray, inner: np.ndarray) -> np.ndarray:
        """(N,) whether the camera sees points given by face and face coordinates (N, 2), and its view is usable."""
        seen = self.screen.sees(face, inner)
        if self.usable is not None:
            seen[seen] = self.usable.sees(face[seen], inner[seen])
        return seen


def look(image: Image, active: np.ndarray, depth_order: str = "exact", usable: Usable | None = None) -> Sight:
    """What the camera of `image` sees of the `active` faces, (F,) bool; all others count as hidden.

    With `usable`, what it sees in a usable way.
    """
    borders = []
    if usable is not None:
        face = np.flatnonzero(active & image.front)
        whole, part, cuts = usable.whole_or_cuts(face)
        active = np.zeros_like(active)
        active[face[whole | part]] = True
        borders.append(cuts)
    screen = Screen.of(image, active, depth_order)
    asked = (active & image.front)[screen.parent]
    status = np.zeros(len(image.front), dtype=np.int8)
    status[screen.parent[asked]] = WHOLE  # until something is found to cut or to hide it
    own = image.surface.intersections
    own_cuts = Cuts.alike(own.face, own.start, own.end)
    cuts = Cuts.joined([crossings(screen, asked), *(some.of_faces(status == WHOLE) for some in (own_cuts, *borders))])
    status[cuts.face] = CUT
    uncut = np.flatnonzero(status == WHOLE)
    seen, n_repairs = _patches_seen(screen, uncut)
    status[uncut[~seen]] = HIDDEN
    on_grid = np.zeros(len(status), dtype=bool)
    on_grid[own.face] = True
    on_grid[image.parent[image.is_part]] = True
    return Sight(screen, status, cuts, on_grid, n_repairs, usable)


def _patches_seen(screen: Screen, uncut: np.ndarray):
    """Whether each of the faces `uncut`, which nothing cuts, is seen; and how many patches did not agree."""
    image, surface = screen.image, screen.image.surface
    number = np.full(len(surface.faces), -1)
    number[uncut] = np.arange(len(uncut))
    # Ordered by their vertices, neighbours need not be hidden by the same faces: each is asked.
    edge_faces = surface.edge_faces if screen.face_distance is None else surface.edge_faces[:0]
    edge_faces = edge_faces[number[edge_faces[:, 0]] >= 0]  # few are left late in a long row of cameras
    pair = number[edge_faces]
    pair = pair[pair[:, 1] >= 0]
    graph = coo_array((np.ones(len(pair), dtype=np.int8), (pair[:, 0], pair[:, 1])), shape=(len(uncut),) * 2)
    n_patches, patch = connected_components(graph, directed=False)
    # The faces with the largest images speak for their patch.
    corner = image.corners[image.whole[uncut]]
    x, y = image.x[corner], image.y[corner]
    size = np.abs((x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (y[:, 1] - y[:, 0]) * (x[:, 2] - x[:, 0]))
    order = np.lexsort((-size, patch))
    count = np.bincount(patch, minlength=n_patches)
    rank = np.empty(len(uncut), dtype=int)
    rank[order] = counting(count)
    probe = np.flatnonzero(rank < PROBES)

    def centre_seen(which: np.ndarray) -> np.ndarray:
        return screen.sees(uncut[which], np.full((len(which), 2), 1 / 3))

    votes = np.bincount(patch[probe], weights=centre_seen(probe), minlength=n_patches)
    seen = (votes > 0)[patch]
    split = (votes > 0) & (votes < np.minimum(count, PROBES))
    if split.any():
        doubtful = np.flatnonzero(split[patch])
        seen[doubtful] = centre_seen(doubtful)
    return seen, int(split.sum())
