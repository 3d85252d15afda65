"""How a long search says how far it is."""

from collections.abc import Callable

Progress = Callable[[str, int, int], object]
"""Called with what is being done, how many steps of it are done, and how many there are."""


def nothing(what: str, done: int, total: int) -> None:
    """Say nothing."""


def numbered(progress: Progress | None, n_cameras: int) -> Progress | None:
    """The same for one of several numbers of cameras, with the number before what is being done."""
    if progress is None:
        return None
    return lambda what, done, total: progress(f"{n_cameras} cameras: {what}", done, total)
