"""Predicted errors over a reconstructed surface: root mean square and quantiles."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exact.predicted.bound import Predictor, nearest
from exact.predicted.contour import triangulate
from exact.usable.information import variance
from exact.visibility.coverage import Pieces

# Triangles are quartered until they are smaller than this beside their distance from the cameras; of those that are
# smaller still their centre speaks for all, to a millionth.
FINE, TINY = 0.004, 0.0015
# Points of a triangle that integrate quadratic functions exactly, each with a third of its area.
NODES = np.array([[2 / 3, 1 / 6, 1 / 6], [1 / 6, 2 / 3, 1 / 6], [1 / 6, 1 / 6, 2 / 3]])


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors at the nodes of a quadrature over what is reconstructed.

    Attributes
    ----------
    depth, normal : (N,) float
        Standard deviation along the depth axis and along the surface's normal [mm].
    weights : (N,) float
        Area each node stands for [mm²], weighted if weights were given.

    Examples
    --------
    >>> found = Errors(np.array([0.1, 0.7]), np.array([0.1, 0.1]), np.array([3.0, 1.0]))
    >>> round(found.rms(), 6), found.quantiles([0.5, 0.9])
    (0.360555, (0.1, 0.7))
    """

    depth: np.ndarray
    normal: np.ndarray
    weights: np.ndarray

    def rms(self, error: str = "depth") -> float:
        """Root of the mean square over the area [mm]; nan where nothing is reconstructed."""
        if not self.weights.sum() > 0:
            return float("nan")
        return float(np.sqrt(np.average(getattr(self, error) ** 2, weights=self.weights)))

    def quantiles(self, shares: Sequence[float] = (0.05, 0.5, 0.95), error: str = "depth") -> tuple[float, ...]:
        """Errors [mm] that these shares of the area do not exceed; nan where nothing is reconstructed."""
        if not self.weights.sum() > 0:
            return (float("nan"),) * len(shares)
        values = np.quantile(getattr(self, error), list(shares), weights=self.weights, method="inverted_cdf")
        return tuple(values.tolist())


def errors_over(predictor: Predictor, whole: np.ndarray, whole_seen: np.ndarray, pieces: Pieces, weights) -> Errors:
    """Errors over the faces `whole` (W,), seen by `whole_seen` (W, M), and over pieces; `weights` (F,) or None."""
    surface = predictor.surface
    cut = triangulate(pieces.polygon)
    face = np.concatenate([whole, pieces.face[cut.piece]])
    seen = np.concatenate([whole_seen, pieces.seen[cut.piece]])
    unit = np.array([[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]])
    corner = np.concatenate([np.repeat(unit, len(whole), axis=0), cut.corner])
    face, seen, corner, is_tiny = _small(predictor, face, seen, corner)
    sides = corner[:, 1:] - corner[:, :1]
    area = surface.areas[face] * np.abs(sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0])
    area = area if weights is None else area * weights[face]
    nodes = np.einsum("nk,tki->tni", NODES, corner[~is_tiny]).reshape(-1, 2)
    inner = np.concatenate([corner[is_tiny].mean(axis=1), nodes])
    face, seen, area = (
        np.concatenate([values[is_tiny], np.repeat(values[~is_tiny], 3, axis=0)]) for values in (face, seen, area)
    )
    area[is_tiny.sum() :] /= 3
    total = predictor.totals(surface.points(face, inner), seen)
    depth, normal = (
        np.sqrt(np.maximum(variance(total, predictor.directions(error, face)), 0.0)) for error in ("depth", "normal")
    )
    return Errors(depth, normal, area)


def _small(predictor: Predictor, face: np.ndarray, seen: np.ndarray, corner: np.ndarray):
    """The same triangles, quartered until they are small beside their distance from the cameras, and which are tiny."""
    surface, done = predictor.surface, []
    while len(face):
        at = surface.points(np.repeat(face, 3), corner.reshape(-1, 2)).reshape(-1, 3, 3)
        centre = at.mean(axis=1)
        size = np.linalg.norm(at - centre[:, None], axis=2).max(axis=1) / nearest(predictor.cameras, centre)
        far = size > FINE
        done.append((face[~far], seen[~far], corner[~far], size[~far] < TINY))
        a, b, c = corner[far].transpose(1, 0, 2)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        corner = np.concatenate([np.stack(part, axis=1) for part in parts])
        face, seen = np.tile(face[far], 4), np.tile(seen[far], (4, 1))
    if not done:
        return face, seen, corner, np.zeros(0, dtype=bool)
    return tuple(np.concatenate(part) for part in zip(*done, strict=True))
