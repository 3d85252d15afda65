"""camring count: the fewest cameras that reach a target, well placed and equidistant."""

from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

import placement
from exact.workers import background
from experiments.cli.results_folder import results_folder
from experiments.figures.count import write_count
from experiments.files.errors import InputError
from experiments.files.table import finite, write_table
from experiments.layouts import layout_content
from experiments.request import rig as rig_file
from experiments.request.request import Request, request
from experiments.request.target_fraction import checked_target, reach
from experiments.tables.sites import headings
from experiments.terminal.console import note, print_json, table, terminal
from experiments.terminal.progress import progress_stages
from placement.recommend import fewest_cameras
from placement.search.search import import_descent

TABLE, PICTURE, LAYOUT = OUTPUTS = ("count.csv", "count.png", "layout.json")


def run(
    meshes: list[str],
    rig_path: Path | None,
    options: dict[str, Any],
    *,
    target: float,
    max_cameras: int,
    depth: float | None,
    detail: str | None,
    out: Path,
    force: bool,
    as_json: bool,
) -> None:
    """Try one number of cameras after another; print and write. `options` are those of the rig, by their keys."""
    checked_target(target)
    asked = request(meshes, depth, detail, rig_file.rig(rig_path, **options))
    fewest = fewest_cameras(asked.demand, asked.rig.constraints)
    if max_cameras < fewest:
        raise InputError(f"--max-cameras is {max_cameras}; it must be at least {fewest} for this request")
    asked.check_cameras(fewest)
    results_folder(out, OUTPUTS, asked.subjects[0], force)
    for name in OUTPUTS:
        (out / name).unlink(missing_ok=True)  # of an earlier run, it would pass for this one's if this one stops
    counts: list[placement.CountResult] = []

    def keep(counted: placement.CountResult) -> None:
        """Put on disk what is known so far."""
        counts.append(counted)
        write_table(out / TABLE, [figures(one) for one in counts])
        found = counted.placement
        if found is not None and found.fraction >= target and not (out / LAYOUT).exists():
            layout_content.write(out / LAYOUT, layout_content.placement_content(found, asked))

    background(import_descent)  # while the site is sampled
    with progress_stages() as progress:
        problem = asked.problem(progress)
        numbers = range(fewest, max_cameras + 1)
        found = placement.recommend(
            problem, target, asked.rig.constraints, numbers, asked.rig.certify, progress, on_count=keep
        )
    write_count(out / PICTURE, asked.name, asked.of, found)
    words = in_words(found, asked.of)
    if as_json:
        print_json(
            {
                "target": target,
                "n_cameras": found.n_cameras,
                "n_equidistant": found.n_equidistant,
                "in_words": words,
                "counts": [figures(counted) for counted in found.counts],
                "layout": None if found.placement is None else layout_content.placement_content(found.placement, asked),
            }
        )
    else:
        _print(asked, found, words)
    note(f"wrote {', '.join(str(out / name) for name in OUTPUTS if (out / name).exists())}")
    best = max((counted for counted in found.counts if counted.placement), key=lambda counted: counted.fraction or 0.0)
    reach(target, best.fraction or 0.0, f"the optimised {best.n_cameras} cameras")


def figures(counted: placement.CountResult) -> dict[str, Any]:
    """Every figure of one number of cameras in full; None where there is none."""
    found = counted.placement
    certificate, rolls = (None, None) if found is None else (found.certificate, found.rolls)
    return {
        "n_cameras": counted.n_cameras,
        "equidistant_fraction": counted.equidistant_fraction,
        "best_equidistant_fraction": counted.best_equidistant_fraction,
        "best_equidistant_phase_deg": None if found is None else float(np.degrees(found.best_equidistant_phase)),
        "optimised_fraction": counted.fraction,
        "equidistant_rms_error_mm": None if found is None else finite(found.equidistant_error_rms),
        "optimised_rms_error_mm": None if found is None else finite(found.error_rms),
        "bound_fraction": None if certificate is None else certificate.bound_fraction,
        "gap": None if certificate is None else certificate.gap,
        "grid_bound_fraction": None if certificate is None else certificate.grid_bound_fraction,
        "grid_gap": None if certificate is None else certificate.grid_gap,
        "proven": None if certificate is None else certificate.proven,
        "sampling_error": None if certificate is None else certificate.sampling_error,
        "seconds": None if found is None else round(sum(found.search.seconds.values()), 3),
        "ring_angles_deg": None if found is None else np.degrees(found.angles).tolist(),
        **({} if rolls is None else {"rolls_deg": np.degrees(rolls).tolist()}),
    }


