"""Meshes of the kinds that people bring, of any size: scans, CAD parts and channels."""

from collections.abc import Callable

import numpy as np
import trimesh
from scipy.spatial import ConvexHull

import meshes

# Corners of each cap of a cylinder: enough that its faces are thousands of times as long as wide.
CAP_CORNERS = 2000
# Waves that a field of folds is made of.
WAVES = 40


def sphere(n_faces: int, radius: float = 12.0) -> trimesh.Trimesh:
    """A closed ball of about `n_faces` faces of like size and shape, about the origin.

    Examples
    --------
    >>> ball = sphere(2000)
    >>> len(ball.faces), ball.is_watertight, bool(ball.volume > 0)
    (2000, True, True)
    """
    n = n_faces // 2 + 2
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(n)
    z = 1 - (2 * np.arange(n) + 1) / n
    level = np.sqrt(1 - z * z)
    points = np.stack([level * np.cos(turn), level * np.sin(turn), z], axis=1)
    hull = ConvexHull(points)
    faces = hull.simplices.astype(np.int64)
    corner = points[faces]
    inwards = (np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]) * corner[:, 0]).sum(axis=1) < 0
    faces[inwards] = faces[inwards][:, ::-1]
    # Neighbours stand together, as in the files of scans, rather than as the hull was found.
    faces = faces[np.argsort(faces.min(axis=1), kind="stable")]
    return trimesh.Trimesh(radius * points, faces, process=False)


def _field(directions: np.ndarray, frequency: float, seed: int) -> np.ndarray:
    """(N,) a smooth field of about unit size over directions (N, 3), the same for each seed."""
    rng = np.random.default_rng(seed)
    wave = rng.normal(size=(WAVES, 3))
    wave *= frequency * rng.uniform(0.7, 1.3, size=(WAVES, 1)) / np.linalg.norm(wave, axis=1, keepdims=True)
    phase = rng.uniform(0, 2 * np.pi, WAVES)
    total = np.zeros(len(directions))
    for k in range(WAVES):
        total += np.cos(directions @ wave[k] + phase[k])
    return total * np.sqrt(2 / WAVES)


def brain(n_faces: int, seed: int = 0) -> trimesh.Trimesh:
    """A ball with narrow, deep and overhanging folds, a little rough as scans are; most of it lies in shadow.

    Examples
    --------
    >>> folded = brain(2000)
    >>> len(folded.faces), folded.is_watertight
    (2000, True)
    """
    ball = sphere(n_faces, radius=1.0)
    direction = np.asarray(ball.vertices)
    folds = np.exp(-((_field(direction, 14.0, seed) / 0.45) ** 2))
    # Turned about the axis by height, walls of the folds lean over.
    lean = 0.08 * _field(direction, 9.0, seed + 1)
    rough = 0.15 * np.sqrt(4 * np.pi / n_faces) * np.random.default_rng(seed + 2).normal(size=len(direction))
    radius = 12.0 * (1 - 0.3 * folds + rough)
    c, s = np.cos(lean * (1 - folds)), np.sin(lean * (1 - folds))
    x, y, z = direction.T
    return trimesh.Trimesh(
        radius[:, None] * np.stack([c * x - s * y, s * x + c * y, z], axis=1), ball.faces, process=False
    )


def skull(n_faces: int, seed: int = 0) -> trimesh.Trimesh:
    """A shell with an inner and an outer side and round openings that show the inner one; rough as scans are.

    Examples
    --------
    >>> shell = skull(4000)
    >>> 0.95 < len(shell.faces) / 4000 < 1.05, shell.is_watertight
    (True, True)
    """
    ball = sphere(int(0.56 * n_faces), radius=1.0)
    direction, faces = np.asarray(ball.vertices), np.asarray(ball.faces)
    middle = direction[faces].mean(axis=1)
    rng = np.random.default_rng(seed)
    opening = np.array([[0.0, 0.0, 1.0], [0.75, 0.2, 0.65], [-0.7, 0.4, 0.6], [0.1, -0.8, 0.6], [-0.3, 0.9, 0.2]])
    opening /= np.linalg.norm(opening, axis=1, keepdims=True)
    faces = faces[(middle @ opening.T < np.cos(0.33)).all(axis=1)]
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    ways = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    _, first, count = np.unique(edges, axis=0, return_index=True, return_counts=True)
    start, end = ways[first[count == 1]].T
    n = len(direction)
    bumps = 0.05 * _field(direction, 6.0, seed + 1)
    step = np.sqrt(4 * np.pi / n_faces)
    outer, inner = (
        12.0 * (size + bumps + 0.2 * step * rng.normal(size=n))[:, None] * direction for size in (1.0, 0.85)
    )
    rim = np.concatenate([np.stack([end, start, start + n], axis=1), np.stack([end, start + n, end + n], axis=1)])
    return trimesh.Trimesh(
        np.concatenate([outer, inner]), np.concatenate([faces, faces[:, ::-1] + n, rim]), process=False
    )


