"""Area, centroid and spread of pieces of faces: all that integrals of quadratic functions over them take."""

from dataclasses import dataclass

import numpy as np
import shapely

from exact.predicted.bound import Predictor, distance_from

# Three points of a distribution with unit covariance whose own covariance is that too.
DIRECTIONS = np.sqrt(2) * np.array([[1.0, 0.0], [-0.5, np.sqrt(0.75)], [-0.5, -np.sqrt(0.75)]])


@dataclass(frozen=True, eq=False)
class Moments:
    """Moments of pieces, in the coordinates of their faces.

    Attributes
    ----------
    share : (N,) float
        What part of its face each is.
    centre : (N, 2) float
        Centroids.
    spread : (N, 2, 2) float
        Lower triangular roots L of the covariances L Lᵀ of their points.

    Examples
    --------
    >>> found = Moments.of(np.array([shapely.box(0, 0, 0.5, 0.5)]))
    >>> found.share.tolist(), found.centre.tolist()  # half a face, since a face has an area of one half
    ([0.5], [[0.25, 0.25]])
    >>> x, y = found.nodes[0].T
    >>> bool(np.isclose(0.25 * (x * x).mean(), 0.5 * 0.5**3 / 3))  # the integral of x² over the square
    True
    """

    share: np.ndarray
    centre: np.ndarray
    spread: np.ndarray

    @classmethod
    def of(cls, polygon: np.ndarray) -> "Moments":
        """Moments of polygons and multipolygons (N,), by Green's theorem along their rings."""
        point, ring, owner, is_hole = _rings(polygon)
        box = shapely.bounds(polygon)
        middle, half = (box[:, :2] + box[:, 2:]) / 2, (box[:, 2:] - box[:, :2]) / 2
        # About the middle of its box, where little is lost to rounding even of a small piece.
        x, y = (point - middle[owner[ring]]).T
        side = np.flatnonzero(ring[1:] == ring[:-1])
        x0, y0, x1, y1, ring = x[side], y[side], x[side + 1], y[side + 1], ring[side]
        twice = x0 * y1 - x1 * y0
        terms = (
            twice / 2, (x0 + x1) * twice / 6, (y0 + y1) * twice / 6,
            (x0 * x0 + x0 * x1 + x1 * x1) * twice / 12, (y0 * y0 + y0 * y1 + y1 * y1) * twice / 12,
            (x0 * y1 + 2 * (x0 * y0 + x1 * y1) + x1 * y0) * twice / 24,
        )  # fmt: skip
        of_rings = np.stack([np.bincount(ring, term, len(owner)) for term in terms], dtype=np.float64)
        of_rings *= np.where((of_rings[0] < 0) == is_hole, 1.0, -1.0)
        area, *others = (np.bincount(owner, term, len(polygon)).astype(np.float64) for term in of_rings)
        x, y, xx, yy, xy = (np.divide(other, area, out=np.zeros_like(area), where=area > 0) for other in others)
        # Of a piece whose area is rounding, its points still lie in its box.
        centre = np.clip(np.stack([x, y], axis=1), -half, half)
        x, y = centre.T
        return cls(2 * area, middle + centre, _root(xx - x * x, xy - x * y, yy - y * y, half))

    @classmethod
    def of_triangles(cls, corner: np.ndarray) -> "Moments":
        """Moments of triangles (N, 3, 2)."""
        one, two = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
        centre = corner.mean(axis=1)
        x, y = np.moveaxis(corner - centre[:, None], 2, 0)
        xx, xy, yy = ((one * two).sum(axis=1) / 12 for one, two in ((x, x), (x, y), (y, y)))
        share = np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
        return cls(share, centre, _root(xx, xy, yy, np.ptp(corner, axis=1)))

    @staticmethod
    def joined(parts: "list[Moments]") -> "Moments":
        """All of several sets."""
        return Moments(
            np.concatenate([part.share for part in parts]),
            np.concatenate([part.centre for part in parts]),
            np.concatenate([part.spread for part in parts]),
        )

    def take(self, chosen: np.ndarray) -> "Moments":
        """The chosen ones, by mask or index."""
        return Moments(self.share[chosen], self.centre[chosen], self.spread[chosen])

    @property
    def nodes(self) -> np.ndarray:
        """(N, 3, 2) points, each with a third of the area, that integrate quadratic functions exactly."""
        return self.centre[:, None] + np.einsum("nij,kj->nki", self.spread, DIRECTIONS)

    def sizes(self, predictor: Predictor, face: np.ndarray) -> np.ndarray:
        """(N,) distance of points from the centroid, root mean square, beside that of the nearest camera."""
        surface = predictor.surface
        corner, first, second = (surface.vertices[column] for column in surface.faces[face].T)
        first, second = first - corner, second - corner
        along = self.spread[:, 0, :1] * first + self.spread[:, 1, :1] * second
        across = self.spread[:, 1, 1:] * second
        radius = np.sqrt(np.einsum("nk,nk->n", along, along) + np.einsum("nk,nk->n", across, across))
        return radius / distance_from(predictor.cameras, surface.points(face, self.centre))


def _rings(polygon: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Points (P, 2) of the rings of polygons and multipolygons, whose ring (P,), of which (R,), and if a hole (R,).

    Most are simple, of which no copies are made to get at their rings.
    """
    is_simple = (shapely.get_type_id(polygon) == shapely.GeometryType.POLYGON) & (
        shapely.get_num_interior_rings(polygon) == 0
    )
    simple, other = np.flatnonzero(is_simple), np.flatnonzero(~is_simple)
    point, ring = shapely.get_coordinates(polygon[simple], return_index=True)
    parts, piece = shapely.get_parts(polygon[other], return_index=True)
    rings, part = shapely.get_rings(parts, return_index=True)
    more_points, more = shapely.get_coordinates(rings, return_index=True)
    is_hole = np.zeros(len(rings), dtype=bool)
    is_hole[1:] = part[1:] == part[:-1]
    return (
        np.concatenate([point, more_points]),
        np.concatenate([ring, more + len(simple)]),
        np.concatenate([simple, other[piece[part]]]),
        np.concatenate([np.zeros(len(simple), dtype=bool), is_hole]),
    )


def _root(xx: np.ndarray, xy: np.ndarray, yy: np.ndarray, largest: np.ndarray) -> np.ndarray:
    """(N, 2, 2) lower triangular roots of covariances, with no deviation above `largest` (N, 2), whatever rounding."""
    root = np.zeros((len(xx), 2, 2))
    root[:, 0, 0] = np.sqrt(np.clip(xx, 0.0, largest[:, 0] ** 2))
    across = np.divide(xy, root[:, 0, 0], out=np.zeros_like(xy), where=root[:, 0, 0] > 0)
    root[:, 1, 0] = np.clip(across, -largest[:, 1], largest[:, 1])
    root[:, 1, 1] = np.sqrt(np.clip(yy - root[:, 1, 0] ** 2, 0.0, largest[:, 1] ** 2))
    return root
