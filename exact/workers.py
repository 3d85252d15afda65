"""Processes that share the work: started once, for all threads, and gone when the program ends, however it ends."""

import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from multiprocessing import resource_tracker, util
from typing import Any
from weakref import WeakSet

import numpy as np
from loky import ProcessPoolExecutor
from loky.process_executor import ShutdownExecutorError

from exact.cameras import Camera
from exact.errors import ExactError
from exact.visibility.projection import NEAR
from exact.visibility.surface import Surface

# Each worker has a core to itself; BLAS threads of several would only wait for each other.
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
# Sectors of the image that each worker gets.
SECTORS = 4
# Workers that idle this long go away [s]. Long, since loky warns when one goes just as new work comes: harmless, as it
# starts another, but a program that turns warnings into errors would be stopped by it.
IDLE_SECONDS = 600
# How often a worker looks whether the process that started it is still there [s].
LOOK_SECONDS = 0.5
# What a shell, a terminal or a batch system sends to all processes of a program; the one in charge ends the others.
STOPPING = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
_ENDING = "the program is ending, and what its worker processes were doing is called off"
# Without psutil and pgrep loky cannot look for what its processes have started, which is nothing here.
warnings.filterwarnings("ignore", "Failed to kill subprocesses", UserWarning)


class _State:
    """What all threads of this process share; its lock is held whenever processes are started."""

    def __init__(self) -> None:
        self.changed = threading.Condition()
        self.executors: dict[int, Workers] = {}  # of `processes`, by their number
        self.all: WeakSet[Workers] = WeakSet()
        self.callers = 0  # threads that the end of the program waits for
        self.ending = False


class Workers(ProcessPoolExecutor):
    """Processes with one thread each for linear algebra, that never outlive the one that started them.

    No signal that asks a program to stop reaches them, so that none of them prints a traceback of its own.

    Raises
    ------
    ExactError
        From `submit`, if the program is ending.

    Examples
    --------
    >>> workers = Workers(1)
    >>> workers.submit(abs, -2).result()
    2
    >>> workers.shutdown()
    """

    def __init__(self, size: int):
        with signals_held_back():  # from the processes that look after semaphores
            # Started only later, it would let the signals through that `submit` holds back.
            resource_tracker.ensure_running()
            parent = (os.getpid(),)
            super().__init__(size, timeout=IDLE_SECONDS, env=ONE_THREAD, initializer=leave_with, initargs=parent)
        with _state.changed:
            _state.all.add(self)
        # A process of multiprocessing would wait for its own children before anything else ends them.
        util.Finalize(None, end, exitpriority=20)

    def threads(self) -> list[threading.Thread]:
        """Those of this process that look after the others and hand them their work, as far as they are there."""
        both = (self._executor_manager_thread, getattr(self._call_queue, "_thread", None))
        return [thread for thread in both if thread is not None]

    def submit(self, fn: Callable, /, *args: Any, **kwargs: Any) -> Future:
        """As of an Executor."""
        return _undisturbed(self._submit, fn, *args, **kwargs)

    def _submit(self, fn: Callable, *args: Any, **kwargs: Any) -> Future:
        with _state.changed:
            if _state.ending:
                raise ExactError(_ENDING)
            is_first = self._executor_manager_thread is None
            try:
                with signals_held_back():
                    future = super().submit(fn, *args, **kwargs)
                if is_first:
                    _end_before_threads_are_joined()  # and before loky's own such function, which waits for the work
            except (BrokenExecutor, ShutdownExecutorError, BrokenPipeError):
                raise
            except (RuntimeError, OSError) as error:
                # Some processes may be there, and, if Python began to end just now, loky will not end them.
                self.shutdown(wait=False, kill_workers=True)
                raise ExactError(f"worker processes could not be started ({error}); ask for one worker") from error
            return future


_state = _State()


def _end_before_threads_are_joined() -> None:
    """Have `end` called when the main thread is done; atexit comes too late, after waiting for loky's threads."""
    threading._register_atexit(end)  # pyright: ignore[reportAttributeAccessIssue] # what loky itself is ended by


def end(at_once: bool = False) -> None:
    """End all processes and start no more. Whoever waits for one gets an ExactError.

    Happens by itself when the program ends. Like Python it then waits first for threads that are no daemons and have
    work done by processes, but for `background` ones; not if `at_once`.
    """
    with _state.changed:
        while _state.callers and not at_once:
            _state.changed.wait()
        _state.ending = True
        executors = list(_state.all)
    threads = [thread for executor in executors for thread in executor.threads()]
    for executor in executors:
        executor.shutdown(wait=False, kill_workers=True)
    if not at_once:
        for thread in threads:  # stopped in the middle of it, one leaves a semaphore that nobody signs off
            thread.join(LOOK_SECONDS)


