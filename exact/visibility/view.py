"""What one camera sees."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from exact.cameras import Camera
from exact.demand import Demand
from exact.requests import checked_cameras, checked_scene, refuse_unknown, scene_keywords, shows
from exact.scene import Scene
from exact.usable.limits import Limits
from exact.usable.optics import Optics
from exact.visibility import light
from exact.visibility.coverage import tally
from exact.visibility.pieces.clipping import whole_faces
from exact.visibility.pieces.triangulated import in_space, triangulated
from exact.visibility.pieces.uniting import unite
from exact.visibility.projection import image_polygons

if TYPE_CHECKING:
    import trimesh


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
    _mesh: "trimesh.Trimesh" = field(repr=False)
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
        polygons[whole] = in_space(self._mesh, whole, whole_faces(len(whole)))
        polygons[face] = in_space(self._mesh, face, piece)
        return polygons

    def to_mesh(self) -> "trimesh.Trimesh":
        """Visible part of the surface, with the face each triangle comes from as `face_attributes["parent"]`."""
        return triangulated(self._mesh, *self._parts)[0]


@shows({**scene_keywords(), "limits": Limits(), "optics": Optics()})
def view(mesh: "trimesh.Trimesh | Scene", camera: Camera, **asked: Any) -> View:
    """What `camera` sees of `mesh`, exactly.

    Parameters
    ----------
    mesh : trimesh.Trimesh or Scene
        See `evaluate` for what is seen. Faces that do not count are part of it.
    camera : Camera
    limits, optics
        What makes its views usable: see `Demand`.
    **asked
        The keywords of `Scene`.

    Returns
    -------
    View

    Examples
    --------
    >>> import trimesh
    >>> plate = trimesh.Trimesh([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> camera = Camera.look_at((0, 0, 400), target=(0, 0, 0), up=(0, 1, 0))
    >>> round(view(plate, camera).area, 9)
    100.0
    >>> view(plate, Camera.look_at((0, 0, -400), (0, 0, 0), up=(0, 1, 0))).area  # from behind
    0.0
    """
    refuse_unknown(asked, {*scene_keywords(), "limits", "optics"})
    scene = checked_scene(mesh, asked)
    demand = Demand(1, **{name: asked[name] for name in ("limits", "optics") if name in asked})
    return view_of(scene, camera, demand, lit=True)


def view_of(scene: Scene, camera: Camera, demand: Demand | None = None, lit: bool = False) -> View:
    """As `view`; whether or not it is usable and lit unless that is asked for."""
    surface, (camera,) = scene.surface, checked_cameras([camera])
    every_face = np.ones(len(surface.faces), dtype=bool)
    criterion = (Demand(1) if demand is None else demand).of([camera], surface)
    bright = light.lit(surface, scene.lights, every_face) if lit and scene.lights else None
    seen = tally(surface, [camera], criterion, every_face, workers=1, lit=bright)
    whole = seen.whole_seen[:, 0] & ~seen.is_cut
    visible = seen.pieces.seen[:, 0]
    face, first = np.unique(seen.pieces.face[visible], return_index=True)
    group = np.repeat(np.arange(len(face)), np.diff(np.append(first, visible.sum())))
    piece, _, repairs = unite(group, seen.pieces.polygon[visible])
    areas = np.where(whole, surface.areas, 0.0)
    areas[face] = 2 * surface.areas[face] * shapely.area(piece)

    polygons = np.full(len(surface.faces), shapely.Polygon(), dtype=object)
    shown = np.flatnonzero(whole)
    polygons[shown] = image_polygons(surface, camera, shown, whole_faces(len(shown)))
    polygons[face] = image_polygons(surface, camera, face, piece)
    return View(camera, areas, polygons, seen.n_repairs + repairs, scene.everything, (shown, face, piece))
