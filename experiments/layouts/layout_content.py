"""What `camring optimise` and `camring count` write into `layout.json`: the layout, and all that repeats it."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import exact
from experiments.files.table import finite
from experiments.files.whole import written_whole
from experiments.request.declared_fields import declared
from experiments.request.options import CLASSES
from meshes import fingerprint

if TYPE_CHECKING:  # at run time it would bring jax along, which reading a layout hardly ever needs
    import placement
    from experiments.request.request import Request

FORMAT, VERSION = "camring layout", 1
# What the file calls each field of a ring: with its unit, where it has one.
RING = {field.name: f"{field.name}_mm" if "[mm]" in field.words else field.name for field in declared(*CLASSES["Ring"])}


def ring_content(ring: exact.Ring) -> dict[str, Any]:
    """The ring as it stands in the file, lengths in millimetres."""
    values = {key: getattr(ring, name) for name, key in RING.items()}
    return {key: list(value) if isinstance(value, tuple) else value for key, value in values.items()}


def placement_content(found: "placement.Placement", asked: "Request") -> dict[str, Any]:
    """A `placement.Placement` as it stands in the file.

    Areas are sums over the meshes, of several poses of a mesh their mean; fractions are what was maximised: the mean
    over all meshes and poses, or the worst. "mesh" is the first, "meshes" are all of them.
    """
    first, n_poses = found.sites[0], asked.n_poses
    names = ("optimised", "equidistant", "best_equidistant", "ring_maximum")
    areas = (found.area, found.equidistant_area, found.best_equidistant_area, found.ring_area)
    fractions = (found.fraction, found.equidistant_fraction, found.best_equidistant_fraction, 1.0)
    errors = {
        "optimised": found.error_rms,
        "equidistant": found.equidistant_error_rms,
        "best_equidistant": found.best_equidistant_error_rms,
        "most_area": found.most_area_error_rms,
    }
    return {
        "format": FORMAT,
        "version": VERSION,
        "ring": ring_content(found.ring),
        "n_cameras": found.n_cameras,
        "threshold": found.threshold,
        "demand": asdict(found.demand),
        "angles_deg": np.degrees(found.angles).tolist(),
        "angles_rad": list(found.angles),
        **rolls_content(found.rolls),
        "best_equidistant_phase_deg": float(np.degrees(found.best_equidistant_phase)),
        "areas_mm2": {name: area / n_poses for name, area in zip(names, areas, strict=True)},
        "fractions_of_ring_maximum": dict(zip(names, fractions, strict=True)),
        "rms_errors_mm": {name: finite(value) for name, value in errors.items()},
        "give_up": found.give_up,
        "most_area": {
            "angles_deg": np.degrees(found.most_area.angles).tolist(),
            "angles_rad": list(found.most_area.angles),
            **rolls_content(found.most_area.rolls),
            "area_mm2": found.most_area.area / n_poses,
            "fraction_of_ring_maximum": found.most_area.fraction,
        },
        **scene_content(asked),
        "smallest_separation_mm": found.smallest_separation if found.n_cameras > 1 else None,
        "mesh": {"name": asked.subjects[0].name, "sha256": first.mesh_hash, "excluded": asked.excluded[0].words,
                 "n_excluded_faces": first.n_excluded, **_loaded(asked, 0)},
        "meshes": [_mesh_content(found, asked, number) for number in range(len(asked.subjects))],
        "objective": found.objective,
        "constraints": asdict(found.constraints),
        "starts_rad": [list(start) for start in found.starts],
        "certificate": None if found.certificate is None else certificate_content(found.certificate),
        "settings": asdict(found.settings),
        "seed": found.seed,
        "versions": found.versions,
    }  # fmt: skip


def scene_content(asked: "Request") -> dict[str, Any]:
    """What stands around the meshes, and how each of them counts, as any layout file says it."""
    rig, scene = asked.rig, asked.poses[0].scene
    poses = {"n": asked.n_poses, "tilt_deg": rig.tilt_deg, "shift_mm": rig.shift_mm}
    return {
        "obstacles": [fingerprint(one) for one in scene.obstacles],
        "lights": [list(light) for light in scene.lights],
        "poses": poses if asked.n_poses > 1 else None,
        "falloff_mm": rig.falloff_mm,
    }


def rolls_content(rolls: tuple[float, ...] | None) -> dict[str, list[float]]:
    """Rolls of the cameras' own; nothing where they are the ring's."""
    return {} if rolls is None else {"rolls_deg": np.degrees(rolls).tolist(), "rolls_rad": list(rolls)}


def _mesh_content(found: "placement.Placement", asked: "Request", number: int) -> dict[str, Any]:
    """One mesh: what it is, how much it counts, and its areas in each pose."""
    sites = found.sites[number * asked.n_poses : (number + 1) * asked.n_poses]
    return {
        **mesh_content(asked, number, sites[0].mesh_hash),
        "areas_of_poses_mm2": [
            {"optimised": site.area, "equidistant": site.equidistant_area,
             "best_equidistant": site.best_equidistant_area, "ring_maximum": site.ring_area}
            for site in sites
        ],
    }  # fmt: skip


def mesh_content(asked: "Request", number: int, mesh_hash: str) -> dict[str, Any]:
    """One of the meshes asked for, as any layout file says it, with what it takes to load it again."""
    excluded = asked.excluded[number]
    return {
        "name": asked.subjects[number].name,
        "sha256": mesh_hash,
        "excluded": excluded.words,
        "n_excluded_faces": int(excluded.mask.sum()),
        **_loaded(asked, number),
        "weight": asked.weights[number],
    }


def _loaded(asked: "Request", number: int) -> dict[str, Any]:
    """How the mesh was loaded, so that it can be again, and what was said of it."""
    about, rig = asked.subjects[number], asked.rig
    if about.is_site:
        return {"scale": 1.0, "repair": False, "two_sided": False, **about.told}
    return {"scale": rig.scale, "repair": rig.repair, "two_sided": rig.two_sided, **about.told}


def certificate_content(certificate) -> dict[str, Any]:
    """A `placement.Certificate` as it stands in the file: fractions of the ring maximum of the samples."""
    return {
        "bound_fraction": certificate.bound_fraction,
        "gap": certificate.gap,
        "grid_bound_fraction": certificate.grid_bound_fraction,
        "grid_gap": certificate.grid_gap,
        "proven": certificate.proven,
        "surface": None if certificate.surface is None else asdict(certificate.surface),
        "statement": certificate.statement,
    }


def write(path: Path, content: dict[str, Any]) -> None:
    """Write `content` as JSON, whole or not at all."""
    with written_whole(path) as temporary:
        temporary.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n", encoding="utf-8")
