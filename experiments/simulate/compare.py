"""The reconstruction beside the surface: how much of it came out, and how accurately."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import trimesh
from scipy.spatial import KDTree

import exact
from exact.usable.disparity import gradients
from exact.visibility.surface import Surface
from experiments.files.errors import InputError
from experiments.simulate.truth import robust

# Samples of what the cameras see, some 0.15 mm apart on a built-in site.
N_SAMPLES = 150_000
# Points of the reconstruction that are compared, drawn by lot: they tell a standard deviation to a third of a percent.
MOST_POINTS = 200_000
# Of the faces of so many samples around a point the nearest is the one it is an error of.
NEIGHBOURS = 3
# Distances within which a point of the surface counts as reconstructed [mm].
TOLERANCES = (0.1, 0.2, 0.3, 0.5)
# The one of the headline [mm].
TOLERANCE = 0.3
# Reconstructed points farther from the surface are of no place on it; greater distances are not looked into [mm].
ASTRAY = 2.0


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of what at least one camera sees of the counted surface, and what is predicted there.

    Attributes
    ----------
    points, normals : (N, 3) ndarray
        [mm]
    areas : (N,) ndarray
        What each stands for [mm²].
    faces : (N,) ndarray
    seen : (N, M) bool
        Which cameras see it, limits or no.
    incidence : (N, M) ndarray
        Angle between line of sight and normal [rad].
    density : (N, M) ndarray
        Pixels to a square millimetre of the surface.
    sigma : (N,) ndarray
        Standard deviation along the normal from all cameras that see it, with a noise of one pixel [mm]; infinite
        where fewer than two do.
    """

    points: np.ndarray
    normals: np.ndarray
    areas: np.ndarray
    faces: np.ndarray
    seen: np.ndarray
    incidence: np.ndarray
    density: np.ndarray
    sigma: np.ndarray

    @staticmethod
    def of(
        scene: exact.Scene, cameras: Sequence[exact.Camera], demand: exact.Demand, seed: int, n: int = N_SAMPLES
    ) -> "Samples":
        """Sample what is seen of a scene, cut exactly where the set of cameras that see it changes.

        Raises
        ------
        InputError
            If no camera sees anything that counts.
        """
        free = replace(
            demand, limits=exact.Limits(), max_error=None, max_disparity_gradient=None,
            optics=replace(demand.optics, match_noise=1.0),
        )  # fmt: skip
        sets = exact.view_sets(scene, cameras, demand=free)
        cut = sets.to_mesh()
        number = np.asarray(cut.face_attributes["set"])
        weight = np.where(number >= 0, cut.area_faces, 0.0)
        if not weight.any():
            raise InputError(
                "no camera sees any part of the mesh that counts; check where it lies with camring evaluate"
            )
        points, triangle = drawn(cut, n, weight, seed)
        faces = np.asarray(cut.face_attributes["parent"])[triangle]
        seen = sets.seen[number[triangle]]
        normals = np.asarray(scene.everything.face_normals)[faces]
        incidence, density = np.empty(seen.shape), np.empty(seen.shape)
        for i, camera in enumerate(cameras):
            away = camera.position - points
            height, depth = np.einsum("ni,ni->n", away, normals), -away @ camera.rotation[2]
            incidence[:, i] = np.arccos(np.clip(height / np.linalg.norm(away, axis=1), -1.0, 1.0))
            density[:, i] = np.prod(demand.optics.focal(camera)) * np.maximum(height, 0.0) / depth**3
        predictor = free.predictor(cameras, scene.surface)
        sigma = predictor.deviations("normal", faces, predictor.totals(points, seen))
        areas = np.full(len(points), float(weight.sum()) / len(points))
        return Samples(points, normals, areas, faces, seen, incidence, density, sigma)

    @property
    def n_views(self) -> np.ndarray:
        """(N,) number of cameras that see each."""
        return self.seen.sum(axis=1)

    @property
    def second_incidence(self) -> np.ndarray:
        """(N,) the second least incidence of the cameras that see it [rad]: a match takes two; infinite of fewer."""
        return _second(np.where(self.seen, self.incidence, np.inf))

    @property
    def second_density(self) -> np.ndarray:
        """(N,) the second greatest density of pixels of the cameras that see it [px/mm²]; 0 of fewer."""
        return -_second(np.where(self.seen, -self.density, 0.0))

    def gradient(
        self, surface: Surface, cameras: Sequence[exact.Camera], pairs: Sequence[tuple[int, int]]
    ) -> np.ndarray:
        """(N,) disparity gradient of each sample of a surface: the least of the pairs that see it, of those matched.

        Infinite where none does.
        """
        least = np.full(len(self.points), np.inf)
        for i, j in pairs:
            both = np.flatnonzero(self.seen[:, i] & self.seen[:, j])
            of_pair = gradients(surface, [cameras[i]], cameras[j], self.faces[both])[:, 0]
            least[both] = np.minimum(least[both], of_pair)
        return least

    def within(self, limits: exact.Limits, demand: exact.Demand, max_error: float | None, noise: float) -> np.ndarray:
        """(N,) whether cameras enough see it usably, to a normal error of at most `max_error` at a `noise` [pixels]."""
        usable = self.seen.copy()
        if limits.max_incidence is not None:
            usable &= self.incidence <= limits.max_incidence
        if limits.min_pixel_density is not None:
            usable &= self.density >= limits.min_pixel_density
        met = usable.sum(axis=1) >= demand.threshold
        return met if max_error is None else met & (noise * self.sigma <= max_error)


