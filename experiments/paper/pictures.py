"""What each additional number of cameras makes reconstructable, seen from above: data of figures 8 to 10 and 12."""

import base64
import json
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely

import exact
from experiments.files.errors import InputError
from experiments.files.whole import written_whole
from experiments.paper.areas import site_mesh
from experiments.paper.cases import FOV, Case
from experiments.sweeps.task import Task

THRESHOLD = 2
# A face is whole if it lacks no more than rounding.
WHOLE = 1.0 - 1e-12
# Of the display camera: how far above the top surface it stands, in depths of the channel, and by how many millimetres
# the floor's middle lies aside, so that the floor, which perspective makes smaller, still shows within the opening.
DISTANCE, ASIDE = 1.5, 8.0
# Half of what the picture shows of the top surface [mm]: the opening, and all that the cameras see around it.
HALF_WIDTH, OF_ELLIPTICAL, OF_WIDE = 18.5, 22.0, 30.5
# Coordinates are kept in whole micrometres, a tenth of a pixel at most; what is smaller than a hundredth of a square
# millimetre each way is not drawn.
UNIT, LEAST_AREA = 1e-3, 1e-4
# Shades of a colour, from steep to level.
DARKEST, LIGHT = 0.72, (-0.4, -0.5, -0.77)
# Seconds that it takes, in those of an area with one camera: only faces that fewer cameras leave open are looked at.
CAMERAS_WORTH = 150


@dataclass(frozen=True, eq=False)
class Picture:
    """What the display camera shows.

    Attributes
    ----------
    counts : tuple of int
        Numbers of cameras, ascending.
    half_width : float
        The picture reaches this far from its middle [mm at the top surface].
    polygons : (N,) ndarray of object
        In the plane through the middle of the top surface [mm right, mm down], in the order in which to draw them.
    level : (N,) int
        Index of the first of `counts` that reconstructs each; `len(counts)` where none does.
    shade : (N,) float
        Factor of the colour, by the slope of the face.
    """

    counts: tuple[int, ...]
    half_width: float
    polygons: np.ndarray
    level: np.ndarray
    shade: np.ndarray


def display_camera(depth: float, half_width: float) -> exact.Camera:
    """A camera high above a site, slightly tilted, looking at the middle of its top surface; ring angle 0 is right."""
    above = DISTANCE * depth
    target = np.array([0.0, 0.0, depth])
    size = (2 * half_width, 2 * half_width)
    return exact.Camera.look_at(target + above * np.array([0.0, -ASIDE / depth, 1.0]), target, (0, 1, 0), size)


