"""Area-weighted, stratified sample points of a surface.

The surface is cut into small pieces, the pieces are put in an order in which neighbours on the list are
neighbours in space, and the list is cut into N strata of equal area with one uniform point in each. So every
sample stands for the same area, and the error of a sampled area falls faster than 1/sqrt(N).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import trimesh
from jaxtyping import Bool, Float, Int

from exact.whole_numbers import is_whole
from placement.errors import PlacementError

# A piece may be this many times as long as the side of a square that holds one stratum's area: with 2, pieces
# are smaller than strata, and more cutting no longer lowers the error.
PIECE_LENGTH = 2.0


@dataclass(frozen=True, eq=False)
class SurfaceSamples:
    """Points on a surface, each standing for a patch of it.

    Attributes
    ----------
    points : (N, 3) ndarray
        Sample points [mm].
    normals : (N, 3) ndarray
        Unit normals of the faces they lie on, outwards.
    weights : (N,) ndarray
        Area each one stands for [mm²]; they add up to the area that is sampled.
    faces : (N,) ndarray of int
        Face each one lies on.
    """

    points: Float[np.ndarray, "N 3"]
    normals: Float[np.ndarray, "N 3"]
    weights: Float[np.ndarray, " N"]
    faces: Int[np.ndarray, " N"]

    def __len__(self) -> int:
        return len(self.weights)

    def subset(self, chosen: Bool[np.ndarray, " N"] | Int[np.ndarray, " C"]) -> "SurfaceSamples":
        """The chosen ones, by mask or index."""
        return SurfaceSamples(self.points[chosen], self.normals[chosen], self.weights[chosen], self.faces[chosen])

    @property
    def area(self) -> float:
        """Area the samples stand for [mm²]."""
        return float(self.weights.sum())


def sample_surface(
    mesh: trimesh.Trimesh,
    n_samples: int,
    exclude: np.ndarray | None = None,
    seed: int = 0,
    within: Callable[[np.ndarray], np.ndarray] | None = None,
) -> SurfaceSamples:
    """Stratified sample points of the part of `mesh` that is not excluded.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        The surface [mm].
    n_samples : int
        Number of points N.
    exclude : (F,) ndarray of bool, optional
        Faces that get no sample.
    seed : int
        Same seed, same points.
    within : callable, optional
        Told (P, 3, 3) corners of small triangles, says which of them may get samples, (P,) bool; all by default.

    Returns
    -------
    SurfaceSamples
        Without any point if `within` leaves nothing.

    Raises
    ------
    PlacementError
        If `exclude` has the wrong shape or leaves nothing, or the mesh has no area.

    Examples
    --------
    >>> cube = trimesh.creation.box((10, 10, 10))
    >>> samples = sample_surface(cube, 1000, exclude=cube.face_normals[:, 2] > 0.5)
    >>> len(samples), round(samples.area, 9)
    (1000, 500.0)
    """
    if not (is_whole(n_samples) and n_samples >= 1):
        raise PlacementError(f"number of samples is {n_samples}; it must be a whole number, at least 1")
    used = ~checked_exclude(mesh, exclude)
    faces = np.flatnonzero(used & (mesh.area_faces > 0))
    if len(faces) == 0:
        raise PlacementError(
            f"nothing is left to sample: {int((~used).sum())} of {len(used)} faces are excluded and the rest "
            "has no area; exclude fewer faces"
        )
    corners, parents, areas = np.asarray(mesh.triangles)[faces], faces, mesh.area_faces[faces]
    sampled = np.inf
    # Less area to sample makes smaller strata, which smaller pieces follow more closely.
    while len(corners) and areas.sum() < 0.5 * sampled:
        sampled = areas.sum()
        corners, parents = _cut(corners, parents, PIECE_LENGTH * np.sqrt(sampled / n_samples))
        if within is not None:
            kept = within(corners)
            corners, parents = corners[kept], parents[kept]
        areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    if not areas.sum() > 0:
        return SurfaceSamples(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0, dtype=int))
    order = np.argsort(_morton_code(corners.mean(axis=1)), kind="stable")
    corners, parents, areas = corners[order], parents[order], areas[order]

    edges = np.concatenate([[0.0], np.cumsum(areas)])
    rng = np.random.default_rng(seed)
    along = (np.arange(n_samples) + rng.random(n_samples)) / n_samples * edges[-1]
    piece = np.clip(np.searchsorted(edges, along, side="right") - 1, 0, len(areas) - 1)
    # The square root makes points uniform over a triangle (Osada et al. 2002, section 4.2).
    toward, across = np.sqrt(rng.random(n_samples))[:, None], rng.random(n_samples)[:, None]
    a, b, c = corners[piece].transpose(1, 0, 2)
    points = (1 - toward) * a + toward * ((1 - across) * b + across * c)
    owner = parents[piece]
    weights = np.full(n_samples, edges[-1] / n_samples)
    return SurfaceSamples(points, np.asarray(mesh.face_normals)[owner], weights, owner)


def checked_exclude(mesh: trimesh.Trimesh, exclude) -> Bool[np.ndarray, " F"]:
    """(F,) bool: `exclude` checked against `mesh`, nothing excluded for None.

    Raises
    ------
    PlacementError
        If it is not one boolean per face, or all faces are excluded.

    Examples
    --------
    >>> checked_exclude(trimesh.creation.box(), None).sum()
    np.int64(0)
    """
    n_faces = len(mesh.faces)
    if exclude is None:
        return np.zeros(n_faces, dtype=bool)
    mask = np.asarray(exclude)
    if mask.shape != (n_faces,) or mask.dtype != np.bool_:
        raise PlacementError(
            f"exclude has shape {mask.shape} and type {mask.dtype}; it must be one boolean for each of the "
            f"{n_faces} faces"
        )
    if mask.all():
        raise PlacementError(f"all {n_faces} faces are excluded; nothing is left to reconstruct")
    return mask


def _cut(
    corners: Float[np.ndarray, "P 3 3"], parents: Int[np.ndarray, " P"], limit: float
) -> tuple[Float[np.ndarray, "Q 3 3"], Int[np.ndarray, " Q"]]:
    """Halve (P, 3, 3) triangles at their longest edge until no edge is longer than `limit`."""
    finished_corners, finished_parents = [], []
    while len(corners):
        lengths = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)  # edge i: corner i to i + 1
        longest = lengths.argmax(axis=1)
        small = lengths.max(axis=1) <= limit
        finished_corners.append(corners[small])
        finished_parents.append(parents[small])
        corners, parents, longest = corners[~small], parents[~small], longest[~small]
        rows = np.arange(len(corners))
        a, b, c = (corners[rows, (longest + i) % 3] for i in range(3))
        middle = (a + b) / 2
        corners = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
        parents = np.concatenate([parents, parents])
    return np.concatenate(finished_corners), np.concatenate(finished_parents)


def _morton_code(points: Float[np.ndarray, "P 3"]) -> Int[np.ndarray, " P"]:
    """(P,) position of (P, 3) points along a Z-order curve: close on the curve is close in space."""
    low = points.min(axis=0)
    extent = float((points.max(axis=0) - low).max()) or 1.0
    bits = 10  # per axis: a thousandth of the extent, far below the spacing of the strata
    cells = ((points - low) / extent * (2**bits - 1)).astype(np.int64)
    code = np.zeros(len(points), dtype=np.int64)
    for bit in range(bits):
        for axis in range(3):
            code |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return code