def _second(values: np.ndarray) -> np.ndarray:
    """(N,) the second least of each row."""
    if values.shape[1] < 2:
        return np.full(len(values), np.inf)
    return np.partition(values, 1, axis=1)[:, 1]


@dataclass(frozen=True, eq=False)
class Comparison:
    """A reconstruction beside the surface.

    Attributes
    ----------
    samples : Samples
    distance : (N,) ndarray
        From each sample to the nearest reconstructed point [mm]; infinite where none is near.
    points : (P, 3) ndarray
        Reconstructed points that belong to the counted surface [mm].
    error : (P,) ndarray
        How far each is from the surface, above it positive [mm].
    sample : (P,) ndarray
        The sample nearest to each.
    astray : float
        Share of all reconstructed points that are more than 2 mm from any surface.
    """

    samples: Samples
    distance: np.ndarray
    points: np.ndarray
    error: np.ndarray
    sample: np.ndarray
    astray: float

    def area(self, tolerance: float = TOLERANCE, chosen: np.ndarray | None = None) -> float:
        """Area [mm²] with a reconstructed point this near [mm], of all or of that of the `chosen` samples."""
        near = self.distance <= tolerance
        return float(self.samples.areas[near if chosen is None else near & chosen].sum())

    def completeness(self, tolerance: float, chosen: np.ndarray) -> float:
        """Share of the area of the `chosen` samples with a reconstructed point this near [mm]; nan of none."""
        return self.area(tolerance, chosen) / float(self.samples.areas[chosen].sum()) if chosen.any() else float("nan")

    def precision(self, tolerance: float) -> float:
        """Share of the reconstructed points that are this near to the surface [mm]; nan of none."""
        near = float((np.abs(self.error) <= tolerance).mean()) if len(self.error) else float("nan")
        return (1.0 - self.astray) * near

    def accuracy(self, chosen: np.ndarray | None = None) -> float:
        """Robust standard deviation of the points about the surface, along its normal [mm]; nan of none."""
        return robust(self.error if chosen is None else self.error[chosen[self.sample]])

    def predicted(self, noise: float, chosen: np.ndarray | None = None) -> float:
        """The median of what is predicted for the same points at this noise of matches [pixels]."""
        known = np.isfinite(self.samples.sigma[self.sample])
        known = known if chosen is None else known & chosen[self.sample]
        return float(noise * np.median(self.samples.sigma[self.sample[known]])) if known.any() else float("nan")


def compared(samples: Samples, scene: exact.Scene, points: np.ndarray, seed: int) -> Comparison:
    """Measure reconstructed points (P, 3) [mm] against the surface.

    Points that lie nearest to what does not count, such as the top surface, are left out, and those that are astray.
    """
    found = KDTree(points) if len(points) else None
    distance = np.full(len(samples.points), np.inf)
    if found is not None:
        distance = np.asarray(found.query(samples.points, distance_upper_bound=ASTRAY)[0])
    if len(points) > MOST_POINTS:
        points = points[np.sort(np.random.default_rng(seed).choice(len(points), MOST_POINTS, replace=False))]
    if found is None:
        return Comparison(samples, distance, points, np.zeros(0), np.zeros(0, dtype=np.int64), 0.0)
    everything = scene.everything
    rest = _rest(scene, len(samples.points), float(samples.areas.sum()), seed)
    around = KDTree(np.concatenate([samples.points, rest[0]]))
    faces = np.concatenate([samples.faces, rest[1]])
    near = np.asarray(around.query(points, k=NEIGHBOURS, distance_upper_bound=ASTRAY)[1])
    known = near[:, 0] < around.n
    astray = 1.0 - float(known.mean())
    points, near = points[known], near[known]
    near = np.where(near < around.n, near, near[:, :1])
    offset = np.stack([_offset(everything, faces[column], points) for column in near.T])
    best = np.argmin(np.linalg.norm(offset, axis=2), axis=0)
    number = np.arange(len(points))
    sample = near[number, best]
    counts = sample < len(samples.points)
    gap = offset[best, number]
    above = np.einsum("ni,ni->n", gap, everything.face_normals[faces[sample]])
    error = np.copysign(np.linalg.norm(gap, axis=1), above)
    return Comparison(samples, distance, points[counts], error[counts], sample[counts], astray)


def _rest(scene: exact.Scene, n_counted: int, counted_area: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Samples of what does not count, as close as those of what does, and their faces."""
    everything = scene.everything
    weight = np.where(scene.counted, 0.0, everything.area_faces)
    n = round(n_counted * float(weight.sum()) / counted_area)
    if n == 0:
        return np.zeros((0, 3)), np.zeros(0, dtype=np.int64)
    return drawn(everything, n, weight, seed)


def drawn(mesh: trimesh.Trimesh, n: int, weight: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) points of a mesh [mm], as many on each face as its weight says, and their faces."""
    points, face, *_ = trimesh.sample.sample_surface(mesh, n, face_weight=weight, seed=seed)
    return np.asarray(points), np.asarray(face)


def _offset(mesh: trimesh.Trimesh, faces: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(P, 3) from the nearest point of one face each to the points [mm]."""
    return points - trimesh.triangles.closest_point(mesh.triangles[faces], points)
