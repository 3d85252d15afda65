"""Triangles that pieces of faces are divided into, to look at errors in each."""

from dataclasses import dataclass

import numpy as np
import shapely

from exact.visibility.surface import Surface


@dataclass(frozen=True, eq=False)
class Triangles:
    """Triangles in the coordinates of their faces: which piece each is from, (N,), and its corners, (N, 3, 2)."""

    piece: np.ndarray
    corner: np.ndarray

    def take(self, chosen: np.ndarray) -> "Triangles":
        """The chosen ones, by mask or index."""
        return Triangles(self.piece[chosen], self.corner[chosen])

    def quartered(self) -> "Triangles":
        """Four of each, between its corners and the middles of its sides."""
        a, b, c = self.corner.transpose(1, 0, 2)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        return Triangles(np.tile(self.piece, 4), np.concatenate([np.stack(part, axis=1) for part in parts]))

    @property
    def polygons(self) -> np.ndarray:
        """(N,) polygons."""
        return np.asarray(shapely.polygons(np.concatenate([self.corner, self.corner[:, :1]], axis=1)))

    def points(self, surface: Surface, face: np.ndarray) -> np.ndarray:
        """(N, 3, 3) their corners in space [mm], where `face` are the faces of all pieces."""
        return surface.points(np.repeat(face[self.piece], 3), self.corner.reshape(-1, 2)).reshape(-1, 3, 3)
