"""Curves that fill in while they are computed: area over the number of cameras, and what accuracy costs in area."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import placement
from placement.recommend import fewest_cameras

if TYPE_CHECKING:
    from experiments.design.design import Design
    from experiments.design.searches import Tell

# Numbers of cameras are tried up to this one, or to those that are looked at.
MOST_COUNTED = 10


def counts(problem: placement.Problem, design: "Design", tell: "Tell") -> None:
    """The most that cameras of each number reconstruct, and equidistant ones, until both reach all there is."""
    numbers = range(fewest_cameras(design.whole, design.limits), max(MOST_COUNTED, len(design.angles)) + 1)

    def on_count(found: placement.CountResult) -> None:
        n, made = found.n_cameras, found.placement
        tell("point", _point("equidistant", n, found.equidistant_fraction, problem.ring.equidistant(n).tolist()))
        if made is not None:
            tell("point", _point("optimised", n, made.fraction, list(made.angles)))

    placement.recommend(
        problem, 1.0, design.limits, numbers, certify=False, progress=progress_of(tell), on_count=on_count
    )  # fmt: skip


def trade_off(problem: placement.Problem, design: "Design", tell: "Tell") -> None:
    """Layouts of which none has both more area and less error, and equidistant ones; errors in mm."""
    found = problem.tradeoff(len(design.angles), design.limits, certify=False, progress=progress_of(tell))
    for layout in (*found.layouts, *found.compared):
        if layout.kind != "opposite pairs":
            kind = "optimised" if layout.kind == "searched" else layout.kind
            tell("point", _point(kind, layout.error_rms, layout.fraction, list(layout.angles)))


CURVES = {"how many cameras": counts, "trade-off": trade_off}


def _point(line: str, at: float, fraction: float, angles: list[float]) -> dict[str, Any]:
    return {"line": line, "at": at, "fraction": fraction, "angles": angles}


def progress_of(tell: "Tell") -> Callable[[str, int, int], None]:
    """The progress of `placement`, told to the page."""
    return lambda what, done, total: tell("progress", (what, done, total))
