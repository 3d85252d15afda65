"""The picture of `camring bench surrogate`: six panels, from rank to gradient."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from experiments.bench.surrogate_accuracy import Accuracy, Sampling, Truth
from experiments.bench.surrogate_statistics import least
from experiments.bench.surrogate_tables import mean, series
from experiments.files.whole import written_whole
from placement.settings import Settings

COLOURS = ("#1f5fa8", "#c0392b", "#2e8b57", "#8e44ad", "#d98c00", "#555555")


def draw(
    path: Path,
    truths: Sequence[Truth],
    estimates: Sequence[dict[float, np.ndarray]],
    rows: Sequence[Accuracy],
    samplings: Sequence[Sampling],
    settings: Settings,
) -> None:
    """Write the picture as PNG."""
    figure = Figure(figsize=(15, 9), dpi=110, layout="constrained")
    axes = figure.subplots(2, 3)
    _ranks(axes[0, 0], truths, estimates, settings.temperatures[-1])
    _temperatures(axes[0, 1], truths, rows, settings.temperatures)
    _errors(axes[0, 2], truths, estimates)
    _samples(axes[1, 0], samplings, settings)
    _profiles(axes[1, 1], samplings, settings)
    _gradients(axes[1, 2], truths, rows)
    for ax in axes.flat:
        ax.spines[["top", "right"]].set_visible(False)
        ax.tick_params(labelsize=9)
    with written_whole(path) as temporary:
        figure.savefig(temporary)


def _each(truths: Sequence[Truth]):
    for number, truth in enumerate(truths):
        yield truth, f"{truth.site} {truth.depth_mm:g} mm", COLOURS[number % len(COLOURS)]


def _ranks(ax, truths, estimates, temperature) -> None:
    for (truth, label, colour), estimated in zip(_each(truths), estimates, strict=True):
        exactly, soft = 100 * truth.areas / truth.ring_area, 100 * estimated[temperature] / truth.ring_area
        ax.plot(exactly, soft, ".", color=colour, markersize=4, alpha=0.6, label=label)
    ends = ax.get_xlim()
    ax.plot(ends, ends, color="black", linewidth=0.8)
    ax.set(xlabel="exact area [% of the ring maximum]", ylabel="soft coverage [% of the ring maximum]")
    ax.set_title(f"Random layouts: soft coverage at {temperature:g} rad\nagainst exact area", fontsize=11)
    ax.legend(fontsize=8)


def _temperatures(ax, truths, rows, stages) -> None:
    for truth, label, colour in _each(truths):
        own = [r for r in rows if (r.site, r.depth_mm) == (truth.site, truth.depth_mm) and r.temperature_rad > 0]
        for style, words, groups in (("-", label, ("all",)), (":", None, {r.n_cameras for r in own} - {"all"})):
            found = {
                t: least([r.rank_correlation for r in own if r.temperature_rad == t and r.n_cameras in groups])
                for t in sorted({r.temperature_rad for r in own})
            }
            known = {t: 1 - value for t, value in found.items() if value is not None}
            ax.plot(list(known), list(known.values()), style, marker=".", color=colour, label=words)
    ax.axhline(0.01, color="black", linewidth=1, linestyle="--", label="bound for layouts of any M")
    for stage in stages:
        ax.axvline(stage, color="#bbbbbb", linewidth=0.8, zorder=0)
    ax.set(xscale="log", yscale="log", xlabel="temperature [rad] (grey: stages of the search)")
    ax.set_ylabel("1 - rank correlation with the exact area")
    ax.set_title("Does soft coverage rank layouts rightly? Lower is better;\ndotted: the worst single M", fontsize=11)
    ax.legend(fontsize=8)


def _errors(ax, truths, estimates) -> None:
    for (truth, label, colour), estimated in zip(_each(truths), estimates, strict=True):
        sizes = 100 * np.sort(np.abs(estimated[0.0] - truth.areas)) / truth.ring_area
        ax.step(sizes, 100 * np.arange(1, len(sizes) + 1) / len(sizes), where="post", color=colour, label=label)
        ax.plot([sizes.mean()] * 2, [0, 4], color=colour, linewidth=3)
    ax.axvline(0.3, color="black", linewidth=1, linestyle="--", label="bound for the mean")
    ax.set(xlabel="error of hard coverage [% of the ring maximum]", ylabel="layouts within this error [%]")
    ax.set(xlim=(0, None), ylim=(0, 101))
    ax.set_title("Hard coverage on the default samples\n(bars at the foot: mean errors)", fontsize=11)
    ax.legend(fontsize=8, loc="lower right")


def _samples(ax, samplings, settings) -> None:
    groups = series(samplings, settings, "n_samples")
    for n, group in groups.items():
        ax.plot([n] * len(group), [100 * row.mean_error for row in group], ".", color=COLOURS[0], alpha=0.7)
    means, predicted = ([100 * mean(g, name) for g in groups.values()] for name in ("mean_error", "predicted_error"))
    ax.plot(list(groups), means, color=COLOURS[0], label="mean error (dots: each site and seed)")
    ax.plot(list(groups), predicted, color=COLOURS[1], label="standard error predicted from the strata")
    ax.axhline(0.3, color="black", linewidth=1, linestyle="--", label="bound")
    ax.axvline(settings.n_samples, color="#bbbbbb", linewidth=0.8, zorder=0)
    ax.set(xscale="log", yscale="log", xlabel="samples (grey: chosen)", ylabel="error of hard coverage [% of maximum]")
    ax.set_xticks(list(groups), [str(n) for n in groups])
    ax.set_yticks([0.05, 0.1, 0.2, 0.5, 1.0], ["0.05", "0.1", "0.2", "0.5", "1"])
    ax.minorticks_off()
    ax.set_title("How many samples?", fontsize=11)
    ax.legend(fontsize=8)


def _profiles(ax, samplings, settings) -> None:
    for name, words, colour, below in (
        ("n_angles", "ring angles", COLOURS[0], 4),
        ("bisections", "bisections", COLOURS[2], -14),
    ):
        groups = series(samplings, settings, name)
        sizes = [100 * mean(group, "profile_error") for group in groups.values()]
        seconds = [mean(group, "tracing_s") for group in groups.values()]
        ax.plot(seconds, sizes, "o-", color=colour, label=f"{words} varied")
        for value, x, y in zip(groups, seconds, sizes, strict=True):
            ax.annotate(f"{value}", (x, y), textcoords="offset points", xytext=(4, below), fontsize=9, color=colour)
    ax.set(yscale="log", xlabel="processor time to trace [s]", ylabel="mean error by profiles [% of maximum]")
    ax.set_title("How many ring angles and bisections?\nAgainst rays to the same samples", fontsize=11)
    ax.legend(fontsize=8)


def _gradients(ax, truths, rows) -> None:
    for truth, label, colour in _each(truths):
        found = {
            r.temperature_rad: r.gradient_error
            for r in rows
            if (r.site, r.depth_mm) == (truth.site, truth.depth_mm) and r.gradient_error
        }
        ax.plot(list(found), list(found.values()), ".-", color=colour, label=label)
    ax.set(xscale="log", yscale="log", xlabel="temperature [rad]")
    ax.set(ylim=(1e-10, 1e-4), ylabel="largest error / largest derivative")
    ax.set_title("Gradient of soft coverage\nagainst central differences", fontsize=11)
    ax.legend(fontsize=8)
