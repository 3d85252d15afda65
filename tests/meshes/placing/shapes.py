"""Surfaces made with the focus in the origin and the cameras on the +z side, and the same ones lying anywhere."""

from collections.abc import Callable

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

import meshes
from tests.meshes.defects import bowl, mesh_of, sheet


def height_field(height: Callable, half: float, n: int = 50) -> trimesh.Trimesh:
    """An open surface over a square, its front up."""
    x, y = np.meshgrid(np.linspace(-half, half, n), np.linspace(-half, half, n), indexing="ij")
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return mesh_of(np.stack([x, y, height(x, y)], axis=-1).reshape(-1, 3), faces)


def bump() -> trimesh.Trimesh:
    """Like a tooth, on a plate larger than the field of view."""
    return height_field(
        lambda x, y: 9 / (1 + (np.hypot(x, 1.2 * y) / 5) ** 6) * (1 + 0.15 * np.cos(x) * np.cos(1.3 * y)), 20
    )


def waves() -> trimesh.Trimesh:
    """A sheet much larger than the field of view."""
    return height_field(lambda x, y: 2 * np.sin(x / 5) * np.cos(y / 4), 30)


def trench() -> trimesh.Trimesh:
    """A solid with a trench along x, 24 mm long, 8 mm wide and 20 mm deep, whose floor is at z = 0."""
    hole = trimesh.creation.box(bounds=[[-12, -4, 0], [12, 4, 30]])
    block = trimesh.creation.box(bounds=[[-30, -30, -4], [30, 30, 20]])
    return trimesh.boolean.difference([block, hole]).subdivide_to_size(6.0)


SHAPES = {
    **{f"{name}@{depth}": lambda name=name, depth=depth: meshes.site(name, depth=depth) for name, depth in (
        ("circ_flat", 50), ("circ_flat", 100), ("circ_angled", 50), ("circ_artery", 50), ("circ_overhang", 50),
        ("spine_disc", 50),
    )},
    "bowl": bowl, "bump": bump, "sheet": sheet, "waves": waves,
}  # fmt: skip


def somewhere(seed: int) -> np.ndarray:
    """(4, 4) a turn and a shift by some hundred millimetres."""
    motion = np.eye(4)
    motion[:3, :3] = Rotation.random(random_state=seed).as_matrix()
    motion[:3, 3] = np.random.default_rng(seed).uniform(-400, 400, 3)
    return motion


def lying(mesh: trimesh.Trimesh, motion: np.ndarray) -> trimesh.Trimesh:
    return mesh_of(trimesh.transform_points(mesh.vertices, motion), mesh.faces)
