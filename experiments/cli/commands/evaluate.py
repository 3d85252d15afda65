"""camring evaluate: the exact area that a given set of ring cameras reconstructs."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import exact
from experiments.cli.options import refuse_ring_beside_layout
from experiments.cli.results_folder import results_folder
from experiments.files.errors import InputError
from experiments.files.whole import image_names, output_folder
from experiments.layouts import layout_content, layout_file
from experiments.request import rig as rig_file
from experiments.request.exact_work import ring_maximum, workers_for
from experiments.request.meshes import Subject
from experiments.request.option_text import parse_angles
from experiments.request.outlook import seen
from experiments.request.request import Request, request
from experiments.request.rig import overridden
from experiments.request.target_fraction import checked_target, reach
from experiments.tables.sites import weights_words
from experiments.terminal.console import note, print_json, table, terminal
from experiments.terminal.progress import progress_bar
from placement.rings.ring_places import Places, cameras_of
from placement.search.ring_maximum import unbased

OUTPUTS = (
    "reconstructable.stl", "reconstructable.ply", "coverage.ply", "coverage.glb", "errors.ply", "errors.glb",
    "evaluation.json",
)  # fmt: skip
# More cameras are not listed one by one, and their errors take as long as the rest together, and more.
MOST_SHOWN = 32
# Shares of the area whose greatest errors are told.
SHARES = (0.05, 0.5, 0.95)
# Less of a mesh than this part of its area is rounding, such as of a face that is seen from its edge.
UNSEEN = 1e-12
# So much of what is seen is the back if that is why nothing counts [parts].
ALL_BACK = 0.5
# Cameras nearer to each other than this [mm] are in one place: less than any mount moves.
SAME_PLACE = 1e-3


@dataclass(frozen=True, eq=False)
class _Cameras:
    """Cameras on a ring or several, which of them each sits on, from 0, and what makes a point count."""

    rings: tuple[exact.Ring, ...]
    ring_of: np.ndarray
    angles: np.ndarray
    demand: exact.Demand
    rolls: np.ndarray | None = None

    @property
    def is_several(self) -> bool:
        """Whether it takes words to say on which ring a camera sits."""
        return len(self.rings) > 1

    def all(self) -> tuple[exact.Camera, ...]:
        """(M,) the cameras."""
        if not self.is_several:
            return tuple(self.rings[0].cameras(self.angles, self.rolls))
        return cameras_of(self.rings, Places(self.ring_of, self.angles))


def run(
    mesh: str,
    rig_path: Path | None,
    options: dict[str, Any],
    *,
    angles_deg: str | None,
    layout: Path | None,
    depth: float | None,
    detail: str | None,
    target: float | None,
    out: Path | None,
    images: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Evaluate, print and write; `options` are those of the rig, by the names of their keys."""
    checked_target(target)
    ways = [way is not None for way in (options["count"], angles_deg, layout)]
    if sum(ways) > 1 or (not any(ways) and rig_path is None):
        raise InputError(
            "give the cameras in exactly one way: --cameras N, --angles-deg 0,90,180, --layout FILE, or --rig FILE "
            "with their number"
        )
    if layout is not None:
        refuse_ring_beside_layout(options, rig_path)
    # One mesh as it is: what a rig file says of several and of poses is for layouts that serve them all.
    made = None if layout is None else layout_file.read(layout, several=True)
    if made is not None and len(made.rings) > 1 and options["place"] is not None:
        raise InputError("--place finds the place of one ring; leave it out, or give a layout on one ring")
    given = options if made is None else options | made.loaded(mesh, options)
    rig = replace(rig_file.rig(rig_path, **given), jitter=1, site_weights=None)
    asked = request([mesh], depth, detail, rig, None if made is None else made.ring)
    if made is not None:
        made.refuse_other_mesh(asked.subjects[0].mesh, asked.name, force)
        rings, demand = (asked.ring, *made.rings[1:]), overridden(made.moved_to(asked.ring), options)
        cameras = _Cameras(rings, made.ring_of, made.angles, demand, made.rolls)
    else:
        listed = angles_deg is not None
        angles = np.radians(parse_angles(angles_deg)) if listed else asked.ring.equidistant(asked.rig.n_cameras)
        cameras = _Cameras((asked.ring,), np.zeros(len(angles), dtype=int), angles, asked.demand)
    _warn_of_one_place(cameras)
    if out is not None:
        results_folder(out, OUTPUTS, asked.subjects[0], force)
    if images is not None:
        output_folder(images, image_names(len(cameras.angles)), force)
    result, content = _evaluate(asked, cameras, with_maximum=target is not None, with_meshes=out is not None)
    if as_json:
        print_json(content)
    else:
        _print(asked, cameras, result, content)
    if out is not None:
        _write(out, asked, result, content)
    if images is not None:
        _write_images(images, asked, cameras)
    if target is not None:
        reach(target, content["fraction_of_ring_maximum"], f"these {len(cameras.angles)} cameras")


