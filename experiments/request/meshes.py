"""From the words of a command line to meshes, rings and masks."""

import os
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import trimesh

import exact
import meshes
from experiments.files.errors import InputError
from experiments.terminal.console import note
from experiments.terminal.progress import working

if TYPE_CHECKING:  # at run time it would bring jax along, which a mesh alone does not need
    from experiments.request.rig import Rig

# Mesh files say nothing about it: the field of view of Wachter 2021 [mm].
USUAL_FOV = (36.0, 24.0)


@dataclass(frozen=True, eq=False)
class Subject:
    """The surface a command is about.

    Attributes
    ----------
    name : str
        Site and depth, or the file's name.
    mesh : trimesh.Trimesh
    is_site : bool
        Whether it is a built-in reference site.
    fov : (float, float)
        Field of view recommended for it [mm].
    """

    name: str
    mesh: trimesh.Trimesh
    is_site: bool
    fov: tuple[float, float]


def subject(name: str, depth: float | None, detail: str | None, repair: bool = False, scale: float = 1.0) -> Subject:
    """A mesh file, or a built-in site if there is no such file.

    Parameters
    ----------
    name : str
        Path of an STL, OBJ or PLY file, or name of a site, with its depth or without: circ_artery@50.
    depth, detail : float or None, str or None
        Of a built-in site.
    repair, scale : bool, float
        How to load a file: see `meshes.load`. What is odd about it, but no fault, is said on stderr.

    Raises
    ------
    InputError, meshes.MeshError
    """
    if is_site(name):
        return _site(name, depth, detail, scale)
    if depth is not None or detail is not None:
        raise InputError(
            f"--depth and --detail belong to built-in sites, and {name} is not one; "
            f"leave them out, or choose one of {', '.join(meshes.SITES)}"
        )
    if not os.path.exists(name) and not Path(name).suffix:
        raise InputError(
            f"{name}: neither a file nor a built-in site; give the path of an STL, OBJ or PLY file, "
            f"or one of {', '.join(meshes.SITES)}"
        )
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", meshes.MeshWarning)
        mesh = meshes.load(name, repair=repair, scale=scale)
    for warning in caught:
        note(f"warning: {warning.message}")
    return Subject(printable(Path(name).name), mesh, False, USUAL_FOV)


def printable(name: str) -> str:
    r"""A file's name for tables and figures: what is no text, or would start a line, becomes a replacement character.

    Examples
    --------
    >>> printable("scan 3.stl"), printable("scan\n3\udcff.stl")
    ('scan 3.stl', 'scan�3�.stl')
    """
    return "".join(one if one.isprintable() else "�" for one in name)


def is_site(name: str) -> bool:
    """Whether a built-in site is meant, with its depth or without; a file of that name goes first."""
    return name.partition("@")[0] in meshes.SITES and not os.path.exists(name)


def _site(name: str, depth: float | None, detail: str | None, scale: float) -> Subject:
    name, at, own_depth = name.partition("@")
    site = meshes.SITES[name]
    if scale != 1.0:
        raise InputError(f"the built-in site {name} is in millimetres; leave the scale of {scale:g} out")
    if at and depth is not None:
        raise InputError(f"{name}@{own_depth} says the depth, and so does --depth {depth:g}; leave one of them out")
    try:
        depth = float(own_depth) if at else depth
    except ValueError as error:
        raise InputError(
            f"{name}@{own_depth}: after @ stands the depth in millimetres, as in {name}@{site.depths[0]:g}"
        ) from error
    depth = site.depths[0] if depth is None else depth
    with working(f"building {name}"):
        mesh = meshes.site(name, depth=depth, **({} if detail is None else {"detail": detail}))
    return Subject(f"{name}, depth {depth:g} mm", mesh, True, site.fov)


@dataclass(frozen=True, eq=False)
class Exclusion:
    """Faces that are not counted: (F,) bool, and which they are in words."""

    mask: np.ndarray
    words: str


def exclusion(about: Subject, choice: str | None) -> Exclusion:
    """Faces that are not counted.

    Parameters
    ----------
    choice : str or None
        "top" for the top surface, "none", or the path of a text file with one face index per line (from 0). None
        stands for "top" at built-in sites, whose top surface is covered by drapes, and for "none" elsewhere.
    """
    mesh = about.mesh
    choice = ("top" if about.is_site else "none") if choice is None else choice
    if choice == "none":
        return Exclusion(np.zeros(len(mesh.faces), dtype=bool), "nothing")
    if choice == "top":
        mask = meshes.top_surface(mesh)
        return Exclusion(mask, f"the top surface, {mesh.area_faces[mask].sum():.2f} mm²")
    try:
        lines = Path(choice).read_text(encoding="utf-8").split()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"--exclude is {choice!r}; it must be top, none, or a text file with one face index per line"
        ) from error
    mask = np.zeros(len(mesh.faces), dtype=bool)
    for word in lines:
        # Longer ones than that of the last face need no reading, and Python reads no more than 4300 digits.
        if not (word.isascii() and word.isdigit() and len(word) <= len(str(len(mask))) and int(word) < len(mask)):
            raise InputError(
                f"{choice} holds {word[:40]!r}; each line must be a face index from 0 to {len(mask) - 1} for this mesh"
            )
        mask[int(word)] = True
    return Exclusion(mask, f"{mask.sum()} faces listed in {choice}, {mesh.area_faces[mask].sum():.2f} mm²")


@dataclass(frozen=True, eq=False)
class Request:
    """One surface with the ring over it, all words understood."""

    about: Subject
    excluded: Exclusion
    ring: exact.Ring
    rig: "Rig"


def request(name: str, depth: float | None, detail: str | None, rig: "Rig") -> Request:
    """What a command is about: the mesh or site `name` under the ring of `rig` (see `rig_file.rig`).

    Raises
    ------
    InputError, meshes.MeshError, exact.ExactError

    Examples
    --------
    >>> from experiments.request import rig as rig_file
    >>> asked = request("circ_flat", None, "coarse", rig_file.rig(diameter=20.0))
    >>> asked.about.name, asked.ring.diameter, bool(asked.excluded.mask.any())
    ('circ_flat, depth 50 mm', 20.0, True)
    """
    about = subject(name, depth, detail, rig.repair, rig.scale)
    return Request(about, exclusion(about, rig.exclude), rig.ring(about.fov), rig)
