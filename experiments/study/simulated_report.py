"""The page of the simulated study, simulated.md, with its figure, from the rows on disk."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from tabulate import tabulate

from experiments.figures.palette import BLUE, GREEN, GREY, ORANGE
from experiments.files.whole import written_whole
from experiments.study.simulated_layouts import KINDS, MATCHED
from experiments.study.simulated_rows import (
    PREDICTIONS,
    TOLERANCE_WORDS,
    LimitRow,
    SimulatedRow,
    best_limit,
    rank_correlation,
)
from experiments.study.simulated_tasks import MATCH_NOISE, MAX_ERROR

FIGURE, PAGE = "simulated.png", "simulated.md"
MARKS = ("o", "s", "^", "D", "v", "P", "X", "*")


def main_width(rows: Sequence[SimulatedRow]) -> int:
    """The resolution of most layouts [pixels]."""
    widths = [row.width_px for row in rows]
    return max(set(widths), key=widths.count)


def write_report(folder: Path, rows: Sequence[SimulatedRow], limits: Sequence[LimitRow]) -> str:
    """Write the page and its figure; give the headline."""
    _write_figure(folder / FIGURE, rows, limits)
    with written_whole(folder / PAGE) as temporary:
        temporary.write_text(page(rows, limits), encoding="utf-8")
    return "\n".join(headline(rows, limits))


def headline(rows: Sequence[SimulatedRow], limits: Sequence[LimitRow]) -> list[str]:
    """What came out, in sentences."""
    width = main_width(rows)
    of = [row for row in rows if row.width_px == width and not row.failure]
    facing = [row.facing_measured_mm / row.facing_predicted_mm for row in rows
              if row.facing_measured_mm is not None and row.facing_predicted_mm]  # fmt: skip
    noise = [row.match_noise_px for row in rows if row.match_noise_px is not None]
    said = []
    if facing:
        said.append(
            f"On facing surfaces (incidence below 60°) the standard deviation along the normal is {min(facing):.2f} to "
            f"{max(facing):.2f} times the predicted one, at a measured noise of {min(noise):.2f} to {max(noise):.2f} "
            "px."
        )
    for kind, unit in (("incidence", "° of incidence"), ("density", " px/mm²"), ("gradient", " of disparity gradient")):
        for one in sorted({row.width_px for row in limits}):
            best = best_limit(limits, kind, one)
            row = next(row for row in limits if (row.kind, row.width_px, row.limit) == (kind, one, best))
            said.append(
                f"At {one} px, what is matched is told best by {'at least' if kind == 'density' else 'at most'} "
                f"{best:.3g}{unit}: wrong for {100 * row.disagree:.1f} % of what is seen."
            )
    for tested, words in ((False, "of the sites that the limits were chosen on"), (True, "of other sites")):
        some = [row for row in of if row.tested == tested]
        if some:
            together = ", ".join(f"{way} {rank_correlation(some, way):.3f}" for way in PREDICTIONS)
            said.append(
                f"Rank correlation of predicted and reconstructed area ({TOLERANCE_WORDS}) over {len(some)} layouts "
                f"{words}: {together}."
            )
    return said


def page(rows: Sequence[SimulatedRow], limits: Sequence[LimitRow]) -> str:
    """The page in Markdown."""
    width = main_width(rows)
    of = [row for row in rows if row.width_px == width and not row.failure]
    parts = [
        "# The simulated reconstruction",
        "Rendered images of equidistant, most-area and proposed layouts of reference sites without their top surface, "
        f"and of those proposed where two cameras must match a point (disparity gradient at most {MATCHED:g}), matched "
        "and triangulated, beside the exact area that is predicted. Ring 30 mm at 400 mm, field of view "
        f"36 × 24 mm, all pairs matched, {MATCH_NOISE:g} px of noise expected; where an error is asked for, at most "
        f"{MAX_ERROR:g} mm along the normal. `camring study --simulated` makes this page.",
        "\n".join(f"- {sentence}" for sentence in headline(rows, limits)),
        f"![Predicted and reconstructed area, and what limits tell]({FIGURE})",
        "## Rank correlations, site by site",
        _correlations(of),
        "## Every layout",
        _table(
            [
                [
                    f"{row.site}, {row.depth_mm} mm", str(row.n_cameras), row.kind, str(row.width_px),
                    *(_cell(row.predicted(way)) for way in ("no limits", "density", "gradient")),
                    _cell(row.within_01_mm2), _cell(row.within_03_mm2), _cell(row.match_noise_px, 3),
                    _cell(row.facing_measured_mm, 4), _cell(row.facing_predicted_mm, 4),
                ]
                for row in rows
            ],
            ["site", "cameras", "layout", "px", "predicted [mm²]", "with density", "gradient",
             "within 0.1 mm [mm²]", "within 0.3 mm", "noise [px]", "facing σ_n measured [mm]", "predicted"],
        ),
    ]  # fmt: skip
    failed = [f"- {row.site}, {row.n_cameras} cameras, {row.kind}: {row.failure}" for row in rows if row.failure]
    return "\n\n".join([*parts, *(["## Failed", "\n".join(failed)] if failed else [])]) + "\n"


def _correlations(rows: Sequence[SimulatedRow]) -> str:
    lines = []
    for site, depth in dict.fromkeys((row.site, row.depth_mm) for row in rows):
        of = [row for row in rows if (row.site, row.depth_mm) == (site, depth)]
        lines.append(
            [f"{site}, {depth} mm", str(len(of)), *(f"{rank_correlation(of, way):.3f}" for way in PREDICTIONS)]
        )
    for tested in sorted({row.tested for row in rows}):
        of = [row for row in rows if row.tested == tested]
        name = "all others, for a test" if tested else "all that limits were chosen on"
        lines.append([name, str(len(of)), *(f"{rank_correlation(of, way):.3f}" for way in PREDICTIONS)])
    return _table(lines, ["site", "layouts", *PREDICTIONS])


def _cell(value: float | None, digits: int = 1) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


def _table(lines: list[list[str]], header: list[str]) -> str:
    return tabulate(lines, header, tablefmt="github", disable_numparse=True)


def _write_figure(path: Path, rows: Sequence[SimulatedRow], limits: Sequence[LimitRow]) -> None:
    """Predicted beside measured, and how often each limit is wrong."""
    figure = Figure(figsize=(15.0, 4.4), dpi=110, layout="constrained")
    left, *others = figure.subplots(1, 4)
    width = main_width(rows)
    of = [row for row in rows if row.width_px == width and not row.failure]
    for (site, depth), mark in zip(dict.fromkeys((row.site, row.depth_mm) for row in of), MARKS, strict=False):
        for kind, colour in zip(KINDS, (GREY, ORANGE, BLUE, GREEN), strict=True):
            chosen = [row for row in of if (row.site, row.depth_mm, row.kind) == (site, depth, kind)]
            label = f"{site}, {depth} mm" if kind == "proposed" else None
            both = [(row.predicted("gradient"), row.within_03_mm2) for row in chosen]
            left.plot(*zip(*both, strict=True), mark, color=colour, ms=5, label=label)
    low, high = left.get_xlim()
    left.plot([low, high], [low, high], ":", color=GREY)
    left.set(xlabel="predicted, with the gradient [mm²]", ylabel=f"reconstructed {TOLERANCE_WORDS} [mm²]",
             title="grey: equidistant, orange: most area,\nblue: proposed, green: matched")  # fmt: skip
    left.legend(frameon=False, fontsize=8)
    names = (("incidence", "greatest incidence [°]"), ("density", "least density [px/mm²]"),
             ("gradient", "greatest disparity gradient"))  # fmt: skip
    for ax, (kind, label) in zip(others, names, strict=True):
        for one, colour in zip(sorted({row.width_px for row in limits}), (ORANGE, BLUE, GREY), strict=False):
            curve = np.array([(row.limit, 100 * row.disagree) for row in limits
                              if (row.kind, row.width_px) == (kind, one)])  # fmt: skip
            ax.plot(*curve.T, color=colour, label=f"{one} px")
        ax.set(xlabel=label, ylabel="wrong, of what is seen [%]", ylim=(0, None))
        ax.legend(frameon=False, fontsize=8)
        ax.set(xscale="linear" if kind == "incidence" else "log")
    for ax in (left, *others):
        ax.grid(color="0.9")
        ax.spines[["top", "right"]].set_visible(False)
    with written_whole(path) as temporary:
        figure.savefig(temporary)
