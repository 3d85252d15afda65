"""Small files for tests: a box as a mesh, a layout, and the texts of other meshes."""

import os
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import trimesh

import meshes

ASCII = (
    "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 5 0 0\nvertex 0 5 0\nendloop\nendfacet\nendsolid\n"
)
PLY = (
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n5 0 0\n0 5 0\n3 0 1 2\n"
)
RING = {"diameter_mm": 30, "working_distance_mm": 400, "fov_mm": [36, 24]}
LAYOUT = {"format": "camring layout", "version": 1, "ring": RING, "angles_deg": [0, 180], "threshold": 2}


def box(size: float = 10.0, at: Sequence[float] = (0, 0, 0)) -> trimesh.Trimesh:
    return trimesh.creation.box((size, size, size)).apply_translation(at)


def stl(mesh: trimesh.Trimesh) -> bytes:
    return meshes.stl_bytes(mesh)


def soup(corners: object) -> trimesh.Trimesh:
    """Faces of three corners each that share no vertex."""
    corners = np.asarray(corners, dtype=float).reshape(-1, 3)
    return trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False)


def put(folder: Path, name: str, content: bytes | str) -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def part(folder: Path) -> Path:
    """A sound mesh, for cases in which something else is wrong."""
    return put(folder, "part.stl", stl(box()))


def made(path: Path, make: Callable[[Path], object]) -> Path:
    if not os.path.lexists(path):
        make(path)
    return path
