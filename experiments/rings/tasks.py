"""The tasks of a sweep over rings: on each the layout that `camring optimise` would propose, and from there on."""

import contextlib
import io
import json
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

import exact
import placement
from experiments.files.errors import InputError
from experiments.files.table import finite
from experiments.layouts.layout_content import RING, placement_content, ring_content, rolls_content
from experiments.request.meshes import is_site
from experiments.request.request import Request, request
from experiments.request.rig_content import rig_content, rig_of
from experiments.sweeps.task import Task

# What a refinement takes from a layout file, and leaves in its own.
STARTS = (
    "format", "version", "ring", "n_cameras", "threshold", "angles_rad", "rolls_rad", "mesh", "constraints",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Asked:
    """What is asked on every ring.

    Attributes
    ----------
    names : (S,) tuple of str
        Files and built-in sites.
    depth, detail : float or None, str or None
        Of built-in sites.
    request : Request
        Of the same meshes, under the ring of its rig.
    """

    names: tuple[str, ...]
    depth: float | None
    detail: str | None
    request: Request

    def task(self, ring: exact.Ring) -> Task:
        """To be done for one ring."""
        return Task(placed, self._inputs() | {"ring": ring_content(ring)})

    def refinement(
        self, layout: dict[str, Any], diameter: tuple[float, float], working_distance: tuple[float, float]
    ) -> Task:
        """To be done from one layout on, as it stands in a layout file, within these bounds [mm]."""
        start = {name: layout[name] for name in STARTS if name in layout}
        bounds = {"diameter": list(diameter), "working_distance": list(working_distance)}
        return Task(refined, self._inputs() | {"layout": start} | bounds, cost=2.0)

    def _inputs(self) -> dict[str, Any]:
        """Of every task, as JSON holds it."""
        rig = self.request.rig
        exclude = rig.exclude if rig.exclude in (None, "top", "none") else os.path.abspath(rig.exclude)
        obstacle = None if rig.obstacle is None else tuple(map(os.path.abspath, rig.obstacle))
        inputs = {
            "names": [name if is_site(name) else os.path.abspath(name) for name in self.names],
            "depth": self.depth,
            "detail": self.detail,
            "scenes": [pose.scene.content_hash for pose in self.request.poses],
            "rig": rig_content(replace(rig, exclude=exclude, obstacle=obstacle)),
        }
        return json.loads(json.dumps(inputs))


def placed(
    names: Sequence[str], depth: float | None, detail: str | None, scenes: Sequence[str], rig: dict[str, Any],
    ring: dict[str, Any],
) -> dict[str, Any]:  # fmt: skip
    """The layout proposed on one ring, as it stands in a layout file, or why there is none.

    Parameters
    ----------
    names, depth, detail
        Of the meshes.
    scenes : sequence of str
        What `exact.Scene.content_hash` must give of each mesh and pose.
    rig : dict
        As `rig_content` gives it.
    ring : dict
        As it stands in a layout file.

    Returns
    -------
    dict
        "layout"; or "refused", why there is none.
    """
    asked = _checked_request(names, depth, detail, scenes, rig)
    asked = replace(asked, ring=exact.Ring(**{name: ring[key] for name, key in RING.items()}))
    try:
        problem = asked.problem(None, workers=1)
        found = problem.optimise(
            asked.rig.n_cameras, asked.rig.constraints, certify=asked.rig.certify, give_up=asked.rig.give_up
        )
    except placement.PlacementError as error:
        return {"refused": str(error)}
    return {"layout": placement_content(found, asked)}


def refined(
    names: Sequence[str], depth: float | None, detail: str | None, scenes: Sequence[str], rig: dict[str, Any],
    layout: dict[str, Any], diameter: Sequence[float], working_distance: Sequence[float],
) -> dict[str, Any]:  # fmt: skip
    """From one layout on, ring and cameras moved together to where they reconstruct more, no less accurately.

    Parameters
    ----------
    names, depth, detail, scenes, rig
        As for `placed`.
    layout : dict
        What a layout file says of ring and cameras.
    diameter, working_distance : (float, float)
        Least and greatest [mm].

    Returns
    -------
    dict
        "layout", as a layout file written by hand would have it, and "fraction_of_counted_area".
    """
    asked = _checked_request(names, depth, detail, scenes, rig)
    ring = exact.Ring(**{name: layout["ring"][key] for name, key in RING.items()})
    found = placement.refine_ring(
        [pose.scene for pose in asked.poses], ring, layout["angles_rad"], rolls=layout.get("rolls_rad"),
        diameter=(diameter[0], diameter[1]), working_distance=(working_distance[0], working_distance[1]),
        constraints=asked.rig.constraints, demand=asked.rig.demand, site_weights=[pose.weight for pose in asked.poses],
        objective=asked.rig.objective,  # type: ignore[arg-type] - checked by it
    )  # fmt: skip
    made = layout | {
        "ring": ring_content(found.ring),
        "demand": asdict(replace(asked, ring=found.ring).demand),
        "angles_deg": np.degrees(found.angles).tolist(),
        "angles_rad": list(found.angles),
        **rolls_content(found.rolls),
        "areas_mm2": {"optimised": found.area / asked.n_poses},
        "rms_errors_mm": {"optimised": finite(found.error_rms)},
        "smallest_separation_mm": found.smallest_separation if len(found.angles) > 1 else None,
    }
    return {"layout": made, "fraction_of_counted_area": found.fraction}


def _checked_request(
    names: Sequence[str], depth: float | None, detail: str | None, scenes: Sequence[str], rig: dict[str, Any]
) -> Request:
    asked = _request(tuple(names), depth, detail, json.dumps(rig))
    if [pose.scene.content_hash for pose in asked.poses] != list(scenes):
        raise InputError(f"{', '.join(names)} is another mesh here than where the sweep was asked for, or has changed")
    return asked


@lru_cache(maxsize=1)
def _request(names: tuple[str, ...], depth: float | None, detail: str | None, rig: str) -> Request:
    """The same meshes for task after task; what there is to say of them was said where the sweep was asked for."""
    with contextlib.redirect_stderr(io.StringIO()):
        return request(names, depth, detail, rig_of(json.loads(rig)))
