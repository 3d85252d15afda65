"""The command `camring`: what it understands. What each subcommand does is in its own module.

Heavy libraries are imported by the subcommands, so that `camring --help` answers at once.
"""

import sys
from pathlib import Path
from typing import Annotated

import typer

import experiments.cli.options as opt
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

app = typer.Typer(
    name="camring",
    help="Where the cameras of a ring should sit so that they reconstruct the most of a surface. "
    "Lengths in millimetres, angles in degrees.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.command()
def optimise(
    meshes: opt.Meshes,
    cameras: opt.Cameras = None,
    threshold: opt.Threshold = None,
    min_separation: opt.MinSeparation = None,
    min_baseline: opt.MinBaseline = None,
    min_angle_deg: opt.MinAngle = None,
    fixed_deg: opt.Fixed = None,
    forbidden_deg: opt.Forbidden = None,
    fov: opt.Fov = None,
    diameter: opt.Diameter = None,
    working_distance: opt.Distance = None,
    focus: opt.Focus = None,
    exclude: opt.Exclude = None,
    objective: opt.Objective = None,
    site_weights: opt.SiteWeights = None,
    falloff_mm: opt.Falloff = None,
    jitter: opt.Jitter = None,
    tilt_deg: opt.TiltDeg = None,
    shift_mm: opt.ShiftMm = None,
    seed: opt.Seed = None,
    certify: opt.Certify = None,
    robustness: Annotated[
        bool,
        typer.Option(
            "--robustness/--no-robustness",
            help="work out what is left when a camera fails or sits askew, and which pairs of cameras do the work",
        ),
    ] = True,
    rig: opt.RigFile = None,
    depth: opt.Depth = None,
    detail: opt.Detail = None,
    repair: opt.Repair = None,
    scale: opt.Scale = None,
    target: opt.Target = None,
    export: Annotated[
        str | None,
        typer.Option(
            help="also write the cameras as camring export does (colmap, transforms, opencv, glb, csv), or the results "
            "as meshes (mesh); several separated by commas",
            show_default="none",
            autocompletion=opt.completing((*opt.FORMATS, "mesh")),
        ),
    ] = None,
    report: Annotated[bool, typer.Option("--report", help="also write report.html, as camring report does")] = False,
    out: opt.Out = Path("out"),
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Find where the cameras should sit, and compare with equidistant ones.

    Writes layout.json, layouts.csv and coverage.png.

    Example: camring optimise scan.stl --cameras 4 --out out/
    """
    from experiments.cli.commands import optimise as command_optimise

    options = dict(
        count=cameras, threshold=threshold, min_separation=min_separation, min_baseline=min_baseline,
        min_angle_deg=min_angle_deg, fixed_deg=fixed_deg, forbidden_deg=forbidden_deg, fov=fov, diameter=diameter,
        working_distance=working_distance, focus=focus, exclude=exclude, objective=objective, site_weights=site_weights,
        falloff_mm=falloff_mm, jitter=jitter, tilt_deg=tilt_deg, shift_mm=shift_mm, seed=seed, certify=certify,
        repair=repair, scale=scale,
    )  # fmt: skip
    command_optimise.run(
        meshes, rig, options, depth=depth, detail=detail, target=target, robust=robustness, export=export,
        with_report=report, out=out, force=force, as_json=json,
    )  # fmt: skip


@app.command()
def count(
    meshes: opt.Meshes,
    target: Annotated[float, typer.Option(help="part of the ring maximum to reach, or the exit status is 1")] = 0.99,
    max_cameras: Annotated[int, typer.Option(help="most cameras to try")] = 16,
    threshold: opt.Threshold = None,
    min_separation: opt.MinSeparation = None,
    min_baseline: opt.MinBaseline = None,
    min_angle_deg: opt.MinAngle = None,
    fixed_deg: opt.Fixed = None,
    forbidden_deg: opt.Forbidden = None,
    fov: opt.Fov = None,
    diameter: opt.Diameter = None,
    working_distance: opt.Distance = None,
    focus: opt.Focus = None,
    exclude: opt.Exclude = None,
    objective: opt.Objective = None,
    site_weights: opt.SiteWeights = None,
    falloff_mm: opt.Falloff = None,
    jitter: opt.Jitter = None,
    tilt_deg: opt.TiltDeg = None,
    shift_mm: opt.ShiftMm = None,
    seed: opt.Seed = None,
    certify: opt.Certify = None,
    rig: opt.RigFile = None,
    depth: opt.Depth = None,
    detail: opt.Detail = None,
    repair: opt.Repair = None,
    scale: opt.Scale = None,
    out: opt.Out = Path("out"),
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Find how many cameras reach a target, well placed and equidistant.

    Writes count.csv, anew after every number of cameras, count.png, and layout.json of the fewest cameras that reach
    the target. Takes a minute or so for each number of cameras; most of it is the bound, which --no-certify leaves out.

    Example: camring count scan.stl --target 0.97 --max-cameras 8 --out count/
    """
    from experiments.cli.commands import count as command_count

    options = dict(
        threshold=threshold, min_separation=min_separation, min_baseline=min_baseline, min_angle_deg=min_angle_deg,
        fixed_deg=fixed_deg, forbidden_deg=forbidden_deg, fov=fov, diameter=diameter, working_distance=working_distance,
        focus=focus, exclude=exclude, objective=objective, site_weights=site_weights, falloff_mm=falloff_mm,
        jitter=jitter, tilt_deg=tilt_deg, shift_mm=shift_mm, seed=seed, certify=certify, repair=repair, scale=scale,
    )  # fmt: skip
    command_count.run(
        meshes, rig, options, target=target, max_cameras=max_cameras, depth=depth, detail=detail, out=out, force=force,
        as_json=json,
    )  # fmt: skip


@app.command()
def evaluate(
    mesh: opt.Mesh,
    cameras: Annotated[int | None, typer.Option(help="that many equidistant cameras")] = None,
    angles_deg: Annotated[str | None, typer.Option(help="ring angles, separated by commas [degrees]")] = None,
    layout: Annotated[
        Path | None, typer.Option(help="layout.json; it brings its own ring, threshold and baseline")
    ] = None,
    threshold: opt.Threshold = None,
    min_baseline: opt.MinBaseline = None,
    fov: opt.Fov = None,
    diameter: opt.Diameter = None,
    working_distance: opt.Distance = None,
    focus: opt.Focus = None,
    exclude: opt.Exclude = None,
    rig: opt.RigFile = None,
    depth: opt.Depth = None,
    detail: opt.Detail = None,
    repair: opt.Repair = None,
    scale: opt.Scale = None,
    target: opt.Target = None,
    out: Annotated[
        Path | None, typer.Option(help="folder for the reconstructable part and the coloured surface as meshes")
    ] = None,
    images: Annotated[
        Path | None, typer.Option(help="folder for a picture of what each camera sees, faces seen in part in red")
    ] = None,
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Exact area that a given ring of cameras reconstructs.

    Give the cameras in one of four ways: --cameras, --angles-deg, --layout, or their number in a --rig file.

    Example: camring evaluate scan.stl --angles-deg 0,90,180 --out out/
    """
    from experiments.cli.commands import evaluate as command_evaluate

    options = dict(
        count=cameras, threshold=threshold, min_baseline=min_baseline, fov=fov, diameter=diameter,
        working_distance=working_distance, focus=focus, exclude=exclude, repair=repair, scale=scale,
    )  # fmt: skip
    command_evaluate.run(
        mesh, rig, options, angles_deg=angles_deg, layout=layout, depth=depth, detail=detail, target=target, out=out,
        images=images, force=force, as_json=json,
    )  # fmt: skip


@app.command()
def compare(
    layouts: Annotated[list[Path], typer.Argument(help="two or more layout.json files")],
    mesh: Annotated[str, typer.Option(help=opt.MESH_HELP, autocompletion=opt.completing(opt.SITES))],
    threshold: Annotated[
        int | None, typer.Option(help="number of cameras that must see a point", show_default="the first layout's")
    ] = None,
    min_baseline: Annotated[
        float | None,
        typer.Option(
            help="least distance between two of the cameras that see a point [mm]",
            show_default="the greatest of the layouts'",
        ),
    ] = None,
    exclude: opt.Exclude = None,
    depth: opt.Depth = None,
    detail: opt.Detail = None,
    repair: opt.Repair = False,
    scale: opt.Scale = 1.0,
    out: Annotated[Path | None, typer.Option(help="folder for layouts.csv and coverage.png")] = None,
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Score several layouts on the same mesh.

    Example: camring compare a/layout.json b/layout.json --mesh scan.stl
    """
    from experiments.cli.commands import compare as command_compare

    command_compare.run(
        layouts, mesh, threshold=threshold, min_baseline=min_baseline, exclude=exclude, depth=depth, detail=detail,
        repair=bool(repair), scale=1.0 if scale is None else scale, out=out, force=force, as_json=json,
    )  # fmt: skip


@app.command()
def export(
    layout: Annotated[Path, typer.Argument(help="layout.json")],
    format: Annotated[
        str,
        typer.Option(
            help="one or more of colmap, transforms, opencv, glb, csv, separated by commas",
            autocompletion=opt.completing(opt.FORMATS),
        ),
    ],
    mesh: Annotated[
        str | None,
        typer.Option(
            help="the mesh the layout was made for, which glb shows: a file, or a built-in site",
            autocompletion=opt.completing(opt.SITES),
        ),
    ] = None,
    depth: opt.Depth = None,
    detail: opt.Detail = None,
    repair: opt.Repair = None,
    resolution: Annotated[
        str | None,
        typer.Option(help="image size, width x height [pixels]", show_default="longer side 3600, pixels square"),
    ] = None,
    out: opt.Out = Path("out"),
    force: Annotated[
        bool, typer.Option("--force", help="replace results that are there; allow another mesh than the layout's")
    ] = False,
    json: opt.Json = False,
) -> None:
    """Write the cameras of a layout in the formats of other programs.

    For COLMAP, nerfstudio (transforms), OpenCV, Blender and viewers of glTF (glb), or as a table (csv).

    Example: camring export out/layout.json --format colmap,transforms --out out/
    """
    from experiments.cli.commands import export as command_export

    command_export.run(layout, format, mesh, depth, detail, bool(repair), resolution, out, force, as_json=json)


@app.command()
def report(
    layout: Annotated[Path, typer.Argument(help="folder with a layout.json, or that file")],
    mesh: Annotated[
        str | None,
        typer.Option(
            help="the mesh that the layout was made for, the first of several: a file, or a built-in site",
            show_default="the built-in site it was made for",
            autocompletion=opt.completing(opt.SITES),
        ),
    ] = None,
    exclude: Annotated[
        str | None,
        typer.Option(help="faces that did not count, if a file lists them", show_default="what layout.json says"),
    ] = None,
    repair: opt.Repair = None,
    out: Annotated[
        Path | None, typer.Option(help="folder for the report", show_default="the layout's own folder")
    ] = None,
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Write a page that shows a layout and all that is known of it, for anyone with a browser.

    Writes report.html: tables, drawings and the surface in three dimensions, in one file that needs no network. Shows
    count.csv of camring count too, if it lies beside layout.json.

    Example: camring report out/ --mesh scan.stl
    """
    from experiments.cli.commands import report as command_report

    command_report.run(layout, mesh, exclude, bool(repair), out, force, json)


@app.command()
def site(
    name: Annotated[
        str | None, typer.Argument(help="name of a built-in site", autocompletion=opt.completing(opt.SITES))
    ] = None,
    depth: opt.Depth = None,
    detail: opt.Detail = None,
    listing: Annotated[bool, typer.Option("--list", help="list the built-in sites")] = False,
    out: Annotated[Path | None, typer.Option(help="mesh file to write: .stl, .ply or .obj")] = None,
    gallery: Annotated[Path | None, typer.Option(help="picture of all sites, cut open, to write: .png")] = None,
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Write a built-in reference site to a mesh file, list them, or draw them all.

    Example: camring site circ_artery --depth 50 --out artery.stl
    """
    from experiments.cli.commands import site as command_site

    command_site.run(name, depth, detail, listing, out, gallery, force, json)


@app.command()
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


rig_app = typer.Typer(help="Rig files: all settings of a request, for --rig.", no_args_is_help=True)
app.add_typer(rig_app, name="rig")


@rig_app.callback()
def rig() -> None:
    """Rig files: all settings of a request, for --rig."""


@rig_app.command("init")
def rig_init(
    path: Annotated[Path, typer.Argument(help="file to write")] = Path("rig.toml"),
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Write a commented rig file that holds every setting with its default and unit.

    Example: camring rig init rig.toml
    """
    from experiments.cli.commands import rig as command_rig

    command_rig.init(path, force, json)


@app.command()
def paper(
    quick: Annotated[bool, typer.Option("--quick", help="two sites, up to 16 cameras: a first look")] = False,
    report_only: opt.ReportOnly = False,
    detail: opt.Detail = None,
    scheduler: opt.Scheduler = None,
    out: opt.Out = Path("out/paper"),
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Repeat the tables, fits and figures of Wachter 2021, beside its numbers; takes minutes.

    A run that was stopped goes on where it was when the same command is given again.

    Example: camring paper --out out/paper
    """
    from experiments.cli.commands import paper as command_paper

    command_paper.run(quick, report_only, detail or "coarse", scheduler, out, force, json)


@app.command()
def study(
    quick: Annotated[bool, typer.Option("--quick", help="two sites, 2 and 3 cameras: a first look")] = False,
    report_only: opt.ReportOnly = False,
    detail: opt.Detail = None,
    scheduler: opt.Scheduler = None,
    out: opt.Out = Path("out/study"),
    force: opt.Force = False,
    json: opt.Json = False,
) -> None:
    """Optimised against equidistant rings on the ten sites of Wachter 2021, with certificates; takes an hour.

    A run that was stopped goes on where it was when the same command is given again.

    Example: camring study --out out/study
    """
    from experiments.cli.commands import study as command_study

    command_study.run(quick, report_only, detail or "coarse", scheduler, out, force, json)


def main(arguments: list[str] | None = None) -> None:
    """Run `camring` and exit: 0; 1 if a target was missed; 2, with one message, if the request cannot be met.

    Without arguments it is the program itself, takes those of the command line, and ends the process whatever still
    runs in it.
    """
    keep_compiled()
    print_anything()
    if arguments is None:
        stop_when_asked()
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
