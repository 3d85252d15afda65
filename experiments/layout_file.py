"""The file `layout.json`: a ring and where its cameras sit, with the exact areas and all that repeats them."""

import json
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

import exact
import placement
from experiments.errors import InputError
from experiments.files import written_whole

FORMAT = "camring layout"
VERSION = 1


@dataclass(frozen=True, eq=False)
class LayoutFile:
    """What is read back from a layout file; `min_baseline` [mm] is that of its constraints, `content` all of it."""

    path: Path
    ring: exact.Ring
    angles: np.ndarray
    threshold: int
    min_baseline: float
    content: dict[str, Any]

    @property
    def mesh_hash(self) -> str | None:
        """Fingerprint of the mesh it was made for, if it says."""
        mesh = self.content.get("mesh")
        return mesh.get("sha256") if isinstance(mesh, dict) else None


def ring_content(ring: exact.Ring) -> dict[str, Any]:
    """The ring as it stands in the file, lengths in millimetres."""
    return {
        "diameter_mm": ring.diameter,
        "working_distance_mm": ring.working_distance,
        "fov_mm": list(ring.fov),
        "focus_mm": list(ring.focus),
        "axis": list(ring.axis),
    }


def placement_content(placement, mesh_name: str, excluded: str) -> dict[str, Any]:
    """A `placement.Placement` as it stands in the file."""
    maximum = placement.ring_area
    areas = {
        "optimised": placement.area,
        "equidistant": placement.equidistant_area,
        "best_equidistant": placement.best_equidistant_area,
        "ring_maximum": maximum,
    }
    constraints = asdict(placement.constraints)
    return {
        "format": FORMAT,
        "version": VERSION,
        "ring": ring_content(placement.ring),
        "n_cameras": placement.n_cameras,
        "threshold": placement.threshold,
        "angles_deg": np.degrees(placement.angles).tolist(),
        "angles_rad": list(placement.angles),
        "best_equidistant_phase_deg": float(np.degrees(placement.best_equidistant_phase)),
        "areas_mm2": areas,
        "fractions_of_ring_maximum": {name: area / maximum for name, area in areas.items()},
        "smallest_separation_mm": placement.smallest_separation if placement.n_cameras > 1 else None,
        "mesh": {"name": mesh_name, "sha256": placement.mesh_hash, "excluded": excluded,
                 "n_excluded_faces": placement.n_excluded},
        "constraints": constraints,
        "certificate": None if placement.certificate is None else certificate_content(placement.certificate),
        "settings": asdict(placement.settings),
        "seed": placement.seed,
        "versions": placement.versions,
    }  # fmt: skip


def certificate_content(certificate) -> dict[str, Any]:
    """A `placement.Certificate` as it stands in the file: fractions of the ring maximum of the samples."""
    return {
        "bound_fraction": certificate.bound_fraction,
        "gap": certificate.gap,
        "grid_bound_fraction": certificate.grid_bound_fraction,
        "grid_gap": certificate.grid_gap,
        "proven": certificate.proven,
        "statement": certificate.statement,
    }


def write(path: Path, content: dict[str, Any]) -> None:
    """Write `content` as JSON, whole or not at all."""
    with written_whole(path) as temporary:
        temporary.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n", encoding="utf-8")


def read(path: Path) -> LayoutFile:
    """Read and check a layout file.

    `angles_rad` is what counts; a file written by hand may give `angles_deg` instead.

    Raises
    ------
    InputError
        If it is not there, not JSON, or says too little or something else than a layout.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"cannot read layout {path}: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} is not a layout file: it holds no valid JSON ({error})") from error
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise InputError(f'{path} is not a layout file: "format" must be "{FORMAT}"; camring optimise writes one')
    if content.get("version") != VERSION:
        raise InputError(
            f"{path} has layout version {content.get('version')!r}; only {VERSION} is known: update camring"
        )
    ring = content.get("ring")
    if not isinstance(ring, dict) or not {"diameter_mm", "working_distance_mm", "fov_mm"} <= set(ring):
        raise InputError(f'{path}: "ring" must give diameter_mm, working_distance_mm and fov_mm')
    try:
        made = exact.Ring(
            diameter=ring["diameter_mm"],
            working_distance=ring["working_distance_mm"],
            fov=ring["fov_mm"],
            focus=ring.get("focus_mm", (0.0, 0.0, 0.0)),
            axis=ring.get("axis", (0.0, 0.0, 1.0)),
        )
        angles = _angles(content)
        made.positions(angles)
        min_baseline = _constraints(content).baseline(made)
    except (exact.ExactError, placement.PlacementError, InputError) as error:
        raise InputError(f"{path}: {error}") from error
    threshold = content.get("threshold", 2)
    if isinstance(threshold, bool) or not isinstance(threshold, int) or not 1 <= threshold <= len(angles):
        raise InputError(f'{path}: "threshold" is {threshold!r}; it must be a whole number from 1 to {len(angles)}')
    return LayoutFile(path, made, angles, threshold, min_baseline, content)


def _constraints(content: dict[str, Any]) -> placement.Constraints:
    """Those the layout meets; none for a file that says nothing of them, such as one written by hand."""
    kept = content.get("constraints", {"min_separation": 0.0})
    known = {field.name for field in fields(placement.Constraints)}
    if not isinstance(kept, dict) or not set(kept) <= known:
        raise InputError(f'"constraints" is {kept!r}; it must give some of {", ".join(sorted(known))}')
    return placement.Constraints(**kept)


def _angles(content: dict[str, Any]) -> np.ndarray:
    for key, unit in (("angles_rad", 1.0), ("angles_deg", np.pi / 180)):
        if key in content:
            values = content[key]
            numbers = isinstance(values, list) and values
            if not numbers or any(isinstance(v, bool) or not isinstance(v, int | float) for v in values):
                raise InputError(f'"{key}" must be a list of at least one number')
            return np.array(values, dtype=np.float64) * unit
    raise InputError('it gives no ring angles; "angles_rad" or "angles_deg" must list them')
