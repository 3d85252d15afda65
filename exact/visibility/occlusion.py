"""Which faces one camera sees whole, which not at all, and along which segments the rest has to be cut.

Walking over a face, what hides it changes only where the image of a silhouette passes in front of it, where another
face cuts through it, or at the border of the field of view. So a face that none of these crosses is seen whole or not
at all, and so is a whole patch of such faces joined by their edges: one point decides. A face that is crossed is cut
along the segments, and each piece is asked for itself, so a segment too many does no harm.

Unlike in Wachter 2021, section 2.3, which orders faces by their nearest vertices, depths are compared at the point
itself, which is right for long, slanted and intersecting faces too. The paper's rule is there for comparison
(`depth_order="vertex"`): then any edge of a face can be where visibility changes.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from exact.cameras import Camera
from exact.visibility.grid import Grid, counting, greatest, least
from exact.visibility.limits import Usable
from exact.visibility.projection import Image, project
from exact.visibility.screen import SMALLEST_IMAGE, Screen, seen_from_outside, twice_areas
from exact.visibility.sight_depth import Depths, cell_centres_in, sight_depth
from exact.visibility.silhouettes import Cuts, crossings
from exact.visibility.surface import Part, Surface

HIDDEN, WHOLE, CUT = 0, 1, 2

# How many faces of a patch are asked. They must agree; if rounding makes them differ, all are asked.
PROBES = 3
# Cameras that are looked at together are in so many groups, and no fewer than so many.
ARCS, FEWEST = 16, 3
# They are at one height if they are to this part of the target distance.
SAME_HEIGHT = 1e-9


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
    number : (F,) int or None
        By which numbers `screen` and `usable` know the faces, if not their own.
    """

    screen: Screen
    status: np.ndarray
    cuts: Cuts
    on_grid: np.ndarray
    n_repairs: int
    usable: Usable | None = None
    number: np.ndarray | None = None

    def sees(self, face: np.ndarray, inner: np.ndarray) -> np.ndarray:
        """(N,) whether the camera sees points given by face and face coordinates (N, 2), and its view is usable."""
        if self.number is not None:
            face = self.number[face]
        seen = self.screen.sees(face, inner)
        if self.usable is not None:
            seen[seen] = self.usable.sees(face[seen], inner[seen])
        return seen

    def of_whole(self, part: Part) -> "Sight":
        """The same of the whole surface, if this is of a part of it: nothing is seen of other faces."""
        status, on_grid = np.zeros(len(part.number), dtype=np.int8), np.zeros(len(part.number), dtype=bool)
        status[part.face], on_grid[part.face] = self.status, self.on_grid
        cuts = self.cuts
        source = np.where(cuts.source >= 0, part.vertex[np.maximum(cuts.source, 0)], cuts.source)
        cuts = Cuts(part.face[cuts.face], cuts.start, cuts.end, source)
        return replace(self, status=status, on_grid=on_grid, cuts=cuts, number=part.number)


@dataclass(frozen=True, eq=False)
class Prospect:
    """What cameras that are still to come may see.

    Attributes
    ----------
    possible : (F, M) bool
        Of which faces each may see something.
    parts : dict of Part, by int
        The part of the surface that matters to each, where no more than a part does.
    """

    possible: np.ndarray
    parts: dict[int, Part]


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


def prospect(
    surface: Surface, cameras: Sequence[Camera], order: np.ndarray, coming: np.ndarray, active: np.ndarray
) -> Prospect:
    """What the cameras `coming`, (M,) bool, may see of the `active` faces, (F,) bool.

    Those about each of the first ones in `order`, (M,) int, which are spread, are looked at together.
    """
    position = np.array([camera.position for camera in cameras])
    away = position - position.mean(axis=0)
    look = np.mean([camera.rotation[2] for camera in cameras], axis=0)
    _, extent, axes = np.linalg.svd(away, full_matrices=False)
    if len(extent) == 3 and extent[2] <= SAME_HEIGHT * extent[0]:  # they are in one plane
        look = axes[2] * np.sign(axes[2] @ look)
    found = Prospect(active[:, None] & coming, {})
    if np.linalg.norm(look) < 0.1:  # some look the other way
        return found
    rotation = Camera.look_at((0, 0, 0), look, up=np.eye(3)[int(np.argmin(np.abs(look)))]).rotation
    step = SAME_HEIGHT * cameras[0].target_distance
    _, height = np.unique(np.round(away @ rotation[2] / step), return_inverse=True)
    nearest = np.linalg.norm(position[:, None] - position[order[:ARCS]], axis=2).argmin(axis=1)
    group = height * ARCS + nearest
    for number in np.unique(group[coming]):
        members = np.flatnonzero(coming & (group == number))
        if len(members) < FEWEST:
            continue
        seen_and_matters = _in_sight(surface, [cameras[int(i)] for i in members], rotation, active)
        if seen_and_matters is not None:
            may_be_seen, matters = seen_and_matters
            found.possible[np.ix_(~may_be_seen, members)] = False
            found.parts.update(dict.fromkeys(members.tolist(), surface.part(matters)))
    return found


