"""One run at a time writes into a folder: a second one is refused, or files of both would mix."""

import hashlib
from pathlib import Path

import filelock
from platformdirs import user_cache_path

from experiments.files.errors import InputError

_held: dict[Path, filelock.BaseFileLock] = {}


def hold(folder: Path) -> None:
    """Keep other runs of this user out of an output folder, until `release_all` or the end of the process.

    The lock lies in the user's cache folder, so that results hold nothing but results; the operating system takes it
    back from a run that was killed.

    Raises
    ------
    InputError
        If another run holds the folder.

    Examples
    --------
    >>> import tempfile
    >>> hold(Path(tempfile.mkdtemp()))
    >>> release_all()
    """
    folder = folder.resolve()
    if folder in _held:
        return
    name = hashlib.sha256(str(folder).encode(errors="surrogateescape")).hexdigest()[:32]
    path = user_cache_path("camring") / "folders" / f"{name}.lock"
    lock = filelock.FileLock(path, blocking=False)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        lock.acquire()
    except filelock.Timeout as error:
        raise InputError(
            f"another run of camring is writing into {folder}; wait until it is done, or give another folder"
        ) from error
    except OSError:
        return  # without a cache folder there is nobody to ask, and results matter more
    _held[folder] = lock


def release_all() -> None:
    """Let other runs have the folders that this one held."""
    while _held:
        _held.popitem()[1].release()
