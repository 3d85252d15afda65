"""What went wrong, for the person at the command line and for the script that called it."""

import errno
import sys
import traceback
from contextlib import suppress

import exact
import meshes
from experiments.cli.exit_status import FAULT, REFUSED, TARGET_MISSED, tell
from experiments.cli.memory_limit import ran_out
from experiments.files.errors import InputError, TargetMissed


def exit_status(error: BaseException) -> int:
    """1: ran, but a target was missed. 2: the message says what was wrong with the request. 70: a fault of camring.

    A request for more than the memory or the disk holds is one that cannot be met: 2.

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
    return REFUSED if isinstance(error, known) or out_of_memory(error) or _no_room(error) else FAULT


def out_of_memory(error: BaseException) -> bool:
    """Whether Python, numpy or JAX asked for more memory than there is.

    Examples
    --------
    >>> out_of_memory(MemoryError()), out_of_memory(ValueError("RESOURCE_EXHAUSTED in a file name"))
    (True, False)
    """
    of_jax = type(error).__name__ in ("JaxRuntimeError", "XlaRuntimeError") and "RESOURCE_EXHAUSTED" in str(error)
    return isinstance(error, MemoryError) or of_jax


def _no_room(error: BaseException) -> bool:
    """Whether a disk is full, or what standard output was sent to."""
    return isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def say(error: BaseException) -> int:
    """Print on stderr what went wrong, with where if it is a fault of camring; return the exit status."""
    status = exit_status(error)
    if status == FAULT:
        with suppress(OSError):
            traceback.print_exception(error)
    elif out_of_memory(error):
        tell(ran_out(error))
    elif _no_room(error):
        tell(f"cannot write: {error}; make room, or give standard output and results another place")
    else:
        tell(error.at_command_line if isinstance(error, meshes.MeshError) else str(error))
    return status
