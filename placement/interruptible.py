"""Long calls into compiled libraries, which Python cannot interrupt, made so that a program can be interrupted."""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


def interruptible(function: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
    """What a function gives; an interrupt ends the wait for it at once, and the program does not wait for it either.

    What goes on then is nobody's any more: it must not change what others use.

    Examples
    --------
    >>> interruptible(max, 1, 2)
    2
    """
    if threading.current_thread() is not threading.main_thread():
        return function(*args, **kwargs)  # no interrupt is raised here
    found: Future[R] = Future()

    def call() -> None:
        try:
            found.set_result(function(*args, **kwargs))
        except BaseException as error:
            found.set_exception(error)

    threading.Thread(target=call, daemon=True).start()
    return found.result()
