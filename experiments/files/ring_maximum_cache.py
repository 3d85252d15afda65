"""Ring maxima of earlier runs, so that the next question about the same site starts searching at once."""

from pathlib import Path

import numpy as np
from platformdirs import user_cache_path

from experiments.files.errors import InputError
from experiments.files.whole import written_whole


class RememberedAreas:
    """Areas [mm²] by what they depend on, one small file each; a folder that cannot be used is done without.

    Parameters
    ----------
    folder : Path, optional
        By default in the user's cache folder.

    Examples
    --------
    >>> import tempfile
    >>> areas = RememberedAreas(Path(tempfile.mkdtemp()))
    >>> areas["one"] = 0.1
    >>> areas.get("one"), areas.get("another")
    (0.1, None)
    """

    def __init__(self, folder: Path | None = None):
        self._folder = user_cache_path("camring") / "ring_maxima" if folder is None else folder

    def get(self, key: str) -> float | None:
        """The area, or None if it is not known."""
        try:
            area = float.fromhex((self._folder / key).read_text("ascii"))
        except (OSError, ValueError):
            return None
        return area if 0 < area < np.inf else None

    def __setitem__(self, key: str, area: float) -> None:
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            with written_whole(self._folder / key) as temporary:
                temporary.write_text(area.hex(), "ascii")
        except (OSError, InputError):
            pass  # it will be evaluated anew
