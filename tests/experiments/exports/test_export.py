"""camring export: independent readers of each format project the same points to the same pixels."""

import csv
import json
import re

import cv2
import numpy as np
import pycolmap
import pygltflib
import pytest
import trimesh

import exact
import meshes
from experiments.cli.app import main

PIXELS = 1e-6  # required of every round trip; the formats carry float64, and 1e-11 is what they reach
SINGLE = 1e-6  # relative: positions in a GLB are float32
LAYOUTS = {
    "usual": ({"diameter_mm": 30, "working_distance_mm": 400, "fov_mm": [36, 24]}, [90, 180, 270, 360], None),
    # Tilted, off the origin, pixels that are not square.
    "tilted": (
        {"diameter_mm": 55, "working_distance_mm": 210, "fov_mm": [50, 41], "focus_mm": [3, -4, 12.5],
         "axis": [0.3, -0.2, 1]},
        [7.5, 100, 215.25],
        (1017, 640),
    ),
    # Half a turn, where a rotation's angle is 0 or 180 degrees, and no camera is upright.
    "from below": (
        {"diameter_mm": 30, "working_distance_mm": 400, "fov_mm": [60, 60], "axis": [0, 0, -1]},
        [0, 180],
        None,
    ),
    "one direction": (
        {"diameter_mm": 40, "working_distance_mm": 300, "fov_mm": [60, 40], "axis": [0.1, 0.2, 1], "roll": 0.7},
        [30, 200],
        None,
    ),
    "rolls of their own": (
        {"diameter_mm": 40, "working_distance_mm": 300, "fov_mm": [60, 40], "roll": "tangential"},
        [30, 200, 300],
        None,
        [-35.0, 12.5, 100.0],
    ),
}  # fmt: skip
ALL = "colmap,transforms,opencv,glb,csv"


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    path = tmp_path_factory.mktemp("scans") / "plate & box.stl"
    parts = [trimesh.creation.box((30, 30, 2)), trimesh.creation.box((4, 30, 20))]
    trimesh.boolean.union(parts, engine="manifold").export(path)
    return path


def write_layout(path, ring, angles_deg, mesh=None, rolls_deg=None):
    content = {"format": "camring layout", "version": 1, "ring": ring, "angles_deg": angles_deg}
    content |= {} if rolls_deg is None else {"rolls_deg": rolls_deg}
    path.write_text(json.dumps(content | ({} if mesh is None else {"mesh": mesh})), encoding="utf-8")
    return path


class Exported:
    """A layout with everything exported from it, and where its cameras see some points according to `exact`."""

    def __init__(self, folder, name, scan):
        ring, angles, resolution, *rolls = LAYOUTS[name]
        write_layout(folder / "layout.json", ring, angles, None, *rolls)
        self.folder, self.scan, self.angles_deg = folder / "out", scan, angles
        size = [] if resolution is None else ["--resolution", f"{resolution[0]}x{resolution[1]}"]
        with pytest.raises(SystemExit) as end:
            main(["export", str(folder / "layout.json"), "--format", ALL, "--mesh", str(scan), *size,
                  "--out", str(self.folder)])  # fmt: skip
        assert not end.value.code
        made = exact.Ring(
            ring["diameter_mm"], ring["working_distance_mm"], tuple(ring["fov_mm"]),
            ring.get("focus_mm", (0, 0, 0)), ring.get("axis", (0, 0, 1)), roll=ring.get("roll", "radial"),
        )  # fmt: skip
        rolls = [np.radians(one) for one in rolls]
        self.resolution = resolution or (3600, round(3600 * made.fov[1] / made.fov[0]))
        self.points = np.array(made.focus) + np.random.default_rng(7).uniform(-25, 25, (200, 3))
        self.cameras = [
            exact.Camera(c.position, c.rotation, c.target_distance, c.fov, np.array(self.resolution, dtype=float))
            for c in made.cameras(np.radians(angles), *rolls)
        ]
        self.names = [f"camera_{number:02d}" for number in range(1, len(angles) + 1)]

    def check(self, pixels):
        """Compare with (M, N, 2) pixels, the upper left corner of the image at (0, 0)."""
        expected = np.array([camera.project(self.points) for camera in self.cameras])
        assert np.isfinite(expected).all()
        assert np.ptp(expected, axis=1).min() > 100  # the points are all over the image
        np.testing.assert_allclose(np.array(pixels), expected, rtol=0, atol=PIXELS)


@pytest.fixture(scope="module", params=LAYOUTS)
def exported(request, tmp_path_factory, scan):
    return Exported(tmp_path_factory.mktemp("exported"), request.param, scan)


