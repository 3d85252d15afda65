"""Plain words and tables on the terminal: nothing in brackets is taken for markup, and pipes get the full width.

Results go to stdout, as tables for people or as one JSON document for machines; notes go to stderr.
"""

import json
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

# Columns of output that goes to a file or a pipe, where nothing tells how wide it may be.
PIPE_WIDTH = 110


def terminal(stderr: bool = False) -> Console:
    """A console for results, or for notes with `stderr`."""
    console = Console(stderr=stderr, highlight=False, markup=False)
    if not console.is_terminal:
        console.width = max(console.width, PIPE_WIDTH)
    return console


def table(*headers: str) -> Table:
    """An empty table; headers and cells are shown as they are."""
    shown = Table()
    for header in headers:
        shown.add_column(Text(header))
    return shown


def note(words: str) -> None:
    """Say on stderr what is no result: what was written, what is odd."""
    terminal(stderr=True).print(words, soft_wrap=True)


def print_json(content: dict[str, Any]) -> None:
    """Print the one JSON document of a command; numbers that are not finite must be left out as None.

    Examples
    --------
    >>> print_json({"area_mm2": 12.5})
    {
      "area_mm2": 12.5
    }
    """
    print(json.dumps(content, indent=2, allow_nan=False))
