"""What the command line refuses."""


class InputError(ValueError):
    """A request that cannot be carried out: says what was got, what is needed, what to do. Exit status 2."""
