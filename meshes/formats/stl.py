"""Read STL files, binary and ASCII, whatever they announce; write binary ones, the same bytes each time."""

import re
from itertools import islice

import numpy as np
import trimesh

from meshes.errors import MeshError
from meshes.formats.polygons import Polygons
from meshes.formats.text import numbers, plain, shown

HEADER_BYTES = 84  # 80 bytes of anything, then the number of triangles as uint32
TRIANGLE = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
# Coordinates of what may be a triangle, and not bytes of another kind, are 0 or of a size between these.
LEAST, MOST = 1e-20, 1e20

VERTEX = rb"\s+vertex\s+(\S+)\s+(\S+)\s+(\S+)"
FACET = re.compile(
    rb"\bfacet(?:\s+normal\s+\S+\s+\S+\s+\S+)?\s+outer\s+loop" + 3 * VERTEX + rb"\s+endloop\s+endfacet\b", re.I
)
# What may stand between facets: names of solids, comments, colours.
BETWEEN = re.compile(rb"\s*(?:(?:(?:solid|end\s*solid|color|colour)\b|[#;!%]|//)[^\n]*(?:\n|\Z)\s*)*\Z", re.I)
# So many facets are turned into numbers at a time, or their words would take more memory than the mesh.
BLOCK = 50_000


