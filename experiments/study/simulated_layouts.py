"""The layouts of the simulated study: equidistant, of most area, as proposed, and with a bound on disparity."""

from collections.abc import Sequence
from typing import Any

import numpy as np

import exact
import meshes
import placement
from experiments.paper.areas import site_mesh

# Kinds of layouts that are compared: the last is proposed where two cameras must match a point, by this gradient.
KINDS = ("equidistant", "most area", "proposed", "matched")
MATCHED = 0.5
# A reference site and its depth [mm].
Site = tuple[str, int]


def named(site: Site, detail: str) -> list:
    """Name, depth [mm] and fingerprint of a reference site."""
    name, depth = site
    return [name, depth, meshes.EXPECTED[name, float(depth), detail].fingerprint]


def layouts(site: Sequence, detail: str, n_cameras: int) -> dict[str, Any]:
    """Ring angles [degrees] of each kind of layout; `site` is its name, depth [mm] and fingerprint.

    Examples
    --------
    >>> found = layouts(named(("circ_flat", 50), "coarse"), "coarse", 2)
    >>> found["equidistant"]
    [180.0, 360.0]
    """
    mesh = site_mesh(str(site[0]), int(site[1]), detail, str(site[2]))
    ring = exact.Ring()
    found, matched = (
        placement.optimise(
            mesh, ring, n_cameras=n_cameras, exclude=meshes.top_surface(mesh), max_disparity_gradient=steepest,
            certify=False,
        )
        for steepest in (None, MATCHED)
    )  # fmt: skip
    angles = (ring.equidistant(n_cameras), found.most_area.angles, found.angles, matched.angles)
    return {kind: np.degrees(one).round(9).tolist() for kind, one in zip(KINDS, angles, strict=True)}
