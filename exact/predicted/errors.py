"""Predicted errors over a reconstructed surface: root mean square and quantiles."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exact.predicted.bound import Predictor
from exact.predicted.moments import Moments
from exact.predicted.triangles import Triangles
from exact.visibility.pieces.clipping import whole_faces
from exact.visibility.pieces.pieces import Pieces
from exact.visibility.pieces.triangulated import triangles_in

# Pieces are divided until their points are, root mean square, nearer to their centroid than this part of the distance
# from the cameras; of those that are smaller still the centroid speaks for all, to a millionth.
FINE, TINY = 0.006, 0.0005


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
    both = (whole, pieces.face), (whole_faces(len(whole)), pieces.polygon), (whole_seen, pieces.seen)
    everything = Pieces(*(np.concatenate(parts) for parts in both))
    owner, moments, sizes = _small(predictor, everything, len(whole))
    face, is_tiny = everything.face[owner], sizes < TINY
    one, three = moments.take(is_tiny), moments.take(~is_tiny)
    inner = np.concatenate([one.centre, three.nodes.reshape(-1, 2)])
    which = np.concatenate([np.flatnonzero(is_tiny), np.repeat(np.flatnonzero(~is_tiny), 3)])
    face, share = face[which], np.concatenate([one.share, np.repeat(three.share / 3, 3)])
    area = surface.areas[face] * share if weights is None else surface.areas[face] * share * weights[face]
    total = predictor.totals(surface.points(face, inner), everything.seen[owner[which]])
    depth, normal = (predictor.deviations(error, face, total) for error in ("depth", "normal"))
    return Errors(depth, normal, area)


def _small(predictor: Predictor, pieces: Pieces, n_whole: int) -> tuple[np.ndarray, Moments, np.ndarray]:
    """Whose they are, moments and sizes of pieces and, of those that are large beside their distance, of parts.

    The first `n_whole` pieces are whole faces, which are all alike in their own coordinates.
    """
    alike = Moments.of(whole_faces(1)).take(np.zeros(n_whole, dtype=np.intp))
    moments = Moments.joined([alike, Moments.of(pieces.polygon[n_whole:])])
    size = moments.sizes(predictor, pieces.face)
    is_small = size <= FINE
    large = np.flatnonzero(~is_small)
    owner, found, sizes = [np.flatnonzero(is_small)], [moments.take(is_small)], [size[is_small]]
    piece, corner = triangles_in(pieces.polygon[large])
    triangles = Triangles(large[piece], corner)
    while len(triangles.piece):
        moments = Moments.of_triangles(triangles.corner)
        size = moments.sizes(predictor, pieces.face[triangles.piece])
        is_small = size <= FINE
        owner.append(triangles.piece[is_small])
        found.append(moments.take(is_small))
        sizes.append(size[is_small])
        triangles = triangles.take(~is_small).quartered()
    return np.concatenate(owner), Moments.joined(found), np.concatenate(sizes)
