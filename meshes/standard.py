"""The standard files: what `meshes.site` must give, on every machine, for every site.

After a change to a shape, `python -c "import meshes.standard as s; s.write_all()"` rebuilds them; say in the changelog
that areas have moved. They were built with manifold3d 3.5; another release may cut the same shape into other triangles.
"""

import csv
from dataclasses import dataclass
from pathlib import Path

import trimesh

from meshes.errors import MeshError
from meshes.fingerprint import fingerprint
from meshes.formats.stl import stl_bytes
from meshes.sites import DETAILS, SITES, site

DATA = Path(__file__).parent / "data"
TABLE = DATA / "expected.csv"
COLUMNS = ("site", "depth_mm", "detail", "faces", "area_mm2", "fingerprint")
PAPER_SITES = ("circ_flat", "circ_angled", "circ_artery", "circ_overhang", "elliptical")


@dataclass(frozen=True)
class Expected:
    """What a site is known to be.

    Attributes
    ----------
    faces : int
    area : float
        Whole surface, with the outside of the block [mm2].
    fingerprint : str
        As by `meshes.fingerprint`.
    """

    faces: int
    area: float
    fingerprint: str


def _read_table() -> dict[tuple[str, float, str], Expected]:
    if not TABLE.exists():
        return {}
    with TABLE.open(newline="", encoding="ascii") as file:
        return {
            (row["site"], float(row["depth_mm"]), row["detail"]): Expected(
                int(row["faces"]), float(row["area_mm2"]), row["fingerprint"]
            )
            for row in csv.DictReader(file)
        }


# (site, depth, detail) -> Expected, for every site there is.
EXPECTED = _read_table()


def standard_file(name: str, depth: float) -> Path:
    """Path of the committed binary STL file of one of the paper's sites, coarse.

    Examples
    --------
    >>> standard_file("circ_artery", 50).name
    'circ_artery_50.stl'
    """
    if name not in PAPER_SITES or depth not in SITES[name].depths:
        raise MeshError(f"there is no standard file of {name!r} at depth {depth!r}; build it with `meshes.site`")
    return DATA / f"{name}_{depth:g}.stl"


def standard_bytes(name: str, depth: float) -> bytes:
    """Content of the file that `standard_file` names, built anew."""
    return stl_bytes(site(name, depth, "coarse"), f"camring reference site {name}, depth {depth:g} mm, coarse")


def expected_of(mesh: trimesh.Trimesh) -> Expected:
    """Count, measure and fingerprint a mesh."""
    return Expected(len(mesh.faces), round(float(mesh.area), 3), fingerprint(mesh))


def write_all(folder: Path = DATA) -> None:
    """Build every site at every detail; write the standard files and the table of what is expected."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / TABLE.name).open("w", newline="", encoding="ascii") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for name, spec in SITES.items():
            for depth in spec.depths:
                for detail in DETAILS:
                    known = expected_of(site(name, depth, detail))
                    row = (name, f"{depth:g}", detail, known.faces, f"{known.area:.3f}", known.fingerprint)
                    writer.writerow(row)
    for name in PAPER_SITES:
        for depth in SITES[name].depths:
            (folder / f"{name}_{depth:g}.stl").write_bytes(standard_bytes(name, depth))
