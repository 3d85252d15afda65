"""Load a mesh file: is it there, is it a mesh, and then `meshes.check`."""

import io
import os
import re
import warnings
from pathlib import Path

import numpy as np
import trimesh

from meshes.check import check
from meshes.errors import MeshError, MeshWarning
from meshes.stl import read_stl

FORMATS = (".stl", ".obj", ".ply")

# Largest extents [mm] outside of which a mesh is more likely in another unit, with that unit's name and its factor to
# millimetres. Nothing that a ring of cameras looks at is below a millimetre or above ten metres.
LEAST_EXTENT, LIKELY_IF_LESS = 1.0, ("metres", 1000.0)
MOST_EXTENT, LIKELY_IF_MORE = 10_000.0, ("micrometres", 0.001)

# First bytes of what is most often renamed or downloaded by mistake.
MAGIC = {
    b"PK\x03\x04": "a zip archive",
    b"\x1f\x8b": "a gzip archive",
    b"\xff\xd8\xff": "a JPEG picture",
    b"\x89PNG": "a PNG picture",
    b"%PDF": "a PDF document",
    b"<!DOCTYPE": "a web page",
    b"<html": "a web page",
}


def load(path: str | os.PathLike, repair: bool = False, scale: float = 1.0) -> trimesh.Trimesh:
    """Read a triangle mesh from an STL (binary or ASCII), OBJ or PLY file and check it.

    Coordinates times `scale` are taken as millimetres. Coincident vertices are merged, polygons of OBJ and PLY files
    cut into triangles, several objects in one file joined to one mesh; colours, materials and normals are dropped.

    Parameters
    ----------
    path : path_like
        The file; its ending names the format.
    repair : bool
        Put right what can be (see `meshes.check`) instead of refusing it.
    scale : float
        Factor from the file's unit to millimetres: 1000 for a file in metres.

    Returns
    -------
    trimesh.Trimesh
        Checked as by `meshes.check`. It may be open: `mesh.metadata["watertight"]` says. Faces are in the order of the
        file, without those that a repair removed: see `meshes.file_faces`.

    Raises
    ------
    MeshError
        If there is no such file, it cannot be read, it is no mesh, or the mesh fails a check. The message says
        what was got, what is needed and what to do next.

    Warns
    -----
    MeshWarning
        If the mesh is so small or so large that its unit is hardly the millimetre.

    Examples
    --------
    >>> import tempfile
    >>> file = Path(tempfile.mkdtemp()) / "cube.stl"
    >>> _ = trimesh.creation.box((10, 10, 10)).export(file)
    >>> mesh = load(file)
    >>> len(mesh.vertices), len(mesh.faces), mesh.metadata["watertight"]
    (8, 12, True)
    >>> load("no_such_file.stl")
    Traceback (most recent call last):
        ...
    meshes.errors.MeshError: no_such_file.stl: no such file; give the path of an STL, OBJ or PLY file
    """
    path = Path(path)
    if isinstance(scale, bool) or not isinstance(scale, int | float | np.number) or not 0 < scale < np.inf:
        raise MeshError(f"scale is {scale!r}; needed is a positive number, such as 1000 for a file in metres")
    data = _read(path)
    suffix = path.suffix.lower()
    if suffix == ".stl":
        corners = read_stl(path, data)
        vertices, faces = corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)
    else:
        vertices, faces = _read_with_trimesh(path, data, suffix)
    mesh = _merged(path, vertices, faces)
    with np.errstate(over="ignore"):  # the check then says which vertex is not finite
        mesh.vertices *= float(scale)  # a factor of 1 changes no bit
    mesh = check(mesh, repair=repair, name=str(path))
    if hint := _unit_hint(mesh, float(scale)):
        warnings.warn(f"{path}: {hint}", MeshWarning, stacklevel=2)
    return mesh


def _unit_hint(mesh: trimesh.Trimesh, scale: float) -> str | None:
    """What the extent of a mesh says against millimetres, if anything."""
    extent = float(mesh.extents.max())
    if LEAST_EXTENT <= extent <= MOST_EXTENT:
        return None
    unit, factor = LIKELY_IF_LESS if extent < LEAST_EXTENT else LIKELY_IF_MORE
    return (
        f"the largest side is {extent:.3g} mm, so its unit is probably {unit}; load it with scale={scale * factor:g} "
        f"(--scale {scale * factor:g} at the command line) if that is so"
    )


def _read(path: Path) -> bytes:
    """All bytes of the file, if it is a file of a known kind."""
    if not os.path.exists(path):  # unlike pathlib's, it says no to a name that cannot be
        raise MeshError(f"{path}: no such file; give the path of an STL, OBJ or PLY file")
    if not path.is_file():
        raise MeshError(f"{path}: a {'folder' if path.is_dir() else 'device'}; give an STL, OBJ or PLY file")
    if path.suffix.lower() not in FORMATS:
        raise MeshError(
            f'{path}: ends in "{path.suffix}"; needed is a mesh that ends in .stl, .obj or .ply. '
            "Export it in one of these formats"
        )
    try:
        data = path.read_bytes()
    except OSError as error:
        raise MeshError(
            f"{path}: cannot be read ({error.strerror or error}); check its permissions and the disk"
        ) from error
    if not data:
        raise MeshError(f"{path}: 0 bytes; needed is a mesh. Copy or export it again")
    for magic, kind in MAGIC.items():
        if data[: len(magic)].lower() == magic.lower():
            raise MeshError(f"{path}: {kind}, not a mesh; unpack it, or give the STL, OBJ or PLY file itself")
    return data


