"""An independent estimate of T-view areas: points strewn over the faces, one Embree ray to each camera.

It shares no code with `exact`: its cameras are written from the paper's text (section 2.2), its visibility is ray
casting, its area a mean. Only the cameras' placement on the ring is taken as angles.
"""

from dataclasses import dataclass

import numpy as np
from trimesh.ray.ray_pyembree import RayMeshIntersector

# Rays start this far from the surface [mm], since Embree works in single precision; a point closer than this to what
# hides it is judged wrong, which biases the estimate by far less than its standard error.
LIFT = 1e-3


@dataclass(frozen=True)
class Estimate:
    """Area [mm²] and its standard error [mm²]."""

    area: float
    standard_error: float


def ring_camera(angle, diameter=30.0, working_distance=400.0):
    """Centre, tangential and radial image axes and viewing direction of a ring camera with its focus at the origin."""
    centre = np.array([diameter / 2 * np.cos(angle), diameter / 2 * np.sin(angle), working_distance])
    look = -centre / np.linalg.norm(centre)
    tangential = np.array([-np.sin(angle), np.cos(angle), 0.0])
    return centre, tangential, np.cross(tangential, look), look


def count_views(mesh, points, normals, cameras, fov):
    """(N,) how many `cameras`, as given by `ring_camera`, see each point."""
    intersector = RayMeshIntersector(mesh, scale_to_box=False)
    count = np.zeros(len(points), dtype=int)
    for centre, tangential, radial, look in cameras:
        to_camera = centre - points
        depth = -(to_camera @ look)
        scale = np.linalg.norm(centre) / depth  # from the point's depth to the plane through the focus
        facing = (to_camera * normals).sum(axis=1) > 0
        inside = (np.abs(to_camera @ tangential * scale) <= fov[0] / 2) & (depth > 0)
        inside &= np.abs(to_camera @ radial * scale) <= fov[1] / 2
        asked = np.flatnonzero(facing & inside)
        direction = to_camera[asked] / np.linalg.norm(to_camera[asked], axis=1, keepdims=True)
        origin = points[asked] + LIFT * (normals[asked] + direction)
        # From the camera downwards, nothing may come before the point: the far end is where rounding matters least.
        count[asked] += ~intersector.intersects_any(origin, direction)
    return count


def estimate(mesh, angles, threshold, n_points, exclude=None, fov=(36.0, 24.0), seed=0):
    """Area seen by at least `threshold` cameras at ring `angles`, from about `n_points` stratified samples."""
    rng = np.random.default_rng(seed)
    areas = mesh.area_faces.copy()
    if exclude is not None:
        areas[exclude] = 0.0
    share = areas / areas.sum() * n_points
    number = np.floor(share + rng.random(len(share))).astype(int)
    number = np.where(areas > 0, np.maximum(number, 2), 0)
    face = np.repeat(np.arange(len(areas)), number)
    u, v = rng.random((2, len(face)))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    corner = mesh.triangles[face]
    points = corner[:, 0] + u[:, None] * (corner[:, 1] - corner[:, 0]) + v[:, None] * (corner[:, 2] - corner[:, 0])
    cameras = [ring_camera(angle) for angle in angles]
    seen = count_views(mesh, points, mesh.face_normals[face], cameras, fov) >= threshold
    hits = np.bincount(face, weights=seen, minlength=len(areas))
    mean = np.divide(hits, number, out=np.zeros(len(areas)), where=number > 0)
    # Laplace's rule keeps a face whose few samples agree from claiming to be certain.
    spread = (hits + 0.5) / (number + 1)
    variance = np.divide(areas**2 * spread * (1 - spread), number, out=np.zeros(len(areas)), where=number > 0)
    return Estimate(float((areas * mean).sum()), float(np.sqrt(variance.sum())))
