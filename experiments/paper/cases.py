"""What Wachter 2021 measured: ten sites, ten numbers of cameras, two fields of view."""

from dataclasses import dataclass

import exact
import meshes
from experiments.paper.published import CAMERA_COUNTS

FOV = {"36x24": (36.0, 24.0), "60x60": (60.0, 60.0)}
CIRCULAR = ("circ_flat", "circ_angled", "circ_artery", "circ_overhang")
QUICK_COUNTS = tuple(n for n in CAMERA_COUNTS if n <= 16)


@dataclass(frozen=True)
class Case:
    """One site under one field of view.

    Attributes
    ----------
    site : str
    depth : int
        Of the channel [mm].
    fov : str
        Width x height [mm], a key of `FOV`.
    """

    site: str
    depth: int
    fov: str

    @property
    def title(self) -> str:
        """For people."""
        return f"{self.site}, {self.depth} mm" + ("" if self.fov == "36x24" else ", field of view 60 × 60 mm")

    @property
    def key(self) -> str:
        """For file names."""
        return f"{self.site}_{self.depth}_{self.fov}"

    @property
    def ring(self) -> exact.Ring:
        """The ring of cameras."""
        return exact.Ring(fov=FOV[self.fov])

    def mesh_hash(self, detail: str) -> str:
        """Fingerprint of the mesh that every machine must build of it."""
        return meshes.EXPECTED[self.site, float(self.depth), detail].fingerprint


def cases(quick: bool) -> list[Case]:
    """All twelve, or with `quick` those of two sites.

    Examples
    --------
    >>> len(cases(quick=False)), [case.key for case in cases(quick=True)]
    (12, ['circ_artery_50_36x24', 'elliptical_50_36x24', 'elliptical_50_60x60'])
    """
    if quick:
        return [Case("circ_artery", 50, "36x24"), Case("elliptical", 50, "36x24"), Case("elliptical", 50, "60x60")]
    sites = [(name, depth) for depth in (50, 100) for name in (*CIRCULAR, "elliptical")]
    return [
        *(Case(name, depth, "36x24") for name, depth in sites),
        *(Case("elliptical", depth, "60x60") for depth in (50, 100)),
    ]
