"""What a layout is to reconstruct: one site or several, which of their faces count, and how they count together."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
import trimesh

import exact
from exact.requests import checked_scene, refuse_unknown
from exact.requests import scene_keywords as of_scene
from placement.errors import PlacementError, refusing

Objective = Literal["mean", "worst"]
Surfaces: TypeAlias = "trimesh.Trimesh | exact.Scene | Sequence[trimesh.Trimesh | exact.Scene]"
# Beside the weights of sites, those of faces have a longer name.
RENAMED = {"weights": "face_weights"}
ORIGINAL = {longer: name for name, longer in RENAMED.items()}


@dataclass(frozen=True, eq=False)
class Site:
    """One surface and how much it counts.

    Attributes
    ----------
    scene : exact.Scene
        The mesh and what of it counts.
    share : float
        Its part in the mean over all sites; all shares add up to 1.
    """

    scene: exact.Scene
    share: float


@dataclass(frozen=True, eq=False)
class Sites:
    """Sites that one layout is to serve.

    Attributes
    ----------
    members : tuple of Site
    objective : "mean" or "worst"
        What is maximised: the mean of the sites' fractions of their ring maxima, or the least of them.
    """

    members: tuple[Site, ...]
    objective: Objective

    @property
    def shares(self) -> np.ndarray:
        """(S,) part of each site in the mean."""
        return np.array([site.share for site in self.members])

    @property
    def n_faces(self) -> int:
        """Faces of all of them."""
        return sum(len(site.scene.surface.faces) for site in self.members)

    def combined(self, fractions) -> float:
        """One figure for the (S,) fractions of the sites."""
        values = np.asarray(fractions, dtype=np.float64)
        return float(values.min() if self.objective == "worst" else self.shares @ values)

    @property
    def of(self) -> str:
        """What the combined fraction is a fraction of, in words."""
        if len(self.members) == 1:
            return "the ring maximum"
        how = "at the worst of" if self.objective == "worst" else "averaged over"
        return f"the ring maximum {how} {len(self.members)} sites"


def scene_keywords() -> dict[str, Any]:
    """What of each mesh may be said beside it, with the defaults: as for `exact.Scene`, weights as `face_weights`."""
    return {RENAMED.get(name, name): default for name, default in of_scene().items()}


def checked_sites(
    mesh: Surfaces, *, site_weights: Sequence[float] | None = None, objective: Objective = "mean", **asked: Any
) -> Sites:
    """Check a request's meshes and all that goes with each.

    Parameters
    ----------
    mesh : trimesh.Trimesh, exact.Scene, or sequence of them
    site_weights : (S,) sequence of float, optional
        How much each site counts in the mean; equally by default.
    objective : {"mean", "worst"}
    **asked
        What an `exact.Scene` holds beside the mesh, for all meshes or a sequence with one for each; its weights are
        called `face_weights`. One array serves several meshes with equally many faces, such as poses of the same site.

    Raises
    ------
    PlacementError
        If something does not fit.

    Examples
    --------
    >>> box = trimesh.creation.box()
    >>> checked_sites([box, box], site_weights=[3, 1]).shares.tolist()
    [0.75, 0.25]
    """
    several = [mesh] if isinstance(mesh, trimesh.Trimesh | exact.Scene) else list(mesh)
    if not several:
        raise PlacementError("there is no mesh; give one or several")
    for one in several:
        if not isinstance(one, trimesh.Trimesh | exact.Scene):
            raise PlacementError(f"a mesh is a {type(one).__name__}; a trimesh.Trimesh is needed: see meshes.load")
    if objective not in get_args(Objective):
        raise PlacementError(f'objective is {objective!r}; it must be "mean" or "worst"')
    shares = np.ones(len(several)) if site_weights is None else np.asarray(site_weights, dtype=np.float64)
    if shares.shape != (len(several),) or not np.isfinite(shares).all() or (shares < 0).any() or not shares.any():
        raise PlacementError(
            f"site_weights are {site_weights!r}; they must be {len(several)} numbers, at least 0 and not all 0"
        )
    refuse_unknown(asked, scene_keywords())
    each = {name: _each(asked.get(name), several) for name in scene_keywords()}
    members = []
    for number, (one, share) in enumerate(zip(several, shares / shares.sum(), strict=True)):
        own = {ORIGINAL.get(name, name): values[number] for name, values in each.items()}
        with refusing():
            scene = checked_scene(one, own)
        _refuse_uncounted(scene)
        members.append(Site(scene, float(share)))
    return Sites(tuple(members), objective)


def falloff(mesh: trimesh.Trimesh, ring: exact.Ring, distance: float) -> np.ndarray:
    """Weights that fall off with the distance from the focus, for `face_weights`.

    A face at `distance` counts half, one twice as far 1/16: the weight is 2^-(r / distance)^2, with r from the focus
    to the middle of the face. Faces that are large beside `distance` should be divided first.

    Parameters
    ----------
    mesh : trimesh.Trimesh
    ring : exact.Ring
        Has the focus.
    distance : float
        Where a face counts half [mm].

    Returns
    -------
    (F,) ndarray

    Examples
    --------
    >>> falloff(trimesh.creation.box((2, 2, 2)), exact.Ring(), distance=1.0).max().round(2)
    np.float64(0.43)
    """
    if not (np.isfinite(distance) and distance > 0):
        raise PlacementError(f"distance is {distance}; it must be positive and finite [mm]")
    away = np.linalg.norm(mesh.triangles_center - np.array(ring.focus), axis=1)
    return np.exp2(-np.square(away / distance))


def _each(given, several: Sequence) -> list:
    """One entry for each mesh, from one for all or a sequence."""
    if given is None or isinstance(given, np.ndarray):
        return [given] * len(several)
    given = list(given)
    if len(given) != len(several):
        raise PlacementError(f"{len(given)} arrays are given for {len(several)} meshes; give one each, or one for all")
    return given


def _refuse_uncounted(scene: exact.Scene) -> None:
    """Refuse a surface of which nothing counts: there is nothing to search for."""
    n_faces = len(scene.counted)
    if not scene.counted.any():
        raise PlacementError(f"all {n_faces} faces are excluded; nothing is left to reconstruct")
    if scene.weights is not None and not scene.weights.any():
        raise PlacementError(f"the weights of all {n_faces} faces are 0; give some of them more")
