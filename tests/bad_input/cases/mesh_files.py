"""Meshes that cannot be used, and sound ones that no camera sees."""

import os
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import trimesh

import exact
import meshes
import placement
from tests.bad_input.cases.case import Case
from tests.support.files import ASCII, PLY, box, made, part, put, soup, stl


def changed(place: int, number: float) -> bytes:
    """A box of which one coordinate, counted from the first corner's x, is another number."""
    data = bytearray(stl(box()))
    struct.pack_into("<f", data, 84 + 12 + 4 * place, number)
    return bytes(data)


def wound(faces: slice) -> trimesh.Trimesh:
    mesh = box()
    turned = mesh.faces.copy()
    turned[faces] = turned[faces, ::-1]
    return trimesh.Trimesh(mesh.vertices, turned, process=False)


def mesh_file(name: str, content: bytes | str, message: str) -> Case:
    """A mesh file that cannot be used."""
    return Case(
        lambda folder: ("evaluate", put(folder, name, content), "--cameras", 2),
        message,
        lambda folder: meshes.load(folder / name),
        meshes.MeshError,
    )


def mesh_path(make: Callable[[Path], Path], message: str) -> Case:
    """A path at which there is no mesh file to read."""
    return Case(
        lambda folder: ("evaluate", make(folder), "--cameras", 2),
        message,
        lambda folder: meshes.load(make(folder)),
        meshes.MeshError,
    )


TRIANGLE = [(0, 0, 0), (5, 0, 0), (0, 5, 0)]

