"""A progress bar on stderr for what takes longer than a moment."""

from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, TextColumn, TimeRemainingColumn
from rich.status import Status


@contextmanager
def progress_bar(what: str, total: int) -> Iterator[Callable[[int], None]]:
    """Show a bar until the block ends; call the function it gives with the number of further steps done."""
    with _bar() as bar:
        task = bar.add_task(what, total=total)
        yield lambda steps: bar.advance(task, steps)


@contextmanager
def progress_stages() -> Iterator[Callable[[str, int, int], None]]:
    """Show a bar whose words, steps done and number of steps are set by the function it gives."""
    with _bar() as bar:
        task = bar.add_task("", total=None)
        yield lambda what, done, total: bar.update(task, description=what, completed=done, total=total)


@contextmanager
def progress_tasks(what: str, costs: Mapping[str, float], done: Collection[str]) -> Iterator[Callable[[str], None]]:
    """Show a bar of tasks of unequal cost, some of them `done` before; call what it gives with each that gets done.

    The time left is told by the cost, for the first tasks may take a hundred times as long as the last.
    """
    counted = TextColumn("{task.fields[n_done]} of {task.fields[n_tasks]} tasks")
    columns = (TextColumn("{task.description}"), BarColumn(), counted, TimeRemainingColumn())
    with _progress(*columns, speed_estimate_period=300.0) as bar:
        task = bar.add_task(what, total=sum(costs.values()), n_done=0, n_tasks=len(costs))
        n_done = len(done)
        bar.update(task, completed=sum(costs[name] for name in done), n_done=n_done)

        def one_more(name: str) -> None:
            nonlocal n_done
            n_done += 1
            bar.update(task, advance=costs[name], n_done=n_done)

        yield one_more


def working(what: str) -> Status:
    """A context that shows a spinner for something whose end cannot be told."""
    return Console(stderr=True).status(what)


def _bar() -> Progress:
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    return _progress(*columns)


def _progress(*columns: ProgressColumn, speed_estimate_period: float = 30.0) -> Progress:
    """A bar that goes when it is done; none in a file or a pipe, where it would leave an empty line."""
    console = Console(stderr=True)
    return Progress(
        *columns,
        console=console,
        transient=True,
        disable=not console.is_terminal,
        speed_estimate_period=speed_estimate_period,
    )