def test_colmap_reads_the_same_cameras(exported):
    model = pycolmap.Reconstruction(str(exported.folder / "colmap"))
    images = [model.images[number] for number in sorted(model.images)]
    assert [image.name for image in images] == [f"{name}.png" for name in exported.names]
    assert model.num_points3D() == 0
    assert len({image.camera_id for image in images}) == len(images)
    for image in images:
        camera = model.cameras[image.camera_id]
        assert camera.model.name == "PINHOLE"
        assert (camera.width, camera.height) == exported.resolution
        camera.verify_params()
    exported.check([[image.project_point(point) for point in exported.points] for image in images])


def test_transforms_follow_opengl(exported):
    content = json.loads((exported.folder / "transforms.json").read_text(encoding="utf-8"))
    pixels = []
    for frame, name in zip(content["frames"], exported.names, strict=True):
        assert frame["file_path"] == f"images/{name}.png"
        assert (frame["w"], frame["h"]) == exported.resolution
        to_world = np.array(frame["transform_matrix"])
        assert np.linalg.det(to_world[:3, :3]) == pytest.approx(1)
        x, y, z = (np.linalg.inv(to_world) @ np.vstack([exported.points.T, np.ones(len(exported.points))]))[:3]
        assert (z < 0).all()  # it looks along -z
        across, up = frame["fl_x"] * x / -z, frame["fl_y"] * y / -z
        pixels.append(np.stack([frame["cx"] + across, frame["cy"] - up], axis=1))
    exported.check(pixels)


def test_opencv_projects_the_same(exported):
    content = json.loads((exported.folder / "opencv.json").read_text(encoding="utf-8"))
    assert [camera["name"] for camera in content["cameras"]] == exported.names
    pixels = []
    for camera in content["cameras"]:
        assert (camera["width"], camera["height"]) == exported.resolution
        turn, matrix, shift = np.array(camera["R"]), np.array(camera["K"]), np.array(camera["t"])
        projected, _ = cv2.projectPoints(
            exported.points, cv2.Rodrigues(turn)[0], shift, matrix, np.array(camera["distortion"])
        )
        pixels.append(projected[:, 0] + 0.5)  # OpenCV's (0, 0) is the centre of the first pixel
    exported.check(pixels)


def test_table_says_the_same(exported):
    with (exported.folder / "cameras.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["camera"] for row in rows] == exported.names
    assert [row["image"] for row in rows] == [f"{name}.png" for name in exported.names]
    pixels = []
    assert [float(row["ring_angle_deg"]) for row in rows] == pytest.approx(exported.angles_deg)
    for row in rows:
        assert (int(row["width_px"]), int(row["height_px"])) == exported.resolution
        away = exported.points - [float(row[f"{axis}_mm"]) for axis in "xyz"]
        right, down, depth = (
            away @ [float(row[f"{direction}_{axis}"]) for axis in "xyz"] for direction in ("right", "down", "look")
        )
        pixels.append(
            np.stack(
                [
                    float(row["cx_px"]) + float(row["fx_px"]) * right / depth,
                    float(row["cy_px"]) + float(row["fy_px"]) * down / depth,
                ],
                axis=1,
            )
        )
    exported.check(pixels)


def in_millimetres(points):
    """World points [mm, z up] from those of a GLB [m, y up]."""
    return 1000 * np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1)


def accessor(file, number):
    """(N, k) what an accessor of a GLB holds; none of ours is interleaved or starts inside its view."""
    told = file.accessors[number]
    view = file.bufferViews[told.bufferView]
    kind, width = {5126: "<f4", 5125: "<u4"}[told.componentType], {"VEC3": 3, "SCALAR": 1}[told.type]
    start = (view.byteOffset or 0) + (told.byteOffset or 0)
    return np.frombuffer(file.binary_blob(), kind, told.count * width, start).reshape(-1, width)


def test_gltf_cameras_project_the_same(exported):
    file = pygltflib.GLTF2().load(exported.folder / "site_and_cameras.glb")
    assert file.scenes[0].extras["unit"] == "metre"
    nodes = [node for node in file.nodes if node.camera is not None]
    assert [node.name for node in nodes] == exported.names
    assert [node.extras["ring_angle_deg"] for node in nodes] == pytest.approx(exported.angles_deg)
    roots = {file.nodes[number].name for number in file.scenes[0].nodes}
    assert set(exported.names) <= roots  # their matrices are those of the world
    gltf_points = np.stack([exported.points[:, 0], exported.points[:, 2], -exported.points[:, 1]]) / 1000
    pixels = []
    for node in nodes:
        lens = file.cameras[node.camera].perspective
        matrix = np.array(node.matrix).reshape(4, 4).T
        assert np.linalg.det(matrix[:3, :3]) == pytest.approx(1)  # no scale: glTF cameras must not have one
        x, y, z = (np.linalg.inv(matrix) @ np.vstack([gltf_points, np.ones(len(exported.points))]))[:3]
        assert (lens.znear < -z).all()
        assert (-z < lens.zfar).all()
        half_height = np.tan(lens.yfov / 2)
        sideways, upward = x / -z / (half_height * lens.aspectRatio), y / -z / half_height
        width, height = node.extras["width"], node.extras["height"]
        assert (width, height) == exported.resolution
        pixels.append(np.stack([(1 + sideways) * width / 2, (1 - upward) * height / 2], axis=1))
    exported.check(pixels)


