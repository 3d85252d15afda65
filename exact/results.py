"""What came out: the reconstructable part of a surface."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from exact.cameras import Camera
from exact.demand import Criterion, Demand, every_view
from exact.errors import ExactError
from exact.predicted.errors import Errors, errors_over
from exact.predicted.reconstructed import area_by_face, reconstructed
from exact.scene import Scene
from exact.visibility.coverage import Tally, tally
from exact.visibility.pieces.pieces import Pieces
from exact.visibility.pieces.triangulated import triangulated

if TYPE_CHECKING:  # making a mesh and drawing alone need these
    import trimesh
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
    _met: tuple[np.ndarray, Pieces] = field(repr=False)
    _has_all_views: bool = field(default=False, repr=False)

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
        weights = self.scene.weights
        return None if weights is None else self.scene.of_mesh(weights)

    @property
    def area(self) -> float:
        """Reconstructable area [mm²], weighted if weights were given; 0.0 if there is none."""
        return float(self.scene.worth(self.face_areas))

    @property
    def level_areas(self) -> np.ndarray:
        """(threshold,) area seen by at least 1, 2, .. `threshold` cameras [mm²], weighted like `area`."""
        return self.scene.worth(self.level_face_areas)

    @property
    def camera_areas(self) -> np.ndarray:
        """(M,) area that each camera sees, within the limits of the demand [mm²], weighted like `area`.

        What counts for each by itself, whatever the others see. At no cost after `evaluate(…, all_views=True)`, which
        has looked from every camera at everything; otherwise each camera looks once more.
        """
        scene, seen = self.scene, self._tally
        if self._has_all_views:
            whole, columns = ~seen.is_cut & scene.counted, zip(seen.whole_seen.T, seen.pieces.seen.T, strict=True)
            parts = [(whole & of_faces, seen.pieces.take(of_pieces)) for of_faces, of_pieces in columns]
        else:
            one = Criterion(1, limits=self.demand.limits, optics=self.demand.optics)
            asked = (one, scene.counted, 1, None, "exact", scene.lit)
            of_each = (tally(scene.surface, [camera], *asked) for camera in self._cameras)
            parts = [reconstructed(scene.surface, scene.counted, found, one) for found in of_each]
        return np.array([scene.worth(area_by_face(scene.surface, *part)) for part in parts])

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

    @cached_property
    def errors(self) -> Errors:
        """Predicted errors over the reconstructable area, from all cameras that see each point."""
        predictor = self.demand.predictor(self._cameras, self.scene.surface)
        whole, pieces = self._accurate
        index = np.flatnonzero(whole)
        return errors_over(predictor, index, self._all_views.whole_seen[index], pieces, self.scene.weights)

    @property
    def error_rms(self) -> float:
        """Root of the mean square of the predicted errors over the area [mm]; nan where there is none.

        Along depth or the normal, as `demand.error` says.
        """
        return self.errors.rms(self.demand.error)

    def error_quantiles(self, shares: Sequence[float] = (0.05, 0.5, 0.95)) -> tuple[float, ...]:
        """Predicted errors [mm] that these shares of the area do not exceed."""
        return self.errors.quantiles(shares, self.demand.error)

    def area_to(self, max_error: float) -> float:
        """Area reconstructed to a predicted error of at most `max_error` [mm²], exact to 1e-6 of it.

        Parameters
        ----------
        max_error : float
            One standard deviation, along depth or the normal as `demand.error` says [mm].

        Raises
        ------
        ExactError
            If it is not positive.
        """
        demand = replace(self.demand, max_error=max_error)
        if self.demand.max_error is not None and max_error >= self.demand.max_error:
            return self.area
        surface, criterion = self.scene.surface, demand.of(self._cameras, self.scene.surface)
        met = reconstructed(surface, self.scene.counted, self._all_views, criterion)
        return float(self.scene.worth(area_by_face(surface, *met)))

    @cached_property
    def _all_views(self) -> Tally:
        """What is reconstructed at least, cut where the set of cameras that see it changes."""
        if self._has_all_views:
            return self._tally
        surface, (whole, pieces) = self.scene.surface, self._met
        is_cut = np.zeros_like(whole)
        is_cut[pieces.face] = True
        seen = np.ones((len(pieces.face), 1), dtype=bool)
        part = Tally(whole[:, None], is_cut, Pieces(pieces.face, pieces.polygon, seen), 0)
        return tally(
            surface, self._cameras, every_view(self.demand, self._cameras), whole | is_cut, workers=1, lit=part
        )

    @cached_property
    def _accurate(self) -> tuple[np.ndarray, Pieces]:
        """As `_met`, cut where the set of cameras changes."""
        if self._has_all_views:
            return self._met
        criterion = replace(self.demand.of(self._cameras, self.scene.surface), bound=None)
        return reconstructed(self.scene.surface, self.scene.counted, self._all_views, criterion)

    def to_mesh(self, level: int | None = None, errors: bool = False) -> "trimesh.Trimesh":
        """Reconstructable part of the surface as a mesh.

        `face_attributes["parent"]` is the face of each triangle, `face_attributes["file_face"]` that of the mesh's file
        (`meshes.file_faces`).

        Parameters
        ----------
        level : int, optional
            Give instead the part seen by exactly `level` cameras, 0 to `threshold`, where `threshold` stands for
            that many or more.
        errors : bool
            Cut it where the set of cameras changes, and give the predicted errors [mm] at the centre of each triangle
            as `face_attributes["depth_error"]` and `["normal_error"]`; not together with `level`.

        Returns
        -------
        trimesh.Trimesh
            Open, oriented like the input; without faces if there is nothing to show.
        """
        scene, seen = self.scene, self._tally
        if errors:
            if level is not None:
                raise ExactError("errors are those of the reconstructable part; give either level or errors")
            return self._mesh_with_errors()
        if level is None:
            whole, shown = self._met
        else:
            whole = np.minimum(seen.whole_seen.sum(axis=1), self.threshold) == level
            whole &= scene.counted & ~seen.is_cut & (scene.surface.areas > 0)
            shown = seen.pieces.take(np.minimum(seen.pieces.seen.sum(axis=1), self.threshold) == level)
        return self._triangulated(np.flatnonzero(whole), shown)[0]

    def _triangulated(self, whole: np.ndarray, pieces: Pieces) -> "tuple[trimesh.Trimesh, np.ndarray]":
        """The faces and pieces as a mesh, and which piece each triangle after the whole faces is from."""
        from meshes import file_faces  # what reads files is heavy, and areas need none of it

        mesh, piece = triangulated(self.scene.mesh, whole, pieces.face, pieces.polygon)
        mesh.face_attributes["file_face"] = file_faces(self.scene.mesh)[0][mesh.face_attributes["parent"]]
        return mesh, piece

    def _mesh_with_errors(self) -> "trimesh.Trimesh":
        whole, pieces = self._accurate
        index = np.flatnonzero(whole)
        mesh, piece = self._triangulated(index, pieces)
        seen = np.concatenate([self._all_views.whole_seen[index], pieces.seen[piece]])
        predictor, face = self.demand.predictor(self._cameras, self.scene.surface), mesh.face_attributes["parent"]
        total = predictor.totals(np.asarray(mesh.triangles_center), seen)
        for error in ("depth", "normal"):
            mesh.face_attributes[f"{error}_error"] = predictor.deviations(error, face, total)
        return mesh
