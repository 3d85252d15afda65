"""Bad input of every kind, and what the command line says to it.

Each case is a function of an empty folder, which it fills, and gives the arguments of `camring`; with the words that
the one message on stderr must hold, and, where a library call reads the same input, that call and its exception.
"""

import json
import os
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

import exact
import meshes
import placement
from experiments.files.errors import InputError
from experiments.request import layout_file
from experiments.request import rig as rig_file


@dataclass(frozen=True)
class Case:
    """Arguments to be refused, the words of the refusal, and the library call that refuses the same."""

    arguments: Callable[[Path], Sequence[object]]
    message: str
    library: Callable[[Path], object] | None = None
    error: type[Exception] = InputError


def box(size: float = 10.0, at: Sequence[float] = (0, 0, 0)) -> trimesh.Trimesh:
    return trimesh.creation.box((size, size, size)).apply_translation(at)


def stl(mesh: trimesh.Trimesh) -> bytes:
    return meshes.stl_bytes(mesh)


def changed(place: int, number: float) -> bytes:
    """A box of which one coordinate, counted from the first corner's x, is another number."""
    data = bytearray(stl(box()))
    struct.pack_into("<f", data, 84 + 12 + 4 * place, number)
    return bytes(data)


def soup(corners: object) -> trimesh.Trimesh:
    corners = np.asarray(corners, dtype=float).reshape(-1, 3)
    return trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False)


def wound(faces: slice) -> trimesh.Trimesh:
    mesh = box()
    turned = mesh.faces.copy()
    turned[faces] = turned[faces, ::-1]
    return trimesh.Trimesh(mesh.vertices, turned, process=False)


def put(folder: Path, name: str, content: bytes | str) -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def part(folder: Path) -> Path:
    """A sound mesh, for cases in which something else is wrong."""
    return put(folder, "part.stl", stl(box()))


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


def made(path: Path, make: Callable[[Path], object]) -> Path:
    if not os.path.lexists(path):
        make(path)
    return path


