"""Which exceptions are answers to the person at the command line, rather than faults of the program."""

import sys

import exact
import meshes
from experiments.errors import InputError


def is_refusal(error: BaseException) -> bool:
    """Whether the message of `error` says what was wrong with the request.

    Examples
    --------
    >>> is_refusal(InputError("--fov is 'x'; it must be width x height")), is_refusal(ValueError("bug"))
    (True, False)
    """
    known: tuple[type[BaseException], ...] = (InputError, meshes.MeshError, exact.ExactError)
    placement = sys.modules.get("placement")  # not imported just to ask: a refusal of its own has imported it
    if placement is not None:
        known += (placement.PlacementError,)
    return isinstance(error, known)
