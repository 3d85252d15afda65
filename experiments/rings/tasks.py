"""The tasks of a sweep over rings: on each ring the layout that `camring optimise` would propose."""

import contextlib
import io
import json
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import exact
import placement
from experiments.files.errors import InputError
from experiments.request.layout_file import RING, placement_content, ring_content
from experiments.request.meshes import is_site
from experiments.request.request import Request, request
from experiments.request.rig_content import rig_content, rig_of
from experiments.sweeps.task import Task


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
        rig = self.request.rig
        exclude = rig.exclude if rig.exclude in (None, "top", "none") else os.path.abspath(rig.exclude)
        obstacle = None if rig.obstacle is None else tuple(map(os.path.abspath, rig.obstacle))
        inputs = {
            "names": [name if is_site(name) else os.path.abspath(name) for name in self.names],
            "depth": self.depth,
            "detail": self.detail,
            "scenes": [pose.scene.content_hash for pose in self.request.poses],
            "rig": rig_content(replace(rig, exclude=exclude, obstacle=obstacle)),
            "ring": ring_content(ring),
        }
        return Task(placed, json.loads(json.dumps(inputs)))


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
    asked = _request(tuple(names), depth, detail, json.dumps(rig))
    if [pose.scene.content_hash for pose in asked.poses] != list(scenes):
        raise InputError(f"{', '.join(names)} is another mesh here than where the sweep was asked for, or has changed")
    asked = replace(asked, ring=exact.Ring(**{name: ring[key] for name, key in RING.items()}))
    try:
        problem = asked.problem(None, workers=1)
        found = problem.optimise(
            asked.rig.n_cameras, asked.rig.constraints, certify=asked.rig.certify, give_up=asked.rig.give_up
        )
    except placement.PlacementError as error:
        return {"refused": str(error)}
    return {"layout": placement_content(found, asked)}


def counted_areas(asked: Request) -> list[float]:
    """Area [mm²] of all that counts of each mesh and pose, seen or not; weighted if faces are."""
    scenes = [pose.scene for pose in asked.poses]
    return [float(scene.worth(scene.of_mesh(scene.surface.areas * scene.counted))) for scene in scenes]


@lru_cache(maxsize=1)
def _request(names: tuple[str, ...], depth: float | None, detail: str | None, rig: str) -> Request:
    """The same meshes for task after task; what there is to say of them was said where the sweep was asked for."""
    with contextlib.redirect_stderr(io.StringIO()):
        return request(names, depth, detail, rig_of(json.loads(rig)))
