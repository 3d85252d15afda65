"""The one exception class of `exact`."""


class ExactError(ValueError):
    """A ring, a camera or a request for an area that cannot be: says what was got, what is needed, what to do."""
