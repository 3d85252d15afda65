"""Where the tasks of a sweep are done: processes on this machine, or the workers of a Dask cluster."""

import os
import warnings
from concurrent.futures import Executor, Future
from typing import Protocol

from exact.workers import Workers
from experiments.files.errors import InputError

# How long a Dask scheduler and its first worker may take to answer [s].
PATIENCE = 30


class Pool(Protocol):
    """An executor that can be had anew when it breaks."""

    places: int  # tasks it takes at a time
    description: str

    def submit(self, function, *arguments) -> Future:
        """As of an Executor; raises BrokenExecutor when it is broken."""
        ...

    def renew(self) -> None:
        """Go on after a break."""
        ...

    def close(self, at_once: bool) -> None:
        """Let the workers go: when they are idle, or in the middle of what they do."""
        ...


class LocalPool:
    """Processes on this machine, one task each, with one thread each for linear algebra.

    Examples
    --------
    >>> pool = LocalPool(1)
    >>> pool.submit(abs, -2).result()
    2
    >>> pool.close(at_once=True)
    """

    def __init__(self, places: int | None = None):
        self.places = places or os.cpu_count() or 1
        self.description = f"{self.places} local process{'es' if self.places > 1 else ''}"
        self._executor = self._new()

    def _new(self) -> Workers:
        # What a process remembers from task to task, loky takes for a leak; it starts a new one, which does no harm.
        warnings.filterwarnings("ignore", "A worker was restarted while some jobs", UserWarning)
        return Workers(self.places)

    def submit(self, function, *arguments) -> Future:
        """As of an Executor."""
        return self._executor.submit(function, *arguments)

    def renew(self) -> None:
        """Start other processes."""
        self._executor.shutdown(kill_workers=True)
        self._executor = self._new()

    def close(self, at_once: bool) -> None:
        """End the processes."""
        self._executor.shutdown(wait=True, kill_workers=at_once)


class ClusterPool:
    """The workers of a Dask cluster.

    Its scheduler gives what a lost worker was doing to another one, and gives up on a task that has lost it four.

    Raises
    ------
    InputError
        If Dask is not installed, or no scheduler or no worker answers.
    """

    def __init__(self, address: str):
        try:
            from distributed import Client
        except ImportError as error:
            raise InputError(
                "--scheduler needs Dask, which is not installed; pip install 'camring[cluster]' brings it"
            ) from error
        try:
            self._client = Client(address, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError) as error:
            raise InputError(f"no Dask scheduler answers at {address}; start one with `dask scheduler`") from error
        try:
            self._client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError as error:
            self._client.close()
            raise InputError(f"the Dask scheduler at {address} has no worker; `dask worker {address}`") from error
        self._executor: Executor = self._client.get_executor(pure=False)
        self.description = "Dask cluster"
        # The scheduler deals them out, so it can have them all.
        self.places = 10**9

    def submit(self, function, *arguments) -> Future:
        """As of an Executor."""
        return self._executor.submit(function, *arguments)

    def renew(self) -> None:
        """Nothing to do: the scheduler looks after its workers."""

    def close(self, at_once: bool) -> None:
        """Leave the cluster; what it is still doing is called off."""
        self._executor.shutdown(wait=not at_once)
        self._client.close()
