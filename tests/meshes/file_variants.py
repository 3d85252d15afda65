"""One small solid in every way that files are written, whole, odd or damaged, with what must come of each."""

from tests.meshes.one_solid import (
    CAPS,
    POLYGONS,
    QUADS,
    TRIANGLES,
    VARIANTS,
    VERTICES,
    WALLS,
    add,
    ascii_stl,
    binary_ply,
    binary_stl,
    line_ends,
    obj,
    off,
    points,
)
from tests.meshes.ply_variants import ply_variants

__all__ = ["VARIANTS"]


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
    add("OFF, cut after a face of one corner", ".off", "OFF\n3 1 0\n0 0 0\n5 0 0\n0 5 0\n1 0", "no faces")
    add("OFF, word", ".off", text.replace("20 0 0", "20 0 x"), "a vertex needs three numbers")
    add("OFF, binary", ".off", b"OFF BINARY\n" + bytes(99), "that is binary")
    add("OFF, four dimensions", ".off", text.replace("OFF", "4OFF"), "other than three dimensions")
    add("OFF, no head", ".off", text.replace("OFF\n", ""), 'does not begin with "OFF"')


stl_variants()
obj_variants()
ply_variants()
off_variants()
