"""Where a ring of cameras should stand over a mesh that lies anywhere: which side to look at, and which point."""

from dataclasses import dataclass

import numpy as np
import trimesh

from meshes.condition.mending import mended
from meshes.errors import MeshError
from meshes.placing.poses import Pose, RingShape, better, levelled, views
from meshes.placing.sides import sides
from meshes.placing.sight import Sight, Surface, across

# Points on the surface while a side is looked for, or so many on what is in view at once, but no more than that.
COARSE, IN_WINDOW, MOST_COARSE = 5_000, 30, 40_000
# Points around the axis, out to this many fields of view, while its place is made better, and for what is said of it.
MIDDLE, FINE, NEAR = 4_000, 20_000, 2.0
# Digits after the point of what is found [mm] and of unit vectors, which turn the ring by less than 0.01 mm.
DIGITS, UNIT_DIGITS = 3, 5


@dataclass(frozen=True)
class Place:
    """Where a ring stands over a mesh.

    Attributes
    ----------
    focus : (float, float, float)
        The point that all cameras look at [mm].
    axis : (float, float, float)
        Direction from it to the ring's centre.
    zero_towards : (float, float, float)
        Direction in which ring angle 0 lies, across the axis.
    at : str
        What the focus is in the middle of: "the floor of a hollow" or "the surface in view".
    area : float
        Area that at least two of sixteen places on the ring see of the front [mm²], estimated at points.
    share : float
        The same as a part of the mesh's.
    """

    focus: tuple[float, float, float]
    axis: tuple[float, float, float]
    zero_towards: tuple[float, float, float]
    at: str
    area: float
    share: float


def place(
    mesh: trimesh.Trimesh,
    *,
    diameter: float = 30.0,
    working_distance: float = 400.0,
    fov: tuple[float, float] = (36.0, 24.0),
) -> Place:
    """Find where a ring should stand over a mesh, however it lies.

    It looks into the hollow of which most is seen, or, of a surface without one, at the side of which most is seen;
    from where most of it is in view; with the focus on the floor of a deep hollow, else in the middle of what is in
    view. Ring angle 0 is chosen so that the longer side of the field of view lies along the greatest length of what is
    seen there. Turning and shifting the mesh turns and shifts the place with it.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        Its fronts are looked at. Left as it is.
    diameter, working_distance, fov : float, float, (float, float)
        Of the ring [mm], as for `exact.Ring`, which takes what is found: ``Ring(focus=found.focus, axis=found.axis,
        zero_towards=found.zero_towards)``.

    Raises
    ------
    MeshError
        If the mesh has no face with area, a length is not positive, or nothing is seen from any side.

    Examples
    --------
    >>> cup = trimesh.creation.revolve([(0, -6), (9, -6), (9, 14), (8, 14), (8, -5), (0, -5)], sections=24)
    >>> _ = cup.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0], [0, 0, 0]))
    >>> found = place(cup)
    >>> (np.round(found.axis, 1) + 0.0).tolist(), found.at
    ([0.0, -1.0, 0.0], 'the floor of a hollow')
    """
    ring = RingShape(_length("diameter", diameter), _length("working_distance", working_distance),
                      (_length("fov width", fov[0]), _length("fov height", fov[1])))  # fmt: skip
    found = mended(mesh, "mesh")
    surface = Surface(found.vertices, found.faces)
    n_windows = surface.areas.sum() / (np.pi * ring.inner**2)
    from_afar = Sight(surface, int(np.clip(IN_WINDOW * n_windows, COARSE, MOST_COARSE)))
    poses = []
    for side in sides(from_afar, ring):
        poses.append(better(Sight(surface, MIDDLE, side.focus, side.axis, NEAR * ring.outer), ring, side))
    best = max(poses, key=lambda pose: pose.worth)
    return _told(Sight(surface, FINE, best.focus, best.axis, NEAR * ring.outer), ring, best)


def _length(name: str, value: float) -> float:
    if not (isinstance(value, int | float | np.number) and 0 < value < np.inf):
        raise MeshError(f"{name} is {value!r}; needed is a positive number of millimetres")
    return float(value)


def _told(sight: Sight, ring: RingShape, pose: Pose) -> Place:
    """With ring angle 0, in numbers that can be written down; they are what holds."""
    pose = levelled(sight, ring, pose)
    axis, focus = _rounded(pose.axis, UNIT_DIGITS), _rounded(pose.focus, DIGITS)
    unit = np.array(axis) / np.linalg.norm(axis)
    seen = views(sight, ring, np.array(focus), unit).sum(axis=0) >= 2
    if not seen.any():
        raise MeshError("no part of the mesh is seen from two places of the ring; it may be too small or too far")
    points, worth = sight.points[seen], sight.worth[seen]
    plane = np.column_stack(across(unit))
    flat = (points - worth @ points / worth.sum()) @ plane
    _, directions = np.linalg.eigh((worth * flat.T) @ flat)
    # The camera at ring angle 0 has the width of its image across the direction to it.
    zero = directions[:, 0 if ring.fov[0] >= ring.fov[1] else 1]
    zero = plane @ (zero if worth @ (flat @ zero) ** 3 >= 0 else -zero)
    area = float(worth.sum())
    return Place(
        focus, axis, _rounded(zero, UNIT_DIGITS),
        "the floor of a hollow" if pose.deep else "the surface in view",
        round(area, 3), round(area / float(sight.surface.areas.sum()), 5),
    )  # fmt: skip


def _rounded(vector: np.ndarray, digits: int) -> tuple[float, float, float]:
    x, y, z = (np.round(vector, digits) + 0.0).tolist()
    return x, y, z
