"""The one exception class of `placement`."""


class PlacementError(ValueError):
    """A request for a layout that cannot be met: says what was got, what is needed, what to do."""
