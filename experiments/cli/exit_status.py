"""With which status `camring` ends, and that all it printed has arrived before it does."""

import atexit
import io
import os
import signal
import sys

TARGET_MISSED, REFUSED, FAULT, INTERRUPTED = 1, 2, 70, 130
# What shells report of a program that wrote into a pipe which nobody reads any more.
PIPE_CLOSED = 128 + 13


def as_documented(status: object) -> int:
    """Our status for one with which typer ends by itself: it says 1, which is a missed target, for a closed pipe.

    Examples
    --------
    >>> as_documented(None), as_documented(2), as_documented(1)
    (0, 2, 141)
    """
    if status == INTERRUPTED:
        print("camring: interrupted; what is written is whole", file=sys.stderr)
    known = status if isinstance(status, int) else 0
    return PIPE_CLOSED if known == 1 else known


def finish_undisturbed() -> None:
    """Take no interrupt any more once Python has begun to end: all is written, and taking itself down may abort it."""
    atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)


def print_anything() -> None:
    """Let what standard output cannot encode be escaped, rather than stop a command that has its results."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def flushed(status: int) -> int:
    """Send off what was printed; `status`, or another one if it does not arrive.

    Otherwise Python does it at its very end, where a full disk or a closed pipe gives a traceback and a status of 120.
    """
    try:
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        status = PIPE_CLOSED
    except OSError as error:
        if status == 0:
            print(f"camring: cannot write to standard output: {error.strerror}; give it another place", file=sys.stderr)
            status = REFUSED
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or Python would try it once more
    return status