def test_gltf_shows_the_site_and_each_frustum(exported):
    file = pygltflib.GLTF2().load(exported.folder / "site_and_cameras.glb")
    shapes = {file.meshes[node.mesh].name: file.meshes[node.mesh] for node in file.nodes if node.mesh is not None}
    assert set(shapes) == {exported.scan.name, *(f"{name} frustum" for name in exported.names)}
    site = shapes[exported.scan.name].primitives[0]
    corners = in_millimetres(accessor(file, site.attributes.POSITION).astype(float))
    mesh = meshes.load(exported.scan)
    np.testing.assert_allclose(corners[accessor(file, site.indices)[:, 0]], mesh.triangles.reshape(-1, 3), atol=1e-5)
    width, height = exported.resolution
    for camera, name in zip(exported.cameras, exported.names, strict=True):
        lines = shapes[f"{name} frustum"].primitives[0]
        assert lines.mode == pygltflib.LINES
        ends = in_millimetres(accessor(file, lines.attributes.POSITION).astype(float))
        tolerance = SINGLE * np.abs(ends).max()
        at_centre = np.linalg.norm(ends - camera.position, axis=1) < tolerance
        assert at_centre.sum() == 4
        seen = camera.project(ends[~at_centre])
        for corner in [(0, 0), (width, 0), (width, height), (0, height)]:
            assert (np.linalg.norm(seen - corner, axis=1) < 0.01).any()
        assert seen[:, 1].min() < -0.1 * height  # the mark says which way is up
    # Nothing tells where the site's file lay.
    assert str(exported.scan.parent).encode() not in (exported.folder / "site_and_cameras.glb").read_bytes()


def test_more_than_99_cameras_sort_by_name(camring, tmp_path):
    layout = write_layout(tmp_path / "layout.json", LAYOUTS["usual"][0], np.linspace(1, 360, 120).tolist())
    status, out, _ = camring("export", layout, "--format", "csv", "--out", tmp_path / "out")
    assert status == 0
    assert "120 cameras, 3600 x 2400 pixels each" in out
    with (tmp_path / "out" / "cameras.csv").open(encoding="utf-8", newline="") as file:
        names = [row["camera"] for row in csv.DictReader(file)]
    assert names == sorted(names)
    assert names[-1] == "camera_120"


@pytest.fixture
def layout(tmp_path):
    return write_layout(tmp_path / "layout.json", *LAYOUTS["usual"][:2])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--format", "colmp"], "no format 'colmp'; choose from colmap, .*, csv. Did you mean colmap"),
        (["--format", "csv,Nerfstudio"], "no format 'Nerfstudio'.* Did you mean transforms"),
        (["--format", "csv,"], "no format ''; choose from colmap"),
        (["--format", "zzz"], "choose from colmap, transforms, opencv, glb, csv$"),
        (["--format", "mesh"], "camring evaluate MESH --layout"),
        (["--format", "csv,glb"], "give the mesh that the layout was made for, as in --mesh scan.stl"),
        (["--format", "csv", "--mesh", "circ_flat"], "--mesh is for glb only"),
        (["--format", "csv", "--depth", "50"], "give --mesh too, or leave them out"),
        (["--format", "csv", "--resolution", "0x600"], "--resolution is '0x600'; it must be width x height"),
        (["--format", "csv", "--resolution", "36x24.5"], "whole pixels, as in 3600x2400"),
        (["--format", "csv", "--resolution", "big"], "--resolution is 'big'"),
    ],
)  # fmt: skip
def test_refusals(camring, layout, tmp_path, arguments, said):
    status, out, err = camring("export", layout, *arguments, "--out", tmp_path / "out")
    assert (status, out) == (2, "")
    assert re.search(said, err.strip().replace("\n", " "))
    assert not (tmp_path / "out").exists()


def test_a_file_that_is_no_layout_is_refused(camring, scan, tmp_path):
    (tmp_path / "other.json").write_text("{}", encoding="utf-8")
    assert "is not a layout file" in camring("export", tmp_path / "other.json", "--format", "csv")[2]
    assert "cannot read layout" in camring("export", tmp_path / "none.json", "--format", "csv")[2]


