"""Areas of meshes made up at random, as bad as scans get, against rays.

More of them by hand: CAMRING_RANDOM_MESHES=1000 pytest tests/exact/test_random_meshes.py
"""

import os

import numpy as np
import pytest
import trimesh

import exact
from tests.support.ray_oracle import ring_camera

RING = exact.Ring()
N_MESHES = int(os.environ.get("CAMRING_RANDOM_MESHES", "25"))
N_POINTS = 20_000
# Laplace's rule keeps an estimate from claiming to be certain; of a thousand meshes a few are far off by chance.
STANDARD_ERRORS = 6.0


def estimate(triangles, angles, rng, fov=(36.0, 24.0)):
    """Area seen by at least two cameras, and its standard error [mm²]: rays in float64, each against all faces.

    Embree's single precision does not tell a sliver of 10 nm from its neighbours.
    """
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    areas = np.linalg.norm(normals, axis=1) / 2
    face = np.repeat(np.arange(len(triangles)), N_POINTS // len(triangles))
    u, v = rng.random((2, len(face), 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    a, b, c = np.moveaxis(triangles, 1, 0)
    points = a[face] + u * (b - a)[face] + v * (c - a)[face]
    count = np.zeros(len(face), dtype=int)
    for angle in angles:
        centre, tangential, radial, look = ring_camera(angle)
        ray = centre - points
        scale = -np.linalg.norm(centre) / (ray @ look)
        seen = (((centre - a) * normals).sum(axis=1) > 0)[face]
        seen &= (np.abs(ray @ tangential * scale) <= fov[0] / 2) & (np.abs(ray @ radial * scale) <= fov[1] / 2)
        for other in range(len(triangles)):
            e1, e2 = b[other] - a[other], c[other] - a[other]
            cross = np.cross(ray, e2)
            away = points - a[other]
            with np.errstate(divide="ignore", invalid="ignore"):
                share = 1 / (cross @ e1)
                first = (away * cross).sum(axis=1) * share
                turned = np.cross(away, e1)
                second = (ray * turned).sum(axis=1) * share
                distance = turned @ e2 * share
            hit = (first >= 0) & (second >= 0) & (first + second <= 1) & (distance > 0) & (distance < 1)
            seen &= ~hit | (face == other)
        count += seen
    hits, number = np.bincount(face, weights=count >= 2, minlength=len(areas)), np.bincount(face, minlength=len(areas))
    spread = (hits + 0.5) / (number + 1)
    return (areas * hits / number).sum(), np.sqrt((areas**2 * spread * (1 - spread) / number).sum())


def corners(rng, kind):
    """(F, 3, 3) of a mesh of its kind."""
    n = int(rng.integers(2, 25))
    middle = rng.uniform(-8, 8, (n, 1, 3))
    if kind == "soup":
        return middle + rng.normal(0, 4, (n, 3, 3))
    if kind == "spikes":
        base = middle + rng.normal(0, 0.05, (n, 3, 3))
        base[:, 0] += rng.normal(0, 15, (n, 3))
        return base
    if kind == "slivers":
        along = rng.normal(0, 8, (n, 1, 3)) * np.array([-1.0, 0.1, 1.0])[None, :, None]
        return middle + along + rng.normal(0, 10.0 ** rng.uniform(-5, -1), (n, 3, 3))
    if kind == "coplanar":
        first = middle + rng.normal(0, 4, (n, 3, 3)) * np.array([1, 1, 0.1])
        return np.concatenate([first, first + rng.normal(0, 1e-9, first.shape) + np.array([0.3, 0.2, 0])])
    size = 10.0 ** rng.uniform(-6, 3, (n, 1, 1))
    return middle + size * rng.normal(0, 1, (n, 3, 3))


KINDS = ("soup", "spikes", "slivers", "coplanar", "sizes")


@pytest.mark.parametrize("number", range(N_MESHES))
def test_area_within_the_error_of_rays(number):
    rng = np.random.default_rng(number)
    triangles = corners(rng, KINDS[number % len(KINDS)])
    mesh = trimesh.Trimesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), process=False)
    angles = rng.uniform(0, 2 * np.pi, 3)
    result = exact.evaluate(mesh, RING.cameras(angles), threshold=2)
    assert (result.face_areas >= 0).all()
    assert (result.face_areas <= mesh.area_faces * (1 + 1e-9)).all()
    assert (np.diff(result.level_areas) <= 1e-9 * mesh.area).all()
    area, error = estimate(triangles, angles, rng)
    assert abs(result.area - area) <= STANDARD_ERRORS * error, (result.area, area, error, result.repairs)

    # A kilometre away ten digits are left.
    away = np.array([1e6, -1e6, 5e5])
    far = trimesh.Trimesh(mesh.vertices + away, mesh.faces, process=False)
    shifted = exact.evaluate(far, exact.Ring(focus=tuple(away)).cameras(angles), threshold=2)
    assert (shifted.face_areas >= 0).all()
    assert (shifted.face_areas <= far.area_faces * (1 + 1e-9)).all()
