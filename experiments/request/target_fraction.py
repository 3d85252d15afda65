"""A fraction of the ring maximum that must be reached, for scripts: the exit status tells."""

from experiments.files.errors import InputError, TargetMissed


def checked_target(target: float | None) -> None:
    """Refuse a target that is no fraction, before anything is computed.

    Raises
    ------
    InputError
        If it is given and not within (0, 1].
    """
    if target is not None and not 0 < target <= 1:
        raise InputError(f"--target is {target:g}; it must be a fraction of the ring maximum, above 0 and at most 1")


def reach(target: float | None, fraction: float, who: str) -> None:
    """Say whether `who` meets the target; nothing without one.

    Raises
    ------
    TargetMissed
        If `fraction` is below it.

    Examples
    --------
    >>> reach(0.99, 0.995, "6 cameras"), reach(None, 0.5, "2 cameras")
    (None, None)
    >>> reach(0.99, 0.95, "4 cameras")
    Traceback (most recent call last):
    experiments.files.errors.TargetMissed: target missed: 4 cameras reach 0.9500 of the ring maximum; needed is 0.99
    """
    if target is not None and fraction < target:
        raise TargetMissed(f"target missed: {who} reach {fraction:.4f} of the ring maximum; needed is {target:g}")
