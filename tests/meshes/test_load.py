import os
import struct
import tracemalloc

import numpy as np
import pytest
import trimesh

import meshes


@pytest.fixture
def box():
    return trimesh.creation.box((10, 20, 30))


def ascii_stl(mesh) -> str:
    return trimesh.exchange.stl.export_stl_ascii(mesh)


def written(folder, name, content):
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


@pytest.mark.parametrize(
    "name", ["box.stl", "box.STL", "box.obj", "box.ply", "with ' quotes \" & blanks.stl", "модель.ply"]
)
def test_reads_each_format(tmp_path, box, name):
    path = tmp_path / name
    path.write_bytes(
        box.export(file_type=path.suffix.lower()[1:], **({"encoding": "binary"} if "ply" in name else {}))
        if "obj" not in name
        else box.export(file_type="obj").encode()
    )
    mesh = meshes.load(path)
    assert len(mesh.vertices) == 8 and len(mesh.faces) == 12
    assert mesh.area == pytest.approx(2200)
    assert mesh.metadata["watertight"] is True
    assert type(mesh) is trimesh.Trimesh
    assert meshes.load(str(path)).area == mesh.area


def test_reads_ascii_stl_and_ply(tmp_path, box):
    stl = written(tmp_path, "a.stl", ascii_stl(box).replace("solid ", "SOLID my name", 1))
    ply = written(tmp_path, "a.ply", box.export(file_type="ply", encoding="ascii"))
    for path in (stl, ply):
        assert meshes.load(path).volume == pytest.approx(6000)


def test_reads_a_binary_stl_whose_header_says_solid(tmp_path, box):
    data = b"solid made by a scanner".ljust(80) + box.export(file_type="stl")[80:]
    assert meshes.load(written(tmp_path, "a.stl", data)).volume == pytest.approx(6000)


def test_normals_of_the_file_do_not_matter(tmp_path, box):
    data = bytearray(box.export(file_type="stl"))
    for face in range(12):
        data[84 + 50 * face : 96 + 50 * face] = bytes(12)
    mesh = meshes.load(written(tmp_path, "a.stl", bytes(data)))
    np.testing.assert_allclose(np.linalg.norm(mesh.face_normals, axis=1), 1)
    assert mesh.volume == pytest.approx(6000)


def test_several_objects_become_one_mesh(tmp_path, box):
    other = box.copy()
    other.apply_translation((100, 0, 0))
    two = ascii_stl(box) + ascii_stl(other)
    assert meshes.load(written(tmp_path, "two.stl", two)).volume == pytest.approx(12000)
    obj = "mtllib none.mtl\n" + "".join(
        f"o part{i}\nusemtl colour{i}\n"
        + "".join(f"v {x} {y} {z}\n" for x, y, z in part.vertices)
        + "".join(f"f {a} {b} {c}\n" for a, b, c in part.faces + 1 + 8 * i)
        for i, part in enumerate((box, other))
    )
    mesh = meshes.load(written(tmp_path, "two.obj", obj))
    assert mesh.volume == pytest.approx(12000)
    assert mesh.body_count == 2


def test_polygons_are_cut_into_triangles(tmp_path):
    obj = "v 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\nf 1 2 3 4\n"
    mesh = meshes.load(written(tmp_path, "quad.obj", obj))
    assert len(mesh.faces) == 2 and mesh.area == pytest.approx(6)
    assert mesh.metadata["watertight"] is False


def test_site_survives_its_file(tmp_path):
    mesh = meshes.site("spine_disc", 50)
    path = written(tmp_path, "site.stl", meshes.stl_bytes(mesh, "a site"))
    assert meshes.fingerprint(meshes.load(path)) == meshes.fingerprint(mesh)
    assert trimesh.load_mesh(path).is_watertight  # readable by others


@pytest.mark.parametrize("header", ["x" * 81, "solid", "Größe"])
def test_stl_header_must_be_short_ascii(box, header):
    with pytest.raises(meshes.MeshError, match="at most 80 ASCII characters"):
        meshes.stl_bytes(box, header)


