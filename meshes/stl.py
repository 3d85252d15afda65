"""Read STL files, binary and ASCII, without believing what they announce; write binary ones, the same bytes each time.

trimesh reads well-formed STL files too, but keeps quiet about an ASCII file that breaks off or holds a word where a
number belongs: it returns the part before it. An area of half a surface looks like any other, so this reader refuses.
"""

from pathlib import Path

import numpy as np
import trimesh

from meshes.errors import MeshError

HEADER_BYTES = 84  # 80 bytes of anything, then the number of triangles as uint32
TRIANGLE = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(path: Path, data: bytes) -> np.ndarray:
    """Corners of every triangle of an STL file.

    Parameters
    ----------
    path : Path
        Only for messages.
    data : bytes
        The whole file.

    Returns
    -------
    (F, 3, 3) ndarray
        Corners in file units. The normals of the file are dropped: programs write zeros, or normals that
        contradict the order of the corners.

    Raises
    ------
    MeshError
        If the file is neither kind of STL, or not whole.
    """
    announced = int(np.frombuffer(data[80:HEADER_BYTES], "<u4")[0]) if len(data) >= HEADER_BYTES else None
    needed = None if announced is None else HEADER_BYTES + announced * TRIANGLE.itemsize
    # Size first, the word "solid" second: many programs start the header of a binary file with it.
    if needed == len(data):
        triangles = np.frombuffer(data, TRIANGLE, offset=HEADER_BYTES)
        with np.errstate(invalid="ignore"):  # signalling nan; the check names its vertex
            return triangles["corners"].astype(np.float64)
    if data.lstrip()[:5].lower() == b"solid" and b"\0" not in data:
        return _read_ascii(path, data)
    if announced is None:
        raise MeshError(
            f"{path}: {len(data)} bytes, but even an empty binary STL file has {HEADER_BYTES}, and an ASCII one "
            'starts with "solid". The file is cut short or not an STL file; export it again'
        )
    raise MeshError(
        f"{path}: the header announces {announced} triangles, which take {needed} bytes, but the file has "
        f"{len(data)}. It is cut short, or not an STL file; copy or export it again"
    )


def stl_bytes(mesh: trimesh.Trimesh, header: str = "") -> bytes:
    """Binary STL file of a mesh.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        Coordinates are rounded to single precision, as the format has it.
    header : str
        At most 80 ASCII characters; not starting with "solid", which some programs take for an ASCII file.

    Returns
    -------
    bytes
        The same for the same mesh: no date, no version.

    Examples
    --------
    >>> len(stl_bytes(trimesh.creation.box(), "a cube")) == 84 + 12 * 50
    True
    """
    try:
        text = header.encode("ascii")
    except UnicodeEncodeError:
        text = b""
    if len(text) > 80 or (header and not text) or text.lower().startswith(b"solid"):
        raise MeshError(f'STL header is {header!r}; it must be at most 80 ASCII characters, not starting with "solid"')
    triangles = np.zeros(len(mesh.faces), TRIANGLE)
    corners = np.asarray(mesh.vertices, dtype=np.float64)[mesh.faces]
    triangles["corners"] = corners
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.sqrt((normals * normals).sum(axis=1))[:, None]
    triangles["normal"] = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)
    return text.ljust(80) + np.uint32(len(triangles)).astype("<u4").tobytes() + triangles.tobytes()


def _read_ascii(path: Path, data: bytes) -> np.ndarray:
    corners, facets, open_solids = [], 0, 0
    for number, line in enumerate(data.decode("utf-8", errors="replace").splitlines(), start=1):
        words = line.split()
        if not words:
            continue
        keyword = words[0].lower()
        if keyword == "vertex":
            try:
                corner = [float(word) for word in words[1:]]
            except ValueError:
                corner = []
            if len(corner) != 3:
                raise MeshError(
                    f'{path}: line {number} reads "{line.strip()[:60]}"; a vertex needs three numbers. '
                    "Correct the line or export the file again"
                )
            corners.append(corner)
        elif keyword == "facet":
            if len(corners) != 3 * facets:
                raise _bad_facet(path, number, len(corners), facets)
            facets += 1
        elif keyword in ("solid", "endsolid"):
            open_solids += 1 if keyword == "solid" else -1
    if len(corners) != 3 * facets:
        raise _bad_facet(path, None, len(corners), facets)
    if open_solids > 0:
        raise MeshError(
            f'{path}: ASCII STL with {facets} facets and no closing "endsolid"; the file is cut short. '
            "Copy or export it again"
        )
    return np.array(corners, dtype=np.float64).reshape(-1, 3, 3)


def _bad_facet(path: Path, number: int | None, corners: int, facets: int) -> MeshError:
    where = "at the end of the file" if number is None else f"before line {number}"
    return MeshError(
        f"{path}: {corners} vertices in {facets} facets {where}; every facet needs three. "
        "The file is damaged or not a triangle mesh; export it again"
    )
