"""The reference sites: deterministic models of surgical channels.

The ten models of Wachter 2021 were cut from a scan of a head and are not public. These are of the same kind and, for
equidistant cameras, of nearly the same areas.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import trimesh

from meshes.anatomy import Anatomy, Opening
from meshes.condition.check import check
from meshes.errors import MeshError
from meshes.further_anatomy import CEREBELLOPONTINE, EYE_ANTERIOR, GLIOBLASTOMA, SPINE_DISC
from meshes.paper_anatomy import PAPER_ANATOMY
from meshes.solid import carve

DETAILS = {"coarse": 4_000, "middle": 20_000, "fine": 80_000}  # faces, about


@dataclass(frozen=True)
class Site:
    """How a reference site is built, and the field of view it is meant for.

    Attributes
    ----------
    name : str
    title : str
        What it shows, in one line.
    depths : tuple of float
        Channel depths it is offered at [mm].
    openings : tuple of Opening
        One for each depth.
    anatomy : Anatomy
        What lies at the bottom; the same at each depth.
    fov : tuple of float
        Recommended field of view, tangential and radial [mm].
    block : float
        Width of the block of tissue [mm], wider than what cameras see of the top surface.
    fine_edge : float
        Edges at fine detail, as a part of what the usual rule gives: less where it makes too few faces.
    """

    name: str
    title: str
    depths: tuple[float, ...]
    openings: tuple[Opening, ...]
    anatomy: Anatomy
    fov: tuple[float, float] = (36.0, 24.0)
    block: float = 60.0
    fine_edge: float = 1.0


# The corners are what the published areas with and without top surface show (Wachter 2021, Tables A1 to A3): the
# difference is the field of view's share of the top surface, less the opening. For the elliptical sites it fits a block
# 60 mm wide and an opening of about 780 mm2, somewhat fuller than the ellipse 42.5 mm by 22.5 mm (751 mm2).
CIRCULAR = (Opening((12.5, 12.5), corners=39), Opening((12.5, 12.5), corners=34))
ELLIPTICAL = (Opening((21.25, 11.25), corners=48, exponent=2.2),) * 2
PAPER_DEPTHS = (50.0, 100.0)

SITES: dict[str, Site] = {
    site.name: site
    for site in (
        Site(
            "circ_flat",
            "gentle floor with small vessels close to it",
            PAPER_DEPTHS,
            CIRCULAR,
            PAPER_ANATOMY["circ_flat"],
        ),
        Site(
            "circ_angled",
            "vessels, furrows and undercuts rising towards one side",
            PAPER_DEPTHS,
            CIRCULAR,
            PAPER_ANATOMY["circ_angled"],
        ),
        Site(
            "circ_artery",
            "gentle floor and a thick artery with a branch across the channel, 30 mm above",
            PAPER_DEPTHS,
            CIRCULAR,
            PAPER_ANATOMY["circ_artery"],
            fine_edge=0.84,
        ),
        Site(
            "circ_overhang",
            "vessels, furrows and undercuts under a large bulge from the wall",
            PAPER_DEPTHS,
            CIRCULAR,
            PAPER_ANATOMY["circ_overhang"],
        ),
        Site(
            "elliptical",
            "overhangs, furrows and undercuts in an elliptical channel",
            PAPER_DEPTHS,
            ELLIPTICAL,
            PAPER_ANATOMY["elliptical"],
        ),
        Site(
            "eye_anterior",
            "lens and iris in a flat, wide open bed",
            (8.0,),
            (Opening((15.0, 15.0), corners=48),),
            EYE_ANTERIOR,
            fov=(42.0, 42.0),
            block=80.0,
            fine_edge=0.82,
        ),
        Site(
            "spine_disc",
            "disc, dural sac and nerve root under the edge of the lamina",
            (50.0, 75.0, 100.0),
            (Opening((12.5, 12.5), corners=39),) * 3,
            SPINE_DISC,
        ),
        Site(
            "glioblastoma",
            "lobed resection cavity, 55 mm wide, with a bridging vessel",
            (40.0, 65.0, 90.0),
            (Opening((27.5, 27.5), corners=60),) * 3,
            GLIOBLASTOMA,
            fov=(75.0, 75.0),
            block=120.0,
        ),
        Site(
            "cerebellopontine",
            "nerves and an arterial loop in the cleft beside the cerebellum",
            (60.0, 80.0, 100.0),
            (Opening((15.0, 15.0), corners=45),) * 3,
            CEREBELLOPONTINE,
            fov=(44.0, 32.0),
        ),
    )
}


def site(name: str, depth: float = 50, detail: str = "coarse") -> trimesh.Trimesh:
    """Build a reference site.

    Parameters
    ----------
    name : str
        One of `SITES`.
    depth : float
        Height of the top surface above the focus [mm]; one of `SITES[name].depths`.
    detail : str
        Size of the mesh: "coarse", "middle" or "fine", about 4 000, 20 000 and 80 000 faces on the same shape.
        Coarse unless asked for otherwise: those are the standard files, and an exact area takes time in proportion
        to the faces. For pictures take "middle".

    Returns
    -------
    trimesh.Trimesh
        Closed block of tissue with the channel in it, opening towards +z, focus at the origin. The same on every
        call, and yours: changing it changes no other.

    Raises
    ------
    MeshError
        If there is no such site, depth or detail.

    Examples
    --------
    >>> mesh = site("circ_flat", depth=50)
    >>> mesh.is_watertight, mesh.bounds[:, 2].tolist()
    (True, [-12.0, 50.0])
    >>> site("appendix")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    meshes.errors.MeshError: there is no site 'appendix'; choose one of circ_flat, ...
    """
    if name not in SITES:
        raise MeshError(f"there is no site {name!r}; choose one of {', '.join(SITES)}")
    depths = SITES[name].depths
    if depth not in depths:
        raise MeshError(f"site {name} has no depth {depth!r}; choose one of {', '.join(f'{d:g}' for d in depths)} [mm]")
    if detail not in DETAILS:
        raise MeshError(f"there is no detail {detail!r}; choose one of {', '.join(DETAILS)}")
    return _built(name, float(depth), detail).copy()


@lru_cache(maxsize=8)
def _built(name: str, depth: float, detail: str) -> trimesh.Trimesh:
    spec = SITES[name]
    opening = spec.openings[spec.depths.index(depth)]
    mesh = carve(spec.anatomy, opening, depth, spec.block, _edge(spec, opening, depth, detail))
    return check(mesh, name=f"site {name}")


def _edge(spec: Site, opening: Opening, depth: float, detail: str) -> float:
    """Edge length [mm] that gives about the number of faces asked for."""
    outline = opening.polygon()
    perimeter = np.linalg.norm(outline - np.roll(outline, 1, axis=0), axis=1).sum()
    wall = perimeter * spec.anatomy.top
    floor = np.pi * opening.half_axes[0] * opening.half_axes[1]
    # Measured: manifold3d's level sets have about 4.7 faces for a square of the edge length.
    usual = float(np.sqrt(4.7 * (wall + 1.5 * floor) / DETAILS[detail]))
    return usual * spec.fine_edge if detail == "fine" else usual
