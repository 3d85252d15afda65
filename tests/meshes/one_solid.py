"""One small solid, and writers of it in each format: what `file_variants` are made of.

The solid is an L, extruded: its caps are concave polygons of six corners, its walls are quads.
"""

import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

HEIGHT = 7.0
OUTLINE = [(0, 0), (20, 0), (20, 10), (10, 10), (10, 20), (0, 20)]
VERTICES = [(*corner, 0.0) for corner in OUTLINE] + [(*corner, HEIGHT) for corner in OUTLINE]
CAPS = [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11]]
WALLS = [[i, (i + 1) % 6, 6 + (i + 1) % 6, 6 + i] for i in range(6)]
POLYGONS = CAPS + WALLS
# The caps as rectangles, two each, for what is made of convex faces.
QUADS = [[5, 4, 3, 0], [3, 2, 1, 0], [6, 7, 8, 9], [6, 9, 10, 11], *WALLS]
TRIANGLES = [[quad[0], *pair] for quad in QUADS for pair in (quad[1:3], quad[2:])]
AREA = 2 * 300 + 80 * HEIGHT
VOLUME = 300 * HEIGHT


@dataclass(frozen=True)
class Variant:
    """A file; what must be read of it (None for the solid), or the words of the refusal; and of a note."""

    name: str
    content: bytes
    refused: str | None = None
    note: str | None = None
    area: float = AREA
    volume: float | None = VOLUME


VARIANTS: dict[str, Variant] = {}


def add(name: str, ending: str, content: bytes | str, *expected: str | None, **more) -> None:
    """Under its name; text is in UTF-8."""
    assert name not in VARIANTS, name
    data = content.encode() if isinstance(content, str) else content
    VARIANTS[name] = Variant(f"solid{ending}", data, *expected, **more)


def points(faces: Iterable[list[int]] = TRIANGLES) -> np.ndarray:
    return np.array([[VERTICES[corner] for corner in face] for face in faces])


def binary_stl(header: bytes = b"", attribute: int = 0, order: str = "<", announced: int | None = None) -> bytes:
    count = len(TRIANGLES) if announced is None else announced
    rows = [struct.pack(f"{order}12fH", 0, 0, 0, *corners.ravel(), attribute) for corners in points()]
    return header.ljust(80, b"\0") + struct.pack(f"{order}I", count) + b"".join(rows)


def ascii_stl(name: str = "part", triangles: np.ndarray | None = None, number: Callable = "{:g}".format) -> str:
    lines = [f"solid {name}"]
    for corners in points() if triangles is None else triangles:
        lines += ["  facet normal 0 0 0", "    outer loop"]
        lines += [f"      vertex {' '.join(number(one) for one in corner)}" for corner in corners]
        lines += ["    endloop", "  endfacet"]
    return "\n".join([*lines, f"endsolid {name}"]) + "\n"


def obj(faces: Iterable[list[int]] = POLYGONS, corner: Callable[[int], str] = "{}".format, extra: str = "") -> str:
    lines = [f"v {x:g} {y:g} {z:g}{extra}" for x, y, z in VERTICES]
    return "\n".join([*lines, *("f " + " ".join(corner(one + 1) for one in face) for face in faces)]) + "\n"


def ply_header(form: str, n_faces: int, more_vertex: str = "", faces: str = "property list uchar int vertex_indices\n"):
    return (
        f"ply\nformat {form} 1.0\nelement vertex {len(VERTICES)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"{more_vertex}element face {n_faces}\n{faces}end_header\n"
    )


def ascii_ply(faces: list[list[int]] = POLYGONS) -> str:
    rows = [f"{x:g} {y:g} {z:g}" for x, y, z in VERTICES]
    rows += [" ".join(map(str, [len(face), *face])) for face in faces]
    return ply_header("ascii", len(faces)) + "\n".join(rows) + "\n"


def binary_ply(
    faces: list[list[int]] = POLYGONS, order: str = "<", vertex: str = "f", count: str = "B", index: str = "i",
    more: bytes = b"", before: bytes = b"", after: bytes = b"", header: str | None = None,
) -> bytes:  # fmt: skip
    form = "binary_little_endian" if order == "<" else "binary_big_endian"
    body = b"".join(struct.pack(f"{order}3{vertex}", *map(int, one)) + more for one in VERTICES)
    for face in faces:
        body += before + struct.pack(f"{order}{count}{len(face)}{index}", len(face), *face) + after
    return (header or ply_header(form, len(faces))).replace("FORMAT", form).encode() + body


def off(faces: list[list[int]] = POLYGONS, head: str = "OFF", extra: str = "") -> str:
    lines = [head, f"{len(VERTICES)} {len(faces)} 0", *(f"{x:g} {y:g} {z:g}{extra}" for x, y, z in VERTICES)]
    return "\n".join([*lines, *(" ".join(map(str, [len(face), *face])) for face in faces)]) + "\n"


def line_ends(text: str) -> dict[str, str]:
    return {"Unix": text, "Windows": text.replace("\n", "\r\n"), "old Mac": text.replace("\n", "\r")}
