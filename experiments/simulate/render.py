"""What a camera sees of a surface, rendered by Mitsuba 3: pinhole or thin lens, lamps, a texture in space."""

import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import trimesh

import exact
from experiments.files.errors import InputError
from experiments.simulate.texture import N_VOXELS, VOXELS_OF_A_GRAIN, tissue

# Variants of Mitsuba, the quickest first; the last runs anywhere.
VARIANTS = ("llvm_ad_rgb", "scalar_rgb")
# Brightness of what is white, and faces the lamps at the distance of the focus.
WHITE = 0.8
# How the noise is turned against all axes, so that it repeats along no line of an image: axis, and angle [degrees].
TURNED = ([1.0, 2.0, 3.0], 37.0)
# Width and height of a pixel that differ by less than this part are rounding of the number of pixels.
SQUARE = 1e-3
# What the lens lets through: nothing nearer than this part of the focus distance, nothing farther than so many of it.
NEAREST, FARTHEST = 1e-3, 1e3
# How long the trial of a variant may take [s].
PATIENCE = 120.0
TRIAL = "from experiments.simulate.render import try_out; import sys; try_out(sys.argv[1])"


@dataclass(frozen=True, eq=False)
class Stage:
    """All that an image depends on, beside the camera.

    Attributes
    ----------
    mesh : trimesh.Trimesh
        With whatever hides it.
    colours : (F, 3) ndarray or None
        Reflectance of each face, from 0 to 1; None for tissue.
    lamps : (L, 3) ndarray
        Points from which light comes, all equally bright at the focus [mm].
    focus : (3,) ndarray
        Where white is white [mm].
    optics : exact.Optics
    grain : float
        Size of the finest grains [mm].
    rays : int
        Rays of a pixel.
    seed : int
    """

    mesh: trimesh.Trimesh
    colours: np.ndarray | None
    lamps: np.ndarray
    focus: np.ndarray
    optics: exact.Optics
    grain: float
    rays: int
    seed: int


def refuse_oblong_pixels(camera: exact.Camera, optics: exact.Optics) -> None:
    """Refuse pixels that are wider than high, which no sensor has and the renderer does not.

    Raises
    ------
    InputError
    """
    wide, high = optics.focal(camera)
    if abs(wide / high - 1) > SQUARE:
        width, height = optics.resolution
        fits = round(width * camera.fov[1] / camera.fov[0])
        raise InputError(
            f"{width} x {height} pixels over {camera.fov[0]:g} x {camera.fov[1]:g} mm are not square; give --pixels "
            f"{width}x{fits}, or another field of view"
        )