@contextmanager
def processes(workers: int) -> Iterator[Executor]:
    """Executor with at least that many processes, kept for the next call; a new one after one of them has died.

    Threads would wait for each other: most of the time goes into making and reading shapely's objects.

    Raises
    ------
    ExactError
        If a process dies while it is at work, or the program ends and does not wait for this thread.
    """
    thread = threading.current_thread()
    may_finish = not (thread.daemon or getattr(_thread, "is_background", False))
    is_awaited = may_finish and thread is not threading.main_thread()
    if is_awaited:
        with _state.changed:
            _state.callers += 1
    try:
        yield _Here() if may_finish and _state.ending else _undisturbed(_executor, workers)
    except BrokenExecutor as error:
        raise ExactError(
            f"one of {workers} processes that shared the work was stopped from outside, most likely since memory ran "
            "out; ask for fewer workers, a coarser mesh or fewer cameras, or free some memory, and try again"
        ) from error
    except ShutdownExecutorError as error:
        raise ExactError(_ENDING) from error
    finally:
        if is_awaited:
            with _state.changed:
                _state.callers -= 1
                _state.changed.notify_all()


class _Here(Executor):
    """Does the work in the thread that asks, which the end of the program waits for."""

    def submit(self, fn: Callable, /, *args: Any, **kwargs: Any) -> Future:
        done = Future()
        done.set_result(fn(*args, **kwargs))
        return done


def _executor(workers: int) -> Workers:
    with _state.changed:
        size = min((size for size in _state.executors if size >= workers), default=workers)
        executor = _state.executors.get(size)
        if executor is None:
            executor = _state.executors[size] = Workers(size)
    try:
        executor.submit(int)  # starts them; refused if one of them has died meanwhile
    except (BrokenExecutor, ShutdownExecutorError):
        with _state.changed:
            if _state.executors.get(size) is executor:
                del _state.executors[size]
        return _executor(workers)
    return executor


def start_processes(workers: int) -> None:
    """Have `processes` ready soon, with this package imported, while this one does something else."""
    if workers > 1:
        with processes(workers):
            pass  # the first thing they do is to import this module


def _undisturbed(function: Callable, *args: Any, **kwargs: Any) -> Any:
    """What a function gives, called in a thread, where no interrupt is raised.

    In the middle of it, one would leave processes that nobody looks after, or a lock that nobody opens.
    """
    if threading.current_thread() is not threading.main_thread() or _state.ending:
        return function(*args, **kwargs)
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(function, *args, **kwargs).result()


_thread = threading.local()


def background(function: Callable[[], Any]) -> Future:
    """Call a function in a thread of its own; what processes do for it is called off when the program ends.

    Examples
    --------
    >>> background(lambda: 1 + 1).result()
    2
    """
    pool = ThreadPoolExecutor(1, initializer=lambda: setattr(_thread, "is_background", True))
    future = pool.submit(function)
    pool.shutdown(wait=False)
    return future


def shares(surface: Surface, camera: Camera, active: np.ndarray, n: int) -> list[np.ndarray]:
    """The `active` faces in `n` parts of about equal work: sectors of one camera's image, dealt out in turn.

    What is hard to see lies together, so that a part in one piece would often have most of the work; but the narrower
    the sectors, the more of what is in front of them is needed by several workers. Faces that others cut through are
    few, lie in one place and may take as long as all the rest: of these each gets a part.
    """
    index = np.flatnonzero(active)
    local = (surface.vertices[surface.faces[index]].mean(axis=1) - camera.position) @ camera.rotation.T
    image = local[:, :2] / np.maximum(np.abs(local[:, 2:]), NEAR * camera.target_distance)
    away = image - np.median(image, axis=0)
    index = index[np.argsort(np.arctan2(away[:, 1], away[:, 0]), kind="stable")]
    is_crossed = np.zeros_like(active)
    is_crossed[surface.intersections.face] = True
    crossed = is_crossed[index]
    sectors = [np.array_split(of_kind, SECTORS * n) for of_kind in (index[~crossed], index[crossed])]
    shares = []
    for first in range(n):
        share = np.zeros_like(active)
        for of_kind in sectors:
            share[np.concatenate(of_kind[first::n])] = True
        shares.append(share)
    return shares


@contextmanager
def signals_held_back() -> Iterator[None]:
    """Processes and threads that are started meanwhile never get one of `STOPPING`."""
    if not hasattr(signal, "pthread_sigmask"):  # on Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, STOPPING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def leave_with(parent: int) -> None:
    """End this process soon after its parent has ended, however it ended."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(LOOK_SECONDS)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _forget() -> None:
    """A forked process has none of the threads that look after the processes of its parent: it starts its own."""
    global _state
    _of_parents.append(_state)  # to let go of them would wake those threads
    _state = _State()


_of_parents: list[_State] = []
_end_before_threads_are_joined()
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)


def available_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
