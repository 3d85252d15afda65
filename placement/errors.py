"""What goes wrong in a search for a layout."""

from collections.abc import Iterator
from contextlib import contextmanager

import exact


class PlacementError(ValueError):
    """The request cannot be met; the message says what was got, what is needed and what to do."""


@contextmanager
def refusing() -> Iterator[None]:
    """What the evaluator refuses of a request, this package refuses: with the same words and its own exception."""
    try:
        yield
    except exact.ExactError as error:
        raise PlacementError(str(error)) from error
