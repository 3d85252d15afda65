"""The formats a layout can be exported to: what each is for, which files it makes, and how they are written.

A further format is one more file in this folder and one more entry of `FORMATS`.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import cast

from experiments.exports import camera_table, colmap, gltf, opencv, transforms
from experiments.exports.cameras import NamedCamera
from experiments.files.errors import InputError
from experiments.files.whole import output_folder
from experiments.request.meshes import Subject


@dataclass(frozen=True)
class Format:
    """A format: what it is for, its files below the output folder, and their writer.

    `write` takes the output folder, the cameras and the site; the site is None unless `needs_site`.
    """

    purpose: str
    files: tuple[str, ...]
    write: Callable[[Path, Sequence[NamedCamera], Subject | None], None]
    needs_site: bool = False


FORMATS = {
    "colmap": Format(
        "COLMAP text model",
        tuple(f"colmap/{name}" for name in colmap.FILES),
        lambda folder, cameras, site: colmap.write(folder / "colmap", cameras),
    ),
    "transforms": Format(
        "nerfstudio",
        ("transforms.json",),
        lambda folder, cameras, site: transforms.write(folder / "transforms.json", cameras),
    ),
    "opencv": Format(
        "K, R, t as JSON",
        ("opencv.json",),
        lambda folder, cameras, site: opencv.write(folder / "opencv.json", cameras),
    ),
    "glb": Format(
        "site and cameras for Blender and viewers of glTF",
        ("site_and_cameras.glb",),
        lambda folder, cameras, site: gltf.site_and_cameras(
            folder / "site_and_cameras.glb", cast(Subject, site), cameras
        ),
        needs_site=True,
    ),
    "csv": Format(
        "table of the cameras",
        ("cameras.csv",),
        lambda folder, cameras, site: camera_table.write(folder / "cameras.csv", cameras),
    ),
}
# Other words people use for the same.
OTHER_WORDS = {
    "nerfstudio": "transforms",
    "instant-ngp": "transforms",
    "gltf": "glb",
    "blender": "glb",
    "cv2": "opencv",
}


def parse_formats(text: str, option: str, known: Iterable[str] = FORMATS) -> tuple[str, ...]:
    """Names of formats separated by commas, each once.

    Raises
    ------
    InputError
        If one is not known; the message lists those that are and suggests the nearest.

    Examples
    --------
    >>> parse_formats("colmap, CSV,colmap", "--format")
    ('colmap', 'csv')
    """
    known = tuple(known)
    names = []
    for word in text.split(","):
        name = word.strip().lower()
        if name not in known:
            near = get_close_matches(name, (*known, *OTHER_WORDS), n=1)
            meant = OTHER_WORDS.get(near[0], near[0]) if near else None
            raise InputError(
                f"{option}: there is no format {word.strip()!r}; choose from {', '.join(known)}"
                + (f". Did you mean {meant}?" if meant in known else "")
            )
        names.append(name)
    return tuple(dict.fromkeys(names))


def prepare(folder: Path, names: Iterable[str], force: bool) -> tuple[str, ...]:
    """Make `folder` ready for these formats before anything is computed; the files that they will write."""
    files = tuple(file for name in names for file in FORMATS[name].files)
    by_folder: dict[Path, list[str]] = {}
    for file in files:
        by_folder.setdefault((folder / file).parent, []).append(Path(file).name)
    for place, inside in by_folder.items():
        output_folder(place, inside, force)
    return files


def write(folder: Path, names: Iterable[str], cameras: Sequence[NamedCamera], site: Subject | None) -> None:
    """Write these formats into `folder`, which is prepared."""
    for name in names:
        FORMATS[name].write(folder, cameras, site)
