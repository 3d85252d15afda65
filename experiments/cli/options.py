"""Arguments and options that several subcommands of `camring` share: their types, what they mean, how they complete.

An option that a rig file may set has the default None, so that the file's value holds where the option is not given;
`show_default` says what holds without either.
"""

from pathlib import Path
from typing import Annotated

import typer

# Names for the shell to complete; here once more, since where they come from imports what `--help` must not wait for.
SITES = (
    "circ_flat", "circ_angled", "circ_artery", "circ_overhang", "elliptical",
    "spine_disc", "cerebellopontine", "glioblastoma", "eye_anterior",
)  # fmt: skip
DETAILS = ("coarse", "middle", "fine")
BENCHMARKS = ("exact", "sites", "surrogate")
OBJECTIVES = ("mean", "worst")
FORMATS = ("colmap", "transforms", "opencv", "glb", "csv")


def completing(words: tuple[str, ...]):
    """Completion of an option's or argument's words; the shell offers files where none of them fits."""
    return lambda incomplete: [word for word in words if word.startswith(incomplete)]


MESH_HELP = "STL, OBJ or PLY file [mm], or the name of a built-in site"
Mesh = Annotated[str, typer.Argument(help=MESH_HELP, autocompletion=completing(SITES))]
Meshes = Annotated[
    list[str],
    typer.Argument(
        metavar="MESH...",
        help=f"{MESH_HELP}, with its depth if need be: circ_artery@100; several for one layout that serves all",
        autocompletion=completing(SITES),
    ),
]
Depth = Annotated[float | None, typer.Option(help="depth of a built-in site [mm]", show_default="the site's first")]
Detail = Annotated[
    str | None,
    typer.Option(help="size of a built-in site: coarse, middle or fine", autocompletion=completing(DETAILS)),
]
Repair = Annotated[
    bool | None,
    typer.Option("--repair/--no-repair", help="put right what can be: winding, faces without area", show_default="no"),
]
Scale = Annotated[
    float | None,
    typer.Option(help="factor from the mesh file's unit to millimetres: 1000 for metres", show_default="1"),
]
RigFile = Annotated[
    Path | None,
    typer.Option("--rig", help="TOML file of settings, as camring rig init writes one; options given here win over it"),
]
Cameras = Annotated[int | None, typer.Option(help="number of cameras", show_default="4")]
Threshold = Annotated[int | None, typer.Option(help="number of cameras that must see a point", show_default="2")]
Fov = Annotated[
    str | None,
    typer.Option(help="field of view at the focus, width x height [mm]", show_default="36x24, or the site's own"),
]
Diameter = Annotated[float | None, typer.Option(help="diameter of the ring [mm]", show_default="30")]
Distance = Annotated[
    float | None, typer.Option(help="distance of the ring's plane from the focus [mm]", show_default="400")
]
Focus = Annotated[str | None, typer.Option(help="the point that all cameras look at, x,y,z [mm]", show_default="0,0,0")]
Exclude = Annotated[
    str | None,
    typer.Option(
        help="faces that do not count: top (the top surface), none, or a file with one face index per line",
        show_default="top for built-in sites, none for files",
        autocompletion=completing(("top", "none")),
    ),
]
MinSeparation = Annotated[float | None, typer.Option(help="least distance between two cameras [mm]", show_default="5")]
MinBaseline = Annotated[
    float | None, typer.Option(help="least distance between two of the cameras that see a point [mm]", show_default="0")
]
MinAngle = Annotated[
    float | None,
    typer.Option(help="the same as an angle at the focus [degrees]; the stricter of both counts", show_default="0"),
]
Fixed = Annotated[
    str | None,
    typer.Option(help="ring angles of cameras that stay where they are, as in 0,90 [degrees]", show_default="none"),
]
Forbidden = Annotated[
    str | None,
    typer.Option(help="arcs without cameras, start:end, as in 60:90,200:230 [degrees]", show_default="none"),
]
Target = Annotated[
    float | None,
    typer.Option(
        help="fraction of the ring maximum that must be reached, or the exit status is 1", show_default="none"
    ),
]
Seed = Annotated[int | None, typer.Option(help="of the search; the same seed gives the same layout", show_default="0")]
Certify = Annotated[
    bool | None,
    typer.Option("--certify/--no-certify", help="bound what any layout could reconstruct", show_default="certify"),
]
Objective = Annotated[
    str | None,
    typer.Option(
        help="of several meshes: maximise the mean of their fractions of the ring maximum, or that of the worst",
        show_default="mean",
        autocompletion=completing(OBJECTIVES),
    ),
]
SiteWeights = Annotated[
    str | None, typer.Option(help="how much each mesh counts in the mean, as in 1,2", show_default="all equally")
]
Falloff = Annotated[
    float | None,
    typer.Option(
        help="distance from the focus at which a face counts half, falling off on [mm]", show_default="all count fully"
    ),
]
Jitter = Annotated[
    int | None, typer.Option(help="poses of each mesh to serve, the mesh as it is among them", show_default="1")
]
TiltDeg = Annotated[float | None, typer.Option(help="greatest tilt of the poses [degrees]", show_default="2")]
ShiftMm = Annotated[float | None, typer.Option(help="greatest shift of the poses [mm]", show_default="1")]
ReportOnly = Annotated[
    bool, typer.Option("--report-only", help="compute nothing; write tables and figures anew from what is there")
]
Scheduler = Annotated[
    str | None,
    typer.Option(help="address of a Dask scheduler, tcp://...", show_default="the processors of this machine"),
]
Json = Annotated[bool, typer.Option("--json", help="results as one JSON document on stdout")]
Out = Annotated[Path, typer.Option(help="folder for the results; it is made if need be")]
Force = Annotated[bool, typer.Option("--force", help="replace results that are already there")]