ASCII = (
    "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 5 0 0\nvertex 0 5 0\nendloop\nendfacet\nendsolid\n"
)
PLY = (
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n5 0 0\n0 5 0\n3 0 1 2\n"
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

RING = {"diameter_mm": 30, "working_distance_mm": 400, "fov_mm": [36, 24]}
LAYOUT = {"format": "camring layout", "version": 1, "ring": RING, "angles_deg": [0, 180], "threshold": 2}


def layout(message: str, *without: str, **changes: object) -> Case:
    """A layout file of which some fields are other than they should be, or not there."""
    content = {name: value for name, value in (LAYOUT | changes).items() if name not in without}
    return layout_text(json.dumps(content), message)


def layout_text(content: bytes | str, message: str) -> Case:
    return Case(
        lambda folder: ("evaluate", part(folder), "--layout", put(folder, "my.json", content)),
        message,
        lambda folder: layout_file.read(folder / "my.json"),
    )


def ring(**changes: object) -> dict[str, object]:
    return RING | changes


LAYOUTS = {
    "no layout file": Case(
        lambda folder: ("evaluate", part(folder), "--layout", folder / "my.json"),
        r"cannot read layout .*my\.json: No such file",
        lambda folder: layout_file.read(folder / "my.json"),
    ),
    "layout is a folder": Case(
        lambda folder: ("evaluate", part(folder), "--layout", folder),
        r"cannot read layout .*: Is a directory",
        layout_file.read,
    ),
    "layout cut short": layout_text(json.dumps(LAYOUT)[:-9], r"my\.json is not a layout file: it holds no valid JSON"),
    "layout of bytes": layout_text(b"\xff\xfe\x00", r"holds no valid JSON"),
    "layout nested without end": layout_text("[" * 200_000, r"holds no valid JSON"),
    "layout number of many digits": layout_text(
        json.dumps(LAYOUT).replace("180", "1" * 5000), r"my\.json is not a layout file: it holds no valid JSON"
    ),
    "layout is a list": layout_text("[1, 2]", r'is not a layout file: "format" must be "camring layout"'),
    "layout is another file": layout_text('{"name": "box"}', r'"format" must be .*camring optimise writes one'),
    "layout of a newer version": layout(r"has layout version 2; only 1 is known: update camring", version=2),
    "layout without version": layout(r"has layout version None; only 1 is known", "version"),
    "layout version true": layout(r"has layout version True; only 1 is known", version=True),
    "layout without ring": layout(r'my\.json: "ring" must give diameter_mm', "ring"),
    "layout with half a ring": layout(
        r'"ring" must give diameter_mm, working_distance_mm and fov_mm', ring={"fov_mm": 1}
    ),
    "layout with a word for a diameter": layout(
        r"diameter.* is 'wide'; it must be a number", ring=ring(diameter_mm="wide")
    ),
    "layout with a truth for a diameter": layout(
        r"diameter.* is True; it must be a number", ring=ring(diameter_mm=True)
    ),
    "layout with no diameter at all": layout(r"diameter.* is 0; it must be positive", ring=ring(diameter_mm=0)),
    "layout of a ring beyond the moon": layout(
        r"diameter is 1e\+300 mm; .*at most 1e\+09", ring=ring(diameter_mm=1e300)
    ),
    "layout of a ring of many digits": layout(
        r"working distance is inf; it must be positive and finite", ring=ring(working_distance_mm=10**400)
    ),
    "layout with a negative field of view": layout(
        r"fov height is -24.*; it must be positive", ring=ring(fov_mm=[36, -24])
    ),
    "layout with one number for a field of view": layout(r"fov is 36; it must be 2", ring=ring(fov_mm=36)),
    "layout with an infinite focus": layout(
        r"focus is .*; it must be 3 finite numbers", ring=ring(focus_mm=[0, 0, float("inf")])
    ),
    "layout with no axis": layout(r"ring axis is the zero vector", ring=ring(axis=[0, 0, 0])),
    "layout with a misspelt part of a ring": layout(
        r"there is no field 'focus' in \"ring\"; did you mean focus_mm\?", ring=ring(focus=[0, 0, 1])
    ),
    "layout with a misspelt field": layout(r"there is no field 'treshold'; did you mean threshold\?", treshold=1),
    "layout without angles": layout(r"gives no ring angles", "angles_deg"),
    "layout without any angle": layout(r'"angles_deg" must be a list of at least one number', angles_deg=[]),
    "layout with words for angles": layout(r'"angles_deg" must be a list', angles_deg=["north", "south"]),
    "layout with one number for angles": layout(r'"angles_rad" must be a list', angles_rad=1.0),
    "layout angle not a number": layout(r"ring angles .* finite", angles_deg=[0, float("nan")]),
    "layout angle of 1e300": layout(r"ring angle 2 is 1\.7.*e\+298 rad; .*at most", angles_deg=[0, 1e300]),
    "layout angle of many digits": layout(r"ring angles?.*", angles_deg=[0, 10**400]),
    "layout angles that disagree": layout(
        r'"angles_deg" and "angles_rad" are not the same angles; leave one of them out', angles_rad=[0.0, 3.0]
    ),
    "layout of another number of cameras": layout(r'"n_cameras" is 3, and there are 2 ring angles', n_cameras=3),
    "layout with T = 0": layout(r'"threshold" is 0; it must be a whole number from 1 to 2', threshold=0),
    "layout with T > M": layout(r'"threshold" is 3; it must be a whole number from 1 to 2', threshold=3),
    "layout with half a threshold": layout(r'"threshold" is 1\.5; it must be', threshold=1.5),
    "layout with constraints of another kind": layout(r'"constraints" is \[5\]; it must give some of', constraints=[5]),
    "layout with a negative baseline": layout(r"min_baseline is -1", constraints={"min_baseline": -1}),
    "layout with a word for a baseline": layout(r"min_baseline is 'no'", constraints={"min_baseline": "no"}),
    "layout with a baseline wider than the ring": layout(
        r"no two cameras are 31 mm apart on a ring of 30 mm", constraints={"min_baseline": 31}
    ),
    "layout with a mesh of another kind": layout(r'"mesh" is .*; it must give .*sha256', mesh=["a.stl"]),
    "layout made for another mesh": Case(
        lambda folder: (
            "evaluate",
            part(folder),
            "--layout",
            put(folder, "my.json", json.dumps(LAYOUT | {"mesh": {"name": "other.stl", "sha256": "0" * 64}})),
        ),
        r"my\.json was made for 'other\.stl', and part\.stl is not the same mesh; give that one, or --force",
    ),
    "layouts made for another mesh": Case(
        lambda folder: (
            "compare",
            put(folder, "a.json", json.dumps(LAYOUT)),
            put(folder, "b.json", json.dumps(LAYOUT | {"mesh": {"name": "other.stl", "sha256": "0" * 64}})),
            "--mesh",
            part(folder),
        ),
        r"b\.json was made for 'other\.stl', and part\.stl is not the same mesh; give that one, or --force",
    ),
}


def rig(content: bytes | str, message: str, error: type[Exception] = InputError) -> Case:
    return Case(
        lambda folder: ("optimise", part(folder), "--rig", put(folder, "rig.toml", content), "--out", folder / "out"),
        message,
        lambda folder: rig_file.rig(folder / "rig.toml").ring((36.0, 24.0)),
        error,
    )


RIGS = {
    "no rig file": Case(
        lambda folder: ("optimise", part(folder), "--rig", folder / "no.toml"),
        r"cannot read rig file .*no\.toml: No such file .*; camring rig init writes one",
        lambda folder: rig_file.read(folder / "no.toml"),
    ),
    "misspelt key": rig("[ring]\ndiametre = 30\n", r"no key 'diametre' in \[ring\]; did you mean diameter\?"),
    "misspelt section": rig("[camera]\ncount = 3\n", r"no section \[camera\]; did you mean \[cameras\]\?"),
    "key in the wrong section": rig("[ring]\ncount = 3\n", r"count in \[ring\] is in the wrong place; .*\[cameras\]"),
    "key twice": rig("[ring]\ndiameter = 30\ndiameter = 31\n", r"holds no valid TOML"),
    "rig of bytes": rig(b"\xff\xfe", r"rig\.toml is not a rig file: it holds no valid TOML"),
    "rig nested without end": rig("a = " + "[" * 100_000, r"rig\.toml is not a rig file: it holds no valid TOML"),
    "words for a number": rig("[ring]\ndiameter = 'wide'\n", r"diameter in \[ring\] is 'wide'; it must be a number"),
    "number of many digits": rig(f"[ring]\ndiameter = {10**400}\n", r"diameter in \[ring\] is 1000.*must be a number"),
    "digits without end": rig(f"[ring]\ndiameter = {'1' * 5000}\n", r"rig\.toml is not a rig file"),
    "a number that is none": rig(
        "[constraints]\nmin_separation = nan\n", r"min_separation .* is nan; it must be a number"
    ),
    "part of a camera": rig("[cameras]\ncount = 2.5\n", r"count in \[cameras\] is 2\.5; it must be a whole number"),
    "fixed camera at 1e300": rig("[constraints]\nfixed_deg = [1e300]\n", r"fixed .*at most", placement.PlacementError),
    "ring without width": rig("[ring]\ndiameter = 0\n", r"ring diameter is 0.*; it must be positive", exact.ExactError),
    "focus on the ring": rig(
        "[ring]\ndiameter = 1e-200\nworking_distance = 1e-200\n",
        r"diameter is 1e-200.*at least 1e-09",
        exact.ExactError,
    ),
    "ring lost in a far focus": rig("[ring]\nfocus = [0, 0, 1e18]\n", r"focus is .*at most 1e\+09", exact.ExactError),
}


def evaluated(message: str, *options: object, library: Callable[[], object] | None = None) -> Case:
    return Case(
        lambda folder: ("evaluate", part(folder), *options),
        message,
        None if library is None else lambda folder: library(),
        exact.ExactError,
    )


def optimised(message: str, *options: object) -> Case:
    return Case(lambda folder: ("optimise", part(folder), "--out", folder / "out", *options), message)


OPTIONS = {
    "angle not a number": evaluated(r"--angles-deg is '0,nan'; every angle must be finite", "--angles-deg", "0,nan"),
    "angle of 1e300": evaluated(
        r"ring angle 2 is 1.*e\+\d+ rad; .*at most",
        "--angles-deg",
        "0,1e300",
        library=lambda: exact.Ring().cameras([0, 1e300]),
    ),
    "T = 0": evaluated(r"threshold is 0; it must be a whole number, at least 1", "--cameras", 2, "--threshold", 0),
    "T > M": evaluated(r"threshold is 3 with 2 cameras.*lower the threshold", "--cameras", 2, "--threshold", 3),
    "no camera": evaluated(r"number of cameras is 0; .*at least 1", "--cameras", 0),
    "a billion cameras": evaluated(r"number of cameras is 1000000000; .*at most", "--cameras", 10**9),
    "field of view of 0": evaluated(r"--fov is '0x24'; .*both positive", "--cameras", 2, "--fov", "0x24"),
    "negative field of view": evaluated(r"--fov is '-36x24'; .*both positive", "--cameras", 2, "--fov", "-36x24"),
    "endless field of view": evaluated(r"--fov is .*both positive", "--cameras", 2, "--fov", f"{'9' * 400}x24"),
    "ring diameter not a number": evaluated(
        r"ring diameter is nan; it must be positive and finite",
        "--cameras",
        2,
        "--diameter",
        "nan",
        library=lambda: exact.Ring(diameter=float("nan")),
    ),
    "ring in the plane of the focus": evaluated(
        r"working distance is 0.*; it must be positive",
        "--cameras",
        2,
        "--working-distance",
        0,
        library=lambda: exact.Ring(working_distance=0),
    ),
    "baseline not a number": evaluated(r"min_baseline is nan; it must be", "--cameras", 2, "--min-baseline", "nan"),
    "baseline wider than the ring": evaluated(r"no two cameras are 40 mm apart", "--cameras", 2, "--min-baseline", 40),
    "scale not a number": evaluated(r"scale is nan; needed is a positive number", "--cameras", 2, "--scale", "nan"),
    "target of 99": evaluated(r"--target is 99; it must be a fraction", "--cameras", 2, "--target", 99),
    "target not a number": evaluated(r"--target is nan; it must be a fraction", "--cameras", 2, "--target", "nan"),
    "depth of a file": evaluated(r"--depth and --detail belong to built-in sites", "--cameras", 2, "--depth", 50),
    "excluded faces not there": evaluated(
        r"--exclude is 'tpo'; it must be top, none", "--cameras", 2, "--exclude", "tpo"
    ),
    "cameras twice": evaluated(r"exactly one way", "--cameras", 2, "--angles-deg", "0,90"),
    "option misspelt": evaluated(r"No such option: --camera", "--camera", 2),
    "words for a number of cameras": evaluated(r"--cameras'?: .*valid integer", "--cameras", "two"),
    "separation not a number": optimised(r"min_separation is nan; it must be", "--min-separation", "nan"),
    "negative separation": optimised(r"min_separation is -1.*at least 0", "--min-separation", -1),
    "housings wider than the ring": optimised(
        r"12 cameras at 10 mm need a ring", "--cameras", 12, "--min-separation", 10
    ),
    "a billion cameras side by side": optimised(r"1000000000; .*at most", "--cameras", 10**9, "--min-separation", 0),
    "fixed cameras in one place": optimised(
        r"fixed .*0 mm apart|at 0 mm|two fixed", "--cameras", 3, "--fixed-deg", "10,10"
    ),
    "no place left": optimised(r"forbidden", "--cameras", 3, "--forbidden-deg", "0:180,180:360"),
    "no weight at all": optimised(r"--site-weights is '0'; it must be", "--site-weights", "0"),
    "weights for more meshes": optimised(r"site_weights are .* there are 1 mesh", "--site-weights", "1,2"),
    "no objective": optimised(r"objective is 'best'; it must be", "--objective", "best"),
    "negative seed": optimised(r"seed is -1; it must be a whole number, at least 0", "--seed", -1),
    "no pose": optimised(r"poses is 0|jitter.* is 0; it must be", "--jitter", 0),
    "a tilt without end": optimised(r"tilt.* is inf", "--jitter", 2, "--tilt-deg", "inf"),
    "light that falls off at once": optimised(r"distance is 0|falloff.* is 0", "--falloff-mm", 0),
    "unknown export": optimised(r"there is no format 'colmp'.*Did you mean colmap\?", "--export", "colmp"),
}


def listed(name: str, content: bytes | str, message: str) -> Case:
    return Case(
        lambda folder: ("evaluate", part(folder), "--cameras", 2, "--exclude", put(folder, name, content)), message
    )


EXCLUDED = {
    "index of no face": listed("f.txt", "0\n12\n", r"f\.txt holds '12'; each line must be a face index from 0 to 11"),
    "index below 0": listed("f.txt", "-1\n", r"f\.txt holds '-1'; each line must be"),
    "index of many digits": listed("f.txt", "1" * 5000, r"f\.txt holds '111.*; each line must be"),
    "indices of bytes": listed("f.txt", b"\xff\xfe", r"--exclude is .*f\.txt'; it must be top, none, or a text file"),
}


def output(make: Callable[[Path], Path], message: str, *command: object) -> Case:
    """A place where no result can be put."""
    command = command or ("evaluate", "--cameras", 2)
    return Case(
        lambda folder: (command[0], part(folder), *command[1:], "--out", make(folder)),
        message,
    )


OUTPUTS = {
    "output folder is a file": output(lambda folder: put(folder, "taken", b"mine"), r"taken is a file; give another"),
    "output folder below a file": output(
        lambda folder: put(folder, "taken", b"mine") / "out", r"cannot write to output folder .*out: Not a directory"
    ),
    "output folder is a dangling link": output(
        lambda folder: made(folder / "out", lambda path: path.symlink_to(folder / "gone")), r"out is .*; give another"
    ),
    "output folder of an impossible name": output(lambda folder: folder / ("o" * 300), r"File name too long; give"),
    "results are there": output(
        lambda folder: put(made(folder / "out", Path.mkdir), "evaluation.json", b"mine").parent,
        r"out already holds evaluation\.json; give another place, or --force",
    ),
    "a folder where a result belongs": output(
        lambda folder: made(folder / "out" / "evaluation.json", lambda path: path.mkdir(parents=True)).parent,
        r"evaluation\.json is a folder; move it away",
        "evaluate",
        "--cameras",
        2,
        "--force",
    ),
}

CASES = MESHES | SCENES | LAYOUTS | RIGS | OPTIONS | EXCLUDED | OUTPUTS
