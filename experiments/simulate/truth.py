"""What the cameras truly look at: depth and face of each pixel, by rays; and how well matches agree with it."""

from dataclasses import dataclass

import numpy as np
import trimesh
from trimesh.ray.ray_pyembree import RayMeshIntersector

import exact
from experiments.simulate.depth_map import Estimate, pixel_rays

# Of a normal distribution the standard deviation is so many of its median absolute deviations.
NORMAL = 1.4826
# Surfaces seen at less than this from their normal face the camera [rad].
FACING = np.radians(60.0)
# Matches that are off by more than this are of another point [pixels].
SAME_POINT = 3.0


@dataclass(frozen=True, eq=False)
class TrueDepth:
    """What a camera's pixels show.

    Attributes
    ----------
    depth : (H, W) ndarray
        Along the optical axis [mm]; nan where a ray hits nothing.
    cosine : (H, W) ndarray
        Of the angle between the ray and the normal.
    """

    depth: np.ndarray
    cosine: np.ndarray


def true_depth(mesh: trimesh.Trimesh, camera: exact.Camera) -> TrueDepth:
    """Cast a ray through the centre of each pixel of a camera, whose `resolution` is that of its image.

    Examples
    --------
    >>> camera = exact.Camera.look_at((0, 0, 400), (0, 0, 0), up=(0, 1, 0), resolution=(3, 2))
    >>> found = true_depth(trimesh.creation.box((100, 100, 2)), camera)
    >>> found.depth.round(3).tolist(), bool((found.cosine > 0.99).all())
    ([[399.0, 399.0, 399.0], [399.0, 399.0, 399.0]], True)
    """
    rays = pixel_rays(camera)
    origin = np.broadcast_to(camera.position, rays.shape)
    face = RayMeshIntersector(mesh).intersects_first(origin, rays)
    # Embree reckons in single precision; which plane it is, is enough.
    normal, corner = mesh.face_normals[face], mesh.vertices[mesh.faces[face, 0]]
    height, slope = np.einsum("ni,ni->n", corner - camera.position, normal), np.einsum("ni,ni->n", rays, normal)
    depth = np.divide(height, slope, out=np.full(len(rays), np.nan), where=(face >= 0) & (slope != 0))
    cosine = np.abs(slope) / np.linalg.norm(rays, axis=1)
    width, rows = camera.resolution.astype(int)
    return TrueDepth(depth.reshape(rows, width), np.where(face >= 0, cosine, 0.0).reshape(rows, width))


def robust(values: np.ndarray) -> float:
    """Standard deviation about the median, of all but outliers; nan of nothing.

    Examples
    --------
    >>> round(robust(np.append(np.random.default_rng(0).standard_normal(100_000), np.full(1_000, 1e3))), 1)
    1.0
    """
    return float(NORMAL * np.median(np.abs(values - np.median(values)))) if len(values) else float("nan")


def match_noise(estimate: Estimate, truth: TrueDepth) -> float:
    """Standard deviation [pixels] in each image of a pair's matches on surfaces that face the camera; nan of none."""
    facing = (truth.cosine > np.cos(FACING)) & np.isfinite(estimate.depth) & np.isfinite(truth.depth)
    depth, true = estimate.depth[facing].astype(np.float64), truth.depth[facing]
    off = (1 / depth - 1 / true) / estimate.noise
    return robust(off[np.abs(off) <= SAME_POINT])
