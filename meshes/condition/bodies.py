"""The bodies that a mesh consists of: which of the closed ones are inside-out, and which are hollows in another."""

import numpy as np

from meshes.condition.neighbours import bodies

# A body is taken to lie where most of this many of its points lie, for bodies that stick in others or touch them.
PROBES = 5
# They lie this far inside its surface, in parts of its size: far above rounding, far below the thickness of anything.
DEPTH = 1e-6
# Inside a closed body the winding number is 1, outside 0; in a body with a hole it lies between, and who is within the
# hole's smallest lid has more than this.
INSIDE = 0.5


def inside_out(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which bodies of a mesh are inside-out.

    A closed body of negative volume is, unless it lies in the solid of others: then it is a hollow in them.

    Parameters
    ----------
    vertices, faces : (V, 3) float [mm], (F, 3) int
        Neighbouring faces are wound alike; all faces have area.

    Returns
    -------
    body : (F,) int
        Number of the body that each face belongs to: faces that hang together by edges of two faces.
    volume : (B,) float
        Enclosed volume of each body [mm³], negative if its normals point inwards; for an open one any number.
    inverted : (B,) bool
        Closed bodies that are inside-out.

    Examples
    --------
    >>> import trimesh
    >>> cube = trimesh.creation.box()
    >>> hollow = trimesh.Trimesh(0.5 * cube.vertices, cube.faces[:, ::-1], process=False)
    >>> both = trimesh.util.concatenate([cube, hollow])
    >>> inside_out(both.vertices, both.faces)[2].tolist(), inside_out(hollow.vertices, hollow.faces)[2].tolist()
    ([False, False], [True])
    """
    _, _, body, is_closed = bodies(faces)
    n_bodies = len(is_closed)
    corners = vertices[faces]
    # About the middle of the mesh: far from the origin the terms would cancel badly.
    corners = corners - 0.5 * (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1)))
    volumes = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    volume = np.bincount(body, weights=volumes, minlength=n_bodies)
    inverted = np.zeros(n_bodies, dtype=bool)
    suspects = np.flatnonzero(is_closed & (volume < 0))
    if not len(suspects):
        return body, volume, inverted
    low, high = np.full((n_bodies, 3), np.inf), np.full((n_bodies, 3), -np.inf)
    np.minimum.at(low, body, corners.min(axis=1))
    np.maximum.at(high, body, corners.max(axis=1))
    # From the largest down, so that of the others around a suspect it is known already what they are.
    sign = np.ones(n_bodies)
    sign[suspects] = 0
    for suspect in suspects[np.argsort(volume[suspects], kind="stable")]:
        # A closed body counts only for points within its box.
        near = (sign != 0) & (~is_closed | ((low <= high[suspect]) & (high >= low[suspect])).all(axis=1))
        own, others = corners[body == suspect], near[body]
        winding = _winding(_probes(own), corners[others], sign[body[others]])
        inverted[suspect] = np.median(winding) <= INSIDE
        sign[suspect] = -1 if inverted[suspect] else 1
    return body, volume, inverted


def _probes(corners: np.ndarray) -> np.ndarray:
    """(P, 3) points just inside a body whose normals point inwards, each beside a face; faces (F, 3, 3)."""
    a, b, c = corners[np.linspace(0, len(corners) - 1, PROBES).astype(int)].transpose(1, 0, 2)
    inwards = np.cross(b - a, c - a)
    inwards /= np.linalg.norm(inwards, axis=1, keepdims=True)
    return (a + b + c) / 3 + DEPTH * np.ptp(corners, axis=(0, 1)).max() * inwards


def _winding(points: np.ndarray, corners: np.ndarray, sign: np.ndarray) -> np.ndarray:
    """(P,) how often triangles (N, 3, 3) wind around each point: their solid angles, counted by `sign`, over 4 pi.

    Van Oosterom and Strackee 1983; for open surfaces see Jacobson et al. 2013.
    """
    total = []
    for point in points:
        a, b, c = (corners - point).transpose(1, 0, 2)
        la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
        along = la * lb * lc + lc * (a * b).sum(axis=1) + la * (b * c).sum(axis=1) + lb * (c * a).sum(axis=1)
        angle = 2 * np.arctan2((a * np.cross(b, c)).sum(axis=1), along)
        total.append(float(angle @ sign) / (4 * np.pi))
    return np.array(total)