def picture(
    site: str, depth: float, detail: str, mesh_hash: str, fov: Sequence[float], counts: Sequence[int], half_width: float
) -> dict[str, Any]:
    """Compute a picture, packed as `unpacked` reads it.

    Examples
    --------
    >>> case = Case("circ_flat", 50, "36x24")
    >>> shown = unpacked(picture("circ_flat", 50, "coarse", case.mesh_hash("coarse"), (36, 24), [2, 4], 18.5))
    >>> sorted(set(shown.level.tolist()))
    [0, 1, 2]
    """
    mesh = site_mesh(site, depth, detail, mesh_hash)
    camera, ring = display_camera(depth, half_width), exact.Ring(fov=(float(fov[0]), float(fov[1])))
    shown = exact.view(mesh, camera)
    left = shown.face_areas > 0
    parts: list[np.ndarray] = []
    levels: list[np.ndarray] = []
    faces: list[np.ndarray] = []
    for level, n in enumerate(counts):
        # Only what fewer cameras leave open is looked at; the other faces hide what is behind them all the same.
        found = exact.evaluate(mesh, ring.cameras(ring.equidistant(n)), threshold=THRESHOLD, exclude=~left)
        polygons, n_views, face = exact.seen_from(found, camera)
        new = n_views >= THRESHOLD
        parts.append(polygons[new])
        faces.append(face[new])
        levels.append(np.full(int(new.sum()), level))
        left &= found.face_areas < WHOLE * mesh.area_faces
    parts.append(shown.polygons[left])
    faces.append(np.flatnonzero(left))
    levels.append(np.full(int(left.sum()), len(counts)))
    # Fewer cameras are drawn over more, which is right for a point that few reconstruct, whether or not more do.
    polygons, level, face = (np.concatenate(columns[::-1]) for columns in (parts, levels, faces))
    polygons, owner = shapely.get_parts(polygons, return_index=True)
    large = (shapely.area(polygons) > LEAST_AREA) & (shapely.get_dimensions(polygons) == 2)
    polygons, owner = polygons[large], owner[large]
    lamp = camera.rotation.T @ np.array(LIGHT)
    shade = DARKEST + (1 - DARKEST) * np.clip(mesh.face_normals[face[owner]] @ lamp, 0, 1)
    _, coordinates, (rings, owners) = shapely.to_ragged_array(polygons)
    return {
        "counts": list(counts),
        "half_width": half_width,
        "level": _packed(level[owner], "<u1"),
        "shade": _packed(np.round(255 * shade), "<u1"),
        # Steps are small numbers, which pack far better than where they lead.
        "coordinates": _packed(np.diff(np.round(coordinates / UNIT), axis=0, prepend=0.0), "<i4"),
        "rings": _packed(np.diff(rings), "<i4"),
        "polygons": _packed(np.diff(owners), "<i4"),
    }


def unpacked(content: dict[str, Any]) -> Picture:
    """What `picture` has packed."""
    coordinates = UNIT * _unpacked(content["coordinates"], "<i4").reshape(-1, 2).cumsum(axis=0)
    offsets = tuple(np.append(0, _unpacked(content[name], "<i4").cumsum()) for name in ("rings", "polygons"))
    polygons = shapely.from_ragged_array(shapely.GeometryType.POLYGON, coordinates, offsets)
    return Picture(
        tuple(content["counts"]), float(content["half_width"]), np.asarray(polygons),
        _unpacked(content["level"], "<u1").astype(int), _unpacked(content["shade"], "<u1") / 255.0,
    )  # fmt: skip


def picture_tasks(cases: Sequence[Case], counts: Sequence[int], detail: str) -> list[Task]:
    """A task for each case."""
    return [
        Task(
            picture,
            {
                "site": case.site, "depth": case.depth, "detail": detail, "mesh_hash": case.mesh_hash(detail),
                "fov": FOV[case.fov], "counts": list(counts), "half_width": _half_width(case),
            },
            cost=CAMERAS_WORTH,
            packages=("meshes", "exact"),
        )
        for case in cases
    ]  # fmt: skip


def _half_width(case: Case) -> float:
    if case.fov == "60x60":
        return OF_WIDE
    return OF_ELLIPTICAL if case.site == "elliptical" else HALF_WIDTH


def write_picture(folder: Path, case: Case, content: dict[str, Any]) -> None:
    """Keep a picture's data."""
    with written_whole(folder / f"{case.key}.json") as temporary:
        temporary.write_text(json.dumps(content) + "\n", encoding="utf-8")


def read_picture(folder: Path, case: Case) -> Picture | None:
    """What `write_picture` has kept; None if it could not be computed."""
    path = folder / f"{case.key}.json"
    if not path.exists():
        return None
    try:
        return unpacked(json.loads(path.read_text(encoding="utf-8")))
    except (ValueError, KeyError, zlib.error) as error:
        raise InputError(f"{path} cannot be read ({error}); run `camring paper` again without --report-only") from error


def _packed(values: np.ndarray, kind: str) -> str:
    return base64.b64encode(zlib.compress(np.asarray(values).astype(kind).tobytes(), 9)).decode("ascii")


def _unpacked(text: str, kind: str) -> np.ndarray:
    return np.frombuffer(zlib.decompress(base64.b64decode(text)), dtype=kind)
