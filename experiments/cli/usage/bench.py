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
            "meshes: time and memory for scans, CAD parts and channels of up to a million faces; "
            "sites: the reference sites against the published areas; "
            "surrogate: what the search maximises against exact areas",
            autocompletion=opt.completing(opt.BENCHMARKS),
        ),
    ],
    out: opt.Out = Path("out"),
    force: opt.Force = False,
    json: opt.Json = False,
    most_faces: Annotated[
        int | None, typer.Option("--most-faces", help="meshes: leave out those of more faces than this")
    ] = None,
) -> None:
    """Measure how right and how fast camring is on this machine; takes minutes.

    Example: camring bench exact --out out/
    """
    if most_faces is not None and what != "meshes":
        from experiments.files.errors import InputError

        raise InputError(f"--most-faces is for the benchmark meshes; {what} has meshes of its own")
    if what == "exact":
        from experiments.bench import exact_areas as bench_exact

        bench_exact.run(out, force, json)
    elif what == "sites":
        from experiments.bench import sites as bench_sites

        bench_sites.run(out, force, json)
    elif what == "meshes":
        from experiments.bench import any_size as bench_meshes

        bench_meshes.run(out, force, json, most_faces)
    elif what == "surrogate":
        from experiments.bench import surrogate as bench_surrogate

        bench_surrogate.run(out, force, json)
    else:
        from experiments.files.errors import InputError

        raise InputError(f"there is no benchmark {what!r}; choose exact, meshes, sites or surrogate")
