"""Many independent tasks, done by a pool, each on disk as soon as it is done, so that a killed run goes on.

A file in the sweep's folder holds the outcome of one task and is named by a hash of all that the outcome depends on.
Tasks that have one are not done again, unless they failed.
"""

import json
from collections import Counter, deque
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from pathlib import Path

from experiments.files.errors import InputError
from experiments.files.whole import output_folder, written_whole
from experiments.sweeps.pool import ClusterPool, LocalPool, Pool
from experiments.sweeps.task import Outcome, Task, perform
from experiments.terminal.progress import progress_tasks

# How often a task is tried whose worker dies: a lack of memory may pass, a fault of the program does not.
ATTEMPTS = 3


def pool_for(scheduler: str | None) -> Pool:
    """The processors of this machine, or the cluster whose Dask scheduler has this address.

    Raises
    ------
    InputError
        If there is no such cluster, or Dask is not installed.
    """
    return LocalPool() if scheduler is None else ClusterPool(scheduler)


def on_disk(tasks: Sequence[Task], folder: Path) -> dict[str, Outcome]:
    """Outcomes, by name of the task, that an earlier run has left in the folder; failed ones are not among them."""
    found = {}
    for name in {task.name for task in tasks}:
        path = _path(folder, name)
        if path.exists():
            content = json.loads(path.read_text(encoding="utf-8"))
            if not content["failure"]:
                found[name] = Outcome(content["result"], "", content["seconds"])
    return found


def sweep(
    tasks: Sequence[Task],
    folder: Path,
    pool: Pool,
    report: Callable[[Task, Outcome], object] | None = None,
) -> list[Outcome]:
    """Do the tasks that the folder does not hold yet.

    Parameters
    ----------
    tasks : sequence of Task
    folder : Path
        Where outcomes are kept, one file a task; it is made if need be.
    pool : Pool
        What does them; it stays open.
    report : callable, optional
        Called with each task and its outcome when it is done.

    Returns
    -------
    list of Outcome
        In the order of the tasks, whatever the order in which they were done.

    Raises
    ------
    InputError
        If the cluster is lost; what is done is on disk, and the same sweep goes on from there.

    Examples
    --------
    >>> import tempfile
    >>> from experiments.sweeps.pool import LocalPool
    >>> pool, folder = LocalPool(1), Path(tempfile.mkdtemp())
    >>> outcomes = sweep([Task(dict, {"cameras": 2}), Task(dict, {"cameras": 4})], folder, pool)
    >>> [outcome.result for outcome in outcomes], len(list(folder.iterdir()))
    ([{'cameras': 2}, {'cameras': 4}], 2)
    >>> pool.close(at_once=True)
    """
    output_folder(folder, (), force=True)
    outcomes = on_disk(tasks, folder)
    to_do = {task.name: task for task in tasks if task.name not in outcomes}

    def finished(task: Task, outcome: Outcome) -> None:
        # What is read back on a later day is what is used today.
        text = json.dumps(
            {"task": task.identity, "result": outcome.result, "failure": outcome.failure, "seconds": outcome.seconds}
        )
        with written_whole(_path(folder, task.name)) as temporary:
            temporary.write_text(text, encoding="utf-8")
        outcomes[task.name] = Outcome(json.loads(text)["result"], outcome.failure, outcome.seconds)
        if report is not None:
            report(task, outcome)

    left = sorted(to_do.values(), key=lambda task: -task.cost)
    deaths: Counter[str] = Counter()
    places = pool.places
    while left:
        left = _try(left, pool, places, finished, deaths)
        # Which of those that were running has ended a worker, nobody knows: from here on each is tried alone.
        places = 1
    return [outcomes[task.name] for task in tasks]


def shown_sweep(
    what: str, tasks: Sequence[Task], folder: Path, scheduler: str | None
) -> tuple[list[Outcome], str, int]:
    """Do a `sweep` with a bar that says `what`, on a pool of its own, as `pool_for` gives it.

    Returns
    -------
    list of Outcome
        In the order of the tasks.
    str
        Where they were done.
    int
        How many the folder held before.
    """
    done = on_disk(tasks, folder)
    pool = pool_for(scheduler)
    at_once = True
    try:
        with progress_tasks(what, {task.name: task.cost for task in tasks}, done) as progress:
            outcomes = sweep(tasks, folder, pool, lambda task, _: progress(task.name))
        at_once = False
    finally:
        pool.close(at_once)
    return outcomes, pool.description, len(done)


def _try(
    tasks: Sequence[Task],
    pool: Pool,
    places: int,
    finished: Callable[[Task, Outcome], None],
    deaths: Counter[str],
) -> list[Task]:
    """Do the tasks, `places` at a time; those whose worker died and that may be tried again."""
    waiting, again = deque(tasks), []
    running: dict[Future, Task] = {}

    def settle(future: Future) -> bool:
        task = running.pop(future)
        try:
            finished(task, future.result())
        except BrokenExecutor:
            deaths[task.name] += 1
            if deaths[task.name] < ATTEMPTS:
                again.append(task)
            else:
                finished(task, Outcome(None, f"its worker died, {ATTEMPTS} times in a row", 0.0))
            return False
        except CancelledError as error:
            raise InputError("lost the cluster; the same command goes on where this one ended") from error
        except Exception as error:  # noqa: BLE001 - what a cluster says of a task that it gave up
            finished(task, Outcome(None, f"{type(error).__name__}: {error}", 0.0))
        return True

    while waiting or running:
        whole = True
        try:
            while waiting and len(running) < places:
                running[pool.submit(perform, waiting[0], waiting[0].identity["sources"])] = waiting[0]
                waiting.popleft()
        except BrokenExecutor:
            whole = False
        done = wait(running, return_when=FIRST_COMPLETED).done if whole else []
        whole = all([settle(future) for future in done]) and whole
        if not whole:
            for future in list(running):
                settle(future)
            pool.renew()
    return again


def _path(folder: Path, name: str) -> Path:
    return folder / f"{name}.json"
