"""Read the faces of OBJ files: polygons of all objects, groups and materials, in the order of the file."""

import re

import numpy as np

from meshes.errors import MeshError
from meshes.formats.polygons import Polygons
from meshes.formats.text import numbers, plain, shown

# Free-form geometry, of which a surface has area that would be missing, and what reads another file.
FREE_FORM = {b"surf", b"curv", b"curv2", b"bzp", b"bsp", b"cdp", b"res"}
ELSEWHERE = {b"call", b"csh"}


def read_obj(name: str, data: bytes) -> Polygons:
    """Faces of an OBJ file; a vertex may have more numbers than its coordinates, such as a colour.

    Parameters
    ----------
    name : str
        Of the file, for messages.
    data : bytes
        The whole file.

    Raises
    ------
    MeshError
        If a vertex or a face is not as the format has it, or the file is cut short.
    """
    text = plain(data)
    ended = text.endswith(b"\n") or not text.strip()
    if b"\\\n" in text:  # a line goes on in the next; a blank line in its place, to count the lines
        text = re.sub(rb"(?:[^\n]*\\\n)+[^\n]*", _in_one_line, text)
    words, corners, sizes, n_vertices, kinds = [], [], [], 0, set()
    lines = text.split(b"\n")
    for line_number, line in enumerate(lines, start=1):
        parts = (line if b"#" not in line else line.partition(b"#")[0]).split()
        if not parts:
            continue
        kind = parts[0].lower()
        if kind == b"v":
            if len(parts) < 4:
                raise _line_error(name, line_number, line, "a vertex needs three numbers")
            words += parts[1:4]
            n_vertices += 1
        elif kind in (b"f", b"fo"):
            try:
                face = [int(part.partition(b"/")[0]) for part in parts[1:]]
            except ValueError as error:
                raise _line_error(name, line_number, line, "a face needs numbers of vertices") from error
            if 0 in face:
                raise MeshError(
                    f"{name}: line {line_number} refers to vertex 0; OBJ files count from 1. Export the file again"
                )
            corners += [one - 1 if one > 0 else n_vertices + one for one in face]
            sizes.append(len(face))
        else:
            _refuse_kind(name, line_number, line, kind)
            kinds.add(kind)
    vertices = _vertices(name, lines, words)
    # Numbers beyond all vertices are none of them, however long they are.
    corners = np.clip(np.array(corners), -1, len(vertices)) if corners else []
    found = Polygons(vertices, np.array(corners, dtype=np.int64), np.array(sizes, dtype=np.int64), first=1)
    if not sizes:
        raise MeshError(f"{name}: {_without_faces(n_vertices, kinds)}")
    return found if ended else _of_open_end(name, lines[-1], found)


def _in_one_line(several: re.Match) -> bytes:
    return several[0].replace(b"\\\n", b" ") + b"\n" * several[0].count(b"\\\n")


def _refuse_kind(name: str, line_number: int, line: bytes, kind: bytes) -> None:
    if kind in FREE_FORM:
        raise MeshError(
            f"{name}: line {line_number} reads {shown(line)}: free-form curves or surfaces (NURBS), which have no "
            "faces; needed are triangles or polygons. Export it as a mesh"
        )
    if kind in ELSEWHERE:
        raise MeshError(f"{name}: line {line_number} reads {shown(line)}; other files are not read. Give it whole")
    if not kind.isalpha() and not re.fullmatch(rb"[a-z][a-z0-9_]*:?", kind):
        raise _line_error(name, line_number, line, "a line of an OBJ file begins with what it is, such as v or f")


def _without_faces(n_vertices: int, kinds: set[bytes]) -> str:
    if n_vertices and b"l" in kinds:
        return f"{n_vertices} vertices with lines but no faces, a wireframe; needed is at least one triangle"
    cloud = ", a point cloud" if n_vertices else ""
    return f"{n_vertices} vertices and no faces{cloud}; needed is at least one triangle. Make a surface of it first"


def _vertices(name: str, lines: list[bytes], words: list[bytes]) -> np.ndarray:
    try:
        return np.array(numbers(words)).reshape(-1, 3)
    except ValueError as error:
        for line_number, line in enumerate(lines, start=1):
            parts = line.partition(b"#")[0].split()
            try:
                if parts and parts[0].lower() == b"v":
                    numbers(parts[1:4])
            except ValueError:
                raise _line_error(name, line_number, line, "a vertex needs three numbers") from error
        raise


def _of_open_end(name: str, last: bytes, found: Polygons) -> Polygons:
    """A file whose last line has no end: whole, or cut in the middle of that line."""
    parts = last.partition(b"#")[0].split()
    kind = parts[0].lower() if parts else b"#"
    unused = len(found.vertices) - len(np.unique(found.corners))
    if kind not in (b"f", b"fo", b"v") or len(found.sizes) == 0:
        return found
    # A face with fewer corners than all others, or one whose last corner has fewer parts than its first.
    fewer = len(parts) < 4 or len(parts) - 1 < found.sizes[:-1].min(initial=len(parts))
    fewer = fewer or parts[-1].count(b"/") < parts[1].count(b"/")
    if unused or (kind != b"v" and fewer):
        raise MeshError(
            f"{name}: the last line, {shown(last)}, has no end"
            + (f", and {unused} of {len(found.vertices)} vertices belong to no face" if unused else "")
            + ". The file is cut short; copy or export it again, or put an end to the line if it is whole"
        )
    return found.of_open_end(name, last, kind != b"v" and b"/" not in parts[-1])


def _line_error(name: str, line_number: int, line: bytes, needed: str) -> MeshError:
    return MeshError(
        f"{name}: line {line_number} reads {shown(line)}; {needed}. Correct the line or export the file again"
    )