MESHES = {
    "binary STL cut short": mesh_file("a.stl", stl(box())[:-70], r"a\.stl: .*announces 12 triangles.*copy or export"),
    "four billion triangles": mesh_file(
        "a.stl",
        stl(box())[:80] + b"\xff\xff\xff\xff" + stl(box())[84:],
        r"announces 4294967295 triangles, which take 214748364834 bytes, but the file has 684.*copy or export",
    ),
    "four billion faces in a PLY file": mesh_file(
        "a.ply", PLY.replace("face 1", "face 4000000000"), r"a\.ply: .*4000000000 faces, but only .* bytes follow"
    ),
    "four billion vertices in a PLY file": mesh_file(
        "a.ply", PLY.replace("vertex 3", "vertex 4000000000"), r"4000000000 vertices .* bytes follow"
    ),
    "words for numbers": mesh_file(
        "a.stl", ASCII.replace("5 0 0", "five 0 0"), r'line 5 reads "vertex five 0 0"; a vertex needs three numbers'
    ),
    "vertex not a number": mesh_file("a.stl", changed(1, float("nan")), r"is \(.*nan.*needed are finite coordinates"),
    "vertex at infinity": mesh_file("a.stl", changed(2, float("-inf")), r"is \(.*-inf.*needed are finite coordinates"),
    "vertex beyond the moon": mesh_file(
        "a.stl", changed(0, 1e30), r"is \(1e\+30.*needed are finite .* up to 1e\+09 mm"
    ),
    "no faces": mesh_file("a.stl", stl(box())[:80] + bytes(4), r"no faces; needed is at least one triangle"),
    "no faces in words": mesh_file("a.stl", "solid a\nendsolid a\n", r"no faces; needed is at least one triangle"),
    "faces without area only": mesh_file(
        "a.stl", stl(soup([(0, 0, 0), (1, 1, 1), (2, 2, 2)] * 3)), r"all 3 faces have zero area; needed is at least one"
    ),
    "inside-out": mesh_file("a.stl", stl(wound(slice(None))), r"closed, but inside-out .*repair"),
    "mixed winding": mesh_file("a.stl", stl(wound(slice(3))), r"wound in opposite senses.*repair"),
    "a hundred thousand vertices in one place": mesh_file(
        "a.stl", stl(soup(np.full((99_999, 3), 7.0))), r"all 33333 faces have zero area"
    ),
    "face of vertices that are not there": mesh_file(
        "a.obj", "v 0 0 0\nv 5 0 0\nv 0 5 0\nf 1 2 9\n", r"a\.obj: face 0 refers to vertices"
    ),
    "vertex 0 in an OBJ file": mesh_file("a.obj", "v 0 0 0\nv 5 0 0\nv 0 5 0\nf 0 1 2\n", r"line 4 refers to vertex 0"),
    "OBJ coordinate beyond all numbers": mesh_file("a.obj", "v 1e999 0 0\nv 5 0 0\nv 0 5 0\nf 1 2 3\n", r"is \(inf, 0"),
    "PLY cut short": mesh_file("a.ply", PLY[: PLY.index("3 0 1 2")], r"header announces.*cut short or damaged"),
    "PLY without end of header": mesh_file("a.ply", PLY.replace("end_header\n", ""), r"no PLY header"),
    "zip named .stl": mesh_file("a.stl", b"PK\x03\x04" + bytes(99), r"a\.stl: a zip archive, not a mesh; unpack it"),
    "JPEG named .stl": mesh_file("a.stl", b"\xff\xd8\xff\xe0" + bytes(99), r"a JPEG picture, not a mesh"),
    "web page named .stl": mesh_file("a.stl", "<!DOCTYPE html><h1>Please log in", r"a web page, not a mesh"),
    "PDF named .obj": mesh_file("a.obj", "%PDF-1.7 \n", r"a PDF document, not a mesh"),
    "empty file": mesh_file("a.stl", b"", r"a\.stl: 0 bytes; needed is a mesh. Copy or export it again"),
    "prose": mesh_file("a.stl", "Dear colleague,\nthe scan is attached.\n" * 9, r"not an STL file; copy or export"),
    "bytes that are no text": mesh_file(
        "a.stl", b"solid \xff\xfe\nfacet\nvertex \xc3\x28 1 2\nendfacet", r"three numbers"
    ),
    "other format": mesh_file("a.step", "ISO-10303-21;", r'ends in "\.step"; needed is a mesh that ends in \.stl'),
    "no such file": mesh_path(lambda folder: folder / "none.stl", r"none\.stl: no such file; give the path of"),
    "folder": mesh_path(lambda folder: made(folder / "a.stl", Path.mkdir), r"a\.stl: a folder; give an STL"),
    "pipe": mesh_path(lambda folder: made(folder / "a.stl", os.mkfifo), r"a\.stl: a device; give an STL"),
    "dangling link": mesh_path(
        lambda folder: made(folder / "a.stl", lambda path: path.symlink_to(folder / "gone.stl")), r"no such file"
    ),
    "link to itself": mesh_path(
        lambda folder: made(folder / "a.stl", lambda path: path.symlink_to(path)), r"a\.stl: no such file"
    ),
    "name too long": mesh_path(lambda folder: folder / f"{'a' * 300}.stl", r"aaa\.stl: .*no such file|cannot be read"),
    "below a file": mesh_path(lambda folder: part(folder) / "a.stl", r"part\.stl/a\.stl: no such file"),
}


def scene(mesh: trimesh.Trimesh, message: str, *options: object) -> Case:
    """A sound mesh that no camera sees; to the library this is an area of 0."""
    return Case(lambda folder: ("evaluate", put(folder, "a.stl", stl(mesh)), "--cameras", 2, *options), message)


UNSEEN = r"no camera sees any part of a\.stl that counts; check that it lies at the focus .*--scale"
SCENES = {
    "mesh behind the cameras": scene(box(at=(0, 0, 900)), UNSEEN),
    "mesh outside the field of view": scene(box(at=(200, 0, 0)), UNSEEN),
    "mesh around the cameras": scene(box(2000.0), UNSEEN),
    "mesh that looks away": scene(soup([(0, 0, 0), (0, 5, 0), (5, 0, 0)]), UNSEEN),
    "everything excluded": scene(soup(TRIANGLE), UNSEEN, "--exclude", "top"),
    "nothing for optimise": Case(
        lambda folder: ("optimise", put(folder, "a.stl", stl(box(at=(200, 0, 0)))), "--out", folder / "out"),
        r"no camera on this ring sees anything: .*check units, orientation and position of the mesh",
        lambda folder: placement.Problem(box(at=(200, 0, 0)), exact.Ring()),
        placement.PlacementError,
    ),
}
