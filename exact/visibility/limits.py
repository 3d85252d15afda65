"""Where one camera's views are usable: which faces whole, which not at all, and along which segments the rest is cut.

On a face, depth is an affine function of the place and the angle of incidence grows with the distance from the foot of
the perpendicular from the camera: borders are straight lines and circles.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from exact.usable.limits import Limits
from exact.usable.optics import Optics
from exact.visibility.projection import UNIT_FRAME, Image, lone_corner_first
from exact.visibility.screen import barycentric
from exact.visibility.silhouettes import FARTHEST, MARGIN, NEAREST, STEEPEST, Cuts

# An arc is cut along chords of at most this angle [rad], and along at least so many. They are moved outwards so far
# that they bound the area of the arc; only at its two ends, over less than a chord, a difference remains.
CHORD_ANGLE, LEAST_CHORDS = np.radians(1.0), 8


@dataclass(frozen=True, eq=False)
class Usable:
    """What the limits leave of the views of one camera.

    Attributes
    ----------
    image : Image
    limits : Limits
    optics : Optics
    """

    image: Image
    limits: Limits
    optics: Optics

    @cached_property
    def _height(self) -> np.ndarray:
        """(F,) height of the camera above the plane of each face [mm]."""
        surface, position = self.image.surface, self.image.camera.position
        corner = surface.vertices[surface.faces[:, 0]]
        return np.einsum("fi,fi->f", surface.normals, position - corner)

    def sees(self, face: np.ndarray, inner: np.ndarray) -> np.ndarray:
        """(N,) whether views of points given by face and face coordinates (N, 2) are usable."""
        surface = self.image.surface
        points = surface.points(face, inner)
        return self.limits.met(points, surface.normals[face], self.image.camera, self.optics)

    def whole_or_cuts(self, face: np.ndarray) -> tuple[np.ndarray, np.ndarray, Cuts]:
        """Of the faces (N,): which are usable all over, (N,) bool, which in part, (N,) bool, and what cuts those."""
        lines, inside, outside = self._depths(face)
        arcs = Cuts.none()
        if self.limits.max_incidence is not None:
            arcs, within, beyond = self._incidence(face[~outside], self.limits.max_incidence)
            some = ~outside
            inside[some] &= within
            outside[some] |= beyond
        part = ~inside & ~outside
        chosen = np.zeros(len(self.image.front), dtype=bool)
        chosen[face[part]] = True
        return inside, part, Cuts.joined([lines.of_faces(chosen), arcs.of_faces(chosen)])

    def _depths(self, face: np.ndarray):
        """Lines of least and greatest depth; faces all within, and all outside."""
        surface, camera = self.image.surface, self.image.camera
        corner = surface.vertices[surface.faces[face]]
        depth = (corner - camera.position) @ camera.rotation[2]
        near, far = self.limits.depths(camera, self.optics, self._height[face])
        low, high = depth.min(axis=1), depth.max(axis=1)
        parts = []
        for border, source in ((np.full(len(face), near), NEAREST), (far, FARTHEST)):
            crossed = np.flatnonzero((low < border) & (border < high))
            start, end = _level(depth[crossed] - border[crossed, None])
            parts.append(Cuts.alike(face[crossed], start, end, source))
        return Cuts.joined(parts), (low >= near) & (high <= far), (high < near) | (low > far)

    def _incidence(self, face: np.ndarray, largest: float):
        """Arcs of the greatest angle of incidence; faces all within it, and all outside."""
        surface, position = self.image.surface, self.image.camera.position
        corner = surface.vertices[surface.faces[face]]
        height = self._height[face]
        foot = position - height[:, None] * surface.normals[face]
        radius = height * np.tan(largest)
        # Coordinates in the plane, with the foot as the origin.
        first = corner[:, 1] - corner[:, 0]
        first = first / np.linalg.norm(first, axis=1, keepdims=True)
        second = np.cross(surface.normals[face], first)
        flat = np.stack([np.einsum("fki,fi->fk", corner - foot[:, None], along) for along in (first, second)], axis=2)
        within = (np.hypot(flat[:, :, 0], flat[:, :, 1]) <= radius[:, None]).all(axis=1)
        nearest = _distance_to(flat)
        beyond = nearest > radius
        parts = [Cuts.none()]
        for i in np.flatnonzero(~within & ~beyond):
            start, end = _arcs(flat[i], radius[i])
            parts.append(Cuts.alike(np.full(len(start), face[i]), start, end, STEEPEST))
        return Cuts.joined(parts), within, beyond


def _level(value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Segments where affine functions with these values at the corners, (N, 3) of both signs, are 0: ends (N, 2)."""
    turn, _ = lone_corner_first(value > 0)
    value = np.take_along_axis(value, turn, axis=1)
    corner = UNIT_FRAME[turn]
    t = value[:, :1] / (value[:, :1] - value[:, 1:])
    ends = corner[:, :1] + t[:, :, None] * (corner[:, 1:] - corner[:, :1])
    along = ends[:, 1] - ends[:, 0]
    return ends[:, 0] - MARGIN * along, ends[:, 1] + MARGIN * along


