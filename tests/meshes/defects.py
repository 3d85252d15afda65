"""Defects that meshes of scans have, made in shapes of which the right area is known."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import trimesh


def bowl() -> trimesh.Trimesh:
    """A thick bowl, open upwards: a closed solid."""
    profile = [(0, -6), (5, -5), (9, -1), (10, 4), (8, 4), (7, 0), (4, -3), (0, -4)]
    return trimesh.creation.revolve(profile, sections=24)


def knob() -> trimesh.Trimesh:
    """A closed solid that bulges towards the cameras."""
    ball = trimesh.creation.icosphere(2, 9.0)
    ball.vertices *= 1 + 0.2 * np.sin(3 * ball.vertices[:, :1] / 9) * np.cos(2 * ball.vertices[:, 1:2] / 9)
    return ball


def sheet() -> trimesh.Trimesh:
    """An open sheet with waves, its front up."""
    n = 13
    x, y = np.meshgrid(np.linspace(-9, 9, n), np.linspace(-8, 8, n), indexing="ij")
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    vertices = np.stack([x, y, 1.5 * np.sin(x / 3) * np.cos(y / 4)], axis=-1).reshape(-1, 3)
    return trimesh.Trimesh(vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]), process=False)


SHAPES: dict[str, Callable[[], trimesh.Trimesh]] = {"bowl": bowl, "knob": knob, "sheet": sheet}


@dataclass(frozen=True, eq=False)
class Defect:
    """A mesh with a defect, and the same surface as it should be wound."""

    broken: trimesh.Trimesh
    right: trimesh.Trimesh


def mesh_of(vertices, faces) -> trimesh.Trimesh:
    return trimesh.Trimesh(vertices, faces, process=False)


def near(mesh: trimesh.Trimesh, rng: np.random.Generator, share: float) -> np.ndarray:
    """(F,) bool: a patch about a random face."""
    middle = mesh.triangles_center
    away = np.linalg.norm(middle - middle[rng.integers(len(middle))], axis=1)
    return away <= np.quantile(away, share)


def rims_of(mesh: trimesh.Trimesh) -> list[np.ndarray]:
    return [] if mesh.is_watertight else [np.array(one.points[:-1]) for one in mesh.outline().entities if one.closed]


def turned(faces: np.ndarray, which: np.ndarray) -> np.ndarray:
    return np.where(which[:, None], faces[:, ::-1], faces)


def crack(mesh, rng):
    """A strip of faces is missing; the rest is inside-out."""
    right = mesh_of(mesh.vertices, mesh.faces[~near(mesh, rng, rng.uniform(0.01, 0.05))])
    return Defect(mesh_of(right.vertices, right.faces[:, ::-1]), right)


def shell(mesh, rng):
    """All is inside-out, and its vertices are not joined."""
    right = mesh_of(mesh.triangles.reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3))
    return Defect(mesh_of(right.vertices, right.faces[:, ::-1]), right)


def patch(mesh, rng):
    """A patch is wound the other way."""
    return Defect(mesh_of(mesh.vertices, turned(mesh.faces, near(mesh, rng, rng.uniform(0.02, 0.9)))), mesh)


def island(mesh, rng):
    """A patch is wound the other way, with a gap around it that is a face wide."""
    inner = near(mesh, rng, rng.uniform(0.05, 0.8))
    kept = inner | ~np.isin(mesh.faces, mesh.faces[inner]).any(axis=1)
    right = mesh_of(mesh.vertices, mesh.faces[kept])
    return Defect(mesh_of(mesh.vertices, turned(right.faces, inner[kept])), right)


def doubled(mesh, rng):
    """Each face is there both ways round, in any order."""
    both = np.concatenate([mesh.faces, mesh.faces[:, ::-1]])
    return Defect(mesh_of(mesh.vertices, rng.permutation(both)), mesh)


def repeated(mesh, rng):
    """Some faces are there twice."""
    again = np.concatenate([mesh.faces, np.roll(mesh.faces[rng.integers(len(mesh.faces), size=9)], 1, axis=1)])
    return Defect(mesh_of(mesh.vertices, rng.permutation(again)), mesh)


def bad_fill(mesh, rng):
    """A patch is cut out and filled with a fan about its middle that is wound the wrong way, or joined crosswise."""
    before, rims = len(rims_of(mesh)), []
    while len(rims) != before + 1:  # a patch at the border leaves no hole
        rest = mesh_of(mesh.vertices, mesh.faces[~near(mesh, rng, 0.04)])
        rims = rims_of(rest)
    rim = min(rims, key=lambda one: np.ptp(rest.vertices[one], axis=0).sum())
    vertices = np.vstack([rest.vertices, rest.vertices[rim].mean(axis=0)])
    after = np.roll(rim, -1)
    fan = np.column_stack([rim, after, np.full(len(rim), len(rest.vertices))])
    forwards = {tuple(edge) for face in rest.faces.tolist() for edge in zip(face, face[1:] + face[:1], strict=True)}
    if (int(rim[0]), int(after[0])) in forwards:
        fan = fan[:, ::-1]
    wrong = fan[:, ::-1] if rng.random() < 0.5 else turned(fan, np.arange(len(fan)) % 2 == 0)
    return Defect(mesh_of(vertices, np.vstack([rest.faces, wrong])), mesh_of(vertices, np.vstack([rest.faces, fan])))


DEFECTS = (crack, shell, patch, island, doubled, repeated, bad_fill)


def cases(each: int) -> Iterator[tuple[str, Defect]]:
    """So many of each defect in each shape."""
    for shape, make in SHAPES.items():
        for defect in DEFECTS:
            for seed in range(each):
                yield f"{shape}, {defect.__name__}, {seed}", defect(make(), np.random.default_rng(seed))
