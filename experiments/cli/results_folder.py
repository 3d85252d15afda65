"""The folder that a command writes into, with a picture of where the ring stands if a place was looked for."""

from collections.abc import Iterable
from pathlib import Path

from experiments.files.whole import output_folder
from experiments.request.meshes import Subject
from experiments.terminal.console import note

PLACE = "place.png"


def results_folder(folder: Path, names: Iterable[str], about: Subject, force: bool) -> None:
    """Make `folder` ready for files of these names, and draw mesh, ring and field of view, before anything is computed.

    Raises
    ------
    InputError
        As by `output_folder`.
    """
    output_folder(folder, (*names, *([PLACE] if about.place else ())), force)
    if about.place is not None and about.ring is not None:
        from experiments.figures.placed import write_place  # matplotlib is heavy, and figures alone need it

        write_place(folder / PLACE, about.name, about.mesh, about.ring)
        note(f"wrote {folder / PLACE}")
