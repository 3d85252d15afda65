"""Turn the field of a site's air into a watertight block of tissue, by manifold3d's solid booleans."""

import numpy as np
import trimesh
from manifold3d import CrossSection, Manifold

from meshes.anatomy import Anatomy, Opening, air

RIM = 2.0  # height of the exact prism under the opening [mm]
LIP = 0.2  # the wall below stands in by this much [mm], so that no two surfaces of the booleans nearly coincide
BASE = 12.0  # tissue below z = 0 [mm]
STRETCH = 2.0  # triangles of the plain channel are this much longer along z than those of the anatomy
MARGIN = 6.0  # how far pockets and furrows may reach beyond the opening [mm]
FLOOR_MARGIN = 7.0  # how far they may reach below z = 0 [mm]
# The wall is upright at the rim, so vertices this near to it (in edge lengths) may move onto it along z; else cutting
# there would leave needles.
SNAP = 0.45


def _stretched(anatomy: Anatomy, z: np.ndarray) -> np.ndarray:
    """Height of a grid point: the grid is stretched along z above the anatomy."""
    return z + (STRETCH - 1) * np.maximum(z - anatomy.top, 0.0)


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
    rim = depth - RIM
    grid_rim = rim if rim < anatomy.top else anatomy.top + (rim - anatomy.top) / STRETCH
    reach = np.array(opening.half_axes) + MARGIN
    bounds = (-reach[0], -reach[1], -FLOOR_MARGIN, reach[0], reach[1], grid_rim + 2 * edge)

    # manifold3d asks for one point at a time, which is slow; so note its points, compute them all at once, and
    # answer from the table in the second run. Reading by coordinates does not depend on the order of its questions.
    grid: list[tuple[float, float, float]] = []

    def note(x: float, y: float, z: float) -> float:
        grid.append((x, y, z))
        return -1.0

    Manifold.level_set(note, bounds, edge)
    points = np.array(grid)
    points[:, 2] = _stretched(anatomy, points[:, 2])
    table = dict(zip(grid, air(anatomy, opening, rim, LIP, points).tolist(), strict=True))
    channel = Manifold.level_set(lambda x, y, z: table[x, y, z], bounds, edge)

    def stretch_and_snap(vertices: np.ndarray) -> np.ndarray:
        vertices = np.array(vertices)
        z = _stretched(anatomy, vertices[:, 2])
        vertices[:, 2] = np.where(np.abs(z - rim) < SNAP * edge, rim, z)
        return vertices

    channel = channel.warp_batch(stretch_and_snap).trim_by_plane((0.0, 0.0, -1.0), -rim)
    channel = max(channel.decompose(), key=lambda body: body.volume())  # a hollow with no way out is no site
    prism = CrossSection([opening.polygon()]).extrude(RIM + 1.0).translate((0.0, 0.0, rim))
    tissue = Manifold.cube((block, block, BASE + depth)).translate((-block / 2, -block / 2, -BASE))
    solid = (tissue - (channel + prism)).to_mesh64()
    vertices = np.asarray(solid.vert_properties)[:, :3].astype(np.float32).astype(np.float64)
    return trimesh.Trimesh(vertices, np.asarray(solid.tri_verts, dtype=np.int64), process=False)