def _errors(counted: placement.CountResult) -> str:
    """Errors of the equidistant and the optimised layout; nothing where they are not finite, as of single cameras."""
    found = counted.placement
    if found is None or not np.isfinite([found.equidistant_error_rms, found.error_rms]).all():
        return ""
    return f"{found.equidistant_error_rms:.4f}, {found.error_rms:.4f}"


def in_words(found: placement.Recommendation, of: str) -> str:
    """What a recommendation says; `of` says what a fraction is a fraction of."""
    wanted, most = _percent(found.target), found.counts[-1].n_cameras
    by_number = {counted.n_cameras: counted for counted in found.counts}
    if found.n_cameras is None:
        fits = [counted.n_cameras for counted in found.counts if counted.placement is not None]
        room = "" if fits[-1] == most else f"; more than {fits[-1]} do not fit"
        words = f"{fits[-1]} well-placed cameras do not reach {wanted} of {of}{room}"
    else:
        words = f"{_cameras(found.n_cameras)} {'reaches' if found.n_cameras == 1 else 'reach'} {wanted} of {of}"
    if found.n_equidistant is None:
        words += f"; an equidistant ring does not with up to {most}."
    else:
        words += f"; an equidistant ring needs {found.n_equidistant}."
    fewer = by_number.get((found.n_cameras or 0) - 1)
    certificate = None if fewer is None or fewer.placement is None else fewer.placement.certificate
    if certificate is not None and certificate.bound_fraction < found.target:
        words += (
            f" No layout of {_cameras(fewer.n_cameras)} does: on the samples none exceeds "  # type: ignore[union-attr]
            f"{_percent(certificate.bound_fraction)} (standard error {_percent(certificate.sampling_error)})."
        )
    return words


def _percent(fraction: float) -> str:
    return f"{100 * fraction:.4g} %" if fraction >= 0.1 else f"{100 * fraction:.2f} %"


def _cameras(n: int) -> str:
    return f"{n} camera{'' if n == 1 else 's'}"


def _print(asked: Request, found: placement.Recommendation, words: str) -> None:
    console = terminal()
    first = next(counted.placement for counted in found.counts if counted.placement is not None)
    for line in headings(asked, first):
        console.print(line)
    console.print(_count_table(found))
    if asked.rig.certify:
        console.print(
            "Bound: no layout at any angles reconstructs more of the samples; gap: to what the optimised one "
            "reconstructs of the same samples; proven: best layout at multiples of "
            f"{np.degrees(asked.rig.settings.certificate_step):g}° known to 0.2 %. The other fractions are exact."
        )
    console.print(words)
    if found.placement is not None:
        angles = ", ".join(f"{angle:.3f}" for angle in np.degrees(found.placement.angles))
        console.print(f"ring angles of the {found.n_cameras} [degrees]: {angles}")
        if found.placement.rolls is not None:
            rolls = ", ".join(f"{roll:.3f}" for roll in np.degrees(found.placement.rolls))
            console.print(f"their rolls [degrees]: {rolls}")


def _count_table(found: placement.Recommendation) -> Table:
    shown = table(
        "cameras", "equidistant", "equidistant,\nbest phase", "optimised", "RMS error [mm]:\nequidistant, optimised",
        "bound for\nany layout", "gap", "proven"
    )  # fmt: skip
    for counted in found.counts:
        certificate = None if counted.placement is None else counted.placement.certificate
        mark = " *" if counted.n_cameras == found.n_cameras else ""
        shown.add_row(
            str(counted.n_cameras) + mark,
            f"{100 * counted.equidistant_fraction:.2f} %",
            f"{100 * counted.best_equidistant_fraction:.2f} %",
            "do not fit" if counted.fraction is None else f"{100 * counted.fraction:.2f} %",
            _errors(counted),
            *(
                ("", "", "")
                if certificate is None
                else (
                    f"{100 * certificate.bound_fraction:.2f} %",
                    f"{100 * (certificate.gap or 0.0):.2f} %",
                    "yes" if certificate.proven else "time ran out",
                )
            ),
        )
    return shown
