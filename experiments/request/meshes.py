"""From the words of a command line to meshes, rings and masks."""

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

import exact
import meshes
import placement
from experiments.files.errors import InputError
from experiments.request import placing
from experiments.request.outlook import forecast, places, unit_words, warnings_about
from experiments.terminal.console import note
from experiments.terminal.progress import working
from meshes.condition import overlapping
from meshes.load import unit_hint

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
    warnings : tuple of str
        Why an answer about it is likely not what is meant.
    ring : exact.Ring or None
        The ring that looks at it, as far as one was given.
    place : meshes.Place or None
        What was found, if a place for the ring was looked for.
    """

    name: str
    mesh: trimesh.Trimesh
    is_site: bool
    fov: tuple[float, float]
    warnings: tuple[str, ...] = ()
    ring: exact.Ring | None = None
    place: meshes.Place | None = None

    @property
    def told(self) -> dict[str, Any]:
        """What is to be known of the mesh, as it stands in results."""
        kept = self.mesh.metadata
        return {
            "notes": list(kept.get("notes", ())),
            "repairs": list(kept.get("repairs", ())),
            "warnings": list(self.warnings),
            "place": placing.content(self.place),
        }


def subject(
    name: str,
    depth: float | None,
    detail: str | None,
    repair: bool = False,
    scale: float = 1.0,
    two_sided: bool = False,
    ring: exact.Ring | None = None,
    place: bool = False,
) -> Subject:
    """A mesh file, or a built-in site if there is no such file.

    Parameters
    ----------
    name : str
        Path of an STL, OBJ, PLY or OFF file, or name of a site, with its depth or without: circ_artery@50.
    depth, detail : float or None, str or None
        Of a built-in site.
    repair, scale, two_sided : bool, float, bool
        How to load a file: see `meshes.load`. What is odd about it, but no fault, is said on stderr.
    ring : exact.Ring, optional
        From where the surface is looked at.
    place : bool
        Look for a place for that ring; where it is is said on stderr.

    Raises
    ------
    InputError, meshes.MeshError
    """
    if is_site(name):
        built = _site(name, depth, detail, scale)
        return _placed(built, name, *placing.over(built.mesh, ring)) if place and ring else replace(built, ring=ring)
    if depth is not None or detail is not None:
        raise InputError(
            f"--depth and --detail belong to built-in sites, and {name} is not one; "
            f"leave them out, or choose one of {', '.join(meshes.SITES)}"
        )
    if not os.path.exists(name) and not Path(name).suffix:
        raise InputError(
            f"{name}: neither a file nor a built-in site; give the path of an STL, OBJ, PLY or OFF file, "
            f"or one of {', '.join(meshes.SITES)}"
        )
    mesh, found = meshes.read(name, scale), None
    if place and ring is not None:
        ring, found = placing.over(placing.before_repair(mesh, repair, name, two_sided), ring)
    seen_from = None if ring is None else places(ring)
    mesh = meshes.check(mesh, repair, name, two_sided=two_sided, seen_from=seen_from)
    # Where a place was found, nothing else says that a mesh is small for the field of view.
    hint = (unit_hint if found is None else unit_words)(float(mesh.extents.max()), scale)
    on_top = overlapping.words(
        overlapping.overlapping(np.asarray(mesh.vertices), np.asarray(mesh.faces)), meshes.file_faces(mesh)[0]
    )
    warned = [f"{name}: {words}" for words in (hint, on_top) if words]
    if ring is not None:
        warned += warnings_about(name, mesh, ring)
    about = Subject(printable(Path(name).name), mesh, False, USUAL_FOV, tuple(warned), ring)
    if found is not None and ring is not None:
        about = _placed(about, name, ring, found)
    for kind, words in (("note", about.told["notes"]), ("repaired", about.told["repairs"])):
        if words:
            note(f"{kind}: {name}: {'; '.join(words)}")
    for words in about.warnings:
        note(f"warning: {words}")
    few = placement.Settings().for_faces(len(mesh.faces))
    if few != placement.Settings():
        note(
            f"note: {name}: {len(mesh.faces)} faces; one layout of eight cameras takes {forecast(len(mesh.faces))}; a "
            f"search scores few layouts exactly, polishes none and takes {few.ring_cameras} cameras for the ring "
            "maximum (most_faces among the settings of a rig file)"
        )
    return about


def _placed(about: Subject, name: str, ring: exact.Ring, place: meshes.Place) -> Subject:
    """The same under a ring for which a place was found, which is said."""
    note(f"placed: {name}: {placing.words(place)}")
    return replace(about, ring=ring, place=place)


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
        "top" for the top surface, which lies highest along the ring's axis where a place was found for it, "none", or
        the path of a text file with one face index per line (from 0). These count the faces of the mesh's file,
        whatever a repair removed. None stands for "top" at built-in sites, whose top surface is covered by drapes, and
        for "none" elsewhere.
    """
    mesh = about.mesh
    choice = ("top" if about.is_site else "none") if choice is None else choice
    if choice == "none":
        return Exclusion(np.zeros(len(mesh.faces), dtype=bool), "nothing")
    if choice == "top":
        mask = meshes.top_surface(mesh, about.place.axis if about.place and not about.is_site else None)
        return Exclusion(mask, f"the top surface, {mesh.area_faces[mask].sum():.2f} mm²")
    try:
        lines = Path(choice).read_text(encoding="utf-8").split()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"--exclude is {choice!r}; it must be top, none, or a text file with one face index per line"
        ) from error
    number, n_in_file = meshes.file_faces(mesh)
    listed = np.zeros(n_in_file, dtype=bool)
    for word in lines:
        # Longer ones than that of the last face need no reading, and Python reads no more than 4300 digits.
        if not (word.isascii() and word.isdigit() and len(word) <= len(str(n_in_file)) and int(word) < n_in_file):
            raise InputError(
                f"{choice} holds {word[:40]!r}; each line must be a face index from 0 to {n_in_file - 1} for this mesh"
            )
        listed[int(word)] = True
    mask = listed[number]
    return Exclusion(mask, f"{listed.sum()} faces listed in {choice}, {mesh.area_faces[mask].sum():.2f} mm²")
