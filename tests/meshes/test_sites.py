import csv
from pathlib import Path

import numpy as np
import pytest
import trimesh

import meshes
from meshes.standard import PAPER_SITES, TABLE, expected_of, standard_bytes

EVERY = [(name, depth) for name, site in meshes.SITES.items() for depth in site.depths]
CIRCULAR = [(name, depth) for name, depth in EVERY if name.startswith("circ_")]
PAPER = [(name, depth) for name, depth in EVERY if name in PAPER_SITES]


def polygon_area(corners: int, radius: float) -> float:
    return corners / 2 * radius**2 * np.sin(2 * np.pi / corners)


@pytest.mark.parametrize(("name", "depth"), EVERY)
def test_site_is_one_sound_body(name, depth):
    mesh = meshes.site(name, depth)
    assert mesh.is_watertight and mesh.is_winding_consistent and mesh.is_volume
    assert mesh.body_count == 1
    assert mesh.volume > 0
    assert mesh.metadata == {"watertight": True, "notes": [], "repairs": []}


@pytest.mark.parametrize(
    ("name", "depth", "detail"), [(*case, "coarse") for case in CIRCULAR] + [("circ_artery", 100, "middle")]
)
def test_top_surface_leaves_open_the_published_polygon(name, depth, detail):
    mesh = meshes.site(name, depth, detail)
    top = meshes.top_surface(mesh)
    opening = 60.0**2 - mesh.area_faces[top].sum()
    assert opening == pytest.approx(polygon_area({50: 39, 100: 34}[depth], 12.5), abs=1e-4)  # rounding to float32
    assert np.all(mesh.vertices[mesh.faces[top]][..., 2] == depth)
    corner = mesh.vertices[np.abs(mesh.vertices - [12.5, 0, depth]).max(axis=1) == 0]
    assert len(corner) == 1  # the first vertex lies on +x


@pytest.mark.parametrize("depth", [50, 100])
def test_elliptical_opening_is_what_the_published_areas_show(depth):
    # Tables A1 to A3: the top surface seen by 360 cameras is the part of the block within the field of view, less the
    # opening. That part is a disc for 36 x 24 mm, and a disc cut by the block's sides for 60 x 60 mm.
    published = {50: (498.59, 2756.43), 100: (363.67, 2542.31)}[depth]
    mesh = meshes.site("elliptical", depth)
    top = trimesh.Trimesh(mesh.vertices, mesh.faces[meshes.top_surface(mesh)])
    rng = np.random.default_rng(0)
    points, _ = trimesh.sample.sample_surface(top, 40_000, seed=rng)
    for (width, height), area in zip(((36, 24), (60, 60)), published, strict=True):
        scale = 1 - depth / 400
        reach = np.hypot(width / 2 * scale, height / 2 * scale + 15 * depth / 400)
        seen = top.area * np.mean(np.hypot(*points[:, :2].T) < reach)
        assert seen == pytest.approx(area, abs=35)  # 25 mm2 of deviation in shape, 10 mm2 of sampling


@pytest.mark.parametrize(("name", "depth"), EVERY)
def test_site_lies_as_documented(name, depth):
    mesh, spec = meshes.site(name, depth), meshes.SITES[name]
    assert mesh.bounds[1].tolist() == [spec.block / 2, spec.block / 2, depth]
    middle = mesh.ray.intersects_location([[0.05, 0.02, -11.9]], [[0, 0, 1.0]])[0][:, 2]
    assert -6 < middle.min() < 6  # the floor under the focus


@pytest.mark.parametrize(("name", "depth"), EVERY)
def test_block_is_wider_than_the_field_of_view_at_the_top(name, depth):
    spec = meshes.SITES[name]
    scale = 1 - depth / 400
    reach = np.hypot(spec.fov[0] / 2 * scale, spec.fov[1] / 2 * scale + 15 * depth / 400)
    assert spec.block / 2 > reach


@pytest.mark.parametrize(
    ("name", "depth", "detail"),
    [(*case, "coarse") for case in EVERY] + [(name, site.depths[0], "middle") for name, site in meshes.SITES.items()],
)
def test_site_is_what_is_expected(name, depth, detail):
    mesh = meshes.site(name, depth, detail)
    assert expected_of(mesh) == meshes.EXPECTED[name, depth, detail]
    assert 0.6 < len(mesh.faces) / meshes.DETAILS[detail] < 1.4


def test_every_site_is_in_the_table_once():
    with TABLE.open(newline="") as file:
        keys = [(row["site"], float(row["depth_mm"]), row["detail"]) for row in csv.DictReader(file)]
    assert keys == [(name, depth, detail) for name, depth in EVERY for detail in meshes.DETAILS]
    fine = [known.faces for (_, _, detail), known in meshes.EXPECTED.items() if detail == "fine"]
    assert min(fine) > 50_000


@pytest.mark.parametrize(("name", "depth"), PAPER)
def test_standard_file_is_regenerated_byte_by_byte(name, depth):
    path = meshes.standard_file(name, depth)
    data = path.read_bytes()
    assert data == standard_bytes(name, depth)
    assert len(data) < 300_000
    assert meshes.fingerprint(meshes.load(path)) == meshes.fingerprint(meshes.site(name, depth))


def test_site_twice_is_the_same_and_independent():
    first, second = meshes.site("circ_flat", 50), meshes.site("circ_flat", 50)
    assert meshes.stl_bytes(first) == meshes.stl_bytes(second)
    first.apply_translation((1, 2, 3))
    assert meshes.fingerprint(meshes.site("circ_flat", 50)) == meshes.fingerprint(second)


def test_details_are_of_the_same_shape():
    coarse, middle = (meshes.site("circ_overhang", 50, detail) for detail in ("coarse", "middle"))
    assert coarse.area == pytest.approx(middle.area, rel=0.005)
    assert coarse.volume == pytest.approx(middle.volume, rel=0.001)
    distance = trimesh.proximity.closest_point(middle, coarse.vertices)[1]
    assert distance.max() < 0.6  # mm, about a third of a coarse edge


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"name": "appendix"}, "no site 'appendix'; choose one of circ_flat, circ_angled"),
        ({"name": "circ_flat", "depth": 60}, "circ_flat has no depth 60; choose one of 50, 100"),
        ({"name": "circ_flat", "detail": "huge"}, "no detail 'huge'; choose one of coarse, middle, fine"),
    ],
)
def test_site_names_what_there_is(arguments, message):
    with pytest.raises(meshes.MeshError, match=message):
        meshes.site(**arguments)


def test_standard_file_only_for_the_sites_of_the_paper():
    with pytest.raises(meshes.MeshError, match="no standard file of 'spine_disc' at depth 50"):
        meshes.standard_file("spine_disc", 50)


@pytest.mark.parametrize("file", sorted(Path(meshes.__file__).parent.glob("*.py")), ids=lambda file: file.name)
def test_files_stay_short(file):
    assert len(file.read_text(encoding="utf-8").splitlines()) <= 250
