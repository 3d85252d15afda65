"""What came out: the reconstructable part of a surface."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import trimesh

from exact.cameras import Camera
from exact.demand import Demand
from exact.scene import Scene
from exact.visibility.coverage import Tally
from exact.visibility.triangulated import triangulated
from meshes import file_faces

if TYPE_CHECKING:  # drawing alone needs matplotlib
    from matplotlib.axes import Axes


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
        """Reconstructable part of the surface as a mesh.

        `face_attributes["parent"]` is the face of each triangle, `face_attributes["file_face"]` that of the mesh's file
        (`meshes.file_faces`).

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
        found = triangulated(scene.mesh, np.flatnonzero(whole), shown.face, shown.polygon)[0]
        found.face_attributes["file_face"] = file_faces(scene.mesh)[0][found.face_attributes["parent"]]
        return found
