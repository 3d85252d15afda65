"""Write results so that a file is either absent or whole, and never silently replaces another."""

import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from experiments.files.errors import InputError
from experiments.files.folder_lock import hold

# Part of the name of a file that is being written, and of none that a person makes.
MARK = ".camring-"


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """A temporary path in the same folder that becomes `path` when the block ends without an error.

    Raises
    ------
    InputError
        If the file cannot be written, because the disk is full, say; then nothing of it is left.

    Examples
    --------
    >>> folder = Path(tempfile.mkdtemp())
    >>> with written_whole(folder / "areas.csv") as temporary:
    ...     _ = temporary.write_text("face,area_mm2")
    >>> [file.name for file in folder.iterdir()]
    ['areas.csv']
    """
    # The ending stays last: writers of pictures and meshes choose their format by it.
    temporary = None
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem[:40]}{MARK}", suffix=path.suffix)
        os.close(handle)
        temporary = Path(name)
        yield temporary
        os.chmod(temporary, 0o666 & ~_umask())  # mkstemp's own mode lets nobody else read a result
        os.replace(temporary, path)
    except OSError as error:
        raise InputError(
            f"cannot write {path}: {error.strerror or error}; make room, or give another place, and run it "
            "again (with --force over what is written already)"
        ) from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def _remove_remains(folder: Path) -> None:
    """Remove what runs that were killed while they wrote into a folder have left there."""
    for remains in folder.glob(f".*{MARK}????????*"):
        remains.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def output_folder(folder: Path, names: Iterable[str], force: bool) -> Path:
    """Make `folder`, ready for files of these names, before anything is computed.

    Raises
    ------
    InputError
        If it is not a folder, cannot be written to, holds one of the files already and `force` is not given, or
        another run is writing into it.
    """
    names = tuple(names)
    _check_place(folder, names, force)
    hold(folder)
    _remove_remains(folder)
    return folder


def _check_place(folder: Path, names: tuple[str, ...], force: bool) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except FileExistsError as error:
        raise InputError(f"output folder {folder} is a file; give another folder") from error
    except OSError as error:
        raise InputError(f"cannot write to output folder {folder}: {error.strerror}; give another one") from error
    for name in names:
        if (folder / name).is_dir():
            raise InputError(f"{folder / name} is a folder; move it away, or give another place for the results")
    present = [name for name in names if os.path.lexists(folder / name)]
    if present and not force:
        raise InputError(f"{folder} already holds {', '.join(present)}; give another place, or --force to replace them")


def output_file(path: Path, force: bool) -> Path:
    """Make sure that the single file `path` can be written; errors as for `output_folder`."""
    if path.is_dir():
        raise InputError(f"{path} is a folder; give the name of a file")
    _check_place(path.parent, (path.name,), force)
    return path


def image_names(n_cameras: int) -> list[str]:
    """Names of the files with the images of that many cameras, numbered from 1 as cameras are.

    Examples
    --------
    >>> image_names(2)
    ['camera_01.png', 'camera_02.png']
    """
    digits = max(2, len(str(n_cameras)))
    return [f"camera_{number:0{digits}d}.png" for number in range(1, n_cameras + 1)]
