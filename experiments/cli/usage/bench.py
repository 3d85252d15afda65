"""How `camring bench` is called."""

from pathlib import Path
from typing import Annotated

import typer

import experiments.cli.options as opt


def bench(
    what: Annotated[
        str,
        typer.Argument(
            help="exact: the exact evaluator, its accuracy and speed; "
            "sites: the reference sites against the published areas; "
            "surrogate: what the search maximises against exact areas",
            autocompletion=opt.completing(opt.BENCHMARKS),
        ),
    ],
    out: opt.Out = Path("out"),
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Measure how right and how fast camring is on this machine; takes minutes.

    Example: camring bench exact --out out/
    """
    if what == "exact":
        from experiments.bench import exact_areas as bench_exact

        bench_exact.run(out, force, json)
    elif what == "sites":
        from experiments.bench import sites as bench_sites

        bench_sites.run(out, force, json)
    elif what == "surrogate":
        from experiments.bench import surrogate as bench_surrogate

        bench_surrogate.run(out, force, json)
    else:
        from experiments.files.errors import InputError

        raise InputError(f"there is no benchmark {what!r}; choose exact, sites or surrogate")
