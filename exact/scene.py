"""On what: a mesh, what of it counts, what hides and lights it, checked once and prepared for many cameras."""

import hashlib
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from exact.cameras import finite_vector
from exact.errors import ExactError
from exact.visibility.coverage import Tally
from exact.visibility.light import lit
from exact.visibility.surface import Surface, prepare

if TYPE_CHECKING:
    import trimesh

# What was prepared of a mesh, for the next request about the same one. A mesh that was changed has another hash, and is
# not found again.
_PREPARED: "WeakKeyDictionary[trimesh.Trimesh, Surface]" = WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class Scene:
    """A surface and what of it counts, ready for any cameras.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        The surface [mm]: closed or open, in one or several shells, which may intersect each other and themselves.
    exclude : (F,) ndarray of bool, optional
        Faces that are not counted, such as `meshes.top_surface(mesh)`. They hide what is behind them all the same.
    weights : (F,) ndarray of float, optional
        Factor by which the area of each face counts, at least 0.
    obstacles : sequence of trimesh.Trimesh, optional
        Meshes that hide what is behind them and never count, such as instruments [mm].
    lights : sequence of (3,) array_like, optional
        Points from which light comes [mm]: what none of them shines on is not reconstructed. By default all is lit.

    Attributes
    ----------
    everything : trimesh.Trimesh
        The mesh and, after its faces, those of the obstacles.

    Raises
    ------
    ExactError
        If an array does not fit, or `mesh` is not a triangle mesh with finite vertices and at least one face with
        area, has two neighbouring faces of opposite winding, or is closed and inside out.

    Examples
    --------
    >>> import trimesh
    >>> box = trimesh.creation.box((10, 10, 10))
    >>> scene = Scene(box, exclude=box.face_normals[:, 2] < 0.5)
    >>> float(scene.surface.areas[scene.counted].sum())
    100.0
    """

    mesh: "trimesh.Trimesh"
    exclude: np.ndarray | None = None
    weights: np.ndarray | None = None
    obstacles: "tuple[trimesh.Trimesh, ...]" = ()
    lights: tuple[tuple[float, float, float], ...] = ()
    everything: "trimesh.Trimesh" = field(init=False, repr=False)
    surface: Surface = field(init=False, repr=False)
    counted: np.ndarray = field(init=False, repr=False)

    def __post_init__(self):
        import trimesh

        if not isinstance(self.mesh, trimesh.Trimesh):
            raise ExactError(f"mesh is a {type(self.mesh).__name__}; a trimesh.Trimesh is needed: see meshes.load")
        exclude = _mask(self.exclude, len(self.mesh.faces))
        weights = _weights(self.weights, len(self.mesh.faces))
        obstacles = _obstacles(self.obstacles)
        everything = self.mesh
        if obstacles:
            _surface(self.mesh)  # so that what is wrong with it is not said of all
            everything = _together([self.mesh, *map(_outside_out, obstacles)])
        more = len(everything.faces) - len(exclude)
        for name, value in (
            ("obstacles", obstacles),
            ("lights", _lights(self.lights)),
            ("everything", everything),
            ("surface", _surface(everything)),
            ("counted", np.append(~exclude, np.zeros(more, dtype=bool))),
            ("exclude", exclude),
            ("weights", None if weights is None else np.append(weights, np.zeros(more))),
        ):
            if isinstance(value, np.ndarray):
                value.flags.writeable = False
            object.__setattr__(self, name, value)

    @property
    def is_weighted(self) -> bool:
        """Whether faces count with weights of their own."""
        return self.weights is not None

    @cached_property
    def mesh_hash(self) -> str:
        """Fingerprint of the mesh (`meshes.fingerprint`)."""
        from meshes import fingerprint

        return fingerprint(self.mesh)

    @cached_property
    def content_hash(self) -> str:
        """SHA-256 of all that an area depends on beside cameras and demand, in hexadecimal."""
        content = hashlib.sha256(self.mesh_hash.encode() + self.counted.tobytes())
        content.update(b"" if self.weights is None else self.weights.tobytes())
        from meshes import fingerprint

        for obstacle in self.obstacles:
            content.update(fingerprint(obstacle).encode())
        content.update(np.array(self.lights).tobytes())
        return content.hexdigest()

    @cached_property
    def lit(self) -> Tally | None:
        """Which part of which face that counts is lit; None where all is."""
        return lit(self.surface, self.lights, self.counted) if self.lights else None

    @property
    def n_faces(self) -> int:
        """Faces of the mesh, without those of obstacles."""
        return len(self.exclude)  # pyright: ignore[reportArgumentType] # set, whatever was given

    def of_mesh(self, by_face: np.ndarray) -> np.ndarray:
        """The entries, (..., F) of all faces, of those of the mesh alone."""
        return by_face[..., : self.n_faces]

    def worth(self, face_areas: np.ndarray) -> np.ndarray:
        """What areas of faces, (..., F) [mm²], count together, weighted if weights were given: (...,) [mm²]."""
        if self.weights is None:
            return face_areas.sum(axis=-1)
        return face_areas @ self.weights[: face_areas.shape[-1]]

    def without_mesh(self) -> "Scene":
        """The same for another process, which takes only what was prepared."""
        _ = self.lit  # found once, not by every worker
        bare = object.__new__(Scene)
        vars(bare).update(vars(self) | {"mesh": None, "everything": None, "obstacles": ()})
        return bare


