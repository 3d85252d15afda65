"""The tables of `camring bench surrogate`: headers and lines of words, for the terminal and for Markdown."""

from collections.abc import Sequence
from statistics import fmean

from experiments.bench.surrogate_accuracy import Accuracy, Sampling
from experiments.bench.surrogate_stages import Stages
from experiments.bench.surrogate_statistics import least
from placement.settings import Settings

Table = tuple[tuple[str, ...], list[tuple[str, ...]]]
VARIED = (("samples", "n_samples"), ("ring angles", "n_angles"), ("bisections", "bisections"))


def accuracy_table(rows: Sequence[Accuracy], temperatures: Sequence[float]) -> Table:
    """Each site at these temperatures [rad], 0 for hard coverage."""
    header = (
        "site", "temperature [rad]", "rank correlation, all", "least for one M", "mean error [%]", "95 % [%]",
        "greatest [%]", "gradient error",
    )  # fmt: skip
    lines = []
    for row in rows:
        if row.n_cameras != "all" or row.temperature_rad not in temperatures:
            continue
        alone = [
            other.rank_correlation for other in rows if other.n_cameras != "all"
            and (other.site, other.depth_mm, other.temperature_rad) == (row.site, row.depth_mm, row.temperature_rad)
        ]  # fmt: skip
        lines.append(
            (
                f"{row.site} {row.depth_mm:g}", f"{row.temperature_rad:g}" if row.temperature_rad else "hard",
                _number(row.rank_correlation), _number(least(alone)), *(
                    f"{100 * size:.2f}" for size in (row.mean_error, row.error_95, row.greatest_error)
                ), "" if row.gradient_error is None else f"{row.gradient_error:.0e}",
            )
        )  # fmt: skip
    return header, lines


def sampling_table(rows: Sequence[Sampling], settings: Settings) -> Table:
    """One number varied at a time, over all sites and seeds."""
    header = (
        "varied", "", "mean error [%]", "predicted [%]", "by profiles [%]", "ring maximum off by [%]",
        "least rank correlation", "tracing, processor [s]", "gradient, processor [ms]",
    )  # fmt: skip
    lines = []
    for words, name in VARIED:
        for value, group in series(rows, settings, name).items():
            lines.append(
                (
                    words, f"{value}" + (" (chosen)" if value == getattr(settings, name) else ""),
                    f"{100 * mean(group, 'mean_error'):.3f}",
                    f"{100 * mean(group, 'predicted_error'):.3f}",
                    f"{100 * mean(group, 'profile_error'):.4f}",
                    f"{100 * max(abs(row.ring_error) for row in group):.2f}",
                    _number(least([row.rank_correlation for row in group])),
                    f"{mean(group, 'tracing_s'):.2f}",
                    f"{1000 * mean(group, 'gradient_s'):.1f}",
                )
            )  # fmt: skip
    return header, lines


def stages_table(rows: Sequence[Stages]) -> Table:
    """Each sequence of temperatures, over all sites."""
    header = ("temperatures [rad]", "mean end [%]", "best end, mean of sites [%]", "flat or failed", "processor [s]")
    lines = []
    for temperatures in dict.fromkeys(row.temperatures_rad for row in rows):
        group = [row for row in rows if row.temperatures_rad == temperatures]
        lines.append(
            (
                temperatures, f"{100 * mean(group, 'mean_end'):.2f}",
                f"{100 * mean(group, 'best_end'):.2f}",
                f"{sum(row.flat_or_failed for row in group)} of {sum(row.n_starts for row in group)}",
                f"{mean(group, 'seconds'):.1f}",
            )
        )  # fmt: skip
    return header, lines


def series(rows: Sequence[Sampling], settings: Settings, name: str) -> dict[int, list[Sampling]]:
    """Rows by the value of one number of the settings, increasing, where the others are as in `settings`.

    Seeds other than the least are there only where samples vary, and left out elsewhere.
    """
    others = [other for _, other in VARIED if other != name]
    first = min(row.seed for row in rows)
    groups: dict[int, list[Sampling]] = {}
    for row in rows:
        alike = all(getattr(row, other) == getattr(settings, other) for other in others)
        if alike and (name == "n_samples" or row.seed == first):
            groups.setdefault(getattr(row, name), []).append(row)
    return dict(sorted(groups.items()))


def mean(rows: Sequence[Sampling] | Sequence[Stages], figure: str) -> float:
    """Mean of one figure of the rows, by its name."""
    return fmean(getattr(row, figure) for row in rows)


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.4f}"