def test_a_file_in_the_place_of_a_folder_is_refused(camring, layout, tmp_path):
    (tmp_path / "taken").write_text("mine", encoding="utf-8")
    status, _, err = camring("export", layout, "--format", "csv", "--out", tmp_path / "taken")
    assert status == 2
    assert "taken is a file; give another folder" in err
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "colmap").write_text("mine", encoding="utf-8")
    status, _, err = camring("export", layout, "--format", "csv,colmap", "--out", tmp_path / "out", "--force")
    assert status == 2
    assert "colmap is a file" in err
    assert (tmp_path / "out" / "colmap").read_text(encoding="utf-8") == "mine"
    assert not (tmp_path / "out" / "cameras.csv").exists()


def test_nothing_is_replaced_without_force(camring, layout, tmp_path):
    arguments = ("export", layout, "--format", "colmap,csv", "--out", tmp_path / "out")
    assert camring(*arguments)[0] == 0
    (tmp_path / "out" / "colmap" / "images.txt").write_text("mine", encoding="utf-8")
    (tmp_path / "out" / "cameras.csv").unlink()
    status, _, err = camring(*arguments)
    assert status == 2
    assert "already holds cameras.txt, images.txt, points3D.txt" in err
    assert (tmp_path / "out" / "colmap" / "images.txt").read_text(encoding="utf-8") == "mine"
    assert camring(*arguments, "--force")[0] == 0
    assert len(pycolmap.Reconstruction(str(tmp_path / "out" / "colmap")).images) == 4


def test_the_site_must_be_the_one_of_the_layout(camring, scan, tmp_path):
    ring, angles, _ = LAYOUTS["usual"]
    mesh = {"name": "plate & box.stl", "sha256": meshes.fingerprint(meshes.load(scan))}
    layout = write_layout(tmp_path / "layout.json", ring, angles, mesh)
    status, _, err = camring("export", layout, "--format", "glb", "--out", tmp_path / "out")
    assert status == 2
    assert "give the mesh, 'plate & box.stl', that the layout was made for" in err.replace("\n", " ")
    other = (
        "export",
        layout,
        "--format",
        "glb",
        "--mesh",
        "circ_flat",
        "--detail",
        "coarse",
        "--out",
        tmp_path / "out",
    )
    status, _, err = camring(*other)
    assert status == 2
    assert "was made for 'plate & box.stl', and circ_flat, depth 50 mm is not the same mesh" in err.replace("\n", " ")
    assert not (tmp_path / "out").exists()
    assert camring(*other, "--force")[0] == 0
    assert camring("export", layout, "--format", "glb", "--mesh", scan, "--out", tmp_path / "right")[0] == 0


def test_a_site_in_metres_is_read_as_for_the_layout(camring, scan, tmp_path):
    mesh = meshes.load(scan)
    trimesh.Trimesh(mesh.vertices / 1000, mesh.faces).export(tmp_path / "metres.stl")
    ring, angles, _ = LAYOUTS["usual"]
    made_for = {"sha256": meshes.fingerprint(meshes.load(tmp_path / "metres.stl", scale=1000)), "scale": 1000}
    layout = write_layout(tmp_path / "layout.json", ring, angles, made_for)
    arguments = ("export", layout, "--format", "glb", "--out", tmp_path / "out", "--mesh")
    assert camring(*arguments, tmp_path / "metres.stl")[0] == 0
    file = pygltflib.GLTF2().load(tmp_path / "out" / "site_and_cameras.glb")
    corners = in_millimetres(accessor(file, file.meshes[0].primitives[0].attributes.POSITION).astype(float))
    assert np.ptp(corners, axis=0) == pytest.approx([30, 30, 20], rel=SINGLE)
    assert "is not the same mesh" in camring(*arguments, "circ_flat")[2]
    write_layout(tmp_path / "layout.json", ring, angles, made_for | {"scale": "metres"})
    assert '"scale" of its "mesh" is \'metres\'; it must be a positive number' in camring(*arguments, scan)[2]


def test_json_names_cameras_and_files(camring, layout, tmp_path):
    status, out, err = camring("export", layout, "--format", "colmap,csv", "--out", tmp_path / "out", "--json")
    told = json.loads(out)
    assert status == 0
    assert told["cameras"] == ["camera_01", "camera_02", "camera_03", "camera_04"]
    assert told["resolution_px"] == [3600, 2400]
    assert sorted(told["files"]) == sorted(str(file) for file in (tmp_path / "out").rglob("*.*"))
    assert "wrote" in err
