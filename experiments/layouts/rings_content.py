"""What `camring optimise` writes for several rings: which camera sits on which, and what each ring does alone."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from experiments.files.table import finite
from experiments.layouts.layout_content import mesh_content, ring_content, scene_content

if TYPE_CHECKING:
    import placement
    from experiments.request.request import Request

RINGS_FORMAT, VERSION = "camring layout on several rings", 1
# The most that a ring takes stands beside what it is.
MOST_CAMERAS = "most_cameras"


def rings_content(found: "placement.RingsPlacement", asked: "Request") -> dict[str, Any]:
    """A `placement.RingsPlacement` as it stands in the file.

    Areas are sums over the meshes, of several poses of a mesh their mean. Rings are counted from 1.
    """
    most, n_poses = found.most_area, asked.n_poses
    return {
        "format": RINGS_FORMAT,
        "version": VERSION,
        "rings": [
            ring_content(ring) | {MOST_CAMERAS: takes} for ring, takes in zip(found.rings, found.most, strict=True)
        ],
        "n_cameras": found.n_cameras,
        "threshold": found.demand.threshold,
        "demand": asdict(found.demand),
        "cameras": _cameras(found.ring_of, found.angles),
        "area_mm2": found.area / n_poses,
        "fraction_of_all_rings": found.fraction,
        "rms_error_mm": finite(found.error_rms),
        "smallest_separation_mm": finite(found.smallest_separation),
        "all_rings_area_mm2": found.maximum_area / n_poses,
        "most_area": {
            "cameras": _cameras(most.ring_of, most.angles),
            "area_mm2": most.area / n_poses,
            "fraction_of_all_rings": most.fraction,
            "rms_error_mm": finite(found.most_area_error_rms),
        },
        "rings_alone": [_alone(one, n_poses) for one in found.alone],
        "give_up": found.give_up,
        "objective": found.objective,
        **scene_content(asked),
        "meshes": [_mesh(found, asked, number) for number in range(len(asked.subjects))],
        "constraints": asdict(found.constraints[0]),
        "certificate": None
        if found.certificate is None
        else asdict(found.certificate) | {"statement": found.certificate.statement},
        "settings": asdict(found.settings),
        "seed": found.seed,
        "versions": found.versions,
    }


def _mesh(found: "placement.RingsPlacement", asked: "Request", number: int) -> dict[str, Any]:
    poses = slice(number * asked.n_poses, (number + 1) * asked.n_poses)
    return {
        **mesh_content(asked, number, found.mesh_hashes[poses][0]),
        "areas_of_poses_mm2": [
            {"optimised": area, "all_rings": maximum}
            for area, maximum in zip(found.areas[poses], found.maximum_areas[poses], strict=True)
        ],
    }


def _cameras(ring_of, angles) -> list[dict[str, Any]]:
    return [
        {"ring": k + 1, "ring_angle_deg": float(np.degrees(angle)), "ring_angle_rad": angle}
        for k, angle in zip(ring_of, angles, strict=True)
    ]


def _alone(one: "placement.OneRing", n_poses: int) -> dict[str, Any]:
    found = one.placement
    if found is None:
        return {"refused": one.refused}
    return {
        "ring_angles_deg": np.degrees(found.angles).tolist(),
        "area_mm2": found.area / n_poses,
        "fraction_of_all_rings": one.fraction,
        "rms_error_mm": finite(found.error_rms),
        "smallest_separation_mm": finite(found.smallest_separation),
        "equidistant_area_mm2": found.equidistant_area / n_poses,
        "equidistant_fraction_of_all_rings": one.equidistant_fraction,
        "equidistant_rms_error_mm": finite(found.equidistant_error_rms),
        "best_equidistant_area_mm2": found.best_equidistant_area / n_poses,
        "best_equidistant_fraction_of_all_rings": one.best_equidistant_fraction,
        "best_equidistant_phase_deg": float(np.degrees(found.best_equidistant_phase)),
        "best_equidistant_rms_error_mm": finite(found.best_equidistant_error_rms),
        "ring_maximum_mm2": found.ring_area / n_poses,
    }
