"""The command `camring`: its subcommands, and how it ends.

How each is called stands in `usage`, what it does in `commands`, which brings the heavy libraries: so `camring --help`
answers at once.
"""

import gc
import sys

import typer

from experiments.cli.exit_status import (
    INTERRUPTED,
    REFUSED,
    as_documented,
    flushed,
    leave,
    print_anything,
    stop_when_asked,
    tell,
)
from experiments.cli.jax_cache import keep_compiled
from experiments.cli.memory_limit import ran_out, too_low
from experiments.cli.one_thread import calculate_in_one_thread
from experiments.cli.usage import (
    bench,
    check,
    compare,
    count,
    design,
    evaluate,
    export,
    optimise,
    published,
    report,
    rig,
    ring,
    simulate,
    site,
    tradeoff,
)

# Objects made before Python looks for cycles among them again. A fifth of the time that imports take goes into looking,
# and all that they make stays.
COLLECT_AFTER = 100_000

app = typer.Typer(
    name="camring",
    help="Where the cameras of a ring should sit so that they reconstruct the most of a surface. "
    "Lengths in millimetres, angles in degrees.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


for declared in (
    optimise.optimise,
    count.count,
    tradeoff.tradeoff,
    ring.ring,
    design.design,
    evaluate.evaluate,
    compare.compare,
    export.export,
    report.report,
    simulate.simulate,
    site.site,
    check.check,
    bench.bench,
    published.paper,
    published.study,
):
    app.command()(declared)
app.add_typer(rig.app, name="rig")


def main(arguments: list[str] | None = None) -> None:
    """Run `camring` and exit: 0; 1 if a target was missed; 2, with one message, if the request cannot be met.

    Without arguments it is the program itself, takes those of the command line, and ends the process whatever still
    runs in it.
    """
    keep_compiled()
    calculate_in_one_thread()
    print_anything()
    if arguments is None:
        stop_when_asked()
        gc.set_threshold(COLLECT_AFTER)
    try:
        status = _status(sys.argv[1:] if arguments is None else arguments)
    except KeyboardInterrupt:  # while it says why it ends
        status = as_documented(INTERRUPTED)
    if "experiments.files.folder_lock" in sys.modules:
        sys.modules["experiments.files.folder_lock"].release_all()
    status = flushed(status)
    if arguments is None:
        leave(status)
    sys.exit(status)


def _status(arguments: list[str]) -> int:
    refusal = None if "numpy" in sys.modules else too_low(arguments)
    try:
        if refusal is None:
            app(arguments, prog_name="camring")
        status = 0
    except SystemExit as end:
        status = as_documented(end.code)
    except MemoryError as error:  # which to import more would take, too
        refusal = ran_out(error)
    except Exception as error:
        from experiments.cli.refusals import say

        status = say(error)
    if refusal is not None:
        tell(refusal)
        status = REFUSED
    return status


if __name__ == "__main__":
    main()
