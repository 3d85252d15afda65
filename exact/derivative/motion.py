"""How fast borders move across their faces when a camera moves, turns, or widens its field of view.

A border is where F(X, q) = 0 on a face. When a parameter q of the camera changes, it moves along its normal in the
face, the unit vector u, by -∂F/∂q / (∇F · u). Along a straight border that is an affine function of the place, so its
value at the middle, times the length, is what the border sweeps over, exactly.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exact.cameras import Camera
from exact.demand import Demand
from exact.derivative.borders import Borders
from exact.visibility.projection import project
from exact.visibility.silhouettes import FARTHEST, NEAREST, SIDES, STEEPEST
from exact.visibility.surface import Surface

# What a camera's parameters are, in this order: position [mm], turn about the axes of the world [rad], half width and
# half height of its field of view at unit depth, distance of its target [mm].
POSITION, ROTATION, EXTENT, TARGET = slice(0, 3), slice(3, 6), slice(6, 8), slice(8, 9)
N_PARAMETERS = 9


@dataclass(frozen=True, eq=False)
class _Border:
    """Where F is 0 on a face: its gradient in space and its derivatives by the parameters, (N, 3), (N, 9)."""

    gradient: np.ndarray
    by_parameters: np.ndarray


def swept(surface: Surface, cameras: Sequence[Camera], borders: Borders, demand: Demand) -> np.ndarray:
    """(N, 9) area that each piece gains [mm²] at each border per unit of its camera's parameters."""
    gained = np.zeros((len(borders.face), N_PARAMETERS))
    for number, camera in enumerate(cameras):
        of_camera = borders.camera == number
        for chosen, border in _kinds(surface, camera, borders, of_camera, demand):
            some = borders.take(chosen)
            along, normal = some.end - some.start, surface.normals[some.face]
            across = border.gradient - normal * _dot(normal, border.gradient)[:, None]
            outwards = np.sign(_dot(across, np.cross(along, normal)))
            size = np.linalg.norm(across, axis=1)
            # A border that is the whole plane of its face has no direction; it has no length either.
            rate = np.divide(outwards * np.linalg.norm(along, axis=1), size, out=np.zeros(len(size)), where=size > 0)
            gained[chosen] = -rate[:, None] * border.by_parameters
        arc = np.flatnonzero(of_camera & (borders.source[:, 0] == STEEPEST))
        gained[arc] = _of_arcs(surface, camera, borders.take(arc))
    return gained


def _kinds(surface: Surface, camera: Camera, borders: Borders, of_camera: np.ndarray, demand: Demand):
    """Borders of one camera by what they are of: which, and how they move."""
    one, other = borders.source.T
    middle = (borders.start + borders.end) / 2 - camera.position
    chosen = np.flatnonzero(of_camera & (one >= 0))
    if len(chosen):
        points = _points(surface, camera, borders.source[chosen])
        yield chosen, _shadows(middle[chosen], points[:, 0], points[:, 1])
    for k, side in enumerate(SIDES):
        chosen = np.flatnonzero(of_camera & (one == side))
        if len(chosen):
            yield chosen, _side_of_view(camera, middle[chosen], k)
    for source in (NEAREST, FARTHEST):
        chosen = np.flatnonzero(of_camera & (one == source))
        if len(chosen):
            normal = surface.normals[borders.face[chosen]]
            border = _depth(camera, middle[chosen], normal)
            border.by_parameters[:] -= _depth_limit(camera, middle[chosen], normal, demand, source == NEAREST)
            yield chosen, border


def _points(surface: Surface, camera: Camera, number: np.ndarray) -> np.ndarray:
    """(N, 2, 3) the ends of silhouettes relative to the camera [mm], by their numbers in its image."""
    points = surface.vertices
    if (number >= len(points)).any():  # where the near plane cuts faces
        image = project(surface, camera)
        depth = 1 / image.inverse_depth[len(points) :]
        local = np.stack([image.x[len(points) :] * depth, image.y[len(points) :] * depth, depth], axis=1)
        points = np.concatenate([points, camera.position + local @ camera.rotation])
    return points[number] - camera.position


