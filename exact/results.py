"""What came out: the view of one camera, and the reconstructable part of a surface."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import shapely
import trimesh

from exact.cameras import Camera
from exact.demand import Demand
from exact.scene import Scene
from exact.visibility.clipping import whole_faces
from exact.visibility.coverage import Tally

if TYPE_CHECKING:  # drawing alone needs matplotlib
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False)
class View:
    """What one camera sees, from `exact.view`.

    Attributes
    ----------
    camera : Camera
    face_areas : (F,) float
        Visible area of each face, measured on the face itself [mm²].
    polygons : (F,) object
        Visible region of each face in the image plane at the target [mm right, mm down of the optical axis]:
        a shapely Polygon or MultiPolygon, empty where nothing is seen.
    repairs : int
        How often rounding made a step fail its own check so that it was done again in a robust way.
    """

    camera: Camera
    face_areas: np.ndarray
    polygons: np.ndarray
    repairs: int
    _mesh: trimesh.Trimesh = field(repr=False)
    _parts: tuple = field(repr=False)

    @property
    def area(self) -> float:
        """Visible area [mm²]; 0.0 if the camera sees nothing."""
        return float(self.face_areas.sum())

    @property
    def polygons_3d(self) -> np.ndarray:
        """(F,) visible region of each face in space [mm]: shapely polygons with z, empty where nothing is seen."""
        whole, face, piece = self._parts
        polygons = np.full(len(self.face_areas), shapely.Polygon(), dtype=object)
        polygons[whole] = _in_space(self._mesh, whole, whole_faces(len(whole)))
        polygons[face] = _in_space(self._mesh, face, piece)
        return polygons

    def to_mesh(self) -> trimesh.Trimesh:
        """Visible part of the surface, with the face each triangle comes from as `face_attributes["parent"]`."""
        return triangulated(self._mesh, *self._parts)[0]


@dataclass(frozen=True, eq=False)
class Reconstruction:
    """What at least `threshold` cameras see, from `exact.evaluate`.

    Attributes
    ----------
    scene : Scene
        The surface and what of it counts.
    demand : Demand
        What makes a point count.
    face_areas : (F,) float
        Reconstructable area of each face [mm²], 0 for excluded faces.
    level_face_areas : (threshold, F) float
        Area of each face seen by at least 1, 2, .. `threshold` cameras [mm²].
    repairs : int
        How often rounding made a step fail its own check so that it was done again in a robust way, and on how many
        faces pieces overlapped so that their sum was cut short.
    """

    scene: Scene = field(repr=False)
    demand: Demand
    face_areas: np.ndarray
    level_face_areas: np.ndarray
    repairs: int
    _cameras: tuple[Camera, ...] = field(repr=False)
    _tally: Tally = field(repr=False)
    _whole_met: np.ndarray = field(repr=False)
    _piece_met: np.ndarray = field(repr=False)

    @property
    def threshold(self) -> int:
        """How many cameras must see a point."""
        return self.demand.threshold

    @property
    def min_baseline(self) -> float:
        """Least distance between some two of the cameras that see a point [mm]."""
        return self.demand.min_baseline

    @property
    def weights(self) -> np.ndarray | None:
        """(F,) factor by which each face's area counts in `area` and `level_areas`; None counts each fully."""
        return self.scene.weights

    @property
    def area(self) -> float:
        """Reconstructable area [mm²], weighted if weights were given; 0.0 if there is none."""
        return float(self.scene.worth(self.face_areas))

    @property
    def level_areas(self) -> np.ndarray:
        """(threshold,) area seen by at least 1, 2, .. `threshold` cameras [mm²], weighted like `area`."""
        return self.scene.worth(self.level_face_areas)

    @property
    def words(self) -> str:
        """What `area` is the area of: "seen by at least 2 cameras", with baseline and weights where there are any."""
        return self.demand.words + (", faces weighted" if self.scene.is_weighted else "")

    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """Draw it from the cameras' side, coloured by the number of views; into `ax`, or axes of its own."""
        from exact import show

        return show.plot(self, ax)

    def _repr_html_(self) -> str:
        from exact import show

        return show.html(self)

    def to_mesh(self, level: int | None = None) -> trimesh.Trimesh:
        """Reconstructable part of the surface as a mesh; `face_attributes["parent"]` is the face of each triangle.

        Parameters
        ----------
        level : int, optional
            Give instead the part seen by exactly `level` cameras, 0 to `threshold`, where `threshold` stands for
            that many or more.

        Returns
        -------
        trimesh.Trimesh
            Open, oriented like the input; without faces if there is nothing to show.
        """
        scene, tally = self.scene, self._tally
        if level is None:
            whole, pieces = self._whole_met, self._piece_met
        else:
            whole = np.minimum(tally.whole_seen.sum(axis=1), self.threshold) == level
            whole &= scene.counted & ~tally.is_cut & (scene.surface.areas > 0)
            pieces = np.minimum(tally.pieces.seen.sum(axis=1), self.threshold) == level
        shown = tally.pieces.take(pieces)
        return triangulated(scene.mesh, np.flatnonzero(whole), shown.face, shown.polygon)[0]


def triangulated(
    mesh: trimesh.Trimesh, whole: np.ndarray, piece_face: np.ndarray, piece: np.ndarray
) -> tuple[trimesh.Trimesh, np.ndarray]:
    """The faces `whole` and the pieces, given in the coordinates of their faces, as one mesh.

    Also, for each of the triangles that follow the whole faces, which piece it is from.
    """
    polygons, owner = shapely.get_parts(piece, return_index=True)
    collections = shapely.constrained_delaunay_triangles(polygons) if len(polygons) else polygons
    triangles, polygon = shapely.get_parts(collections, return_index=True)
    piece_of = owner[polygon]
    parent = piece_face[piece_of]
    inner = shapely.get_coordinates(triangles).reshape(-1, 4, 2)[:, :3]
    turned = np.cross(_as_3d(inner[:, 1] - inner[:, 0]), _as_3d(inner[:, 2] - inner[:, 0]))[:, 2] < 0
    inner[turned] = inner[turned, ::-1]
    corner = np.asarray(mesh.triangles)[parent]
    one, two = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    points = corner[:, None, 0] + inner[:, :, :1] * one[:, None] + inner[:, :, 1:] * two[:, None]
    used, faces = np.unique(mesh.faces[whole], return_inverse=True)
    vertices = np.concatenate([np.asarray(mesh.vertices)[used], points.reshape(-1, 3)])
    faces = np.concatenate([faces.reshape(-1, 3), len(used) + np.arange(3 * len(points)).reshape(-1, 3)])
    result = trimesh.Trimesh(vertices, faces, process=False)
    result.face_attributes["parent"] = np.concatenate([whole, parent])
    return result, piece_of


def _in_space(mesh, face: np.ndarray, polygon: np.ndarray) -> np.ndarray:
    """Polygons in the coordinates of their faces as polygons with x, y and z."""
    inner, index = shapely.get_coordinates(polygon, return_index=True)
    corner = np.asarray(mesh.triangles)[face[index]]
    points = corner[:, 0] + inner[:, :1] * (corner[:, 1] - corner[:, 0]) + inner[:, 1:] * (corner[:, 2] - corner[:, 0])
    return np.asarray(shapely.set_coordinates(np.array(shapely.force_3d(polygon), dtype=object), points))


def _as_3d(flat: np.ndarray) -> np.ndarray:
    return np.concatenate([flat, np.zeros((*flat.shape[:-1], 1))], axis=-1)