class Renderer:
    """Renders the images of one stage.

    Parameters
    ----------
    stage : Stage
    variant : str
        Of Mitsuba: see `best_variant`.
    """

    def __init__(self, stage: Stage, variant: str):
        import mitsuba as mi  # it brings threads along, which processes that only fork must not have

        mi.set_variant(variant)
        self._mi, self._stage = mi, stage
        self._shape = self._mesh()

    def light(self, camera: exact.Camera, seed: int) -> np.ndarray:
        """(H, W, 3) light on the sensor of a camera, 1 for white; `seed` is that of its rays.

        Each lamp is rendered by itself and has as many rays: drawn by lot, lamps that a grazing surface hides from
        would make it flicker.
        """
        lamps, total = self._stage.lamps, 0.0
        rays = -(-self._stage.rays // len(lamps))
        sensor = self._sensor(camera, rays)
        for number, lamp in enumerate(lamps):
            distance = np.linalg.norm(lamp - self._stage.focus)
            power = WHITE * np.pi * float(distance) ** 2 / len(lamps)
            scene = self._mi.load_dict({
                "type": "scene",
                "integrator": {"type": "direct", "bsdf_samples": 0, "emitter_samples": 1},
                "surface": self._shape,
                "sensor": sensor,
                "lamp": {"type": "point", "position": lamp.tolist(), "intensity": {"type": "rgb", "value": power}},
            })  # fmt: skip
            total = total + np.array(self._mi.render(scene, spp=rays, seed=seed * len(lamps) + number))  # type: ignore[arg-type]
        return np.asarray(total)

    def _mesh(self) -> Any:
        mi, mesh, colours = self._mi, self._stage.mesh, self._stage.colours
        properties = mi.Properties()
        reflectance = self._tissue() if colours is None else {"type": "mesh_attribute", "name": "face_color"}
        properties["bsdf"] = mi.load_dict({"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": reflectance}})
        made = mi.Mesh("surface", len(mesh.vertices), len(mesh.faces), props=properties)
        if colours is not None:
            made.add_attribute("face_color", 3, np.asarray(colours, dtype=np.float32).ravel())
        values = mi.traverse(made)
        values["vertex_positions"] = np.asarray(mesh.vertices, dtype=np.float32).ravel()
        values["faces"] = np.asarray(mesh.faces, dtype=np.uint32).ravel()
        values.update()
        return made

    def _tissue(self) -> dict[str, Any]:
        mi = self._mi
        size = N_VOXELS * self._stage.grain / VOXELS_OF_A_GRAIN
        return {
            "type": "volume",
            "volume": {
                "type": "gridvolume", "grid": mi.VolumeGrid(tissue(self._stage.seed)), "wrap_mode": "repeat",
                "raw": True, "to_world": mi.ScalarTransform4f().rotate(*TURNED).scale([size] * 3),
            },
        }  # fmt: skip

    def _sensor(self, camera: exact.Camera, rays: int) -> Any:
        """The camera as Mitsuba has it: it looks along its z, with x to the left and y up."""
        mi, optics = self._mi, self._stage.optics
        right, down, look = camera.rotation
        pose = np.eye(4)
        pose[:3] = np.stack([-right, -down, look, camera.position], axis=1)
        focus = camera.target_distance if optics.focus_distance is None else optics.focus_distance
        width, height = optics.resolution
        lens = {"type": "perspective"} if optics.pupil is None else {
            "type": "thinlens", "aperture_radius": optics.pupil / 2, "focus_distance": focus,
        }  # fmt: skip
        return mi.load_dict(lens | {
            "fov": float(np.degrees(2 * np.arctan(camera.half_extent[0]))), "fov_axis": "x",
            "near_clip": NEAREST * focus, "far_clip": FARTHEST * focus, "to_world": mi.ScalarTransform4f(pose),
            "film": {
                "type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"},
                "pixel_format": "rgb", "component_format": "float32",
            },
            "sampler": {"type": "independent", "sample_count": rays},
        })  # fmt: skip


@cache
def best_variant() -> str:
    """The quickest variant of Mitsuba that runs on this machine.

    One that compiles is tried in a process of its own: with a compiler that it does not go with, it takes its process
    along.
    """
    for variant in VARIANTS[:-1]:
        try:
            tried = subprocess.run(
                [sys.executable, "-c", TRIAL, variant], capture_output=True, timeout=PATIENCE, check=False
            )
        except subprocess.TimeoutExpired:
            continue
        if tried.returncode == 0:
            return variant
    return VARIANTS[-1]


def try_out(variant: str) -> None:
    """Render a small image of everything there is with a variant."""
    plate = trimesh.creation.box((30.0, 30.0, 1.0))
    lamps, focus = np.array([[0.0, 0.0, 400.0]]), np.zeros(3)
    cameras: Sequence[exact.Camera] = exact.Ring().cameras([0.0])
    for pupil, colours in ((None, None), (4.0, np.full((len(plate.faces), 3), 0.5))):
        optics = exact.Optics(resolution=(12, 8), pupil=pupil)
        stage = Stage(plate, colours, lamps, focus, optics, grain=0.1, rays=2, seed=0)
        light = Renderer(stage, variant).light(cameras[0], seed=0)
        if not (np.isfinite(light).all() and light.max() > 0):
            raise SystemExit(1)
