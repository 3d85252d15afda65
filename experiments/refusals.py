"""What went wrong, for the person at the command line and for the script that called it."""

import sys
import traceback

import exact
import meshes
from experiments.errors import InputError, TargetMissed

TARGET_MISSED, REFUSED, FAULT = 1, 2, 70


def exit_status(error: BaseException) -> int:
    """1: ran, but a target was missed. 2: the message says what was wrong with the request. 70: a fault of camring.

    A fault has a status of its own, so that no script takes it for a missed target.

    Examples
    --------
    >>> exit_status(InputError("--fov is 'x'; it must be width x height")), exit_status(ValueError("bug"))
    (2, 70)
    """
    known: tuple[type[BaseException], ...] = (InputError, meshes.MeshError, exact.ExactError)
    placement = sys.modules.get("placement")  # not imported just to ask: a refusal of its own has imported it
    if placement is not None:
        known += (placement.PlacementError,)
    if isinstance(error, TargetMissed):
        return TARGET_MISSED
    return REFUSED if isinstance(error, known) else FAULT


def say(error: BaseException) -> int:
    """Print on stderr what went wrong, with where if it is a fault of camring; return the exit status."""
    status = exit_status(error)
    if status == FAULT:
        traceback.print_exception(error)
    else:
        print(f"camring: {error}", file=sys.stderr)
    return status