def forget() -> None:
    """Drop what was prepared of all meshes, as a benchmark needs it."""
    _PREPARED.clear()


def _surface(mesh: "trimesh.Trimesh") -> Surface:
    surface = _PREPARED.get(mesh)
    if surface is None:
        surface = _PREPARED[mesh] = prepare(mesh)
    return surface


def _obstacles(obstacles) -> "tuple[trimesh.Trimesh, ...]":
    """Obstacles, each of which is fit to be one."""
    import trimesh

    found = (obstacles,) if isinstance(obstacles, trimesh.Trimesh) else tuple(obstacles)
    for number, obstacle in enumerate(found, start=1):
        if not isinstance(obstacle, trimesh.Trimesh):
            raise ExactError(f"obstacle {number} is a {type(obstacle).__name__}; a trimesh.Trimesh is needed")
        try:
            _surface(_outside_out(obstacle))
        except ExactError as error:
            raise ExactError(f"obstacle {number}: {error}") from error
    return found


def _together(meshes: "list[trimesh.Trimesh]") -> "trimesh.Trimesh":
    """One mesh of the faces of several, in their order."""
    import trimesh

    first = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, first, strict=False)])
    return trimesh.Trimesh(np.concatenate([mesh.vertices for mesh in meshes]), faces, process=False)


def _bare(mesh: "trimesh.Trimesh") -> "trimesh.Trimesh":
    """Its vertices and faces alone."""
    import trimesh

    return trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)


def _outside_out(mesh: "trimesh.Trimesh") -> "trimesh.Trimesh":
    """A closed mesh with its normals outwards: either way it hides the same."""
    bare = _bare(mesh)
    if bare.is_watertight and bare.volume < 0:
        bare.invert()
    return bare


def _lights(lights) -> tuple[tuple[float, float, float], ...]:
    found = []
    for number, light in enumerate(lights, start=1):
        found.append(tuple(finite_vector(f"light {number}", light, 3).tolist()))
    return tuple(found)


def _mask(exclude, n_faces: int) -> np.ndarray:
    """(F,) bool: `exclude`, or nothing for None; a copy."""
    if exclude is None:
        return np.zeros(n_faces, dtype=bool)
    mask = np.array(exclude)
    if mask.dtype != bool or mask.shape != (n_faces,):
        raise ExactError(
            f"exclude is an array of {mask.dtype} with shape {mask.shape}; it must be bool with one entry for each of "
            f"the {n_faces} faces"
        )
    return mask


def _weights(weights, n_faces: int) -> np.ndarray | None:
    """(F,) float: `weights`, or None; a copy."""
    if weights is None:
        return None
    values = np.array(weights, dtype=np.float64)
    if values.shape != (n_faces,) or not np.isfinite(values).all() or (values < 0).any():
        raise ExactError(
            f"weights has shape {values.shape}; it must be finite, not negative, one for each of the {n_faces} faces"
        )
    return values