def cylinders(n_faces: int) -> trimesh.Trimesh:
    """Cylinders with caps of `CAP_CORNERS` corners, as CAD programs cut them: fans of long, thin faces.

    Each has 7 996 faces; with fewer faces asked for, there is one with fewer corners.

    Examples
    --------
    >>> parts = cylinders(2000)
    >>> len(parts.faces), parts.is_watertight
    (1996, True)
    """
    corners = min(CAP_CORNERS, n_faces // 4)
    n = max(1, round(n_faces / (4 * corners)))
    angle = 2 * np.pi * np.arange(corners) / corners
    i = np.arange(corners)
    j = (i + 1) % corners
    fan = np.stack([np.zeros(corners - 2, dtype=int), i[1:-1], j[1:-1]], axis=1)
    side = np.concatenate([np.stack([i, j, j + corners], axis=1), np.stack([i, j + corners, i + corners], axis=1)])
    faces = np.concatenate([fan[:, ::-1], side, fan + corners])
    parts = []
    for k in range(n):
        row, column = divmod(k, 5)
        radius, height = 2.0 + 0.15 * (k % 4), 4.0 + (3 * k) % 7
        circle = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1) + [6 * column - 12, 7 * row - 3.5]
        points = np.concatenate([np.column_stack([circle, np.full(corners, z)]) for z in (-height, height)])
        parts.append(trimesh.Trimesh(points, faces, process=False))
    return _together(parts)


def channel(n_faces: int) -> trimesh.Trimesh:
    """A round channel with a fine floor under two vessels: a quarter of all faces is never seen by any camera.

    Examples
    --------
    >>> 0.95 < len(channel(4000).faces) / 4000 < 1.05
    True
    """
    around = int(np.sqrt(0.7 * n_faces))
    rows = round(0.7 * n_faces / 2 / around)
    floor = round(0.8 * rows)

    def floor_and_wall(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        along = v * rows
        out = np.minimum(along / floor, 1.0)
        up = np.maximum(along - floor, 0.0) / (rows - floor)
        radius = 0.3 + 13.7 * out + 0.8 * up
        return np.stack([radius * np.cos(2 * np.pi * u), -radius * np.sin(2 * np.pi * u), 40 * up], axis=-1)

    inside = _grid(floor_and_wall, around, rows)
    length = int(np.sqrt(0.15 * n_faces / 2))
    width = (n_faces - len(inside.faces)) // (4 * length)
    vessels = [
        _grid(
            lambda u, v, x=x: np.stack(
                [x + 3.2 * np.cos(2 * np.pi * u), 22 * v - 11, 4 + 3.2 * np.sin(2 * np.pi * u)], axis=-1
            ),
            width,
            length,
        )
        for x in (-4.0, 4.0)
    ]
    for vessel in vessels:
        vessel.invert()
    return _together([inside, *vessels])


def _together(parts: list[trimesh.Trimesh]) -> trimesh.Trimesh:
    """One mesh of several, none of whose vertices becomes one with another's."""
    first = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + offset for part, offset in zip(parts, first, strict=False)]
    return trimesh.Trimesh(np.concatenate([part.vertices for part in parts]), np.concatenate(faces), process=False)


def _grid(surface: Callable[[np.ndarray, np.ndarray], np.ndarray], n_u: int, n_v: int) -> trimesh.Trimesh:
    """A surface over the unit square, in `n_u` x `n_v` squares of two faces; corners in one place are one."""
    u, v = np.meshgrid(np.linspace(0, 1, n_u + 1), np.linspace(0, 1, n_v + 1), indexing="ij")
    number = np.arange(u.size).reshape(u.shape)
    a, b, c, d = (part.reshape(-1) for part in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return trimesh.Trimesh(surface(u, v).reshape(-1, 3).round(9), faces, process=False)


def site(n_faces: int) -> trimesh.Trimesh:
    """The built-in site `circ_overhang`, 50 mm deep, of the detail whose number of faces is nearest.

    Examples
    --------
    >>> len(site(4000).faces) < 6000
    True
    """
    detail = "coarse" if n_faces < 10_000 else "middle" if n_faces < 41_000 else "fine"
    return meshes.site("circ_overhang", depth=50, detail=detail)


KINDS: dict[str, Callable[[int], trimesh.Trimesh]] = {
    "site": site,
    "sphere": sphere,
    "brain": brain,
    "skull": skull,
    "cylinders": cylinders,
    "channel": channel,
}
