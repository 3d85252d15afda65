"""camring optimise: propose a layout, compare it with equidistant ones, say what it keeps, write and draw it."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import exact
import placement
from exact.workers import available_cores, background, start_processes
from experiments.cli.results_folder import results_folder
from experiments.exports import coverage_mesh, formats
from experiments.exports.cameras import named_cameras
from experiments.layouts import layout_content, layout_file
from experiments.report import NAME as REPORT
from experiments.request import rig as rig_file
from experiments.request.meshes import is_site
from experiments.request.request import Request, request
from experiments.request.target_fraction import checked_target, reach
from experiments.rings.several import RINGS_OUTPUTS, checked_rings, optimise_rings, refuse_for_several, rings_asked
from experiments.tables import layouts as layout_table
from experiments.tables import mounting as mounting_table
from experiments.tables import robustness as robustness_table
from experiments.tables import sites as site_table
from experiments.terminal.console import note, print_json, terminal
from experiments.terminal.progress import progress_stages
from placement.search.search import import_descent

OUTPUTS = ("layout.json", "layouts.csv", "coverage.png")
# Sample points for triangulation angles, shared by all meshes and poses, and the fewest that each gets.
ANGLE_SAMPLES, LEAST_ANGLE_SAMPLES = 20_000, 2_000


def run(
    meshes: list[str],
    rig_path: Path | None,
    options: dict[str, Any],
    *,
    rings: list[str] | None,
    depth: float | None,
    detail: str | None,
    target: float | None,
    robust: bool,
    export: str | None,
    with_report: bool,
    out: Path,
    force: bool,
    as_json: bool,
) -> None:
    """Optimise, print and write; `options` are those of the rig, by the names of their keys."""
    checked_target(target)
    several = rings_asked(rings or (), rig_file.ring_tables(rig_path))
    if several:
        refuse_for_several(options)
    names = () if export is None else formats.parse_formats(export, "--export", (*formats.FORMATS, "mesh"))
    if any(is_site(name) for name in meshes):
        start_processes(available_cores())  # which takes as long as building a site
    asked = request(meshes, depth, detail, rig_file.rig(rig_path, bool(several), **options))
    meshes_too = coverage_mesh.FILES if "mesh" in names else ()
    names = tuple(name for name in names if name in formats.FORMATS)
    if several:
        on_rings = checked_rings(several, {} if rings else options, asked)
        results_folder(out, (*RINGS_OUTPUTS, *meshes_too, *[REPORT] * with_report), asked.subjects[0], force)
        files = formats.prepare(out, names, force)
        fraction = optimise_rings(on_rings, asked, names, bool(meshes_too), with_report, files, out, as_json)
        reach(target, fraction, f"{asked.rig.n_cameras} cameras on all rings")
        return
    asked.check_cameras(asked.rig.n_cameras)
    results_folder(out, (*OUTPUTS, *meshes_too, *[REPORT] * with_report), asked.subjects[0], force)
    files = formats.prepare(out, names, force)
    background(import_descent)  # while the site is sampled
    is_free = asked.ring.roll == "free"
    robust = robust and not is_free
    with progress_stages() as progress:
        problem, (n_cameras, limits) = asked.problem(progress), (asked.rig.n_cameras, asked.rig.constraints)
        # Equidistant rings wait for no search; other processes work on them while this one searches.
        even = [
            background(lambda: _kept(problem, asked, robust, asked.ring.equidistant(n_cameras))),
            background(lambda: _kept(problem, asked, robust, _best_equidistant(problem, asked))),
        ]
        result = problem.optimise(
            n_cameras, limits, certify=asked.rig.certify, give_up=asked.rig.give_up, progress=progress
        )
        layouts = _layouts(result, asked)
        drawing = background(lambda: _draw(out / OUTPUTS[2], asked, result, (layouts[0], layouts[-1])))
        progress("faults and triangulation angles", 0, 1)
        searched = [_kept(problem, asked, robust, layout.angles, layout.rolls) for layout in layouts[2:]]
        rows = _rows(result, asked, layouts, [*(found.result() for found in even), *searched])
        content = layout_content.placement_content(result, asked)
        scenes = [pose.scene for pose in asked.poses]
        mounted = mounting_table.mounting(scenes, asked.ring, result.angles, result.demand, result.rolls)
        if mounted is not None:
            content["mounting"] = mounting_table.mounting_content(mounted, result.angles)
        if robust:
            area, agreed = sum(site.area for site in result.sites), placement.consensus(result)
            content["robustness"] = robustness_table.robustness_content(rows, agreed, area)
        progress("drawing", 0, 1)
        layout_content.write(out / OUTPUTS[0], content)
        layout_table.write_csv(out / OUTPUTS[1], rows)
        drawing.result()
        formats.write(
            out, names, named_cameras(asked.ring, layouts[-1].angles, rolls=layouts[-1].rolls), asked.subjects[0]
        )
        if meshes_too:
            files += _write_meshes(out, asked, layouts[-1], result.demand)
        if with_report:
            from experiments.report import page

            page.write(out / REPORT, layout_file.read(out / OUTPUTS[0]), asked.poses[0].scene)
            files += (REPORT,)
    if as_json:
        print_json(content | {"layouts": [layout_table.figures(row) for row in rows]})
    else:
        _print(asked, result, rows, mounted)
    note(f"wrote {', '.join(str(out / name) for name in (*OUTPUTS, *files))}")
    if len(asked.subjects) > 1 and (meshes_too or any(formats.FORMATS[name].needs_site for name in names)):
        note(f"note: the meshes written show {asked.subjects[0].name}, the first")
    if is_free:
        note("note: for free rolls nothing is told of faults and of a bound; --roll radial or tangential has both")
    reach(target, result.fraction, f"the optimised {asked.rig.n_cameras} cameras")


class Layout(NamedTuple):
    """One of the layouts compared."""

    name: str
    angles: np.ndarray
    areas: tuple[float, ...]
    """Of each mesh or pose [mm²]."""
    fraction: float
    error: float
    """Root mean square of the predicted errors [mm]."""
    rolls: np.ndarray | None = None
    """Where they are free [rad]."""


def _layouts(result: placement.Placement, asked: Request) -> tuple[Layout, ...]:
    """The equidistant layout, the same at its best phase, that with the most area if it is another, the proposed."""
    phase, even, sites = result.best_equidistant_phase, asked.ring.equidistant, result.sites
    at_best = f"equidistant, best phase ({np.degrees(phase):.1f}°)"
    most = result.most_area
    other = Layout(
        "most area", np.array(most.angles), most.areas, most.fraction, result.most_area_error_rms, _array(most.rolls)
    )
    return (
        Layout(
            "equidistant", even(result.n_cameras), tuple(site.equidistant_area for site in sites),
            result.equidistant_fraction, result.equidistant_error_rms,
        ),
        Layout(
            at_best, even(result.n_cameras, phase), tuple(site.best_equidistant_area for site in sites),
            result.best_equidistant_fraction, result.best_equidistant_error_rms,
        ),
        *([other] if (most.angles, most.rolls) != (result.angles, result.rolls) else ()),
        Layout(
            "optimised", np.array(result.angles), tuple(site.area for site in sites), result.fraction,
            result.error_rms, _array(result.rolls),
        ),
    )  # fmt: skip


def _array(rolls: tuple[float, ...] | None) -> np.ndarray | None:
    return None if rolls is None else np.array(rolls)


def _best_equidistant(problem: placement.Problem, asked: Request) -> np.ndarray:
    n_cameras = asked.rig.n_cameras
    phase = placement.best_equidistant_phase(problem, n_cameras, asked.rig.constraints)
    return asked.ring.equidistant(n_cameras, phase)


def _kept(
    problem: placement.Problem, asked: Request, robust: bool, angles: np.ndarray, rolls: np.ndarray | None = None
) -> tuple[placement.Triangulation, placement.Robustness | None]:
    """Triangulation angles of a layout, and what is left of it under faults."""
    found = placement.robustness(problem, angles, asked.rig.constraints) if robust else None
    n_samples = max(ANGLE_SAMPLES // len(asked.poses), LEAST_ANGLE_SAMPLES)
    spread = placement.Triangulation.together(
        [
            placement.triangulation(
                pose.scene, asked.ring, angles, rolls=rolls, demand=asked.demand, n_samples=n_samples
            )
            for pose in asked.poses
        ]
    )
    return spread, found


def _rows(
    result: placement.Placement,
    asked: Request,
    layouts: Sequence[Layout],
    kept: Sequence[tuple[placement.Triangulation, placement.Robustness | None]],
) -> list[layout_table.Row]:
    rows = []
    for layout, (spread, found) in zip(layouts, kept, strict=True):
        breaks = result.constraints.violations(asked.ring, layout.angles)
        gain = None if layout is layouts[0] else layout.fraction - result.equidistant_fraction
        area = sum(layout.areas) / asked.n_poses
        rows.append(
            layout_table.row(
                layout.name,
                layout.angles,
                area,
                layout.fraction,
                gain,
                spread,
                layout.error,
                found,
                breaks,
                np.zeros(len(layout.angles)) if result.rolls is not None and layout.rolls is None else layout.rolls,
            )
        )
    return rows


def _draw(path: Path, asked: Request, result: placement.Placement, layouts: Sequence[Layout]) -> None:
    """The first mesh, or the one of which the layout proposed reconstructs least if the worst was to be raised."""
    from experiments.figures.coverage import Panel, write_coverage  # matplotlib: while other processes are at work

    worst = asked.rig.objective == "worst"
    shown = int(np.argmin([site.fraction for site in result.sites])) if worst else 0
    pose, ring_area = asked.poses[shown], result.sites[shown].ring_area
    which = f" ({'the worst' if worst else 'the first'} of {len(asked.poses)})" if len(asked.poses) > 1 else ""
    panels = [
        Panel(
            layout.name, layout.angles,
            f"{layout.areas[shown]:.1f} mm², {100 * layout.areas[shown] / ring_area:.2f} % of the ring maximum",
            layout.rolls,
        )
        for layout in layouts
    ]  # fmt: skip
    write_coverage(path, pose.name + which, pose.scene, asked.ring, panels, result.demand)


def _write_meshes(out: Path, asked: Request, layout: Layout, demand: exact.Demand) -> tuple[str, ...]:
    cameras = asked.ring.cameras(layout.angles, layout.rolls)
    return coverage_mesh.write(out, exact.evaluate(asked.poses[0].scene, cameras, demand=demand))


def _print(
    asked: Request,
    result: placement.Placement,
    rows: list[layout_table.Row],
    mounted: mounting_table.Mounting | None,
) -> None:
    console = terminal()
    for words in site_table.headings(asked, result, f" of the {result.n_cameras}"):
        console.print(words)
    if len(asked.poses) > 1:
        console.print(site_table.site_table(asked, result))
    console.print(layout_table.layout_table(rows, "equidistant"))
    for row in rows:
        if row.breaks:
            console.print(f"{row.name} is there to compare with and does not meet the constraints: {row.breaks[0]}")
    console.print(
        "optimised ring angles [degrees]: " + ", ".join(f"{angle:.3f}" for angle in np.degrees(result.angles)),
    )
    if result.rolls is not None:
        console.print("optimised rolls [degrees]: " + ", ".join(f"{roll:.3f}" for roll in np.degrees(result.rolls)))
    if mounted is not None:
        console.print(mounting_table.mounting_table(mounted, result.angles))
    found = rows[-1].robustness
    if found is not None:
        console.print(robustness_table.faults_table(rows))
        console.print(robustness_table.faults_caption(rows, asked.of))
        console.print(robustness_table.consensus_words(placement.consensus(result), result.angles))
        if found.pairs:
            area = sum(site.area for site in result.sites)
            console.print(robustness_table.pairs_words(found, area))
            console.print(robustness_table.pairs_table(found, area))
    if result.certificate is not None:
        console.print(result.certificate.statement)
