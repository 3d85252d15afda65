"""Turn the field of a site's air into a watertight block of tissue, by manifold3d's solid booleans."""

from collections.abc import Callable

import numpy as np
import trimesh
from manifold3d import Error, Manifold, Mesh64

from meshes.anatomy import Anatomy, Opening, air, arteries, artery_curves

SMALLEST = 0.003  # edges shorter than this are collapsed and bends flatter than this straightened [mm]
BASE = 12.0  # tissue below z = 0 [mm]
MARGIN = 6.0  # how far pockets and furrows may reach beyond the channel [mm]
FLOOR_MARGIN = 7.0  # how far they may reach below z = 0 [mm]
ROW = 4.0  # triangles of the plain channel are this many edge lengths high
# The wall is upright at `top`, so vertices this near to it (in edge lengths) may move onto it along z, and vertices on
# the cut this near to each other be made one; else cutting there would leave needles.
SNAP = 0.2


def carve(anatomy: Anatomy, opening: Opening, depth: float, block: float, edge: float) -> trimesh.Trimesh:
    """Block of tissue with a channel.

    Parameters
    ----------
    depth : float
        Height of the top surface [mm].
    block : float
        Width of the block along x and y [mm].
    edge : float
        Length of the triangles' edges on the anatomy, about [mm].

    Returns
    -------
    trimesh.Trimesh
        Watertight, one body; coordinates are exact in single precision, so that an STL file holds this very mesh.
    """
    vertices, faces = _bottom(anatomy, opening, edge)
    outline = opening.polygon()
    rows = max(1, round((depth - anatomy.top) / (ROW * edge)))
    heights = np.linspace(anatomy.top, depth, rows + 1)[1:]
    # The topmost row ends 1 mm out of the block, so that no faces coincide there.
    vertices, faces = _with_channel(vertices, faces, outline, np.append(heights, depth + 1.0))
    channel = Manifold(Mesh64(vert_properties=vertices, tri_verts=faces.astype(np.uint64)))
    if channel.status() != Error.NoError:
        raise AssertionError(f"the channel is no solid: {channel.status()}; change `edge` a little")
    tissue = Manifold.cube((block, block, BASE + depth)).translate((-block / 2, -block / 2, -BASE))
    solid = tissue - channel
    if artery_curves(anatomy, above_top=True):
        # Where arteries enter the wall the boolean leaves triangles of any size; the smallest would not survive the
        # rounding to single precision.
        solid = (solid + _arteries(anatomy, edge)).simplify(SMALLEST)
    # The largest body: what the channel has cut off from the block would float in the air.
    solid = max(solid.decompose(), key=lambda body: body.volume()).to_mesh64()
    vertices = np.asarray(solid.vert_properties)[:, :3].astype(np.float32).astype(np.float64)
    return trimesh.Trimesh(vertices, np.asarray(solid.tri_verts, dtype=np.int64), process=False)


def _bottom(anatomy: Anatomy, opening: Opening, edge: float) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (V, 3) and faces (F, 3) of the air of the anatomy, cut off flat and open at its top."""
    reach = np.array(opening.half_axes) + MARGIN
    bounds = (-reach[0], -reach[1], -FLOOR_MARGIN, reach[0], reach[1], anatomy.top + 2 * edge)

    bottom = _level_set(lambda points: air(anatomy, opening, points), bounds, edge)

    def snap(vertices: np.ndarray) -> np.ndarray:
        vertices = np.array(vertices)
        vertices[np.abs(vertices[:, 2] - anatomy.top) < SNAP * edge, 2] = anatomy.top
        return vertices

    bottom = bottom.warp_batch(snap).trim_by_plane((0.0, 0.0, -1.0), -anatomy.top)
    bottom = max(bottom.decompose(), key=lambda body: body.volume())  # a hollow with no way out is no site
    mesh = bottom.to_mesh64()
    vertices, faces = np.asarray(mesh.vert_properties)[:, :3].copy(), np.asarray(mesh.tri_verts, dtype=np.int64)
    at_top = np.abs(vertices[:, 2] - anatomy.top) < 1e-9  # rounding of the cut
    vertices[at_top, 2] = anatomy.top
    faces = faces[~at_top[faces].all(axis=1)]
    loop = _free_edge(vertices, faces)
    merged = np.arange(len(vertices))
    for last, vertex in zip(loop[:-1], loop[1:], strict=True):
        if np.linalg.norm(vertices[vertex] - vertices[merged[last]]) < SNAP * edge:
            merged[vertex] = merged[last]
    if np.linalg.norm(vertices[merged[loop[-1]]] - vertices[loop[0]]) < SNAP * edge:
        merged[merged == merged[loop[-1]]] = loop[0]
    faces = merged[faces]
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    used, faces = np.unique(faces, return_inverse=True)
    return vertices[used], faces.reshape(-1, 3)


def _arteries(anatomy: Anatomy, edge: float) -> Manifold:
    """All arteries above the anatomy's top as one solid, their ends within the tissue."""
    curves = np.vstack(artery_curves(anatomy, above_top=True))
    radius = curves[:, 3:]
    low, high = (curves[:, :3] - radius).min(axis=0) - edge, (curves[:, :3] + radius).max(axis=0) + edge
    return _level_set(lambda points: -arteries(anatomy, points), (*low, *high), edge)


