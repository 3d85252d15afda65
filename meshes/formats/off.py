"""Read the faces of OFF files: text, with colours, normals or texture coordinates or without."""

import re

import numpy as np

from meshes.errors import MeshError
from meshes.formats.polygons import Polygons
from meshes.formats.text import numbers, plain, shown


def read_off(name: str, data: bytes) -> Polygons:
    """Faces of an OFF file.

    Parameters
    ----------
    name : str
        Of the file, for messages.
    data : bytes
        The whole file.

    Raises
    ------
    MeshError
        If it is binary or of other than three dimensions, a line is not as the format has it, or it is cut short.
    """
    text = plain(data)
    start = re.match(rb"(?:\s|#[^\n]*\n)*(ST)?(C)?(N)?(4)?(n)?OFF\b[ \t]*(BINARY)?", text)
    if start is None:
        raise MeshError(f'{name}: it does not begin with "OFF"; the file is damaged or of another kind')
    if start[4] or start[5] or start[6]:
        what = "binary" if start[6] else "of other than three dimensions"
        raise MeshError(f"{name}: an OFF file that is {what}, which is not read. Export it as text, or as PLY")
    lines = [(text.count(b"\n", 0, start.end()) + 1, text[start.end() :].partition(b"\n")[0])]
    lines += list(enumerate(text[start.end() :].split(b"\n")[1:], start=lines[0][0] + 1))
    rows = [(number, line, line.partition(b"#")[0].split()) for number, line in lines]
    rows = [row for row in rows if row[2]]
    try:
        n_vertices, n_faces = (int(word) for word in rows[0][2][:2])
    except (IndexError, ValueError) as error:
        raise MeshError(f"{name}: its header does not count vertices and faces. Export it again") from error
    if min(n_vertices, n_faces) < 0 or n_vertices + n_faces > len(rows) - 1:
        raise MeshError(
            f"{name}: the header announces {n_vertices} vertices and {n_faces} faces, but {len(rows) - 1} lines "
            "follow. It is cut short or damaged; copy or export it again"
        )
    vertices, corners, sizes = [], [], []
    for number, line, words in rows[1 : 1 + n_vertices]:
        try:
            vertices.append(numbers(words[:3]))
            if len(words) < 3:
                raise ValueError
        except ValueError as error:
            raise _line_error(name, number, line, "a vertex needs three numbers") from error
    for number, line, words in rows[1 + n_vertices : 1 + n_vertices + n_faces]:
        try:
            size = int(words[0])
            face = [int(word) for word in words[1 : 1 + size]]  # a colour may follow
            if not 0 <= size == len(face):
                raise ValueError
        except ValueError as error:
            raise _line_error(name, number, line, "a face needs its number of corners, and so many vertices") from error
        corners += face
        sizes.append(size)
    if not sizes:
        cloud = ", a point cloud" if n_vertices else ""
        raise MeshError(f"{name}: {n_vertices} vertices and no faces{cloud}; needed is at least one triangle")
    kept = np.clip(np.array(corners), -1, n_vertices) if corners else []
    table = np.array(vertices, dtype=np.float64).reshape(-1, 3)
    found = Polygons(table, np.array(kept, dtype=np.int64), np.array(sizes, dtype=np.int64))
    last = rows[n_vertices + n_faces]
    return found if text.endswith(b"\n") else found.of_open_end(name, last[1], len(last[2]) == sizes[-1] + 1)


def _line_error(name: str, line_number: int, line: bytes, needed: str) -> MeshError:
    return MeshError(
        f"{name}: line {line_number} reads {shown(line)}; {needed}. Correct the line or export the file again"
    )
