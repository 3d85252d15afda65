"""camring bench meshes: time and memory over the number of faces, for scans, CAD parts and channels."""

import csv
import json
import os
import resource
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, astuple, dataclass, fields
from pathlib import Path

import exact
import meshes
import placement
from exact.workers import end
from experiments.bench.generated_meshes import KINDS
from experiments.files.errors import InputError
from experiments.files.whole import output_folder, written_whole
from experiments.terminal.console import note, print_json, table, terminal
from experiments.terminal.progress import progress_stages

OUTPUTS = ("bench_meshes.csv",)
WORKERS = 2
# Worker processes that were ended are gone by then [s].
REAPED_WITHIN = 2.0


@dataclass(frozen=True)
class Case:
    """What is measured, in a process of its own.

    Attributes
    ----------
    kind : str
        Which of `KINDS`.
    n_faces : int
        About how many faces.
    task : str
        "evaluate", or "optimise" for the best layout without a certificate.
    n_cameras : int
    """

    kind: str
    n_faces: int
    task: str = "evaluate"
    n_cameras: int = 8

    @property
    def words(self) -> str:
        """What it is called in tables."""
        return f"{self.task} {self.n_cameras}, {self.kind} {self.n_faces}"


@dataclass(frozen=True)
class Cost:
    """What a case took.

    Attributes
    ----------
    kind, task : str
    n_faces, n_cameras : int
        Faces as they are.
    wall_s, cpu_s : float
        Time from the mesh to the area [s], of all processes together [s].
    peak_gb : float
        Greatest resident memory of a process [GB].
    area_mm2 : float
        What came out.
    """

    kind: str
    task: str
    n_faces: int
    n_cameras: int
    wall_s: float
    cpu_s: float
    peak_gb: float
    area_mm2: float

    @property
    def cpu_us_per_face(self) -> float:
        """CPU time of a face [µs]."""
        return 1e6 * self.cpu_s / self.n_faces


CASES = (
    Case("sphere", 82_000),
    Case("site", 20_980),
    Case("site", 20_980, n_cameras=360),
    Case("site", 81_738),
    Case("brain", 40_000),
    Case("skull", 60_000),
    Case("cylinders", 80_000),
    Case("channel", 21_000),
    Case("channel", 21_000, n_cameras=360),
    Case("brain", 40_000, "optimise", 4),
    Case("skull", 60_000, "optimise", 4),
    Case("brain", 250_000),
    Case("brain", 1_000_000),
    Case("brain", 1_000_000, "optimise", 4),
)
SPHERE, SITE, BRAIN, SKULL, CYLINDERS = CASES[0], CASES[1], CASES[4], CASES[5], CASES[6]


def run(out: Path, force: bool, as_json: bool = False, most_faces: int | None = None) -> None:
    """Measure all cases of at most so many faces, print and write a table."""
    cases = [case for case in CASES if most_faces is None or case.n_faces <= most_faces]
    if not cases:
        least = min(case.n_faces for case in CASES)
        raise InputError(f"--most-faces is {most_faces}; the smallest mesh of this benchmark has {least} faces")
    output_folder(out, OUTPUTS, force)
    costs = {}
    with progress_stages() as progress:
        for number, case in enumerate(cases):
            progress(case.words, number, len(cases))
            costs[case] = measured(case)
    goals = targets(costs)
    if as_json:
        print_json({
            "costs": [asdict(cost) | {"cpu_us_per_face": cost.cpu_us_per_face} for cost in costs.values()],
            "targets": [dict(zip(("what", "value", "at_most"), goal, strict=True)) for goal in goals],
        })  # fmt: skip
    else:
        _print(costs.values(), goals)
    with written_whole(out / OUTPUTS[0]) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([field.name for field in fields(Cost)])
        writer.writerows(astuple(cost) for cost in costs.values())
    note(f"wrote {out / OUTPUTS[0]}")


