"""Predicted errors over a reconstructed surface: root mean square and quantiles."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exact.predicted.bound import Predictor, sizes
from exact.predicted.triangles import Triangles
from exact.visibility.coverage import Pieces
from exact.visibility.projection import UNIT_FRAME
from exact.visibility.triangulated import triangles_in

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
    face, seen = np.concatenate([whole, pieces.face]), np.concatenate([whole_seen, pieces.seen])
    piece, corner = triangles_in(pieces.polygon)
    unit = np.broadcast_to(UNIT_FRAME, (len(whole), 3, 2))
    piece = np.concatenate([np.arange(len(whole)), len(whole) + piece])
    triangles, is_tiny = _small(predictor, face, Triangles(piece, np.concatenate([unit, corner])))
    tiny, others = triangles.take(is_tiny), triangles.take(~is_tiny)
    nodes = np.einsum("nk,tki->tni", NODES, others.corner).reshape(-1, 2)
    inner = np.concatenate([tiny.corner.mean(axis=1), nodes])
    piece = np.concatenate([tiny.piece, np.repeat(others.piece, 3)])
    face, seen = face[piece], seen[piece]
    shares = np.concatenate([_shares(tiny.corner), np.repeat(_shares(others.corner) / 3, 3)])
    area = surface.areas[face] * shares if weights is None else surface.areas[face] * shares * weights[face]
    total = predictor.totals(surface.points(face, inner), seen)
    depth, normal = (predictor.deviations(error, face, total) for error in ("depth", "normal"))
    return Errors(depth, normal, area)


def _shares(corner: np.ndarray) -> np.ndarray:
    """(N,) what part of their faces triangles (N, 3, 2) are."""
    one, two = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    return np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])


def _small(predictor: Predictor, face: np.ndarray, triangles: Triangles) -> tuple[Triangles, np.ndarray]:
    """The same triangles, quartered until they are small beside their distance from the cameras, and which are tiny."""
    done, is_tiny = [], []
    while True:
        _, size = sizes(predictor.cameras, triangles.points(predictor.surface, face))
        is_small = size <= FINE
        done.append(triangles.take(is_small))
        is_tiny.append(size[is_small] < TINY)
        if is_small.all():
            break
        triangles = triangles.take(~is_small).quartered()
    piece, corner = (np.concatenate([getattr(part, name) for part in done]) for name in ("piece", "corner"))
    return Triangles(piece, corner), np.concatenate(is_tiny)
