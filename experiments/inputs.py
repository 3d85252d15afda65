"""From the words of a command line to meshes, rings and masks."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

import exact
import meshes
from experiments.errors import InputError
from experiments.progress import working


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


def subject(name: str, depth: float | None, detail: str | None, repair: bool = False) -> Subject:
    """A mesh file, or a built-in site if there is no such file.

    Raises
    ------
    InputError, meshes.MeshError
    """
    if name in meshes.SITES and not Path(name).exists():
        site = meshes.SITES[name]
        depth = site.depths[0] if depth is None else depth
        with working(f"building {name}"):
            mesh = meshes.site(name, depth=depth, **({} if detail is None else {"detail": detail}))
        return Subject(f"{name}, depth {depth:g} mm", mesh, True, site.fov)
    if depth is not None or detail is not None:
        raise InputError(
            f"--depth and --detail belong to built-in sites, and {name} is not one; "
            f"leave them out, or choose one of {', '.join(meshes.SITES)}"
        )
    if not Path(name).exists() and not Path(name).suffix:
        raise InputError(
            f"{name}: neither a file nor a built-in site; give the path of an STL, OBJ or PLY file, "
            f"or one of {', '.join(meshes.SITES)}"
        )
    return Subject(Path(name).name, meshes.load(name, repair=repair), False, (36.0, 24.0))


def parse_fov(text: str) -> tuple[float, float]:
    """Width x height in millimetres.

    Examples
    --------
    >>> parse_fov("36x24")
    (36.0, 24.0)
    """
    match = re.fullmatch(r"\s*([0-9.]+)\s*[x×]\s*([0-9.]+)\s*", text)
    try:
        width, height = (float(part) for part in match.groups()) if match else (0.0, 0.0)
    except ValueError:
        width = height = 0.0
    if width <= 0 or height <= 0:
        raise InputError(f"--fov is {text!r}; it must be width x height in millimetres, both positive, as in 36x24")
    return width, height


def parse_angles(text: str) -> np.ndarray:
    """Ring angles in degrees, separated by commas: (M,) radians.

    Examples
    --------
    >>> np.degrees(parse_angles("0, 90,180")).tolist()
    [0.0, 90.0, 180.0]
    """
    try:
        degrees = np.array([float(part) for part in text.split(",")])
    except ValueError as error:
        raise InputError(f"--angles-deg is {text!r}; it must be numbers separated by commas, as in 0,90,180") from error
    if not np.isfinite(degrees).all():
        raise InputError(f"--angles-deg is {text!r}; every angle must be finite")
    return np.radians(degrees)


def ring(about: Subject, fov: str | None, diameter: float, working_distance: float) -> exact.Ring:
    """The ring of a request; without `fov` the one recommended for the site."""
    size = about.fov if fov is None else parse_fov(fov)
    return exact.Ring(diameter=diameter, working_distance=working_distance, fov=size)


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
        if not (word.isascii() and word.isdigit() and int(word) < len(mask)):
            raise InputError(
                f"{choice} holds {word!r}; each line must be a face index from 0 to {len(mask) - 1} for this mesh"
            )
        mask[int(word)] = True
    return Exclusion(mask, f"{mask.sum()} faces listed in {choice}, {mesh.area_faces[mask].sum():.2f} mm²")
