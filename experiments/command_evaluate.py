"""camring evaluate: the exact area that a given set of ring cameras reconstructs."""

from pathlib import Path

import numpy as np

import exact
from experiments import layout_file
from experiments.errors import InputError
from experiments.files import output_folder, written_whole
from experiments.inputs import exclusion, parse_angles, ring, subject
from experiments.progress import progress_bar
from experiments.terminal import table, terminal
from meshes import fingerprint

OUTPUTS = ("reconstructable.stl", "reconstructable.ply", "evaluation.json")


def run(
    mesh: str,
    n_cameras: int | None,
    angles_deg: str | None,
    layout: Path | None,
    threshold: int | None,
    min_baseline: float,
    fov: str | None,
    diameter: float | None,
    working_distance: float | None,
    exclude: str | None,
    depth: float | None,
    detail: str | None,
    repair: bool,
    out: Path | None,
    force: bool,
) -> None:
    """Evaluate, print and write."""
    if sum(choice is not None for choice in (n_cameras, angles_deg, layout)) != 1:
        raise InputError("give the cameras in exactly one way: --cameras N, --angles-deg 0,90,180 or --layout FILE")
    if layout is not None and (fov, diameter, working_distance) != (None, None, None):
        raise InputError("a layout brings its own ring; leave --fov, --diameter and --working-distance out")
    about = subject(mesh, depth, detail, repair)
    if layout is not None:
        made = layout_file.read(layout)
        rig, angles = made.ring, made.angles
        threshold = made.threshold if threshold is None else threshold
        if made.mesh_hash not in (None, fingerprint(about.mesh)):
            terminal(stderr=True).print(f"note: {layout} was made for another mesh")
    else:
        rig = ring(
            about, fov, 30.0 if diameter is None else diameter, 400.0 if working_distance is None else working_distance
        )
        angles = parse_angles(angles_deg) if angles_deg is not None else rig.equidistant(n_cameras or 0)
    threshold = 2 if threshold is None else threshold
    excluded = exclusion(about, exclude)
    if out is not None:
        output_folder(out, OUTPUTS, force)
    cameras = rig.cameras(angles)
    with progress_bar("evaluating", 2 * len(cameras)) as advance:
        result = exact.evaluate(about.mesh, cameras, threshold, excluded.mask, min_baseline, report=advance)
        single = []
        for camera in cameras:
            single.append(exact.evaluate(about.mesh, [camera], 1, excluded.mask).area)
            advance(1)
    refuse_unseen(about.name, result)
    _print(about, excluded.words, angles, result, single)
    if out is None:
        return
    content = {
        "mesh": {"name": about.name, "sha256": fingerprint(about.mesh), "excluded": excluded.words},
        "ring": layout_file.ring_content(rig),
        "angles_rad": angles.tolist(),
        "angles_deg": np.degrees(angles).tolist(),
        "threshold": threshold,
        "min_baseline_mm": min_baseline,
        "area_mm2": result.area,
        "level_areas_mm2": result.level_areas.tolist(),
        "camera_areas_mm2": single,
        "repairs": result.repairs,
    }
    layout_file.write(out / "evaluation.json", content)
    part = result.to_mesh()
    if not len(part.faces):
        print(f"wrote {out / 'evaluation.json'}; nothing is reconstructable, so there is no mesh to write")
        return
    for name in OUTPUTS[:2]:
        with written_whole(out / name) as temporary:
            part.export(temporary)
    print(f"wrote {', '.join(str(out / name) for name in OUTPUTS)}")


def refuse_unseen(name: str, result: exact.Reconstruction) -> None:
    """Raise InputError if no camera sees anything that counts."""
    if result.level_areas[0] == 0.0:
        raise InputError(
            f"no camera sees any part of {name} that counts; check that it lies at the focus (the origin), "
            "inside the field of view, with its normals towards the cameras, and that its unit is millimetres"
        )


def _print(about, excluded: str, angles: np.ndarray, result: exact.Reconstruction, single: list[float]) -> None:
    console = terminal()
    console.print(f"{about.name}: {len(about.mesh.faces)} faces; not counted: {excluded}")
    shown = table("seen by", "exact area [mm²]")
    for level, area in enumerate(result.level_areas, start=1):
        who = "at least 1 camera" if level == 1 else f"at least {level} cameras"
        shown.add_row(who, f"{area:.4f}")
    if result.min_baseline > 0:
        shown.add_row(
            f"… two of them {result.min_baseline:g} mm apart",
            f"{result.area:.4f}",
        )
    console.print(shown)
    shown = table("camera", "ring angle [degrees]", "exact area [mm²]")
    for number, (angle, area) in enumerate(zip(angles, single, strict=True), start=1):
        shown.add_row(str(number), f"{np.degrees(angle):.3f}", f"{area:.4f}")
    if len(angles) <= 32:
        console.print(shown)
    console.print(f"reconstructable area: {result.area:.4f} mm²")
    if result.repairs:
        console.print(f"{result.repairs} steps had to be done in the robust way")
