"""On what: a mesh, which of its faces count and how much, checked once and prepared for many cameras."""

import hashlib
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from exact.errors import ExactError
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
    surface: Surface = field(init=False, repr=False)
    counted: np.ndarray = field(init=False, repr=False)

    def __post_init__(self):
        import trimesh

        if not isinstance(self.mesh, trimesh.Trimesh):
            raise ExactError(f"mesh is a {type(self.mesh).__name__}; a trimesh.Trimesh is needed: see meshes.load")
        surface = _PREPARED.get(self.mesh)
        if surface is None:
            surface = _PREPARED[self.mesh] = prepare(self.mesh)
        exclude = _mask(self.exclude, len(self.mesh.faces))
        for name, value in (
            ("surface", surface),
            ("counted", ~exclude),
            ("exclude", exclude),
            ("weights", _weights(self.weights, len(self.mesh.faces))),
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
        return content.hexdigest()

    def worth(self, face_areas: np.ndarray) -> np.ndarray:
        """What areas of faces, (..., F) [mm²], count together, weighted if weights were given: (...,) [mm²]."""
        return face_areas.sum(axis=-1) if self.weights is None else face_areas @ self.weights

    def without_mesh(self) -> "Scene":
        """The same for another process, which takes only what was prepared."""
        bare = object.__new__(Scene)
        vars(bare).update(vars(self) | {"mesh": None})
        return bare


def forget() -> None:
    """Drop what was prepared of all meshes, as a benchmark needs it."""
    _PREPARED.clear()


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
