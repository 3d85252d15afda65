"""A process of its own for what takes long, so that the page never waits for it."""

import multiprocessing
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable
from contextlib import suppress
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
        self._told, self._is_ended = told, False
        self._lock, self._waiting = threading.Lock(), []
        self._process: Any = None
        # Starting it takes a second, in which the arguments are handed over.
        threading.Thread(target=self._run, args=(serve, arguments), daemon=True).start()

    def ask(self, asked: Asked) -> None:
        """Send a question; it is lost if the process is gone."""
        with self._lock:
            if self._process is None:
                self._waiting.append(asked)
                return
        self._send(asked)

    def end(self) -> None:
        """End it, whatever it does."""
        with self._lock:
            self._is_ended, process = True, self._process
        if process is not None:
            process.kill()
            process.join()

    def _send(self, asked: Asked) -> None:
        with suppress(OSError):  # `told` has got None, or is about to
            self._pipe.send(asked)

    def _run(self, serve: Callable[..., None], arguments: tuple) -> None:
        """Start it, and hand on what it answers."""
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs, os.getpid(), serve, arguments), daemon=True)
        with suppress(OSError), signals_held_back():  # a terminal sends them to all: the one in charge ends the others
            process.start()
        theirs.close()
        with self._lock:
            self._process, waiting = (None if process.pid is None else process), self._waiting
            if self._is_ended and self._process is not None:
                process.kill()
        for asked in waiting:
            self._send(asked)
        while True:
            try:
                answer = self._pipe.recv()
            except (EOFError, OSError):
                answer = None
            if self._is_ended:
                return
            self._told(answer)
            if answer is None:
                return


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
