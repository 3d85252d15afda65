"""Tables as CSV files."""

import csv
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from experiments.files.whole import written_whole


def write_table(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write rows, which all have the keys of the first; lists of numbers are separated by blanks."""
    with written_whole(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        for row in rows:
            lists = {name: " ".join(map(repr, value)) for name, value in row.items() if isinstance(value, list)}
            writer.writerow({**row, **lists})


def finite(number: float) -> float | None:
    """None for what JSON cannot hold and a table leaves empty.

    Examples
    --------
    >>> finite(0.5), finite(math.inf)
    (0.5, None)
    """
    return number if math.isfinite(number) else None
