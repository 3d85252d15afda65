"""glTF binary (GLB): coloured surfaces and cameras for Blender and other viewers.

glTF is in metres and has y up: a world point (x, y, z) in millimetres is written as (x, z, -y) / 1000, which Blender
turns back into (x, y, z) / 1000. A glTF camera looks along its -z with y up. The file says all this in its extras.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from trimesh.exchange.gltf import export_glb
from trimesh.path import Path3D
from trimesh.path.entities import Line

from experiments.exports.cameras import NamedCamera
from experiments.files.whole import written_whole
from experiments.request.meshes import Subject

# World axes [mm] to those of glTF [m].
TO_GLTF = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]) / 1000
CONVENTIONS = {
    "unit": "metre",
    "up": "+y",
    "to_millimetres_and_z_up": "x = 1000 X, y = -1000 Z, z = 1000 Y",
}
SITE_COLOUR = (0.80, 0.74, 0.68)
FRUSTUM_COLOUR = (0.12, 0.37, 0.66)
# What a camera shows in a viewer lies between these multiples of the distance to its target.
NEAR, FAR = 0.01, 10.0


@dataclass(frozen=True, eq=False)
class Part:
    """A surface or lines [mm] with a name and one sRGB colour, each number from 0 to 1."""

    name: str
    shape: trimesh.Trimesh | Path3D
    colour: Sequence[float]


def write(path: Path, parts: Sequence[Part], cameras: Sequence[NamedCamera] = ()) -> None:
    """Write the parts, those without faces left out, and the cameras as cameras of glTF."""
    scene = trimesh.Scene(metadata=dict(CONVENTIONS))
    shown = {}
    for part in parts:
        shape = part.shape
        if isinstance(shape, trimesh.Trimesh):
            if not len(shape.faces):
                continue
            # A mesh made anew carries no metadata, such as the path of the file that it came from.
            shape = trimesh.Trimesh(shape.vertices @ TO_GLTF.T, shape.faces, process=False)
        else:
            shape = Path3D(shape.entities, shape.vertices @ TO_GLTF.T, process=False)
        scene.add_geometry(shape, node_name=part.name, geom_name=part.name)
        shown[part.name] = part

    def finish(tree: dict[str, Any]) -> None:
        tree["asset"]["generator"] = "camring"
        tree["materials"] = [_material(shown[mesh["name"]]) for mesh in tree["meshes"]]
        for number, mesh in enumerate(tree["meshes"]):
            for primitive in mesh["primitives"]:
                primitive["material"] = number
        if cameras:
            first = len(tree["nodes"])
            tree["cameras"] = [_lens(camera) for camera in cameras]
            tree["nodes"] += [_node(number, camera) for number, camera in enumerate(cameras)]
            tree["scenes"][0]["nodes"] += range(first, len(tree["nodes"]))

    with written_whole(path) as temporary:
        temporary.write_bytes(export_glb(scene, include_normals=False, tree_postprocessor=finish))


def site_and_cameras(path: Path, site: Subject, cameras: Sequence[NamedCamera]) -> None:
    """Write a site, the cameras, and the frustum of each as lines from its centre to its field of view."""
    frusta = [Part(f"{camera.name} frustum", _frustum(camera), FRUSTUM_COLOUR) for camera in cameras]
    write(path, [Part(site.name, site.mesh, SITE_COLOUR), *frusta], cameras)


def _material(part: Part) -> dict[str, Any]:
    srgb = np.array(part.colour, dtype=np.float64)
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)  # glTF's colours are linear
    return {
        "name": part.name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [*linear.tolist(), 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": 1.0,
        },
        "doubleSided": True,
    }


def _lens(camera: NamedCamera) -> dict[str, Any]:
    half_width, half_height = camera.camera.half_extent.tolist()
    distance = camera.camera.target_distance / 1000
    perspective = {
        "aspectRatio": half_width / half_height,
        "yfov": 2 * float(np.arctan(half_height)),
        "znear": NEAR * distance,
        "zfar": FAR * distance,
    }
    return {"name": camera.name, "type": "perspective", "perspective": perspective}


def _node(number: int, camera: NamedCamera) -> dict[str, Any]:
    matrix = np.eye(4)
    matrix[:3] = TO_GLTF @ camera.to_world[:3] + 0.0
    matrix[:3, :3] *= 1000  # axes have length 1 in any unit
    (width, height), (fx, fy, cx, cy) = camera.size, camera.pinhole
    extras = {"image": camera.image, "ring_angle_deg": float(np.degrees(camera.angle)),
              "width": width, "height": height, "fx": fx, "fy": fy, "cx": cx, "cy": cy}  # fmt: skip
    return {"name": camera.name, "camera": number, "matrix": matrix.T.ravel().tolist(), "extras": extras}


def _frustum(camera: NamedCamera) -> Path3D:
    """Lines from the centre to the corners of the field of view at the target, its outline, and a mark at its top."""
    pinhole = camera.camera
    x, y = 0.5 * pinhole.fov
    flat = np.array([[-x, -y], [x, -y], [x, y], [-x, y], [-0.2 * x, -y], [0.0, -1.3 * y], [0.2 * x, -y]])
    local = np.column_stack([flat, np.full(len(flat), pinhole.target_distance)])
    corners = pinhole.position + local @ pinhole.rotation
    lines = [[0, 1], [0, 2], [0, 3], [0, 4], [1, 2, 3, 4, 1], [5, 6, 7]]
    entities = [Line(line) for line in lines]
    return Path3D(entities, np.vstack([pinhole.position, corners]), process=False)