def _print(costs, goals) -> None:
    shown = table("task", "mesh", "faces", "time [s]", "CPU [s]", "CPU a face [µs]", "memory [GB]")
    for cost in costs:
        shown.add_row(
            f"{cost.task} {cost.n_cameras}", cost.kind, f"{cost.n_faces}", f"{cost.wall_s:.2f}", f"{cost.cpu_s:.2f}",
            f"{cost.cpu_us_per_face:.0f}", f"{cost.peak_gb:.2f}",
        )  # fmt: skip
    terminal().print(shown)
    if goals:
        shown = table("what", "measured", "at most")
        for what, value, most in goals:
            shown.add_row(what, f"{value:.2f}", f"{most:g}")
        terminal().print(shown)


def targets(costs: dict[Case, Cost]) -> list[tuple[str, float, float]]:
    """What was aimed at, as far as its cases were measured: words, value, and what it should be at most.

    Examples
    --------
    >>> cost = Cost("brain", "optimise", 40_000, 4, wall_s=50.0, cpu_s=80.0, peak_gb=0.5, area_mm2=900.0)
    >>> targets({Case("brain", 40_000, "optimise", 4): cost})
    [('optimise 4, brain 40000 [s]', 50.0, 60.0)]
    """
    rows = []
    for one, other, most in ((CYLINDERS, SPHERE, 5.0), (BRAIN, SITE, 4.0), (SKULL, SITE, 4.0)):
        if one in costs and other in costs:
            ratio = costs[one].cpu_us_per_face / costs[other].cpu_us_per_face
            rows.append((f"CPU a face, {one.kind} over {other.kind}", ratio, most))
    for case, cost in costs.items():
        few = Case(case.kind, case.n_faces)
        if case.n_cameras == 360 and few in costs:
            rows.append((f"360 over 8 cameras, {case.kind}", cost.cpu_s / costs[few].cpu_s, 20.0))
    if CYLINDERS in costs:
        rows.append(("memory, cylinders [GB]", costs[CYLINDERS].peak_gb, 1.5))
    limits = {
        Case("brain", 40_000, "optimise", 4): 60.0, Case("skull", 60_000, "optimise", 4): 120.0,
        Case("brain", 1_000_000): 60.0, Case("brain", 1_000_000, "optimise", 4): 600.0,
    }  # fmt: skip
    rows += [(f"{case.words} [s]", costs[case].wall_s, most) for case, most in limits.items() if case in costs]
    return rows


def measured(case: Case) -> Cost:
    """What `case` takes in a process of its own, since the greatest memory of a process never falls."""
    program = f"from experiments.bench import any_size as b; b.measure(b.{case!r})"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    if done.returncode:
        raise InputError(f"{case.words} ended with status {done.returncode}: {done.stderr.strip()[-500:]}")
    return Cost(**json.loads(done.stdout.splitlines()[-1]))


def measure(case: Case) -> None:
    """Print what `case` takes in this process, as JSON."""
    mesh = KINDS[case.kind](case.n_faces)
    exclude = meshes.top_surface(mesh) if case.kind == "site" else None
    start, cpu = time.perf_counter(), _cpu()
    if case.task == "optimise":
        area = placement.optimise(
            mesh, exact.Ring(), n_cameras=case.n_cameras, exclude=exclude, certify=False, workers=WORKERS
        ).area
    else:
        ring = exact.Ring()
        cameras = ring.cameras(ring.equidistant(case.n_cameras))
        # Starting processes takes longer than most of these evaluations.
        workers = WORKERS if len(mesh.faces) > 200_000 or case.n_cameras > 100 else 1
        area = exact.evaluate(mesh, cameras, exclude=exclude, workers=workers).area
    wall = time.perf_counter() - start
    _end_workers()  # so that what they took is known
    cpu = _cpu() - cpu
    cost = Cost(case.kind, case.task, len(mesh.faces), case.n_cameras, wall, cpu, _peak(), float(area))
    print(json.dumps(asdict(cost)))


def _end_workers() -> None:
    end()
    last = time.monotonic() + REAPED_WITHIN
    try:
        while time.monotonic() < last:
            if os.waitpid(-1, os.WNOHANG) == (0, 0):
                time.sleep(0.01)
    except ChildProcessError:
        pass  # all are gone


def _usage() -> Sequence[resource.struct_rusage]:
    return [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]


def _cpu() -> float:
    return sum(usage.ru_utime + usage.ru_stime for usage in _usage())


def _peak() -> float:
    return max(usage.ru_maxrss for usage in _usage()) * 1024 / 1e9