def _level_set(field: Callable[[np.ndarray], np.ndarray], bounds: tuple[float, ...], edge: float) -> Manifold:
    """Solid where a field is positive.

    manifold3d asks for one point at a time, which is slow; so note its points, compute them all at once, and answer
    from the table in a second run. Reading by coordinates does not depend on the order of its questions.
    """
    grid: list[tuple[float, float, float]] = []

    def note(x: float, y: float, z: float) -> float:
        grid.append((x, y, z))
        return -1.0

    Manifold.level_set(note, bounds, edge)
    table = dict(zip(grid, field(np.array(grid)).tolist(), strict=True))
    return Manifold.level_set(lambda x, y, z: table[x, y, z], bounds, edge)


def _with_channel(
    vertices: np.ndarray, faces: np.ndarray, outline: np.ndarray, heights: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Close an open bottom by an upright prism over `outline`, its sides in rows between the heights.

    The first row joins the free edge of the bottom to the outline. Joining by hand needs no ledge between the two,
    which a boolean would, lest their walls nearly coincide.
    """
    n, rows, first = len(outline), len(heights), len(vertices)
    rings = np.column_stack([np.tile(outline, (rows, 1)), np.repeat(heights, n)])
    here = first + np.arange(n * (rows - 1))
    beside = first + np.roll(np.arange(n * (rows - 1)).reshape(rows - 1, n), -1, axis=1).ravel()
    sides = [[here, beside, beside + n], [here, beside + n, here + n]]
    fan = first + n * (rows - 1) + np.column_stack([np.zeros(n - 2, dtype=int), np.arange(1, n - 1), np.arange(2, n)])
    strip = _strip(_free_edge(vertices, faces), vertices, first + np.arange(n), rings)
    vertices = np.vstack([vertices, rings])
    return vertices, np.vstack([faces, strip, *(np.column_stack(side) for side in sides), fan])


def _free_edge(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Vertices along the one free edge of an open surface, counter-clockwise from +x."""
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    key = edges[:, 0] * len(vertices) + edges[:, 1]
    free = edges[~np.isin(key, edges[:, 1] * len(vertices) + edges[:, 0])]
    follower = dict(free.tolist())
    loop = [int(free[0, 0])]
    while (after := follower[loop[-1]]) != loop[0]:
        loop.append(after)
    if len(loop) != len(free):
        raise AssertionError("the anatomy breaks through the wall at its top; lower it or raise Anatomy.top")
    order = np.array(loop)
    x, y = vertices[order, :2].T
    if (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() < 0:  # twice the area, with the sense of rotation
        order = order[::-1]
    return np.roll(order, -int(_azimuth(vertices[order]).argmin()))


def _azimuth(points: np.ndarray) -> np.ndarray:
    return np.arctan2(points[:, 1], points[:, 0]) % (2 * np.pi)


def _strip(lower: np.ndarray, vertices: np.ndarray, upper: np.ndarray, rings: np.ndarray) -> np.ndarray:
    """Faces between two closed curves round the axis, advancing on the one that lags behind in azimuth."""
    curves = [lower, upper]
    angles = [_azimuth(vertices[lower]), _azimuth(rings[: len(upper)])]
    angles = [np.append(angle, angle[0] + 2 * np.pi) for angle in angles]
    at, faces = [0, 0], []
    while at[0] < len(lower) or at[1] < len(upper):
        here = [int(curve[i % len(curve)]) for curve, i in zip(curves, at, strict=True)]
        ahead = [angle[i + 1] if i + 1 < len(angle) else np.inf for angle, i in zip(angles, at, strict=True)]
        move = int(ahead[1] < ahead[0])
        at[move] += 1
        there = int(curves[move][at[move] % len(curves[move])])
        faces.append([here[0], there, here[1]])
    return np.array(faces)