def _warn_of_one_place(given: _Cameras) -> None:
    """Two cameras in one place are two views to the count, and none to triangulation."""
    if given.demand.threshold < 2 or given.demand.baseline > 0:
        return
    centre = np.array([camera.position for camera in given.all()])
    apart = np.linalg.norm(centre[:, None] - centre[None, :], axis=2)
    apart[np.tri(len(centre), dtype=bool)] = np.inf
    first, second = np.unravel_index(np.argmin(apart), apart.shape)
    if apart[first, second] < SAME_PLACE:
        note(
            f"warning: cameras {first + 1} and {second + 1} sit in the same place, which counts as two views and "
            "triangulates nothing; --min-baseline 1 counts only what cameras 1 mm apart see"
        )


def _evaluate(
    asked: Request, given: _Cameras, with_maximum: bool, with_meshes: bool
) -> tuple[exact.Reconstruction, dict[str, Any]]:
    """The reconstruction, and all figures as they stand in evaluation.json."""
    about, scene = asked.subjects[0], asked.poses[0].scene
    cameras = given.all()
    workers = workers_for(scene, len(cameras))
    few = len(cameras) <= MOST_SHOWN
    at_once = few and not with_meshes  # which would be cut wherever the set of cameras changes
    with progress_bar("evaluating", len(cameras) * (1 if at_once else 2)) as advance:
        result = exact.evaluate(scene, cameras, demand=given.demand, workers=workers, report=advance, all_views=at_once)
        refuse_unseen(about, result, given.rings[0])
        if at_once:
            single = result.camera_areas
        else:  # where one has seen enough the others have not looked
            alone = [[camera] for camera in cameras]
            by_one = replace(unbased(given.demand), threshold=1)
            single = exact.areas(scene, alone, demand=by_one, workers=workers, report=advance)
    maximum = None
    if with_maximum:
        n_ring = asked.settings.ring_cameras
        with progress_bar("evaluating all the ring", n_ring * len(given.rings)) as advance:
            maximum = ring_maximum(scene, given.rings, given.demand, n_ring, advance)
    content = {
        "mesh": {
            "name": about.name,
            "sha256": scene.mesh_hash,
            "excluded": asked.excluded[0].words,
            "scale": asked.rig.scale,
            "repair": asked.rig.repair,
            "two_sided": asked.rig.two_sided,
            **about.told,
        },
        **_rings_content(given),
        "angles_rad": given.angles.tolist(),
        "angles_deg": np.degrees(given.angles).tolist(),
        **({} if given.rolls is None else {"rolls_rad": given.rolls.tolist()}),
        "threshold": given.demand.threshold,
        "min_baseline_mm": given.demand.min_baseline,
        "area_mm2": result.area,
        "level_areas_mm2": result.level_areas.tolist(),
        "camera_areas_mm2": single.tolist(),
        "repairs": result.repairs,
    }
    if result.threshold > 1 and few and result.area > 0:
        content["errors_mm"] = {
            "along": given.demand.error,
            "rms": result.error_rms,
            "quantiles": dict(zip(map(str, SHARES), result.error_quantiles(SHARES), strict=True)),
        }
    if maximum is not None:
        content |= {"ring_maximum_mm2": maximum, "fraction_of_ring_maximum": result.area / maximum if maximum else 0.0}
    return result, content


def _rings_content(given: _Cameras) -> dict[str, Any]:
    """The ring, or the rings and which of them each camera sits on, from 1."""
    if not given.is_several:
        return {"ring": layout_content.ring_content(given.rings[0])}
    return {
        "rings": [layout_content.ring_content(ring) for ring in given.rings],
        "ring_of_camera": (given.ring_of + 1).tolist(),
    }


