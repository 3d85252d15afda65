"""What the command line refuses."""


class InputError(ValueError):
    """A request that cannot be carried out: says what was got, what is needed, what to do. Exit status 2."""


class TargetMissed(Exception):
    """A command ran and its results are out, but they fall short of what was asked for. Exit status 1."""
