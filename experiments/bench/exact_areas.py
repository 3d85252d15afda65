"""camring bench exact: how right and how fast the exact evaluator is, measured in one run."""

import csv
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from trimesh.ray.ray_pyembree import RayMeshIntersector

import exact
import meshes
from exact.scene import forget
from experiments.bench.paper_algorithm import t_view_area
from experiments.files.whole import output_folder, written_whole
from experiments.terminal.console import note, print_json, table, terminal
from experiments.terminal.progress import progress_stages
from placement.samples.sampled_site import faces_towards
from placement.samples.sampling import sample_surface

OUTPUTS = ("bench_exact.csv", "bench_exact.png")
SITE, DEPTH = "circ_artery", 50
N_RAYS = 1_000_000
REPEATS = 5
RING = exact.Ring()


def run(out: Path, force: bool, as_json: bool = False) -> None:
    """Measure, print, write a table and a picture."""
    output_folder(out, OUTPUTS, force)
    rows = []
    with progress_stages() as progress:
        for number, measure in enumerate(MEASUREMENTS):
            progress(measure.__name__.strip("_").replace("_", " "), number, len(MEASUREMENTS))
            rows += measure()
    if as_json:
        print_json({"figures": [dict(zip(("what", "value", "unit", "target"), row, strict=True)) for row in rows]})
    else:
        shown = table("what", "value", "unit", "target")
        for row in rows:
            shown.add_row(*row)
        terminal().print(shown)
    with written_whole(out / OUTPUTS[0]) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("what", "value", "unit", "target"))
        writer.writerows(rows)
    _draw(out / OUTPUTS[1], rows)
    note(f"wrote {out / OUTPUTS[0]}, {out / OUTPUTS[1]}")


