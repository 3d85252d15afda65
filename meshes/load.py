"""Load a mesh file: is it there, is it a mesh, and then `meshes.check`."""

import os
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from meshes.condition.check import check
from meshes.distinct_rows import distinct_rows
from meshes.errors import MeshError, MeshWarning
from meshes.file_faces import number_faces
from meshes.formats.obj import read_obj
from meshes.formats.off import read_off
from meshes.formats.ply import read_ply
from meshes.formats.polygons import Polygons
from meshes.formats.stl import read_stl
from meshes.formats.triangles import triangles_of

READERS = {".stl": read_stl, ".obj": read_obj, ".ply": read_ply, ".off": read_off}

# Largest extents [mm] outside of which a mesh is more likely in another unit. Nothing that a ring of cameras looks at
# is below a millimetre or above ten metres.
LEAST_EXTENT, MOST_EXTENT = 1.0, 10_000.0
# Units that meshes come in, the likeliest first, with their factors to millimetres; and the largest extents [mm] of
# what a ring of cameras mostly looks at.
UNITS = {"metres": 1000.0, "centimetres": 10.0, "inches": 25.4, "micrometres": 0.001}
LEAST_USUAL, MOST_USUAL = 8.0, 600.0

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


def load(
    path: str | os.PathLike,
    repair: bool = False,
    scale: float = 1.0,
    *,
    two_sided: bool = False,
    seen_from: ArrayLike | None = None,
) -> trimesh.Trimesh:
    """Read a triangle mesh from an STL, OBJ, PLY or OFF file and check it.

    Coordinates times `scale` are taken as millimetres. Coincident vertices are merged, polygons cut into triangles,
    several objects in one file joined to one mesh; colours, materials and normals are dropped. A file that is odd but
    whole is read, one that is cut short is refused.

    Parameters
    ----------
    path : path_like
        The file; its ending names the format.
    repair : bool
        Put right what can be (see `meshes.check`) instead of refusing it.
    scale : float
        Factor from the file's unit to millimetres: 1000 for a file in metres.
    two_sided, seen_from : bool, (N, 3) array_like
        As for `meshes.check`.

    Returns
    -------
    trimesh.Trimesh
        Checked as by `meshes.check`. It may be open: `mesh.metadata["watertight"]` says. Faces are in the order of the
        file, without those that were left out; `meshes.file_faces` says which face of the file each is of.
        `mesh.metadata["notes"]` lists what was odd about the file and what was mended.

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
    meshes.errors.MeshError: no_such_file.stl: no such file; give the path of an STL, OBJ, PLY or OFF file
    """
    mesh = check(read(path, scale), repair, str(path), two_sided=two_sided, seen_from=seen_from)
    if hint := unit_hint(float(mesh.extents.max()), float(scale)):
        warnings.warn(f"{path}: {hint}", MeshWarning, stacklevel=2)
    return mesh


def read(path: str | os.PathLike, scale: float = 1.0) -> trimesh.Trimesh:
    """A mesh file as it is, for `meshes.inspect`: its faces as triangles, whether areas mean something on them or not.

    Raises
    ------
    MeshError
        If there is no such file, it cannot be read or is cut short.
    """
    path = Path(path)
    if isinstance(scale, bool) or not isinstance(scale, int | float | np.number) or not 0 < scale < np.inf:
        raise MeshError(f"scale is {scale!r}; needed is a positive number, such as 1000 for a file in metres")
    name = str(path)
    data = _read(path)
    polygons = _in_one_place(READERS[path.suffix.lower()](name, data).checked(name))
    faces, polygon = triangles_of(name, polygons)
    with np.errstate(over="ignore"):  # the check then says which vertex is not finite
        vertices = polygons.vertices * float(scale)  # a factor of 1 changes no bit
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    if len(faces) != len(polygons.sizes) or polygons.number is not None:
        number = np.arange(len(polygons.sizes)) if polygons.number is None else polygons.number
        number_faces(mesh, number[polygon], polygons.n_in_file or len(polygons.sizes))
    mesh.metadata["notes"] = list(polygons.notes)
    return mesh


def unit_hint(extent: float, scale: float = 1.0) -> str | None:
    """What the largest side of a mesh [mm] says against millimetres, if anything."""
    if LEAST_EXTENT <= extent <= MOST_EXTENT:
        return None
    likely = other_units(extent)
    unit = likely[0] if likely else "metres" if extent < LEAST_EXTENT else "micrometres"
    factor = UNITS[unit]
    return (
        f"the largest side is {extent:.3g} mm, so its unit is probably {unit}; load it with scale={scale * factor:g} "
        f"(--scale {scale * factor:g} at the command line) if that is so"
    )


def other_units(extent: float) -> list[str]:
    """Units in which a mesh would be as large as what is mostly looked at, if in millimetres [mm] it is not.

    Examples
    --------
    >>> other_units(0.05), other_units(3.0), other_units(50.0)
    (['metres'], ['centimetres', 'inches'], [])
    """
    if LEAST_USUAL <= extent <= MOST_USUAL:
        return []
    return [unit for unit, factor in UNITS.items() if LEAST_USUAL <= extent * factor <= MOST_USUAL]


def _read(path: Path) -> bytes:
    """All bytes of the file, if it is a file of a known kind."""
    if not os.path.exists(path):  # unlike pathlib's, it says no to a name that cannot be
        raise MeshError(f"{path}: no such file; give the path of an STL, OBJ, PLY or OFF file")
    if not path.is_file():
        raise MeshError(f"{path}: a {'folder' if path.is_dir() else 'device'}; give an STL, OBJ, PLY or OFF file")
    if path.suffix.lower() not in READERS:
        raise MeshError(
            f'{path}: ends in "{path.suffix}"; needed is a mesh that ends in .stl, .obj, .ply or .off. '
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
            raise MeshError(f"{path}: {kind}, not a mesh; unpack it, or give the STL, OBJ, PLY or OFF file itself")
    start = data.lstrip()[:4].upper()
    for kind, ending in (("PLY", ".ply"), ("OFF", ".off")):
        if start in (f"{kind}\n".encode(), f"{kind}\r".encode()) and path.suffix.lower() != ending:
            article = "an" if kind == "OFF" else "a"
            raise MeshError(f"{path}: {article} {kind} file by its content; give it a name that ends in {ending}")
    return data


def _in_one_place(polygons: Polygons) -> Polygons:
    """Vertices in the very same place are one."""
    vertices = polygons.vertices
    if len(polygons.sizes) == 0 or not np.isfinite(vertices[polygons.corners]).all():
        return polygons  # the check shall name the vertex by its number in the file
    first, number = distinct_rows(vertices)
    return replace(polygons, vertices=vertices[first] + 0.0, corners=number[polygons.corners])
