"""The record beside the results of a sweep: what was asked for, with what, and how long it took."""

import json
import platform
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import shapely

from experiments.files.whole import written_whole
from experiments.sweeps.task import Outcome, Task

LIBRARIES = (
    "camring", "embreex", "equinox", "jax", "loky", "manifold3d", "matplotlib", "numpy", "optimistix", "scipy",
    "shapely", "trimesh",
)  # fmt: skip


def write_record(
    path: Path,
    settings: dict[str, Any],
    mesh_hashes: dict[str, str],
    tasks: Sequence[Task],
    outcomes: Sequence[Outcome],
    pool: str,
    wall_seconds: float,
    n_resumed: int,
) -> None:
    """Write what is needed to repeat a run, and to judge it, as JSON.

    Parameters
    ----------
    path : Path
    settings : dict
        All that the run was asked for, with defaults and seeds filled in.
    mesh_hashes : dict
        `meshes.fingerprint` of each mesh, by name.
    tasks, outcomes : sequence
        As of `experiments.sweeps.sweep.sweep`.
    pool : str
        Where the tasks were done.
    wall_seconds : float
        Of this run; tasks that were on disk when it began took their time before.
    n_resumed : int
        How many tasks those were.
    """
    content = {
        "settings": settings,
        "mesh_hashes": mesh_hashes,
        "versions": {
            "python": platform.python_version(),
            "geos": shapely.geos_version_string,
            **{name: version(name) for name in LIBRARIES},
        },
        "platform": f"{platform.system()} {platform.machine()}",
        "pool": pool,
        "wall_seconds": round(wall_seconds, 1),
        "tasks_found_done": n_resumed,
        "task_seconds": round(sum(outcome.seconds for outcome in outcomes), 1),
        "tasks": [
            {
                "name": task.name,
                **task.identity,
                "seconds": round(outcome.seconds, 3),
                **({"failure": outcome.failure} if outcome.failure else {}),
            }
            for task, outcome in zip(tasks, outcomes, strict=True)
        ],
    }
    with written_whole(path) as temporary:
        temporary.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
