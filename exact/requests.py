"""A request as its keywords: what counts, on what, by which cameras; what cannot be is refused before any work.

The keywords are the fields of `Scene` and of `Demand`. They are declared there alone: a function takes all of them as
`**asked`, and hands them on whole.
"""

import difflib
import inspect
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import MISSING, fields
from typing import TYPE_CHECKING, Any, TypeVar

from exact import demand, scene
from exact.cameras import Camera
from exact.demand import Demand
from exact.errors import ExactError
from exact.scene import Scene
from exact.whole_numbers import is_whole

if TYPE_CHECKING:
    import trimesh

Asking = TypeVar("Asking", bound=Callable)


def scene_keywords() -> dict[str, Any]:
    """What a `Scene` holds beside the mesh: names and defaults."""
    return _defaults(scene.Scene, without="mesh")


def demand_keywords() -> dict[str, Any]:
    """What a `Demand` holds: names and defaults."""
    return _defaults(demand.Demand)


def checked_scene(mesh: "trimesh.Trimesh | Scene", asked: Mapping[str, Any]) -> Scene:
    """The `Scene` itself, or one of a mesh and the keywords of `Scene` among those `asked`."""
    given = {name: asked[name] for name in scene_keywords() if asked.get(name) is not None}
    if not isinstance(mesh, Scene):
        return scene.Scene(mesh, **given)
    if given:
        raise ExactError(f"{' and '.join(given)}: part of a Scene; give it to the Scene, and the Scene alone here")
    return mesh


def checked_demand(asked: Mapping[str, Any]) -> Demand:
    """The `Demand` given as `demand`, or one of the keywords of `Demand` among those `asked`."""
    given = {name: asked[name] for name in demand_keywords() if name in asked}
    whole = asked.get("demand")
    if whole is None:
        return demand.Demand(**given)
    if not isinstance(whole, Demand):
        raise ExactError(f"demand is a {type(whole).__name__}; an exact.Demand is needed")
    if given:
        raise ExactError(f"{' and '.join(given)}: part of a Demand; give it to the Demand, and the Demand alone here")
    return whole


def checked(mesh: "trimesh.Trimesh | Scene", asked: Mapping[str, Any]) -> tuple[Scene, Demand]:
    """Scene and demand of a request.

    Raises
    ------
    TypeError
        If a keyword is neither of `Scene` nor of `Demand`.
    ExactError
        If one of them makes no sense.
    """
    refuse_unknown(asked, {*scene_keywords(), *demand_keywords(), "demand"})
    return checked_scene(mesh, asked), checked_demand(asked)


def refuse_unknown(asked: Mapping[str, Any], known: Collection[str]) -> None:
    """Refuse a keyword that is not known, with the one that was probably meant."""
    for name in asked:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            meant = f"; did you mean {near[0]!r}?" if near else f"; there are {', '.join(sorted(known))}"
            raise TypeError(f"unexpected keyword argument {name!r}{meant}")


def shows(keywords: Mapping[str, Any]) -> Callable[[Asking], Asking]:
    """Let help and editors show these keywords of a function, with their defaults, instead of its `**asked`."""

    def decorate(function: Asking) -> Asking:
        own = inspect.signature(function)
        plain = [one for one in own.parameters.values() if one.kind is not inspect.Parameter.VAR_KEYWORD]
        more = [
            inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default)
            for name, default in keywords.items()
        ]
        function.__signature__ = own.replace(parameters=[*plain, *more])  # type: ignore[attr-defined]
        return function

    return decorate


def checked_workers(workers: int) -> int:
    """Number of processes as an int, at least 1."""
    if not (is_whole(workers) and workers >= 1):
        raise ExactError(f"workers is {workers}; it must be a whole number, at least 1")
    return int(workers)


def checked_cameras(cameras: Sequence[Camera]) -> tuple[Camera, ...]:
    """At least one camera."""
    cameras = tuple(cameras)
    if not cameras:
        raise ExactError("there are no cameras; at least one is needed")
    for camera in cameras:
        if not isinstance(camera, Camera):
            raise ExactError(f"a camera is a {type(camera).__name__}; exact.Camera is needed: see Ring.cameras")
    return cameras


def _defaults(kind: type, without: str = "") -> dict[str, Any]:
    return {
        field.name: None if field.default is MISSING else field.default
        for field in fields(kind)
        if field.init and field.name != without
    }


# What `evaluate` and all that hand a whole request on take beside cameras and ring.
ASKED = {**scene_keywords(), **demand_keywords(), "demand": None}
