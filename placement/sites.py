"""What a layout is to reconstruct: one site or several, which of their faces count, and how they count together."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import trimesh

import exact
from meshes import fingerprint
from placement.errors import PlacementError
from placement.sampling import checked_exclude

Objective = Literal["mean", "worst"]


@dataclass(frozen=True, eq=False)
class Site:
    """One mesh and what of it counts.

    Attributes
    ----------
    mesh : trimesh.Trimesh
    excluded : (F,) ndarray of bool
        Faces that do not count.
    face_weights : (F,) ndarray or None
        Factor by which the area of each face counts.
    share : float
        Its part in the mean over all sites; all shares add up to 1.
    mesh_hash : str
        Fingerprint of the mesh.
    """

    mesh: trimesh.Trimesh
    excluded: np.ndarray
    face_weights: np.ndarray | None
    share: float
    mesh_hash: str


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

    def combined(self, fractions) -> float:
        """One figure for the (S,) fractions of the sites."""
        values = np.asarray(fractions, dtype=np.float64)
        return float(values.min() if self.objective == "worst" else self.shares @ values)

    @property
    def of(self) -> str:
        """What the combined fraction is a fraction of, in words."""
        if len(self.members) == 1:
            return "the ring maximum"
        how = "at the worst" if self.objective == "worst" else "in the mean"
        return f"the ring maximum {how} of {len(self.members)} sites"


def checked_sites(
    mesh: trimesh.Trimesh | Sequence[trimesh.Trimesh],
    exclude: np.ndarray | Sequence[np.ndarray | None] | None = None,
    face_weights: np.ndarray | Sequence[np.ndarray | None] | None = None,
    site_weights: Sequence[float] | None = None,
    objective: Objective = "mean",
) -> Sites:
    """Check a request's meshes and all that goes with each.

    Parameters
    ----------
    mesh : trimesh.Trimesh or sequence of them
    exclude, face_weights : (F,) array, or a sequence with one for each mesh, optional
        One array serves several meshes with equally many faces, such as poses of the same site.
    site_weights : (S,) sequence of float, optional
        How much each site counts in the mean; equally by default.
    objective : {"mean", "worst"}

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
    several = [mesh] if isinstance(mesh, trimesh.Trimesh) else list(mesh)
    if not several:
        raise PlacementError("there is no mesh; give one or several")
    for one in several:
        if not isinstance(one, trimesh.Trimesh):
            raise PlacementError(f"a mesh is a {type(one).__name__}; a trimesh.Trimesh is needed: see meshes.load")
    if objective not in get_args(Objective):
        raise PlacementError(f'objective is {objective!r}; it must be "mean" or "worst"')
    weights = np.ones(len(several)) if site_weights is None else np.asarray(site_weights, dtype=np.float64)
    if weights.shape != (len(several),) or not np.isfinite(weights).all() or (weights < 0).any() or not weights.any():
        raise PlacementError(
            f"site_weights are {site_weights!r}; they must be {len(several)} numbers, at least 0 and not all 0"
        )
    members = [
        Site(one, checked_exclude(one, excluded), _checked_weights(one, factors), float(share), fingerprint(one))
        for one, excluded, factors, share in zip(
            several, _each(exclude, several), _each(face_weights, several), weights / weights.sum(), strict=True
        )
    ]
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


def _each(given, several: list[trimesh.Trimesh]) -> list:
    """One entry for each mesh, from one for all or a sequence."""
    if given is None or isinstance(given, np.ndarray):
        return [given] * len(several)
    given = list(given)
    if len(given) != len(several):
        raise PlacementError(f"{len(given)} arrays are given for {len(several)} meshes; give one each, or one for all")
    return given


def _checked_weights(mesh: trimesh.Trimesh, weights) -> np.ndarray | None:
    if weights is None:
        return None
    values = np.asarray(weights, dtype=np.float64)
    if values.shape != (len(mesh.faces),) or not np.isfinite(values).all() or (values < 0).any() or not values.any():
        raise PlacementError(
            f"face_weights have shape {values.shape}; they must be finite, at least 0 and not all 0, one for each of "
            f"the {len(mesh.faces)} faces"
        )
    return values