def test_four_billion_announced_triangles_take_no_memory(tmp_path, box):
    data = bytearray(box.export(file_type="stl"))
    data[80:84] = struct.pack("<I", 2**32 - 1)
    path = written(tmp_path, "huge.stl", bytes(data))
    tracemalloc.start()
    with pytest.raises(
        meshes.MeshError, match="announces 4294967295 triangles, which take 214748364834 bytes, but the"
    ):
        meshes.load(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1e6


BOX = trimesh.creation.box((10, 20, 30))
BINARY = BOX.export(file_type="stl")
ASCII = ascii_stl(BOX)
PLY = BOX.export(file_type="ply", encoding="ascii").decode()
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
FIRST_VERTEX = next(line for line in ASCII.splitlines() if line.startswith("vertex"))

BAD_FILES = {
    "nothing in it": ("a.stl", b"", "0 bytes; needed is a mesh"),
    "unknown ending": ("a.step", b"ISO-10303", r'ends in ".step"; needed is a mesh that ends in .stl, .obj, .ply or'),
    "no ending": ("mesh", b"solid", r'ends in ""; needed is'),
    "zip": ("a.stl", b"PK\x03\x04" + bytes(200), "a zip archive, not a mesh; unpack it"),
    "gzip": ("a.ply", b"\x1f\x8b" + bytes(200), "a gzip archive"),
    "jpeg": ("a.stl", b"\xff\xd8\xff\xe0" + bytes(200), "a JPEG picture, not a mesh"),
    "web page": ("a.obj", b"<!doctype html><p>404", "a web page"),
    "few bytes": ("a.stl", b"\x00\x01\x02", "3 bytes, but even an empty binary STL file has 84"),
    "binary cut short": ("a.stl", BINARY[:-30], "announces 12 triangles, which take 684 bytes, but the file has 654"),
    "binary too long": ("a.stl", BINARY + BINARY[-50:], "684 bytes, but the file has 734: 1 more triangles follow"),
    "text": ("a.stl", "dear colleague, " * 20, "header announces .* not an STL file"),
    "no triangles": ("a.stl", bytes(84), "0 vertices and no faces; needed is at least one triangle"),
    "no facets": ("a.stl", "solid empty\nendsolid empty\n", "no faces; needed is at least one triangle"),
    "words": ("a.stl", ASCII.replace(FIRST_VERTEX, "vertex one two three"), r'line 4 reads "vertex one two three"'),
    "two numbers": ("a.stl", ASCII.replace(FIRST_VERTEX, "vertex 1 2"), "a vertex needs three numbers"),
    "ascii cut short": ("a.stl", ASCII[: ASCII.rindex("endfacet")], "has no end; the file is cut short"),
    "ascii cut in a facet": (
        "a.stl",
        ASCII[: ASCII.rindex("vertex")],
        "the facet that begins in line 79 has no end",
    ),
    "facet of four": (
        "a.stl",
        ASCII.replace(FIRST_VERTEX, FIRST_VERTEX + "\n" + FIRST_VERTEX, 1),
        "4 vertices in the facet of line 2",
    ),
    "nan": ("a.stl", ASCII.replace(FIRST_VERTEX, "vertex nan 0 0"), r"is \(nan, 0, 0\).*needed are finite"),
    "signalling nan": (
        "a.stl",
        BINARY[:96] + struct.pack("<I", 0x7F800001) + BINARY[100:],
        "vertex 0 is .nan, .*needed are finite",
    ),
    "finite but absurd": (
        "a.obj",
        OBJ.replace("v 1 0 0", "v 1e99 0 0"),
        r"vertex 1 is \(1e\+99, 0, 0\).*up to 1e\+09 mm",
    ),
    "infinite": ("a.obj", OBJ.replace("v 1 0 0", "v inf 0 0"), r"vertex 1 is \(inf, 0, 0\).*needed are finite"),
    "obj words": ("a.obj", OBJ.replace("v 1 0 0", "v one 0 0"), r'line 2 reads "v one 0 0"; a vertex needs three'),
    "obj two coordinates": ("a.obj", OBJ.replace("v 1 0 0", "v 1 0"), "a vertex needs three numbers"),
    "obj index too large": ("a.obj", OBJ + "f 1 2 99\n", "face 4 refers to vertices 0, 1, 4, but"),
    "obj index zero": ("a.obj", OBJ + "f 0 1 2\n", "line 9 refers to vertex 0; OBJ files count from 1"),
    "obj without faces": ("a.obj", "v 0 0 0\nv 1 0 0\n", "no faces, a point cloud; needed is at least one triangle"),
    "obj with one line left": ("a.obj", "v 0 0 0 0", "no faces, a point cloud; needed is at least one triangle"),
    "obj of noise": ("a.obj", bytes(range(256)), "a line of an OBJ file begins with what it is"),
    "ply without header": ("a.ply", "plywood", "no PLY header"),
    "ply words": (
        "a.ply",
        PLY.replace("-5.0", "minus", 1).replace("-5 ", "minus ", 1),
        "among its vertex elements stands .*minus",
    ),
    "ply cut short": (
        "a.ply",
        "\n".join(PLY.splitlines()[:-1]) + "\n",
        "announces 8 vertices and 12 faces, but the file ends",
    ),
    "ply huge": ("a.ply", PLY.replace("element face 12", "element face 4000000000"), "4000000000 faces, but only"),
    "ply negative": ("a.ply", PLY.replace("element vertex 8", "element vertex -8"), "announces -8 vertices"),
    "ply index too large": ("a.ply", PLY[: PLY.rindex("3 ")] + "3 0 1 77\n", "refers to vertices 0, 1, 77"),
    "point cloud": (
        "a.ply",
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
        "0 0 0\n1 1 1\n",
        "no faces, a point cloud; needed is at least one triangle",
    ),
}


@pytest.mark.parametrize("case", BAD_FILES)
@pytest.mark.parametrize("repair", [False, True])
def test_bad_file(tmp_path, case, repair):
    name, content, message = BAD_FILES[case]
    path = written(tmp_path, name, content)
    with pytest.raises(meshes.MeshError, match=message) as caught:
        meshes.load(path, repair=repair)
    assert str(path) in str(caught.value)


def test_missing_file_and_folder(tmp_path):
    with pytest.raises(meshes.MeshError, match="no such file; give the path of an STL, OBJ, PLY or OFF file"):
        meshes.load(tmp_path / "none.stl")
    folder = tmp_path / "folder.stl"
    folder.mkdir()
    with pytest.raises(meshes.MeshError, match="a folder; give an STL, OBJ, PLY or OFF file"):
        meshes.load(folder)
    with pytest.raises(meshes.MeshError, match="a device; give"):
        meshes.load(os.devnull)


def test_unreadable_file(tmp_path, monkeypatch):
    path = written(tmp_path, "a.stl", BINARY)

    def refuse(self):
        raise PermissionError(13, "Permission denied")

    # Not by mode bits: the tests may run as root, who may read everything.
    monkeypatch.setattr(type(path), "read_bytes", refuse)
    with pytest.raises(meshes.MeshError, match=r"cannot be read \(Permission denied\); check its permissions"):
        meshes.load(path)


@pytest.mark.parametrize("seed", range(40))
def test_damaged_bytes_give_a_mesh_or_a_mesh_error(tmp_path, seed):
    rng = np.random.default_rng(seed)
    for name, content in (("a.stl", BINARY), ("b.stl", ASCII), ("c.ply", PLY), ("d.obj", OBJ)):
        data = bytearray(content if isinstance(content, bytes) else content.encode())
        for position in rng.integers(0, len(data), size=rng.integers(1, 6)):
            data[position] = rng.integers(0, 256)
        path = written(tmp_path, name, bytes(data[: rng.integers(1, len(data) + 1)] if seed % 2 else data))
        try:
            mesh = meshes.load(path, repair=bool(seed % 3))
        except meshes.MeshError as error:
            assert str(path) in str(error)
        else:
            assert np.isfinite(mesh.vertices).all() and len(mesh.faces) > 0 and mesh.area > 0


@pytest.mark.parametrize(("scale", "extent"), [(1.0, [10, 20, 30]), (25.4, [254, 508, 762]), (0.5, [5, 10, 15])])
def test_scale_leads_to_millimetres(tmp_path, box, scale, extent):
    box.export(tmp_path / "box.ply")
    assert meshes.load(tmp_path / "box.ply", scale=scale).extents == pytest.approx(extent)


@pytest.mark.parametrize(("factor", "unit", "scale"), [(0.001, "metres", "1000"), (1000.0, "micrometres", r"0\.001")])
def test_an_unlikely_extent_is_warned_of(tmp_path, box, factor, unit, scale):
    path = tmp_path / "box.ply"
    box.apply_scale(factor).export(path)
    with pytest.warns(
        meshes.MeshWarning, match=rf"unit is probably {unit}; load it with scale={scale} \(--scale {scale} "
    ):
        mesh = meshes.load(path)
    assert mesh.extents == pytest.approx(np.array([10, 20, 30]) * factor)  # it is not changed for that
    assert meshes.load(path, scale=1 / factor).extents == pytest.approx([10, 20, 30])


@pytest.mark.parametrize("scale", [0, -1.0, float("nan"), float("inf"), True, "mm"])
def test_scale_must_be_a_positive_number(tmp_path, box, scale):
    box.export(tmp_path / "box.ply")
    with pytest.raises(meshes.MeshError, match="needed is a positive number, such as 1000 for a file in metres"):
        meshes.load(tmp_path / "box.ply", scale=scale)


def test_scale_beyond_all_numbers(tmp_path, box):
    box.export(tmp_path / "box.ply")
    with pytest.raises(meshes.MeshError, match="not finite|finite"):
        meshes.load(tmp_path / "box.ply", scale=1e308)


def test_faces_of_an_obj_file_keep_their_order_whatever_they_are_made_of(tmp_path, box):
    lines = [f"v {x} {y} {z}" for x, y, z in box.vertices.tolist()]
    for number, face in enumerate((box.faces + 1).tolist()):
        lines += [f"usemtl {'skin' if number % 6 < 3 else 'bone'}"] * (number % 3 == 0)
        lines += ["f " + " ".join(map(str, face))]
    path = written(tmp_path, "materials.obj", "\n".join(lines) + "\n")
    assert (meshes.load(path).triangles == box.triangles).all()
