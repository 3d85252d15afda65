"""camring design: serve the page on which the cameras of a ring are moved."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from platformdirs import user_state_path

from experiments.cli.extras import refuse_without
from experiments.cli.options import MESH, RING_ITSELF
from experiments.files.errors import InputError
from experiments.files.whole import output_folder
from experiments.layouts import layout_file
from experiments.request import rig as rig_file
from experiments.request.options import keys
from experiments.request.outlook import seen
from experiments.request.request import Request, request
from experiments.request.rig import overridden
from experiments.terminal.console import note, print_json

if TYPE_CHECKING:  # at run time they would bring the extra along
    from experiments.design.design import Design
    from experiments.design.session import Reader

SESSION = "session.json"


def run(
    mesh: str,
    rig_path: Path | None,
    options: dict[str, Any],
    *,
    layout: Path | None,
    depth: float | None,
    detail: str | None,
    port: int,
    browser: bool,
    fresh: bool,
    as_json: bool,
) -> None:
    """Serve; `options` are those of the rig, by the names of their keys."""
    refuse_without("design", "camring design")
    from experiments.design import server
    from experiments.design.history import History
    from experiments.design.session import Reader, Session, nothing_seen
    from experiments.design.studio import Studio

    if layout is not None:
        _refuse_beside_layout(rig_path, options)
    rig = replace(rig_file.rig(rig_path, **options), jitter=1, site_weights=None)
    made = None if layout is None else layout_file.read(layout)
    asked = request([mesh], depth, detail, rig, None if made is None else made.ring)
    kept = _folder(asked) / SESSION
    output_folder(kept.parent, (SESSION,), force=True)  # another run with this mesh would write into it
    reader = Reader(asked.name, _mesh(asked), rig.constraints)
    first = _first(asked, made, options, reader)
    why = "start" if made is None else f"opened from {made.path.name}"
    history = None if fresh else History.read(kept, reader.design)
    if history is None:
        history = History(first, why)
    else:
        tried = len(history.tried)
        note(f"restored {tried} {'layout' if tried == 1 else 'layouts'} tried before; --fresh starts anew")
        given = {name for name, value in options.items() if value is not None}
        if made is not None or rig_path is not None or given - {*MESH, "seed"}:
            history.add(first, why)
    if not seen(asked.subjects[0].mesh, asked.ring).in_view:
        note(f"warning: {nothing_seen(asked.poses[0].scene, asked.ring)}")
    studio = Studio(asked, Session(reader, history), kept)
    studio.keep()

    def opened(address: str) -> None:
        if as_json:
            print_json({"address": address})
        else:
            print(address)
        sys.stdout.flush()  # a pipe, too, is to have it now
        note("open this address in a browser on this machine; Ctrl-C ends it, and what was tried is kept")
        if browser:
            server.open_browser(address)

    server.serve(studio, port, opened)


def _folder(asked: Request) -> Path:
    """Where what is tried with this mesh is kept."""
    return user_state_path("camring") / "designs" / asked.poses[0].scene.content_hash[:32]


def _mesh(asked: Request) -> dict[str, Any]:
    """What a layout file says of the mesh."""
    scene, about = asked.poses[0].scene, asked.subjects[0]
    return {"name": about.name, "sha256": scene.mesh_hash}


def _first(asked: Request, made: layout_file.LayoutFile | None, options: dict[str, Any], reader: "Reader") -> "Design":
    """The design to begin with: that of a layout file, else the equidistant one of the request."""
    from experiments.design.session import first_design

    if made is None:
        asked.check_cameras(asked.rig.n_cameras)
        return first_design(asked.ring, asked.rig)
    made.refuse_other_mesh(asked.subjects[0].mesh, asked.name, force=None)
    demand = overridden(made.moved_to(asked.ring), options)
    return reader.design(replace(made, rings=(asked.ring,), demand=demand))


def _refuse_beside_layout(rig_path: Path | None, options: dict[str, Any]) -> None:
    """Refuse what a layout brings along itself."""
    of_constraints = [name for name, one in keys("Constraints").items() if one.classes == ("Constraints",)]
    flags = [key.flag for name, key in keys().items() if name in ("count", *RING_ITSELF, *of_constraints)
             and options.get(name) is not None]  # fmt: skip
    flags += ["--rig"] * (rig_path is not None)
    if flags:
        raise InputError(
            f"a layout brings its own ring, cameras and constraints; leave {', '.join(flags)} out, and change them on "
            "the page"
        )