def _read_with_trimesh(path: Path, data: bytes, suffix: str) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (V, 3) and faces (F, 3) of an OBJ or PLY file, as trimesh reads it."""
    announced = _announced_by_ply(path, data) if suffix == ".ply" else {}
    options = {"skip_materials": True} if suffix == ".obj" else {}
    if suffix == ".obj":
        data = re.sub(rb"usemtl[ \t][^\r\n]*", b"", data)  # by which trimesh would reorder the faces
    if suffix == ".obj" and (
        zero := re.search(rb"^f[ \t](?:.*[ \t])?0+(?:/\S*)?[ \t\r]*$|^f[ \t]+(?:.*[ \t])?0+[/ \t]", data, re.M)
    ):
        # trimesh takes vertex 0 for vertex 1.
        line = data.count(b"\n", 0, zero.start()) + 1
        raise MeshError(f"{path}: line {line} refers to vertex 0; OBJ files count from 1. Export the file again")
    try:
        with warnings.catch_warnings():
            # numpy only warns when it meets a word for a number, and returns the part before it.
            warnings.filterwarnings("error", message="string or file could not be read to its end")
            mesh = trimesh.load_mesh(io.BytesIO(data), file_type=suffix[1:], process=False, **options)
    # trimesh lets through whatever its parsers stumble over: ValueError, IndexError, KeyError, ImportError, ...
    except Exception as error:
        raise MeshError(
            f"{path}: not a readable {suffix[1:].upper()} file ({type(error).__name__}: {str(error)[:120]}). "
            "Open it in a mesh program and export it again"
        ) from error
    vertices, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64).reshape(-1, 3)
    n_faces, n_vertices = len(faces), len(vertices)
    if n_faces < announced.get("face", 0) or (n_faces and n_vertices < announced.get("vertex", 0)):
        raise MeshError(
            f"{path}: the header announces {announced['vertex']} vertices and {announced['face']} faces, but the "
            f"file holds {n_vertices} and {n_faces}. It is cut short or damaged; copy or export it again"
        )
    return vertices, faces


def _announced_by_ply(path: Path, data: bytes) -> dict[str, int]:
    """Numbers of vertices and faces a PLY header announces, if the file is large enough for them."""
    header, end, body = data.partition(b"end_header")
    if not (header.startswith(b"ply") and end):
        raise MeshError(f'{path}: no PLY header ("ply" ... "end_header"); the file is damaged or of another kind')
    announced = {
        name.decode("ascii"): int(count)
        for name, count in re.findall(rb"^element\s+(vertex|face)\s+(-?\d+)", header, flags=re.MULTILINE)
    }
    if min(announced.values(), default=0) < 0 or sum(announced.values()) > len(body):
        raise MeshError(
            f"{path}: the header announces {announced.get('vertex', 0)} vertices and {announced.get('face', 0)} "
            f"faces, but only {len(body)} bytes follow. The file is cut short or damaged; copy or export it again"
        )
    return {"vertex": 0, "face": 0} | announced


def _merged(path: Path, vertices: np.ndarray, faces: np.ndarray) -> trimesh.Trimesh:
    """Build a bare mesh with coincident vertices merged."""
    if len(faces) == 0:
        return trimesh.Trimesh(np.zeros((len(vertices), 3)), np.zeros((0, 3), dtype=np.int64), process=False)
    if vertices.shape[1:] != (3,):
        raise MeshError(f"{path}: vertices have {vertices.shape[1]} coordinates; needed are three (x, y, z)")
    wrong = np.flatnonzero(((faces < 0) | (faces >= len(vertices))).any(axis=1))
    if len(wrong):
        corners = ", ".join(str(index) for index in faces[wrong[0]])
        raise MeshError(
            f"{path}: face {wrong[0]} refers to vertices {corners}, but there are vertices 0 to "
            f"{len(vertices) - 1} only. The file is damaged; export it again"
        )
    if not np.isfinite(vertices[faces]).all():  # the check shall name the vertex by its number in the file
        return trimesh.Trimesh(vertices, faces, process=False)
    # Exactly equal ones only, and not by trimesh, which counts in steps of 1e-8 that overflow for large numbers.
    # Adding zero turns -0.0, which has other bytes, into 0.0.
    rows = np.ascontiguousarray(vertices + 0.0).view(np.dtype((np.void, 24))).ravel()
    _, first, inverse = np.unique(rows, return_index=True, return_inverse=True)
    order = np.argsort(first)  # as in the file
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    return trimesh.Trimesh(vertices[first[order]], number[inverse][faces], process=False)
