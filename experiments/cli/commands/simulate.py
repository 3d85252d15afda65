"""camring simulate: what comes out when the images of a layout's cameras are rendered, matched and triangulated."""

from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import exact
from experiments.cli.extras import EXTRAS, refuse_without
from experiments.cli.options import refuse_ring_beside_layout
from experiments.cli.results_folder import results_folder
from experiments.files.errors import InputError
from experiments.files.table import write_table
from experiments.layouts import layout_content, layout_file
from experiments.request import rig as rig_file
from experiments.request.request import Request, request
from experiments.request.rig import overridden
from experiments.simulate import ERRORS, FIGURES, OUTPUTS, PREDICTION, TABLE
from experiments.terminal.console import note, print_json, table, terminal
from experiments.terminal.progress import progress_tasks

if TYPE_CHECKING:  # at run time they would bring the extra along
    from experiments.simulate.simulation import Asked, Simulated

DEPTHS, CLOUD = OF_A_LAYOUT = ("depths.png", "reconstruction.ply")
# Pixels along the longer side of a quick image.
QUICK = 900


@dataclass(frozen=True, eq=False)
class _Cameras:
    """The cameras that are asked for, what makes a point count, and which pairs are named."""

    name: str
    ring: exact.Ring
    angles: np.ndarray
    demand: exact.Demand
    pairs: tuple[tuple[int, int], ...] | None
    rolls: np.ndarray | None = None


def run(
    mesh: str,
    rig_path: Path | None,
    options: dict[str, Any],
    *,
    layout: Path | None,
    depth: float | None,
    detail: str | None,
    quick: bool,
    beside_equidistant: bool,
    out: Path,
    force: bool,
    as_json: bool,
) -> None:
    """Simulate, print and write; `options` are those of the rig, by the names of their keys."""
    refuse_without("simulate", "camring simulate")
    from experiments.simulate.simulation import Asked, prepare, simulate

    cameras, asked = _asked(mesh, rig_path, options, layout, depth, detail, quick, force)
    scene = asked.poses[0].scene
    if asked.rig.simulation.texture == "own":
        from experiments.simulate.own_colours import own_colours

        colours = own_colours(mesh, asked.subjects[0].mesh, len(scene.everything.faces))
    else:
        colours = None
    first = Asked(
        cameras.name, scene, cameras.ring, cameras.angles, cameras.demand, asked.rig.simulation, colours, cameras.pairs,
        asked.rig.seed, cameras.rolls,
    )  # fmt: skip
    wanted = _beside(first) if beside_equidistant else [first]
    results_folder(out, OUTPUTS, asked.subjects[0], force)
    for one in wanted:
        prepare(one, out / one.name)
    steps = {name: cost for one in wanted for name, cost in one.steps().items()}
    done = [name for one in wanted for name in one.done(out / one.name)]
    found = []
    with progress_tasks("simulating", steps, done) as progress:
        for one in wanted:
            found.append(simulate(one, out / one.name, progress))
    _tell(out, asked, found, as_json)


def _asked(
    mesh: str,
    rig_path: Path | None,
    options: dict[str, Any],
    layout: Path | None,
    depth: float | None,
    detail: str | None,
    quick: bool,
    force: bool,
) -> tuple[_Cameras, Request]:
    from experiments.simulate.simulation import named_pairs

    if (layout is not None) == (options["count"] is not None or rig_path is not None):
        raise InputError(
            "give the cameras in exactly one way: --layout FILE, --cameras N, or --rig FILE with their number"
        )
    if layout is not None:
        refuse_ring_beside_layout(options)
    if quick and options["resolution"] is not None:
        raise InputError(f"--quick makes images of {QUICK} pixels, and --pixels says how many; leave one of them out")
    made = None if layout is None else layout_file.read(layout)
    given = options if made is None else options | made.loaded(mesh, options)
    rig = replace(rig_file.rig(rig_path, **given), jitter=1, site_weights=None)
    asked = request([mesh], depth, detail, rig, None if made is None else made.ring)
    if made is None:
        angles, demand = asked.ring.equidistant(asked.rig.n_cameras), asked.demand
        cameras = _Cameras("equidistant", asked.ring, angles, demand, None)
    else:
        made.refuse_other_mesh(asked.subjects[0].mesh, asked.name, force)
        demand = overridden(made.moved_to(asked.ring), options)
        every = asked.rig.simulation.matched == "all"
        pairs = None if every else named_pairs(made.content, len(made.angles))
        cameras = _Cameras("layout", asked.ring, made.angles, demand, pairs, made.rolls)
    if quick:
        cameras = replace(cameras, demand=_smaller(cameras.demand, cameras.ring))
    return cameras, asked


def _smaller(demand: exact.Demand, ring: exact.Ring) -> exact.Demand:
    """The same with quick images, in the shape of the field of view."""
    longer = min(QUICK, max(demand.optics.resolution))
    width, height = (max(1, round(longer * side / max(ring.fov))) for side in ring.fov)
    return replace(demand, optics=replace(demand.optics, resolution=(width, height)))


def _beside(first: "Asked") -> "list[Asked]":
    """The layout and the equidistant cameras to compare it with, unless it is that."""
    from experiments.simulate.simulation import equidistant

    other = equidistant(first)
    same = first.rolls is None and np.allclose(np.sort(first.angles), np.sort(other.angles))
    return [first] if same else [first, other]


def _tell(out: Path, request: Request, found: "list[Simulated]", as_json: bool) -> None:
    """Write and print what came out."""
    from experiments.simulate import drawings, tables

    name, first = request.name, found[0].asked
    for one in found:
        drawings.write_depths(out / one.asked.name / DEPTHS, one)
        drawings.write_cloud(out / one.asked.name / CLOUD, one)
    write_table(out / TABLE, [row for one in found for row in tables.classes(one)])
    drawings.write_prediction(out / PREDICTION, name, found)
    drawings.write_errors(out / ERRORS, name, found)
    content = {
        "mesh": name,
        "mesh_sha256": first.scene.mesh_hash,
        "ring": layout_content.ring_content(first.ring),
        "demand": asdict(first.demand),
        "simulation": asdict(first.simulation),
        "seed": first.seed,
        "versions": {one: version(one) for one in ("camring", "numpy", "shapely", *EXTRAS["simulate"].values())},
        "layouts": [tables.summary(one) for one in found],
    }
    layout_content.write(out / FIGURES, content)
    if as_json:
        print_json(content)
    else:
        shown = table(*tables.HEADERS)
        for row in tables.headline(found):
            shown.add_row(*row)
        console = terminal()
        optics = first.demand.optics
        width, height = optics.resolution
        console.print(f"{name}: {width} x {height} pixels, match noise {optics.match_noise:g} px assumed")
        console.print(shown)
    folders = ", ".join(str(out / one.asked.name) for one in found)
    note(f"wrote {', '.join(str(out / name) for name in OUTPUTS)}; images, depth maps and points in {folders}")
