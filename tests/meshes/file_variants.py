"""One small solid in every way that files are written, whole, odd or damaged, with what must come of each.

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


def stl_variants() -> None:
    whole, text = binary_stl(), ascii_stl()
    add("STL binary", ".stl", whole)
    add("STL binary, header solid", ".stl", binary_stl(b"solid made by a scanner"))
    add("STL binary, header with facet and vertex", ".stl", binary_stl(b"solid facet normal vertex endsolid"))
    add("STL binary, colour", ".stl", binary_stl(b"COLOR=\x01\x02\x03\x04,MATERIAL=", attribute=0x8421))
    add("STL binary, upper-case ending", ".STL", whole)
    add("STL binary, big-endian", ".stl", binary_stl(order=">"), note="other order")
    for name, tail in {"newline": b"\n", "text": b"made with love", "zeros": bytes(7), "a row of zeros": bytes(50),
                       "many zeros": bytes(150), "padding to 512": bytes(-len(whole) % 512)}.items():  # fmt: skip
        add(f"STL binary, {name} behind", ".stl", whole + tail, note="at its end")
    add("STL binary, one triangle too many", ".stl", whole + whole[84:134], "1 more triangles follow")
    add("STL binary, number too small", ".stl", binary_stl(announced=7), "13 more triangles follow")
    add("STL binary, number 0", ".stl", binary_stl(announced=0), "announces 0 triangles")
    for cut in (1, 30, 50, 500, len(whole) - 84):
        add(f"STL binary, {cut} bytes cut", ".stl", whole[:-cut], "announces 20 triangles.*cut short")
    add("STL binary, header alone", ".stl", whole[:80], "even an empty binary STL file has 84")
    add("STL binary, no triangle", ".stl", whole[:80] + bytes(4), "no faces; needed is at least one triangle")
    for name, data in line_ends(text).items():
        add(f"STL text, {name}", ".stl", data)
    add("STL text, upper case", ".stl", text.upper())
    add("STL text, upper case keywords", ".stl", text.replace("vertex", "VERTEX").replace("endfacet", "EndFacet"))
    add("STL text, tabs", ".stl", text.replace("  ", "\t").replace(" ", "\t"))
    add("STL text, not indented", ".stl", "\n".join(line.strip() for line in text.splitlines()) + "\n")
    add("STL text, blank lines", ".stl", text.replace("\n", "\n\n \n"))
    add("STL text, blanks at the ends of lines", ".stl", text.replace("\n", "   \n"))
    facets = text.replace("\n", " ").replace("endfacet", "endfacet\n").replace("solid part", "solid part\n", 1)
    add("STL text, a facet a line", ".stl", facets)
    add("STL text, one line", ".stl", text.replace("\n", " "))
    add("STL text, no newline at its end", ".stl", text.rstrip())
    add("STL text, end solid", ".stl", text.replace("endsolid", "end solid"))
    add("STL text, endsolid alone", ".stl", text.replace("endsolid part", "endsolid"))
    add("STL text, solid without name", ".stl", text.replace("solid part", "solid"))
    add("STL text, no endsolid", ".stl", text[: text.index("endsolid")], note='no "endsolid"')
    add("STL text, no solid", ".stl", text.partition("\n")[2])
    add("STL text, comment before", ".stl", "# made by hand\n; twice\n// thrice\n" + text)
    add("STL text, comment between", ".stl", text.replace("  facet", "# comment about a facet\n  facet"))
    add("STL text, blank line before", ".stl", "\n\n " + text)
    add("STL text, byte-order mark", ".stl", "\ufeff" + text)
    for name in ("utf-16", "utf-16-le", "utf-16-be"):
        add(f"STL text, {name}", ".stl", text.replace("part", "деталь").encode(name))
    add("STL text, name in latin-1", ".stl", text.replace("part", "Schädel").encode("latin-1"))
    add("STL text, name with keywords", ".stl", text.replace("part", "my facet, vertex and loop"))
    add("STL text, exponents", ".stl", ascii_stl(number="{:+.6E}".format))
    add("STL text, exponents of Fortran", ".stl", ascii_stl(number=lambda one: f"{one:.6E}".replace("E", "D")))
    add("STL text, normals nan", ".stl", text.replace("normal 0 0 0", "normal nan -nan(ind) 1.#QNAN"))
    add("STL text, facet without normal", ".stl", text.replace(" normal 0 0 0", ""))
    halves = ascii_stl("one", points(TRIANGLES[:9])) + ascii_stl("two", points(TRIANGLES[9:]))
    add("STL text, several solids", ".stl", halves)
    add("STL text, several solids, one end", ".stl", halves.replace("endsolid one\n", ""))
    add("STL text, cut in a number", ".stl", text[: text.rindex("vertex") + 8], "cut short")
    add("STL text, cut in a facet", ".stl", text[: text.rindex("endloop")], "cut short")
    add("STL text, cut in endfacet", ".stl", text[: text.rindex("endfacet") + 4], "cut short")
    add("STL text, comma for the point", ".stl", text.replace("vertex 20 ", "vertex 20,0 "), "needs three numbers")
    add("STL text, two numbers", ".stl", text.replace("vertex 20 0 0", "vertex 20 0"), "needs three numbers")
    add("STL text, four corners", ".stl", text.replace("vertex 20 0 0\n", "vertex 20 0 0\n vertex 1 1 1\n", 1),
        "4 vertices in the facet of line")  # fmt: skip
    add("STL text, endfacet missing", ".stl", text.replace("  endfacet\n", "", 1), "facet")
    add("STL text, words between", ".stl", text.replace("endfacet", "endfacet\nhello", 1), 'reads "hello"')
    add("STL text, nothing in it", ".stl", "solid nothing\nendsolid nothing\n", "no faces")
    add("STL of prose", ".stl", "Dear colleague, the scan is attached. " * 9, "not an STL file")
    add("STL that is a PLY file", ".stl", binary_ply(), "a PLY file by its content.*ends in .ply")
    add("STL that is an OFF file", ".stl", off(), "an OFF file by its content.*ends in .off")


def obj_variants() -> None:
    text = obj()
    for name, data in line_ends(text).items():
        add(f"OBJ, {name}", ".obj", data)
    for turn in range(6):
        turned = [cap[turn:] + cap[:turn] for cap in CAPS]
        add(f"OBJ, concave from corner {turn}", ".obj", obj(turned + WALLS))
    add("OBJ, triangles", ".obj", obj(TRIANGLES))
    add("OBJ, quads", ".obj", obj(QUADS))
    add("OBJ, triangle as a quad", ".obj", obj([[*face, face[2]] for face in TRIANGLES]))
    add("OBJ, polygon with its first corner last", ".obj", obj([[*face, face[0]] for face in POLYGONS]))
    corners = {"texture": "{0}/{0}", "normals": "{0}//1", "texture and normals": "{0}/{0}/1", "slashes": "{0}//",
               "a slash": "{0}/"}  # fmt: skip
    for name, corner in corners.items():
        add(f"OBJ, {name}", ".obj", "vt 0 0\nvn 0 0 1\n" + obj(corner=corner.format))
    add("OBJ, negative numbers", ".obj", obj(corner=lambda one: str(one - 13)))
    add("OBJ, negative numbers with texture", ".obj", obj(corner=lambda one: f"{one - 13}/-1/-1"))
    several = "".join(
        f"o part{number}\n" + "".join(f"v {x:g} {y:g} {z:g}\n" for x, y, z in VERTICES)
        + "".join("f " + " ".join(str(corner - 12) for corner in face) + "\n" for face in faces)
        for number, faces in enumerate((POLYGONS[:3], POLYGONS[3:]))
    )  # fmt: skip
    add("OBJ, negative numbers, several objects", ".obj", several)
    add("OBJ, several objects", ".obj", text.replace("f 7", "o second\ng a b\ns 1\nf 7"))
    materials = (line + ("usemtl a\nusemtl b\n" if line[0] == "f" else "") for line in text.splitlines(True))
    add("OBJ, materials by turns", ".obj", "".join(materials))
    add("OBJ, library of materials", ".obj", "mtllib none.mtl\nusemtl skin\n" + text)
    add("OBJ, tabs", ".obj", text.replace(" ", "\t"))
    add("OBJ, blanks and tabs", ".obj", text.replace(" ", " \t "))
    add("OBJ, indented", ".obj", "".join("  " + line for line in text.splitlines(True)))
    add("OBJ, partly indented", ".obj", "".join(" " * (i % 3) + line for i, line in enumerate(text.splitlines(True))))
    add("OBJ, comments at the ends of lines", ".obj", text.replace("\n", " # f 1 2 3\n"))
    add("OBJ, comments between", ".obj", text.replace("\n", "\n# v 1 2 3\n#\n"))
    add("OBJ, comment in latin-1", ".obj", ("# Schädel\ng Knöchel\n" + text).encode("latin-1"))
    add("OBJ, comment in Shift JIS", ".obj", ("# 頭蓋骨\no 歯\n" + text).encode("shift_jis"))
    add("OBJ, byte-order mark", ".obj", "\ufeff" + text)
    add("OBJ, utf-16", ".obj", text.encode("utf-16"))
    add("OBJ, utf-16 without mark", ".obj", text.encode("utf-16-le"))
    add("OBJ, blank lines", ".obj", text.replace("\n", "\n\n"))
    add("OBJ, lines that go on", ".obj", text.replace("f 1 2 8 7", "f 1 2 \\\n8 7"))
    add("OBJ, colours of vertices", ".obj", obj(extra=" 0.5 0.5 1"))
    add("OBJ, weights of vertices", ".obj", obj(extra=" 1.0"))
    add("OBJ, faces first", ".obj", text[text.index("f ") :] + text[: text.index("f ")])
    add("OBJ, other elements", ".obj", text + "p 1\nl 1 2 3\nvp 0.1\nlod 2\n")
    add(
        "OBJ, unused vertices", ".obj", "v 1e6 0 0\n" + obj(corner=lambda one: str(one + 1)), note="1 vertex of no face"
    )
    add("OBJ, upper case", ".obj", text.upper())
    add("OBJ, exponents", ".obj", text.replace("20", "2.0E+01").replace("v 0 0 0", "v .0 0. +0e-3"))
    add("OBJ, no newline at its end", ".obj", text.rstrip(), note="last line has no end")
    add("OBJ, comment at its end", ".obj", text + "# end")
    add("OBJ, face of two corners", ".obj", text + "f 1 2\n", note="fewer than three corners")
    rows = obj(QUADS, "{0}/{0}/{0}".format)
    add("OBJ, cut in a face", ".obj", text[: text.rindex(" ")], "last line.*has no end.*cut short")
    add("OBJ, cut in a corner", ".obj", rows[:-4], "last line.*cut short")
    add("OBJ, cut long before", ".obj", text[: text.index("f 7") + 8], "belong to no face.*cut short")
    add("OBJ, cut before the first corner", ".obj", text + "f", "last line.*has no end")
    add("OBJ, faces of no corners", ".obj", " f#\0 0\n\nf#", "last line.*has no end")
    add("OBJ, cut in a vertex", ".obj", text[: text.index("v 20 10 7") + 4], "needs three numbers")
    add("OBJ, word for a number", ".obj", text.replace("v 20 0 0", "v 20 zero 0"), 'line 2 reads "v 20 zero 0"')
    add("OBJ, two coordinates", ".obj", text.replace("v 20 0 0", "v 20 0"), "line 2 .*needs three numbers")
    add("OBJ, word for a corner", ".obj", text.replace("f 1 2", "f 1 two"), "face needs numbers")
    add("OBJ, line broken", ".obj", text.replace("f 1 2 8 7", "f 1 2 8\n7"), 'reads "7"; a line of an OBJ')
    add("OBJ, vertex 0", ".obj", text + "f 0 1 2\n", "line 21 refers to vertex 0")
    add("OBJ, vertex 99", ".obj", text + "f 1 2 99\n", "face 8 refers to vertices")
    add("OBJ, vertex -99", ".obj", text + "f 1 2 -99\n", "face 8 refers to vertices")
    add("OBJ, point cloud", ".obj", text[: text.index("f ")], "12 vertices and no faces, a point cloud")
    add("OBJ, wireframe", ".obj", text.replace("f ", "l "), "no faces, a wireframe")
    add("OBJ, NURBS", ".obj", "v 0 0 0\ncstype bspline\ndeg 3 3\nsurf 0 1 0 1 1 1 1 1\nend\n", "free-form")
    add("OBJ, bow tie", ".obj", obj([*POLYGONS, [0, 2, 1, 5]]), "face 8, a polygon of 4 corners, crosses itself")


def ply_variants() -> None:
    text = ascii_ply()
    for name, data in line_ends(text).items():
        add(f"PLY text, {name}", ".ply", data)
    for turn in range(6):
        add(f"PLY text, concave from corner {turn}", ".ply",
            ascii_ply([cap[turn:] + cap[:turn] for cap in CAPS] + WALLS))  # fmt: skip
    add("PLY text, triangles", ".ply", ascii_ply(TRIANGLES))
    add("PLY text, quads", ".ply", ascii_ply(QUADS))
    add("PLY text, tabs", ".ply", text.replace(" ", "\t"))
    add(
        "PLY text, indented",
        ".ply",
        "".join(f"  {line}" if line[0].isdigit() else line for line in text.splitlines(True)),
    )
    add("PLY text, no newline at its end", ".ply", text.rstrip(), note="last line has no end")
    add("PLY text, newlines at its end", ".ply", text + "\n\n")
    add("PLY text, rows wrapped", ".ply", ply_header("ascii", 8) + text.partition("end_header\n")[2].replace(" ", "\n"))
    add(
        "PLY text, rows in one line",
        ".ply",
        ply_header("ascii", 8) + text.partition("end_header\n")[2].replace("\n", " "),
    )
    add("PLY text, byte-order mark", ".ply", "\ufeff" + text)
    add(
        "PLY text, header in upper case",
        ".ply",
        text[: text.index("end_header")].upper() + text[text.index("end_header") :],
    )
    colours = "property uchar red\nproperty float nx\n"
    add(
        "PLY text, colours",
        ".ply",
        ply_header("ascii", 8, colours)
        + "".join(f"{x:g} {y:g} {z:g} 255 0.5\n" for x, y, z in VERTICES)
        + "".join(f"{len(f)} {' '.join(map(str, f))}\n" for f in POLYGONS),
    )
    for cut, what in ((9, "a face"), (90, "the faces"), (150, "the vertices")):
        add(f"PLY text, cut in {what}", ".ply", text[:-cut], "announces 12 vertices and 8 faces.*cut short")
    add("PLY text, cut in a corner", ".ply", text[:-2], "last line.*has no end .*cut short")
    add("PLY text, quads cut", ".ply", ascii_ply(QUADS)[:-14], "announces 12 vertices and 10 faces.*cut short")
    add(
        "PLY text, more faces than announced",
        ".ply",
        text.replace("face 8", "face 7"),
        "5 words follow the last element",
    )
    add("PLY text, word for a number", ".ply", text.replace("20 10 0", "20 ten 0"), "vertex elements stands .*ten")
    add(
        "PLY text, vertex 99", ".ply", text.replace("4 5 0 6 11", "4 5 0 6 99"), "face 7 refers to vertices 5, 0, 6, 99"
    )
    strip = [6 + i if j else i for i in (0, 1, 2, 3, 4, 5, 0) for j in (1, 0)]
    caps = [-1, 0, 5, 3, 4, -1, 0, 3, 1, 2, -1, 6, 7, 9, 8, -1, 6, 9, 11, 10]
    for order, form in ("<", "binary_little_endian"), (">", "binary_big_endian"), ("", "ascii"):
        whole = strip + caps
        head = ply_header(form, 1).replace("element face", "element tristrips")
        if order:
            one = head.encode() + b"".join(struct.pack(f"{order}3f", *vertex) for vertex in VERTICES)
            one += struct.pack(f"{order}B{len(whole)}i", len(whole), *whole)
        else:
            rows = [" ".join(map(str, row)) for row in (*VERTICES, [len(whole), *whole])]
            one = (head + "\n".join(rows) + "\n").encode()
        add(f"PLY strips, {form}", ".ply", one, note="20 triangles in strips")
    for order, name in ("<", "little-endian"), (">", "big-endian"):
        form = "binary_little_endian" if order == "<" else "binary_big_endian"
        add(f"PLY {name}", ".ply", binary_ply(order=order))
        add(f"PLY {name}, triangles", ".ply", binary_ply(TRIANGLES, order))
        add(f"PLY {name}, quads", ".ply", binary_ply(QUADS, order))
        add(
            f"PLY {name}, double",
            ".ply",
            binary_ply(order=order, vertex="d", header=ply_header(form, 8).replace("float", "double")),
        )
        add(
            f"PLY {name}, short",
            ".ply",
            binary_ply(order=order, vertex="h", header=ply_header(form, 8).replace("float", "int16")),
        )
        for count, index, types in ("i", "H", "int ushort"), ("H", "I", "uint16 uint32"), ("B", "B", "uint8 uchar"):
            add(
                f"PLY {name}, {types}",
                ".ply",
                binary_ply(
                    order=order, count=count, index=index, header=ply_header(form, 8).replace("uchar int", types)
                ),
            )
        faces = (
            "property uchar flags\nproperty list uchar int vertex_index\nproperty list uchar float texcoord\n"
            "property float q\n"
        )
        add(
            f"PLY {name}, more of faces",
            ".ply",
            binary_ply(
                order=order,
                before=b"\7",
                after=b"\2" + struct.pack(f"{order}3f", 1, 2, 3),
                header=ply_header(form, 8, faces=faces),
            ),
        )
        add(
            f"PLY {name}, more of triangles",
            ".ply",
            binary_ply(
                TRIANGLES, order, before=b"\7", after=b"\0" + bytes(4), header=ply_header(form, 20, faces=faces)
            ),
        )
        add(
            f"PLY {name}, colours",
            ".ply",
            binary_ply(
                order=order,
                more=b"\1" + bytes(4),
                header=ply_header(form, 8, "property uchar red\nproperty float nx\n"),
            ),
        )
        add(f"PLY {name}, newline behind", ".ply", binary_ply(order=order) + b"\r\n")
        add(f"PLY {name}, byte behind", ".ply", binary_ply(order=order) + b"x", note="ignored 1 byte")
        add(f"PLY {name}, cut", ".ply", binary_ply(order=order)[:-5], "announces 12 vertices and 8 faces.*cut short")
        add(
            f"PLY {name}, triangles cut",
            ".ply",
            binary_ply(TRIANGLES, order)[:-5],
            "12 vertices and 20 faces.*cut short",
        )
    head = ply_header("FORMAT", 8)
    heads = {
        "Windows header": head.replace("\n", "\r\n"), "Mac header": head.replace("\n", "\r"),
        "upper case": head.replace("element", "Element").replace("property", "PROPERTY").replace("float", "FLOAT"),
        "blank lines": head.replace("element", "\nelement"), "blanks": head.replace(" ", "  ").replace("\n", " \n"),
        "comments": head.replace("element", "comment element face 99\nobj_info num_cols 3\ncomment\nelement"),
        "texture": head.replace("element face", "comment TextureFile skin.png\nelement face"),
        "other elements": head.replace("end_header", "element edge 0\nproperty int vertex1\nelement material 0\n"
                                       "property list uchar int x\nend_header"),
    }  # fmt: skip
    for name, one in heads.items():
        add(f"PLY header, {name}", ".ply", binary_ply(header=one))
    marked = binary_ply(header=head.replace("element vertex", "comment Sch?del\nelement vertex"))
    add("PLY header, latin-1", ".ply", marked.replace(b"Sch?del", "Schädel".encode("latin-1")))
    add("PLY header, no end", ".ply", ascii_ply().replace("end_header\n", ""), "no PLY header")
    add("PLY header, no format", ".ply", ascii_ply().replace("format ascii 1.0\n", ""), "does not say|no .format.")
    add("PLY header, unknown type", ".ply", ascii_ply().replace("float x", "complex x"), "header says .*complex")
    add("PLY header, two coordinates", ".ply", ascii_ply().replace("float z", "float q"), "no x, y and z")
    add(
        "PLY header, four billion",
        ".ply",
        binary_ply(header=head.replace("face 8", "face 4000000000")),
        "4000000000 faces, but",
    )
    add("PLY header, less than none", ".ply", ascii_ply().replace("face 8", "face -8"), "-8 faces")
    cloud = ascii_ply([]).replace("element face 0\nproperty list uchar int vertex_indices\n", "")
    add("PLY, point cloud", ".ply", cloud, "12 vertices and no faces, a point cloud")
    add("PLY, no faces", ".ply", ascii_ply([]), "12 vertices and no faces, a point cloud")
    edges = (
        cloud.replace("end_header", "element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header") + "0 1\n"
    )
    add("PLY, wireframe", ".ply", edges, "edges but no faces, a wireframe")
    grid = "element range_grid 2\nproperty list uchar int vertex_indices\nend_header"
    add("PLY, range map", ".ply", cloud.replace("end_header", grid) + "0\n1 5\n", "a range map")


def off_variants() -> None:
    text = off()
    for name, data in line_ends(text).items():
        add(f"OFF, {name}", ".off", data)
    add("OFF, triangles", ".off", off(TRIANGLES))
    add("OFF, numbers in the first line", ".off", text.replace("OFF\n", "OFF "))
    add("OFF, comments", ".off", "# one\n" + text.replace("\n", " # two\n\n# three\n"))
    add("OFF, colours of vertices", ".off", off(head="COFF", extra=" 255 0 0 255"))
    add("OFF, normals", ".off", off(head="NOFF", extra=" 0 0 1"))
    add(
        "OFF, colours of faces",
        ".off",
        "".join(line[:-1] + " 0.5 0.5 0.5\n" if line[:2] in ("4 ", "6 ") else line for line in text.splitlines(True)),
    )
    add("OFF, no newline at its end", ".off", text.rstrip(), note="last line has no end")
    add("OFF, cut in a face", ".off", text[:-5], "a face needs its number of corners")
    add("OFF, cut in the faces", ".off", text[: text.index("4 0")], "announces 12 vertices and 8 faces.*cut short")
    add("OFF, cut after a face of no corners", ".off", "OFF\n4 2 0\n0 0 0\n5 0 0\n0 5 0\n5 5 0\n0\n4 0 1 5 0\n3 0",
        "line|refers to vertices")  # fmt: skip
    add("OFF, word", ".off", text.replace("20 0 0", "20 0 x"), "a vertex needs three numbers")
    add("OFF, binary", ".off", b"OFF BINARY\n" + bytes(99), "that is binary")
    add("OFF, four dimensions", ".off", text.replace("OFF", "4OFF"), "other than three dimensions")
    add("OFF, no head", ".off", text.replace("OFF\n", ""), 'does not begin with "OFF"')


stl_variants()
obj_variants()
ply_variants()
off_variants()
