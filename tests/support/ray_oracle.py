"""An independent estimate of T-view areas: points strewn over the faces, one Embree ray to each camera.

It shares no code with `exact`: its cameras are written from the paper's text (section 2.2), its visibility is ray
casting, its area a mean.
"""

from dataclasses import dataclass

import numpy as np
import trimesh
from trimesh.ray.ray_pyembree import RayMeshIntersector

# Rays start this far from the surface [mm], since Embree works in single precision. A point that something touches
# from nearer is judged visible, which biases an estimate by far less than its standard error.
LIFT = 2e-5
BLOCK = 10_000  # points at a time, so that a processor keeps them at hand


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


class Samples:
    """About `n_points` points, stratified by face, at least two on each that counts; which of them cameras see.

    Faces that turn away from all `angles` count nothing and get no points. An `obstacle` hides what is behind it.
    """

    def __init__(self, mesh, angles, n_points, exclude=None, fov=(36.0, 24.0), seed=0, obstacle=None):
        rng = np.random.default_rng(seed)
        cameras = [ring_camera(angle) for angle in angles]
        corner = mesh.triangles
        # A face turns towards a camera with all its points or with none.
        facing = [(((centre - corner[:, 0]) * mesh.face_normals).sum(axis=1) > 0) for centre, *_ in cameras]
        self.areas = np.where(np.any(facing, axis=0), mesh.area_faces, 0.0)
        if exclude is not None:
            self.areas[exclude] = 0.0
        share = self.areas / self.areas.sum() * n_points
        number = np.floor(share + rng.random(len(share))).astype(int)
        self.number = np.where(self.areas > 0, np.maximum(number, 2), 0)
        self.face = np.repeat(np.arange(len(self.areas)), self.number)
        u, v = rng.random((2, len(self.face), 1))
        u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
        sides = corner[:, 1:] - corner[:, :1]
        points = corner[self.face, 0] + u * sides[self.face, 0] + v * sides[self.face, 1]
        hiding = mesh if obstacle is None else trimesh.util.concatenate([mesh, obstacle])
        self._rays = RayMeshIntersector(hiding, scale_to_box=False)._scene
        normals = mesh.face_normals[self.face]
        self.cameras, self.fov, self.points, self.normals = cameras, fov, points, normals
        self.seen = np.zeros((len(cameras), len(points)), dtype=bool)
        for some in blocks(len(points)):
            for camera, faces, seen in zip(cameras, facing, self.seen, strict=True):
                asked = some[faces[self.face[some]]]
                seen[asked] = _seen(self._rays, points[asked], normals[asked], camera, fov)

    def lit_from(self, light):
        """Which points a light at that place [mm], beyond the whole mesh, shines on."""
        lit = np.zeros(len(self.points), dtype=bool)
        for some in blocks(len(self.points)):
            lit[some] = _unhidden(self._rays, self.points[some], self.normals[some], np.asarray(light))
        return lit

    def estimate(self, cameras, threshold):
        """Area seen by at least `threshold` of the `cameras`, given as indices of the angles."""
        return self.area_of(self.seen[list(cameras)].sum(axis=0) >= threshold)

    def area_of(self, counts):
        """Area of which the points that count, (N,) bool, are samples."""
        hits = np.bincount(self.face, weights=counts, minlength=len(self.areas))
        mean = np.divide(hits, self.number, out=np.zeros(len(hits)), where=self.number > 0)
        # Laplace's rule keeps a face whose few samples agree from claiming to be certain.
        spread = (hits + 0.5) / (self.number + 1)
        variance = self.areas**2 * spread * (1 - spread) / np.maximum(self.number, 1)
        return Estimate(float((self.areas * mean).sum()), float(np.sqrt(variance.sum())))


def _seen(scene, points, normals, camera, fov):
    centre, tangential, radial, look = camera
    to_camera = centre - points
    along, across, depth = to_camera @ tangential, to_camera @ radial, -(to_camera @ look)
    scale = np.linalg.norm(centre) / depth  # from the point's depth to the plane through the focus
    seen = (depth > 0) & (np.abs(along * scale) <= fov[0] / 2) & (np.abs(across * scale) <= fov[1] / 2)
    asked = np.flatnonzero(seen)
    seen[asked] = _unhidden(scene, points[asked], normals[asked], centre)
    return seen


def _unhidden(scene, points, normals, place):
    """Which points can be seen from a place beyond the whole mesh that their faces turn towards."""
    away = place - points
    direction = away / np.sqrt((away**2).sum(axis=1, keepdims=True))
    origin = points + LIFT * (normals + direction)
    hit = scene.run(origin.astype(np.float32), direction.astype(np.float32)) >= 0
    return ~hit & ((away * normals).sum(axis=1) > 0)


def blocks(n_points):
    """Indices of points, a block at a time."""
    return np.split(np.arange(n_points), np.arange(BLOCK, n_points, BLOCK))
