"""With which status `camring` ends, that all it printed has arrived before it does, and that it does end."""

import atexit
import contextlib
import io
import os
import signal
import sys
import threading
from typing import TextIO

TARGET_MISSED, REFUSED, FAULT, INTERRUPTED = 1, 2, 70, 130
# What shells report of a program that wrote into a pipe which nobody reads any more.
PIPE_CLOSED = 128 + 13
# What asks a program to stop: Ctrl-C, the system, a terminal that was closed.
_STOPPING = {getattr(signal, name): name for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)}
# How long a command that is asked to stop may take to come to its end [s]: libraries compute for minutes without
# looking, and some swallow the interrupt.
GRACE = 2.0
# How long threads in the middle of such a library may then hold up the end, and how long putting things in order [s].
PATIENCE = 0.5

_stopped_by = int(signal.SIGINT)
_is_leaving = threading.Event()
_status = 0  # when it is leaving


def as_documented(status: object) -> int:
    """Our status for one with which typer ends by itself: it says 1, which is a missed target, for a closed pipe.

    Examples
    --------
    >>> as_documented(None), as_documented(2), as_documented(1)
    (0, 2, 141)
    """
    if status == INTERRUPTED:
        return _stopped(_stopped_by)
    known = status if isinstance(status, int) else 0
    return PIPE_CLOSED if known == 1 else known


def tell(words: str) -> None:
    """Say something on standard error, if anybody reads it."""
    with contextlib.suppress(OSError, ValueError):
        print(f"camring: {words}", file=sys.stderr)


def _stopped(number: int) -> int:
    """Say so; the status is what shells report of a program that a signal has ended."""
    tell(f"{'interrupted' if number == signal.SIGINT else 'terminated'}; what is written is whole")
    return 128 + number


def stop_when_asked() -> None:
    """Take every request to stop as an interrupt, which unwinds; end without unwinding if that takes too long."""
    atexit.register(_end_at_last)  # before libraries register what they do at the end: the first is called last
    if threading.current_thread() is not threading.main_thread():
        return
    for number in _STOPPING:  # what the caller has the program ignore, it goes on to ignore
        if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(number, _interrupt)
    # Written to even while a library computes and no handler runs.
    asked, told = os.pipe()
    os.set_blocking(told, False)
    signal.set_wakeup_fd(told)
    threading.Thread(target=_end_when_asked, args=(asked,), daemon=True).start()


def _interrupt(number: int, _: object) -> None:
    global _stopped_by
    _stopped_by = number
    raise KeyboardInterrupt


def _end_when_asked(asked: int) -> None:
    number = 0
    while number not in _STOPPING:
        number = os.read(asked, 1)[0]
    if not _is_leaving.wait(GRACE):
        status = _stopped(number)
        _limit(status)
        _end_now(status)


def leave(status: int) -> None:
    """End the program: no interrupt disturbs that any more, and no thread or process holds it up."""
    global _status
    _status = status
    _is_leaving.set()
    if threading.current_thread() is threading.main_thread():
        for number in _STOPPING:
            signal.signal(number, signal.SIG_IGN)
    _limit(status)
    _end_workers()
    sys.exit(status)


def _limit(status: int) -> None:
    """From now on the end is near, even if all locks are held by threads that do not go on."""
    for seconds, end in ((PATIENCE, _end_now), (2 * PATIENCE, os._exit)):
        timer = threading.Timer(seconds, end, (status,))
        timer.daemon = True
        timer.start()


def _end_at_last() -> None:
    if _is_leaving.is_set():
        _end_now(_status)


def _end_workers() -> None:
    workers = sys.modules.get("exact.workers")  # not imported just to end none
    if workers is not None:
        workers.end(at_once=True)


def _end_now(status: int) -> None:
    """End without what Python does at its very end, as multiprocessing ends a child.

    Python would wait for threads, which cannot be stopped, and take all its modules apart, which takes a second.
    Without `_exit_function` semaphores would be left behind, and a warning of them.
    """
    _end_workers()
    if "multiprocessing.util" in sys.modules:
        sys.modules["multiprocessing.util"]._exit_function()
    flushed(status)
    os._exit(status)


def print_anything() -> None:
    """Let what standard output cannot encode be escaped, rather than stop a command that has its results."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:  # closed by the caller: worker processes, and the first file, would take it
            os.dup2(os.open(os.devnull, os.O_RDWR), number)
            os.set_inheritable(number, True)
            setattr(sys, name, open(number, "r" if number == 0 else "w", encoding="utf-8", closefd=False))  # noqa: SIM115
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def flushed(status: int) -> int:
    """Send off what was printed; `status`, or another one if it does not arrive.

    Otherwise Python does it at its very end, where a full disk or a closed pipe gives a traceback and a status of 120.
    """
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        status = PIPE_CLOSED
        _let_go(sys.stdout)
    except OSError as error:
        if status == 0:
            tell(f"cannot write to standard output: {error.strerror}; give it another place")
            status = REFUSED
        _let_go(sys.stdout)
    try:
        sys.stderr.flush()
    except OSError:
        _let_go(sys.stderr)
    return status


def _let_go(stream: TextIO) -> None:
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())  # or Python would try it once more
