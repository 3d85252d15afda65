"""Which way a surface opens."""

import numpy as np
from scipy.spatial import ConvexHull

from meshes.condition.facing import sides
from meshes.condition.winding import sphere_around

# Directions from which the opening is looked for, at so many points.
DIRECTIONS, POINTS = 128, 4_000
# What lies this far below the convex hull, in parts of the size, lies in a hollow.
HOLLOW = 0.02
# Of a mesh with an opening at least this part is seen through it.
OPENING = 0.02


def opening(vertices: np.ndarray, faces: np.ndarray) -> tuple[float, ...] | None:
    """Direction from which most is seen of what lies in hollows, or, of a surface without, most of its front.

    None for a convex solid.

    Examples
    --------
    >>> import trimesh
    >>> bowl = trimesh.creation.icosphere(3, 10).slice_plane((0, 0, 0), (0, 0, -1))
    >>> _ = bowl.invert()
    >>> (np.round(opening(bowl.vertices, bowl.faces), 1) + 0.0).tolist()
    [0.0, 0.0, 1.0]
    """
    corners = vertices[faces]
    points = corners.reshape(-1, 3)
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    deep = np.zeros(len(faces), dtype=bool)
    if np.linalg.matrix_rank(points - points[0], tol=1e-9 * size) == 3:
        planes = ConvexHull(points).equations
        middle = corners.mean(axis=1)
        highest = np.full(len(faces), -np.inf)
        for plane in planes:
            np.maximum(highest, middle @ plane[:3] + plane[3], out=highest)
        deep = highest < -HOLLOW * size
    places = sphere_around(points, DIRECTIONS)
    seen, _, _ = sides(vertices, faces, deep.astype(int), places, n_points=POINTS)
    seen = np.pad(seen, ((0, 0), (0, 2 - seen.shape[1])))
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    directions = (places - middle) / np.linalg.norm(places - middle, axis=1, keepdims=True)
    if seen[:, 1].max() >= OPENING * areas.sum():
        worth = seen[:, 1]
    elif (places_see := seen.sum(axis=1)).min() < 0.1 * places_see.max():  # of a sheet, whose back is turned to some
        worth = places_see
    else:
        return None
    best = directions[np.argmax(worth)]
    # The mean of the directions from which it is seen, each the more the more is seen, on the side of the best.
    mean = (np.maximum(worth, 0)[:, None] ** 4 * directions)[directions @ best > 0].sum(axis=0)
    return tuple((mean / np.linalg.norm(mean)).tolist())
