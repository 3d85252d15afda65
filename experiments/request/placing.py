"""A ring put over a mesh that lies anywhere: what `--place auto` does, and how it is said."""

from dataclasses import asdict, replace
from typing import Any

import trimesh

import exact
import meshes
from experiments.terminal.progress import working


def over(mesh: trimesh.Trimesh, ring: exact.Ring) -> tuple[exact.Ring, meshes.Place]:
    """The ring moved over a mesh, and what was found.

    Raises
    ------
    MeshError

    Examples
    --------
    >>> sheet = trimesh.creation.box((9, 9, 1)).slice_plane((0, 0, 0.4), (0, 0, 1))
    >>> _ = sheet.apply_translation((300, 0, 0))
    >>> ring, place = over(sheet, exact.Ring(diameter=20.0))
    >>> ring.diameter, round(ring.focus[0]), place.at
    (20.0, 300, 'the surface in view')
    """
    with working("looking for a place for the ring"):
        return placed(mesh, ring)


def placed(mesh: trimesh.Trimesh, ring: exact.Ring) -> tuple[exact.Ring, meshes.Place]:
    """The same without a word to the terminal."""
    found = meshes.place(mesh, diameter=ring.diameter, working_distance=ring.working_distance, fov=ring.fov)
    return replace(ring, focus=found.focus, axis=found.axis, zero_towards=found.zero_towards), found


def moved_with(demand: exact.Demand, before: exact.Ring, after: exact.Ring) -> exact.Demand:
    """What makes a point count once the ring stands elsewhere: depth that is along its axis stays so.

    Examples
    --------
    >>> demand = exact.Demand(depth_axis=(0.0, 0.0, 1.0))
    >>> moved_with(demand, exact.Ring(), exact.Ring(axis=(0.0, 1.0, 0.0))).depth_axis
    (0.0, 1.0, 0.0)
    """
    return replace(demand, depth_axis=after.axis) if demand.depth_axis == before.axis else demand


def before_repair(mesh: trimesh.Trimesh, repair: bool, name: str, two_sided: bool) -> trimesh.Trimesh:
    """The mesh on which a place is looked for, repaired as far as that goes without knowing where the cameras are."""
    try:
        return meshes.check(mesh.copy(), repair, name, two_sided=two_sided)
    except meshes.MeshError:  # what is wrong may be where no camera looks
        return mesh


def options(place: meshes.Place) -> str:
    """The options that give the same ring.

    Examples
    --------
    >>> options(meshes.Place((0.0, 1.5, -2.0), (0.0, 0.6, 0.8), (1.0, 0.0, 0.0), "the surface in view", 9.0, 0.5))
    '--focus=0,1.5,-2 --axis=0,0.6,0.8 --zero-towards=1,0,0'
    """
    given = {"focus": place.focus, "axis": place.axis, "zero-towards": place.zero_towards}
    return " ".join(f"--{name}={','.join(f'{one:.10g}' for one in vector)}" for name, vector in given.items())


def words(place: meshes.Place) -> str:
    """What was found, for the person at the command line."""
    return (
        f"the cameras look at {place.at}, and {100 * place.share:.3g} % of the mesh, some {place.area:.4g} mm², are in "
        f"view of two of them at least; the same again with {options(place)}"
    )


def content(place: meshes.Place | None) -> dict[str, Any] | None:
    """What was found, as it stands in results; None where nothing was looked for."""
    if place is None:
        return None
    found = {"focus": "focus_mm", "area": "area_mm2"}
    return {found.get(name, name): value for name, value in asdict(place).items()} | {"options": options(place)}