def _shadows(middle: np.ndarray, one: np.ndarray, other: np.ndarray) -> _Border:
    """Of the silhouette from `one` to `other`: F is the volume over it, the place and the camera."""
    along = other - one
    by = np.zeros((len(middle), N_PARAMETERS))
    by[:, POSITION] = -np.cross(along, middle - one)
    return _Border(np.cross(one, along), by)


def _side_of_view(camera: Camera, middle: np.ndarray, k: int) -> _Border:
    """Of a side of the field of view, in the order of `SIDES`: F = m · (X - C), and m turns with the camera."""
    axis, sign = ((1, 1.0), (0, -1.0), (1, -1.0), (0, 1.0))[k]
    across, look = camera.rotation[axis], camera.rotation[2]
    normal = across + sign * camera.half_extent[axis] * look
    by = _of_plane(normal, middle)
    by[:, EXTENT][:, axis] = sign * (middle @ look)
    return _Border(np.broadcast_to(normal, middle.shape), by)


def _depth(camera: Camera, middle: np.ndarray, normal: np.ndarray) -> _Border:
    """Of a depth: F = look · (X - C) less that depth, which is left to the caller."""
    look = camera.rotation[2]
    return _Border(np.broadcast_to(look, normal.shape), _of_plane(look, middle))


def _of_plane(normal: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """(N, 9) derivatives of m · (X - C), where m (3,) is fixed in the camera."""
    by = np.zeros((len(middle), N_PARAMETERS))
    by[:, POSITION] = -normal
    by[:, ROTATION] = np.cross(normal, middle)
    return by


def _depth_limit(camera: Camera, middle: np.ndarray, normal: np.ndarray, demand: Demand, nearest: bool) -> np.ndarray:
    """(N, 9) derivatives of the least or the greatest depth [mm] that the limits leave on planes."""
    limits, optics = demand.limits, demand.optics
    by = np.zeros((len(middle), N_PARAMETERS))
    height = -_dot(normal, middle)
    near, far = limits.depths(camera, optics, height)
    if limits.max_blur is not None:
        sharp = optics.sharp(camera, limits.max_blur)
        focus = camera.target_distance if optics.focus_distance is None else optics.focus_distance
        share = focus / sharp[0] - 1
        depth, sign = (sharp[0], 1.0) if nearest else (sharp[1], -1.0)
        of_blur = np.broadcast_to(near if nearest else far, len(height)) == depth
        # A depth of g / (1 ± share), where the share grows with g and with the extent of the side with more pixels.
        by_share = -sign * depth / (1 + sign * share) * share
        finest = int(np.argmax(optics.focal(camera)))
        by[of_blur, EXTENT.start + finest] = by_share / camera.half_extent[finest]
        if optics.focus_distance is None:
            by[of_blur, TARGET] = (depth + by_share) / focus
    if limits.min_pixel_density is not None and not nearest:
        dense = np.prod(optics.focal(camera)) * np.maximum(height, 0.0) / limits.min_pixel_density
        of_density = far == np.cbrt(dense)
        third = np.where(of_density, far / 3, 0.0)
        by[:, POSITION] += (third / height)[:, None] * normal
        by[:, EXTENT] -= third[:, None] / camera.half_extent
    return by


def _of_arcs(surface: Surface, camera: Camera, arcs: Borders) -> np.ndarray:
    """(N, 9) area gained at the circle of the greatest incidence, which moves and grows with its foot and height."""
    gained = np.zeros((len(arcs.face), N_PARAMETERS))
    normal = surface.normals[arcs.face]
    height = _dot(normal, camera.position - surface.vertices[surface.faces[arcs.face, 0]])
    foot = camera.position - height[:, None] * normal
    outwards = np.cross(arcs.end - arcs.start, normal)  # as long as the border
    growth = _dot(outwards, (arcs.start + arcs.end) / 2 - foot) / height
    gained[:, POSITION] = outwards + growth[:, None] * normal
    return gained


def _dot(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.einsum("ni,ni->n", one, other)