def read_stl(name: str, data: bytes) -> Polygons:
    """Triangles of an STL file.

    Parameters
    ----------
    name : str
        Of the file, for messages.
    data : bytes
        The whole file.

    Returns
    -------
    Polygons
        Three vertices of its own for each triangle. The normals of the file are dropped: programs write zeros, or
        normals that contradict the order of the corners.

    Raises
    ------
    MeshError
        If the file is neither kind of STL, or not whole.
    """
    announced = int.from_bytes(data[80:HEADER_BYTES], "little") if len(data) >= HEADER_BYTES else None
    needed = None if announced is None else HEADER_BYTES + announced * TRIANGLE.itemsize
    # Size first, the word "solid" second: many programs start the header of a binary file with it.
    if announced is not None and needed == len(data):
        return _triangles(data, announced, TRIANGLE, [])
    if (text := _ascii(data)) is not None:
        return _read_ascii(name, text)
    if announced is None:
        raise MeshError(
            f"{name}: {len(data)} bytes, but even an empty binary STL file has {HEADER_BYTES}, and an ASCII one "
            'starts with "solid". The file is cut short or not an STL file; export it again'
        )
    turned = int.from_bytes(data[80:HEADER_BYTES], "big")
    if HEADER_BYTES + turned * TRIANGLE.itemsize == len(data):
        return _triangles(data, turned, TRIANGLE.newbyteorder(), ["its bytes are in the other order (big-endian)"])
    if announced > 0 and needed is not None and needed < len(data):
        return _with_tail(name, data, announced, needed)
    raise MeshError(
        f"{name}: the header announces {announced} triangles, which take {needed} bytes, but the file has "
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


def _triangles(data: bytes, count: int, kind: np.dtype, notes: list[str]) -> Polygons:
    corners = np.frombuffer(data, kind, count, HEADER_BYTES)["corners"]
    with np.errstate(invalid="ignore"):  # signalling nan; the check names its vertex
        vertices = corners.astype(np.float64).reshape(-1, 3)
    return Polygons.of_triangles(vertices, np.arange(3 * count).reshape(-1, 3), notes)


def _with_tail(name: str, data: bytes, announced: int, needed: int) -> Polygons:
    """A binary file that goes on after its last triangle: padding, or what a program has put there."""
    tail = data[needed:]
    more, rest = divmod(len(tail), TRIANGLE.itemsize)
    if more and not rest and any(tail):
        with np.errstate(invalid="ignore"):
            size = np.abs(np.frombuffer(tail, TRIANGLE)["corners"].astype(np.float64))
        if ((size == 0) | ((size > LEAST) & (size < MOST))).all():
            raise MeshError(
                f"{name}: the header announces {announced} triangles, which take {needed} bytes, but the file has "
                f"{len(data)}: {more} more triangles follow. The number or the file is wrong; export it again"
            )
    what = "bytes of padding" if not any(tail) else "bytes that belong to no triangle"
    return _triangles(data, announced, TRIANGLE, [f"ignored {len(tail)} {what} at its end"])


def _ascii(data: bytes) -> bytes | None:
    """The text of an ASCII file; None for another."""
    text = plain(data)
    if b"\0" in text:
        return None
    start = re.match(rb"\s*(?:(?:[#;!%]|//)[^\n]*\n\s*)*(solid|facet)\b", text, re.I)
    return text if start else None


def _read_ascii(name: str, text: bytes) -> Polygons:
    coordinates, end = [], 0
    found = FACET.finditer(text)
    while block := list(islice(found, BLOCK)):
        for facet in block:
            if facet.start() > end and not BETWEEN.match(text[end : facet.start()]):
                raise _odd(name, text, end)
            end = facet.end()
        words = [word for facet in block for word in facet.groups()]
        try:
            coordinates.append(np.array(numbers(words)))
        except ValueError as error:
            raise _no_number(name, text, block) from error
    if not BETWEEN.match(text[end:]):
        raise _odd(name, text, end)
    vertices = np.concatenate([np.zeros(0), *coordinates]).reshape(-1, 3)
    closed = not len(vertices) or re.search(rb"\bend\s*solid\b", text[end:], re.I)
    notes = [] if closed else ['no "endsolid" at its end; check that the file is whole']
    return Polygons.of_triangles(vertices, np.arange(len(vertices)).reshape(-1, 3), notes)


def _no_number(name: str, text: bytes, facets: list[re.Match]) -> MeshError:
    for facet in facets:
        for group, word in enumerate(facet.groups(), start=1):
            try:
                numbers([word])
            except ValueError:
                return _line_error(name, text, facet.start(group), "a vertex needs three numbers")
    raise AssertionError("every word is a number")


def _line_number(text: bytes, place: int) -> int:
    return text.count(b"\n", 0, place) + 1


def _line_error(name: str, text: bytes, place: int, needed: str) -> MeshError:
    line = text[text.rfind(b"\n", 0, place) + 1 :].split(b"\n", 1)[0]
    return MeshError(
        f"{name}: line {_line_number(text, place)} reads {shown(line)}; {needed}. "
        "Correct the line or export the file again"
    )


def _odd(name: str, text: bytes, begin: int) -> MeshError:
    """What is wrong with the first text after `begin` that is no facet."""
    part = text[begin:]
    facet = re.search(rb"\bfacet\b", part, re.I)
    corner = re.search(rb"\bvertex\b", part, re.I)
    start = min([found.start() for found in (facet, corner) if found], default=None)
    if start is None or not BETWEEN.match(part[:start]):
        start = len(part) - len(part.lstrip())
        return _line_error(name, text, begin + start, "that is no part of an ASCII STL file")
    after = part[start:]
    end = re.search(rb"\bendfacet\b|\bend\s*solid\b|(?<!\A)\bfacet\b", after[1:], re.I)
    if end is None:
        return MeshError(
            f"{name}: the facet that begins in line {_line_number(text, begin + start)} has no end; "
            "the file is cut short. Copy or export it again"
        )
    for found in re.finditer(rb"\bvertex\b([^\n]*)", after[: end.start() + 1], re.I):
        words = re.split(rb"\b(?:vertex|endloop)\b", found[1], flags=re.I)[0].split()
        try:
            fine = len(numbers(words)) == 3
        except ValueError:
            fine = False
        if not fine:
            return _line_error(name, text, begin + start + found.start(), "a vertex needs three numbers")
    n_corners = len(re.findall(rb"\bvertex\b", after[: end.start() + 1], re.I))
    return MeshError(
        f"{name}: {n_corners} vertices in the facet of line {_line_number(text, begin + start)}; a facet is "
        'written as "facet", "outer loop", three times "vertex", "endloop", "endfacet". '
        "The file is damaged or not a triangle mesh; export it again"
    )
