"""The 240 areas: what equidistant cameras reconstruct of each site, with and without its top surface."""

import csv
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

import exact
import meshes
from experiments.files.errors import InputError
from experiments.files.whole import written_whole
from experiments.paper.cases import FOV, Case
from experiments.sweeps.task import Outcome, Task

# Seconds that a task takes before it comes to the cameras, in those that a camera takes.
CAMERAS_OF_OVERHEAD = 8


@dataclass(frozen=True)
class Area:
    """One of the 240; `area_mm2` is None if it could not be computed, and `failure` says why."""

    site: str
    depth_mm: int
    fov_mm: str
    top_surface_included: bool
    n_cameras: int
    area_mm2: float | None
    failure: str


def reconstructable_areas(
    site: str, depth: float, detail: str, mesh_hash: str, fov: Sequence[float], n_cameras: int
) -> dict[str, Any]:
    """Area [mm²] that at least two of `n_cameras` equidistant cameras see, with and without the top surface.

    One evaluation gives both: what is excluded is not counted, but hides what is behind it all the same.

    Raises
    ------
    InputError
        If this machine builds another mesh than the one with the given fingerprint.

    Examples
    --------
    >>> case = Case("circ_flat", 50, "36x24")
    >>> areas = reconstructable_areas("circ_flat", 50, "coarse", case.mesh_hash("coarse"), (36, 24), 2)
    >>> round(areas["included"] - areas["excluded"], 2)  # the same on every circular site, 50 mm deep
    150.74
    """
    mesh = site_mesh(site, depth, detail, mesh_hash)
    ring = exact.Ring(fov=(float(fov[0]), float(fov[1])))
    face_areas = exact.evaluate(mesh, ring.cameras(ring.equidistant(n_cameras)), threshold=2).face_areas
    return {"included": float(face_areas.sum()), "excluded": float(face_areas[~meshes.top_surface(mesh)].sum())}


def site_mesh(site: str, depth: float, detail: str, mesh_hash: str) -> trimesh.Trimesh:
    """The built-in site, if it is the one that is meant; errors as for `reconstructable_areas`."""
    mesh = meshes.site(site, depth, detail)
    if meshes.fingerprint(mesh) != mesh_hash:
        raise InputError(f"this machine builds another {site} {depth:g} mm ({detail}); install the same manifold3d")
    return mesh


def area_tasks(cases: Sequence[Case], counts: Sequence[int], detail: str) -> list[Task]:
    """A task for each case and number of cameras, the numbers running faster."""
    return [
        Task(
            reconstructable_areas,
            {
                "site": case.site, "depth": case.depth, "detail": detail, "mesh_hash": case.mesh_hash(detail),
                "fov": FOV[case.fov], "n_cameras": n,
            },
            cost=n + CAMERAS_OF_OVERHEAD,
            packages=("meshes", "exact"),
        )
        for case in cases
        for n in counts
    ]  # fmt: skip


def area_rows(cases: Sequence[Case], counts: Sequence[int], outcomes: Sequence[Outcome]) -> list[Area]:
    """Two rows for each task of `area_tasks`, in the order of the published file."""
    found = dict(zip([(case, n) for case in cases for n in counts], outcomes, strict=True))
    return [
        Area(
            case.site, case.depth, case.fov, included, n,
            None if outcome.result is None else outcome.result["included" if included else "excluded"],
            outcome.failure,
        )
        for included in (True, False)
        for case in cases
        for n in counts
        for outcome in (found[case, n],)
    ]  # fmt: skip


def write_areas(path: Path, rows: Sequence[Area]) -> None:
    """Write all areas in full."""
    with written_whole(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(field.name for field in fields(Area))
        for row in rows:
            area = "" if row.area_mm2 is None else repr(row.area_mm2)
            writer.writerow([*astuple(row)[:3], int(row.top_surface_included), row.n_cameras, area, row.failure])


def read_areas(path: Path) -> list[Area]:
    """Read what `write_areas` has written.

    Raises
    ------
    InputError
        If there is no such file.
    """
    if not path.exists():
        raise InputError(f"there is no {path}; run `camring paper --out {path.parent}` first, without --report-only")
    with path.open(newline="", encoding="utf-8") as file:
        return [
            Area(
                row["site"], int(row["depth_mm"]), row["fov_mm"], row["top_surface_included"] == "1",
                int(row["n_cameras"]), float(row["area_mm2"]) if row["area_mm2"] else None, row["failure"],
            )
            for row in csv.DictReader(file)
        ]  # fmt: skip


def curve(rows: Sequence[Area], case: Case, included: bool) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of cameras and areas [mm²] of one case, those without a failure."""
    chosen = [
        row
        for row in rows
        if (row.site, row.depth_mm, row.fov_mm, row.top_surface_included) == (case.site, case.depth, case.fov, included)
        and row.area_mm2 is not None
    ]
    return np.array([row.n_cameras for row in chosen]), np.array([row.area_mm2 for row in chosen], dtype=float)
