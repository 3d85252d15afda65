"""A process of its own for what takes long, so that the page never waits for it."""

import multiprocessing
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

import exact
import meshes
import placement
from exact.workers import leave_with, signals_held_back
from experiments.files.errors import InputError


@dataclass(frozen=True)
class Asked:
    """A question: its number, what is to be done, and about what."""

    number: int
    what: str
    about: tuple


@dataclass(frozen=True)
class Answer:
    """Part of an answer to the question of that number: of which kind it is, and what was found."""

    number: int
    kind: str
    found: Any


class Worker:
    """A process that answers what it is asked, and is gone when this one is, however it ends.

    Parameters
    ----------
    serve : callable
        What it does: takes a pipe and the arguments, and does not return.
    arguments : tuple
    told : callable
        Called in a thread with each `Answer`, and with None if the process is gone although nobody ended it.
    """

    def __init__(self, serve: Callable[..., None], arguments: tuple, told: Callable[[Answer | None], None]):
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, os.getpid(), serve, arguments), daemon=True)
        with signals_held_back():  # a terminal sends them to all: the one in charge ends the others
            self._process.start()
        theirs.close()
        self._told, self._is_ended = told, False
        threading.Thread(target=self._listen, daemon=True).start()

    def ask(self, asked: Asked) -> None:
        """Send a question; it is lost if the process is gone."""
        try:
            self._pipe.send(asked)
        except OSError:
            pass  # `told` has got None, or is about to

    def end(self) -> None:
        """End it, whatever it does."""
        self._is_ended = True
        self._process.kill()
        self._process.join()

    def _listen(self) -> None:
        while True:
            try:
                answer = self._pipe.recv()
            except (EOFError, OSError):
                if not self._is_ended:
                    self._told(None)
                return
            if not self._is_ended:
                self._told(answer)


def latest(pipe: Connection) -> Asked:
    """The last question that has come; waits for one."""
    asked = pipe.recv()
    while pipe.poll():
        asked = pipe.recv()
    return asked


def refusal(error: Exception) -> str:
    """What to tell the person at the page; of a fault of camring itself, also where, on standard error."""
    if isinstance(error, InputError | exact.ExactError | placement.PlacementError | meshes.MeshError):
        return str(error)
    if isinstance(error, MemoryError):
        return "not enough memory; take a coarser mesh or fewer cameras"
    traceback.print_exception(error, file=sys.stderr)
    return f"a fault of camring: {type(error).__name__}: {error}"


def _serve(pipe: Connection, parent: int, serve: Callable[..., None], arguments: tuple) -> None:
    """In the process: do the work, and end without a word when nobody asks any more."""
    for name in ("SIGINT", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGTERM])
    leave_with(parent)
    try:
        serve(pipe, *arguments)
    except (EOFError, OSError):  # the pipe is closed
        os._exit(0)