def _seconds(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """Median time of a call on a mesh never seen before [s]."""
    times = []
    for _ in range(repeats):
        forget()
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def _site(detail: str, name: str = SITE):
    mesh = meshes.site(name, depth=DEPTH, detail=detail)
    return mesh, meshes.top_surface(mesh)


def _evaluate(mesh, exclude, n_cameras: int, workers: int = 1) -> exact.Reconstruction:
    return exact.evaluate(mesh, RING.cameras(RING.equidistant(n_cameras)), exclude=exclude, workers=workers)


def _embree(mesh, exclude, n_cameras: int, seed: int = 0) -> tuple[float, float]:
    """The same area by rays to points on the faces that some camera could see, and its standard error [mm²]."""
    samples = sample_surface(mesh, N_RAYS, exclude | ~faces_towards(mesh, RING), seed)
    rays = RayMeshIntersector(mesh, scale_to_box=False)
    count = np.zeros(len(samples.points), dtype=int)
    for camera in RING.cameras(RING.equidistant(n_cameras)):
        away = camera.position - samples.points
        local = -away @ camera.rotation.T
        seen = (away * samples.normals).sum(axis=1) > 0
        seen &= (np.abs(local[:, :2]) <= camera.half_extent * local[:, 2:]).all(axis=1)
        asked = np.flatnonzero(seen)
        count[asked] += ~rays.intersects_any(samples.points[asked] + 1e-4 * samples.normals[asked], away[asked])
    hit = count >= 2
    error = samples.area * np.sqrt(hit.mean() * (1 - hit.mean()) / len(hit))
    return float(samples.weights @ hit), float(error)


def _against_rays() -> list[tuple[str, str, str, str]]:
    mesh, exclude = _site("middle")
    ours = _seconds(lambda: _evaluate(mesh, exclude, 8))
    rays = _seconds(lambda: _embree(mesh, exclude, 8), repeats=3)
    area, (estimate, error) = _evaluate(mesh, exclude, 8).area, _embree(mesh, exclude, 8)
    return [
        (f"faces of {SITE}, depth {DEPTH} mm, middle detail", f"{len(mesh.faces)}", "", ""),
        ("exact area, 8 cameras", f"{ours:.3f}", "s", ""),
        ("Embree estimate, 1e6 points, 8 cameras", f"{rays:.3f}", "s", ""),
        ("exact over Embree time", f"{ours / rays:.3f}", "", "at most 0.3"),
        ("exact less Embree area", f"{area - estimate:+.3f}", "mm²", ""),
        ("standard error of the Embree area", f"{error:.3f}", "mm²", ""),
    ]


def _many_cameras() -> list[tuple[str, str, str, str]]:
    mesh, exclude = _site("middle")
    _evaluate(mesh, exclude, 2, workers=2)  # starts the worker processes
    rows = []
    times = {
        (n, workers): _seconds(
            lambda n=n, workers=workers: _evaluate(mesh, exclude, n, workers), REPEATS if n == 8 else 3
        )
        for n in (8, 360)
        for workers in (1, 2)
    }
    for workers in (1, 2):
        words = "one process" if workers == 1 else "two processes"
        ratio = times[360, workers] / times[8, workers]
        rows += [
            (f"exact area, 8 cameras, {words}", f"{times[8, workers]:.3f}", "s", ""),
            (f"exact area, 360 cameras, {words}", f"{times[360, workers]:.2f}", "s", ""),
            (f"360 over 8 cameras, {words}", f"{ratio:.2f}", "", "at most 20"),
        ]
    return [
        *rows,
        ("one process over two, 360 cameras", f"{times[360, 1] / times[360, 2]:.2f}", "", "at least 1.5"),
        ("one process over two, 8 cameras", f"{times[8, 1] / times[8, 2]:.2f}", "", ""),
    ]


def _many_faces() -> list[tuple[str, str, str, str]]:
    times, faces = [], []
    for detail in ("coarse", "middle", "fine"):
        mesh, exclude = _site(detail, "circ_overhang")  # whose details are nearest to 20 000 and 80 000 faces
        times.append(_seconds(lambda mesh=mesh, exclude=exclude: _evaluate(mesh, exclude, 8), 3))
        faces.append(len(mesh.faces))
    return [
        *((f"exact area, 8 cameras, {f} faces", f"{t:.3f}", "s", "") for f, t in zip(faces, times, strict=True)),
        (f"{faces[2]} over {faces[1]} faces", f"{times[2] / times[1]:.2f}", "", "at most 4.5"),
    ]


def _limits_and_errors() -> list[tuple[str, str, str, str]]:
    """Processor time of limits and errors, in parts of that of a plain evaluation, each the least of several."""
    mesh, exclude = _site("middle")
    cameras = RING.cameras(RING.equidistant(8))
    limits = {"depth_of_field": (370.0, 395.0), "min_pixel_density": 1000.0, "max_incidence": float(np.radians(80))}
    requests = {
        "": {},
        "errors": {"all_views": True},
        **{
            f"limit {name.replace('_', ' ')}": {"limits": exact.Limits(**{name: most})} for name, most in limits.items()
        },
        "one light": {"lights": [(0.0, 60.0, 400.0)]},
        "all limits": {"limits": exact.Limits(**limits)},
        **{f"max_error {most:g} mm": {"max_error": most} for most in (0.1, 0.08, 0.05)},
        "all limits, max_error 0.08 mm": {"limits": exact.Limits(**limits), "max_error": 0.08},
    }
    times: dict[str, list[float]] = {}

    def timed(name: str, start: float) -> None:
        times.setdefault(name, []).append(time.process_time() - start)

    for _ in range(REPEATS):  # in turn, since how fast a machine is changes
        for name, asked in requests.items():
            start = time.process_time()
            found = exact.evaluate(mesh, cameras, exclude=exclude, **asked)
            if name == "errors":
                _ = found.errors
            timed(name, start)
    plain = min(times.pop(""))
    return [
        (f"{name}, 8 cameras, over plain", f"{min(spent) / plain:.2f}", "", "at most 1.6")
        for name, spent in times.items()
    ]


def _memory() -> list[tuple[str, str, str, str]]:
    # In a process of its own, since the greatest memory of a process never falls.
    program = f"from experiments.bench.exact_areas import peak_memory; peak_memory({360})"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return [("peak resident memory, 360 cameras", done.stdout.strip(), "GB", "at most 1.5")]


def peak_memory(n_cameras: int) -> None:
    """Print the greatest resident memory of this process after one evaluation [GB]."""
    mesh, exclude = _site("middle")
    _evaluate(mesh, exclude, n_cameras)
    print(f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9:.2f}")


def _paper_algorithm() -> list[tuple[str, str, str, str]]:
    rows = []
    # On `circ_flat` nearest-vertex order is right, so areas must agree; on `circ_artery` it is not everywhere.
    for name in ("circ_flat", SITE):
        mesh = meshes.site(name, depth=DEPTH, detail="coarse")
        exclude, cameras = meshes.top_surface(mesh), RING.cameras(RING.equidistant(8))
        start = time.perf_counter()
        theirs = t_view_area(exact.Scene(mesh, exclude=exclude), cameras, exact.Demand())
        plain = time.perf_counter() - start
        ours = _seconds(lambda mesh=mesh, exclude=exclude: _evaluate(mesh, exclude, 8))
        area = _evaluate(mesh, exclude, 8).area
        target = "at most 1e-6" if name == "circ_flat" else ""
        rows += [
            (
                f"paper's algorithm over exact time, {name}, {len(mesh.faces)} faces",
                f"{plain / ours:.0f}",
                "",
                "at least 100",
            ),
            (f"paper's algorithm against exact area, {name}", f"{abs(theirs / area - 1):.1e}", "", target),
        ]
    return rows


def _vertex_order() -> list[tuple[str, str, str, str]]:
    rows = []
    for name, site in meshes.SITES.items():
        for depth in site.depths[:2]:
            mesh = meshes.site(name, depth=depth, detail="coarse")
            ring = exact.Ring(fov=site.fov)
            exclude, cameras = meshes.top_surface(mesh), ring.cameras(ring.equidistant(8))
            right, vertex = (
                exact.evaluate(mesh, cameras, exclude=exclude, depth_order=order).area for order in ("exact", "vertex")
            )
            rows.append(
                (f"error of nearest-vertex order, {name} {depth:g}", f"{100 * (vertex / right - 1):+.4f}", "%", "")
            )
    return rows


MEASUREMENTS = (_against_rays, _many_cameras, _many_faces, _limits_and_errors, _memory, _paper_algorithm, _vertex_order)


def _draw(path: Path, rows: list[tuple[str, str, str, str]]) -> None:
    """Each measured ratio as a bar in parts of its target, on a logarithmic axis: left of the line is good."""
    bars = []
    for what, value, _, target in rows:
        if target:
            goal = float(target.split()[-1])
            part = float(value) / goal if target.startswith("at most") else goal / float(value)
            bars.append((what, max(part, 1e-3), f"{value} (target {target})"))
    figure = Figure(figsize=(10, 0.6 * len(bars) + 1.6), dpi=150, layout="constrained")
    ax = figure.subplots()
    where = np.arange(len(bars))[::-1]
    ax.barh(where, [part for _, part, _ in bars], color=["#1f5fa8" if p <= 1 else "#c0392b" for _, p, _ in bars])
    for y, (_, part, words) in zip(where, bars, strict=True):
        ax.text(part * 1.08, y, words, va="center", fontsize=9)
    ax.axvline(1.0, color="black", linewidth=1)
    ax.set_yticks(where, [what for what, _, _ in bars], fontsize=9)
    ax.set(xscale="log", xlim=(5e-4, 60), xlabel="part of what is allowed (left of the line: target met)")
    ax.set_title(f"exact evaluator on {os.cpu_count()} cores", fontsize=11)
    ax.spines[["top", "right"]].set_visible(False)
    with written_whole(path) as temporary:
        figure.savefig(temporary)