def _write(out: Path, asked: Request, result: exact.Reconstruction, content: dict[str, Any]) -> None:
    from experiments.exports import (
        coverage_mesh,  # it brings matplotlib for its colours, which figures alone do not need
    )

    layout_content.write(out / "evaluation.json", content)
    names = coverage_mesh.write(out, result)
    names += coverage_mesh.write_errors(out, result if "errors_mm" in content else None)
    missing = "" if "reconstructable.stl" in names else "; nothing is reconstructable, so there is no mesh of it"
    note(f"wrote {', '.join(str(out / name) for name in (*names, 'evaluation.json'))}{missing}")


def _write_images(folder: Path, asked: Request, given: _Cameras) -> None:
    from experiments.figures.camera_images import write_camera_images  # matplotlib is heavy, and the rest needs none

    with progress_bar("drawing", len(given.angles)) as advance:
        on = [f"ring {k + 1}, " if given.is_several else "" for k in given.ring_of]
        degrees = np.degrees(given.angles) % 360
        places = [f"{ring}ring angle {angle:.1f}°" for ring, angle in zip(on, degrees, strict=True)]
        is_radial = given.rolls is None and all(ring.roll == "radial" for ring in given.rings)
        names = write_camera_images(folder, asked.name, asked.subjects[0].mesh, given.all(), places, is_radial, advance)
    note(f"wrote {folder / names[0]}{f' to {names[-1]}' if len(names) > 1 else ''}")


def refuse_unseen(about: Subject, result: exact.Reconstruction, ring: exact.Ring) -> None:
    """Raise InputError if no camera sees anything that counts."""
    if result.level_areas[0] <= UNSEEN * about.mesh.area:
        back = seen(about.mesh, ring).back
        why = (
            f"; {100 * back:.1f} % of what faces the cameras is its back: --repair turns a surface that is wound the "
            "wrong way, --two-sided counts both sides"
        )
        spans = ", ".join(
            f"{axis} {low:g} to {high:g}" for axis, low, high in zip("xyz", *about.mesh.bounds.tolist(), strict=True)
        )
        raise InputError(
            f"no camera sees any part of {about.name} that counts; check that it lies at the focus (it spans "
            f"{spans} mm, and --focus says where the cameras look; --place auto finds where they should), inside the "
            "field of view, with its normals towards the cameras, and that its unit is millimetres "
            f"(--scale){why if back > ALL_BACK else ''}"
        )


def _print(asked: Request, given: _Cameras, result: exact.Reconstruction, content: dict[str, Any]) -> None:
    console = terminal()
    console.print(f"{asked.name}: {len(asked.subjects[0].mesh.faces)} faces; not counted: {asked.excluded[0].words}")
    if asked.rig.falloff_mm is not None:
        console.print(weights_words(asked.rig.falloff_mm))
    shown = table("seen by", "exact area [mm²]")
    for level, area in enumerate(result.level_areas, start=1):
        who = "at least 1 camera" if level == 1 else f"at least {level} cameras"
        shown.add_row(who, f"{area:.4f}")
    if result.demand.baseline > 0:
        shown.add_row(f"… two of them {result.demand.baseline:.4g} mm apart", f"{result.area:.4f}")
    console.print(shown)
    of_ring = ["ring"] if given.is_several else []
    shown = table("camera", *of_ring, "ring angle [degrees]", "exact area [mm²]")
    rows = zip(given.ring_of, given.angles, content["camera_areas_mm2"], strict=True)
    for number, (k, angle, area) in enumerate(rows, start=1):
        ring = [str(k + 1)] if given.is_several else []
        shown.add_row(str(number), *ring, f"{np.degrees(angle):.3f}", f"{area:.4f}")
    if len(given.angles) <= MOST_SHOWN:
        console.print(shown)
    if "errors_mm" in content:
        errors = content["errors_mm"]
        half, most = (errors["quantiles"][str(share)] for share in SHARES[1:])
        console.print(
            f"predicted {errors['along']} error: RMS {errors['rms']:.4f} mm; half of the area to {half:.4f} mm, "
            f"95 % to {most:.4f} mm"
        )
    if "ring_maximum_mm2" in content:
        console.print(
            f"ring maximum ({asked.settings.ring_cameras} cameras{' on each ring' if given.is_several else ''}): "
            f"{content['ring_maximum_mm2']:.4f} mm², of "
            f"which {100 * content['fraction_of_ring_maximum']:.2f} % are reconstructable"
        )
    console.print(f"reconstructable area: {result.area:.4f} mm²")
    if result.repairs:
        console.print(f"{result.repairs} steps had to be done in the robust way")