def _distance_to(flat: np.ndarray) -> np.ndarray:
    """(N,) distance of the origin from triangles (N, 3, 2) in the plane; 0 inside."""
    side = np.roll(flat, -1, axis=1) - flat
    length_squared = np.maximum((side**2).sum(axis=2), 1e-300)
    t = np.clip(-(flat * side).sum(axis=2) / length_squared, 0.0, 1.0)
    nearest = flat + t[:, :, None] * side
    inside = (barycentric(flat[:, :, 0], flat[:, :, 1], np.zeros(1), np.zeros(1)) >= 0).all(axis=1)
    return np.where(inside, 0.0, np.hypot(nearest[:, :, 0], nearest[:, :, 1]).min(axis=1))


def _arcs(flat: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Chords of the circle about the origin over a triangle (3, 2): ends (C, 2) in the triangle's own coordinates."""
    side = np.roll(flat, -1, axis=0) - flat
    a, b, c = (side**2).sum(axis=1), (flat * side).sum(axis=1), (flat**2).sum(axis=1) - radius**2
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    t = np.stack([(-b - root) / a, (-b + root) / a], axis=1)
    hit = (t >= 0) & (t <= 1) & (b * b >= a * c)[:, None]
    points = (flat[:, None] + t[:, :, None] * side[:, None])[hit]
    angles = np.unique(np.arctan2(points[:, 1], points[:, 0]))
    bounds = np.append(angles, angles[:1] + 2 * np.pi) if len(angles) else np.array([0.0, 2 * np.pi])
    starts, ends = [], []
    inverse = np.linalg.inv(np.stack([flat[1] - flat[0], flat[2] - flat[0]], axis=1))
    for low, high in zip(bounds[:-1], bounds[1:], strict=True):
        middle = inverse @ (radius * np.array([np.cos((low + high) / 2), np.sin((low + high) / 2)]) - flat[0])
        if not (middle.min() >= 0 and middle.sum() <= 1):
            continue
        n_chords = max(LEAST_CHORDS, int(np.ceil((high - low) / CHORD_ANGLE)))
        step = (high - low) / n_chords
        along = low + step * np.arange(n_chords + 1)
        if len(angles):  # moved outwards, a chord need not reach the side of the face where the arc does
            along = np.concatenate([[low - step], along, [high + step]])
        outer = radius * np.sqrt(step / np.sin(step))
        points = (np.stack([np.cos(along), np.sin(along)], axis=1) * outer - flat[0]) @ inverse.T
        if not len(angles):
            points[-1] = points[0]
        starts.append(points[:-1])
        ends.append(points[1:])
    if not starts:
        return np.zeros((0, 2)), np.zeros((0, 2))
    return np.concatenate(starts), np.concatenate(ends)
