"""The solid in every way that PLY files are written."""

import struct

from tests.meshes.one_solid import (
    CAPS,
    POLYGONS,
    QUADS,
    TRIANGLES,
    VERTICES,
    WALLS,
    add,
    ascii_ply,
    binary_ply,
    line_ends,
    ply_header,
)


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