def _in_sight(
    surface: Surface, cameras: Sequence[Camera], rotation: np.ndarray, active: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """Which of the `active` faces some of several cameras near each other may see, and which faces matter to that.

    (F,), (F,) bool: the latter are those and all that can hide some of them. None if it can't be told.

    Others turn their backs to all of them, or lie so deep in shadow that the way between the cameras does not matter.
    All cameras are in one plane, along which a camera of this `rotation` looks at right angles. If each image is moved
    so that one point stays in place, points and their images move in proportion on a straight way from one camera to
    another, depths stay, and so does the side of a face that both see. So a sheet that covers the middle of a cell for
    one camera covers the cell for all, if it neither ends nor folds back where any of them could see that in the cell:
    that is where boxes around all images of its edges are, in place of the edges' own images.
    """
    fixed = surface.vertices[surface.faces[active]].mean(axis=(0, 1))
    low = np.full((3, len(surface.vertices)), np.inf)
    high, of_one = -low, low
    ever, always, outside = np.zeros_like(active), np.ones_like(active), True
    for i, camera in enumerate(cameras):
        image = project(surface, replace(camera, rotation=rotation))
        across, down, ahead = rotation @ (fixed - camera.position)
        if image.frame is not None or not np.isfinite(image.x).all() or ahead <= 0:  # some of it is not ahead
            return None
        outside = outside and seen_from_outside(image)
        ever |= image.front
        always &= image.front
        here = np.stack([image.x - across / ahead, image.y - down / ahead, image.inverse_depth])
        low, high = np.minimum(low, here), np.maximum(high, here)
        of_one = here if i == len(cameras) // 2 else of_one
    triangle = np.flatnonzero((surface.areas > 0) & (ever | (not outside)))
    corner = surface.faces[triangle]
    box = np.stack([*(least(low[k][corner]) for k in (0, 1)), *(greatest(high[k][corner]) for k in (0, 1))])
    farthest, nearest = least(low[2][corner]), greatest(high[2][corner])
    x, y = of_one[:2, corner]
    twice_area = np.abs(twice_areas(x, y))
    asked = (active & ever)[triangle]
    grid = Grid.over(box[:, asked], np.full(2, np.inf), box, twice_area / 2)
    marks = grid.marked(grid.boxes(box[:, asked]))
    owner, cell = grid.touched(*_rectangles(box), marks)
    longest = greatest((box[2:] - box[:2]).T)
    # An edge between faces of which one turns over on the way is somewhere where a sheet folds back.
    side = np.where(always, 1, np.where(ever, 2, 0))[surface.edge_faces]
    folds = (side[:, 0] != side[:, 1]) | (side == 2).any(axis=1)
    loose = ever[surface.loose_edge_faces] | (not outside)
    edges = np.concatenate([surface.edges[folds], surface.loose_edges[loose]])
    end_box = np.concatenate([low[:2, edges].min(axis=2), high[:2, edges].max(axis=2)])
    end, end_cell = grid.touched(*_rectangles(end_box), marks)
    depths = Depths.between(farthest, nearest)
    steps = depths.near(nearest)
    limit = sight_depth(
        grid.n_cells,
        (cell, steps[owner], depths.far(farthest)[owner]),
        cell_centres_in(grid, owner, cell, x, y, twice_area / np.maximum(longest, SMALLEST_IMAGE) ** 2),
        (end_cell, depths.near(high[2, edges].max(axis=1))[end], depths.far(low[2, edges].min(axis=1))[end]),
    )
    in_sight = steps[owner] >= limit[cell]
    may_be_seen, matters = np.zeros((2, len(active)), dtype=bool)
    may_be_seen[triangle[owner[in_sight]]] = True
    may_be_seen &= active & ever
    # What hides such a face somewhere is in sight there, or a sheet that is in sight hides it there too.
    there = np.zeros(grid.n_cells, dtype=bool)
    there[cell[may_be_seen[triangle[owner]]]] = True
    matters[triangle[owner[in_sight & there[cell]]]] = True
    return may_be_seen, matters


def _rectangles(box: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates x and y, each (N, 4), of the corners of boxes (left, low, right, high; (4, N))."""
    return box[[0, 2, 2, 0]].T, box[[1, 1, 3, 3]].T


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
    size = np.abs(twice_areas(x, y))
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
