"""Polygons in the coordinates of their faces: what is around them, what they meet, and what they are together."""

import numpy as np
import shapely

from exact.visibility.pieces.clipping import GRID_SIZE, POLYGON, differ, of_same_face

# Polygons whose boxes are farther apart do not touch.
NEARBY = 1e-7


def unite(group: np.ndarray, polygon: np.ndarray):
    """Unite polygons that do not overlap. Parts that touch no other polygon of their group stay as they are.

    Parameters
    ----------
    group : (N,) int
        Which of them belong together: 0, 1, .. without gaps, ascending.
    polygon : (N,) polygons or multipolygons

    Returns
    -------
    united : (G,) polygons or multipolygons
        One for each group. A union must have the area of its parts, or it is formed again on a precision grid.
    failed : (G,) bool
        Groups that have no such union even then: theirs is an (invalid) multipolygon of the parts side by side.
    n_repairs : int
        Groups whose first union had not the right area.
    """
    part, owner = shapely.get_parts(polygon, return_index=True)
    of_part = group[owner]
    alone = ~_near_others(part, owner, of_part)
    several, of_joined = np.unique(of_part[~alone], return_inverse=True)
    together = np.asarray(shapely.multipolygons(part[~alone], indices=of_joined))
    expected, outline = shapely.area(together), shapely.length(together)
    joined = np.asarray(shapely.union_all(together[:, None], axis=1))
    # Slivers whose area is rounding may come back as nothing at all, which no point speaks for.
    wrong = differ(shapely.area(joined), expected, outline) | shapely.is_empty(joined)
    joined[wrong] = shapely.union_all(together[wrong, None], axis=1, grid_size=GRID_SIZE)
    failed = differ(shapely.area(joined), expected, outline) | shapely.is_empty(joined)
    joined[failed] = together[failed]
    united, of_united = shapely.get_parts(joined, return_index=True)
    united, of_united = np.append(united, part[alone]), np.append(several[of_united], of_part[alone])
    order = np.argsort(of_united, kind="stable")
    has_failed = np.zeros(int(group.max(initial=-1)) + 1, dtype=bool)
    has_failed[several[failed]] = True
    return gathered(united[order], of_united[order]), has_failed, int(wrong.sum())


def gathered(part: np.ndarray, group: np.ndarray) -> np.ndarray:
    """(G,) the parts (N,) of each group, (N,) ascending without gaps: a polygon, or a multipolygon if several."""
    together = np.asarray(shapely.multipolygons(part, indices=group))
    alone = np.bincount(group) == 1
    together[alone] = part[alone[group]]
    return together


def _near_others(part: np.ndarray, owner: np.ndarray, group: np.ndarray) -> np.ndarray:
    """(N,) whether parts come near one of another owner in their group, (N,), (N,)."""
    left, low, right, high = shapely.bounds(part).T
    aside = 2.0 * group  # groups side by side
    box = shapely.box(left + aside - NEARBY, low - NEARBY, right + aside + NEARBY, high + NEARBY)
    one, other = shapely.STRtree(box).query(box)
    near = np.zeros(len(part), dtype=bool)
    near[one[owner[one] != owner[other]]] = True
    return near


def hulls(face: np.ndarray, polygon: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The convex hull of all polygons or multipolygons (N,) of each face, (N,), where it is one: faces, and polygons.

    Both by ascending face, in and out.
    """
    part, owner = shapely.get_parts(polygon, return_index=True)
    face, group = np.unique(face, return_inverse=True)
    hull = np.asarray(shapely.convex_hull(gathered(part, group[owner])))
    flat = shapely.get_type_id(hull) != POLYGON
    return face[~flat], hull[~flat]


def meets(face: np.ndarray, polygon: np.ndarray, of_face: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(N,) whether polygons (N,) of faces (N,) meet or touch one of others (M,) of the same face, by ascending face."""
    owner, at = of_same_face(face, of_face)
    found = np.zeros(len(face), dtype=bool)
    found[owner[shapely.intersects(polygon[owner], other[at])]] = True
    return found
