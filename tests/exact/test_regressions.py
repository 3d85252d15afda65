"""Scenes that once came out wrong."""

import numpy as np
import pytest
import shapely
import trimesh

import exact
import meshes
from exact.visibility.surface import prepare
from tests.support.scenes import AWKWARD, above, rectangle


def test_a_union_that_geos_gets_wrong_is_noticed():
    # unary_union of the unseen cells of one face lost 6 % of it without an error.
    rng = np.random.default_rng(244)
    mesh = AWKWARD["T-junctions"]()
    size = float(np.abs(mesh.vertices).max())
    fov = tuple(size * rng.uniform(0.8, 3.0, 2))
    ring = exact.Ring(diameter=size * rng.uniform(0.5, 4), working_distance=size * rng.uniform(2.5, 8), fov=fov)
    cameras = ring.cameras(rng.uniform(0, 2 * np.pi, 4))
    levels = exact.evaluate(mesh, cameras, threshold=4).level_face_areas.sum(axis=0)
    assert levels == pytest.approx(sum(exact.view(mesh, camera).face_areas for camera in cameras), abs=1e-9)


@pytest.mark.parametrize("offset", [1e-6, 1e-5, 1e-4])
@pytest.mark.parametrize("seed", range(8))
def test_nearly_coplanar_faces_hide_each_other_once(offset, seed):
    # Of two triangles that differ by next to nothing the nearer one is seen at each point: one triangle's area in all.
    rng = np.random.default_rng(seed)
    corners = rng.normal(0, 5, (3, 3)) * [1, 1, 0.2]
    if np.cross(corners[1] - corners[0], corners[2] - corners[0])[2] < 0:
        corners = corners[::-1]
    pair = np.concatenate([corners, corners + rng.normal(0, offset, (3, 3))])
    mesh = trimesh.Trimesh(pair, [[0, 1, 2], [3, 4, 5]], process=False)
    one = trimesh.Trimesh(corners, [[0, 1, 2]], process=False)
    seen = exact.evaluate(mesh, [above(fov=(90, 90))], threshold=1).area
    # A strip as wide as the offset, wider on a face seen at a slant, is seen of both.
    assert seen == pytest.approx(one.area, abs=100 * offset / one.face_normals[0, 2])


@pytest.mark.parametrize("places", [(3.01941960595019, 4.6774823953448035), (1.4660765716752369, 6.19591884457987)])
def test_two_cameras_in_each_of_two_places(places):
    """Slivers between views from the same place came back from a union as nothing, and had no point to ask."""
    mesh, ring = meshes.site("circ_angled", depth=50), exact.Ring()
    top = meshes.top_surface(mesh)
    twice = exact.evaluate(mesh, ring.cameras(np.repeat(places, 2)), threshold=2, exclude=top)
    once = exact.evaluate(mesh, ring.cameras(places), threshold=1, exclude=top)
    assert twice.area == pytest.approx(once.area, rel=1e-9)


def test_a_part_lost_from_a_small_piece_of_a_large_face_is_noticed(monkeypatch):
    """Of a face of ten kilometres the cameras see 1e-11: too little for a tolerance in parts of the face."""
    union_all = shapely.union_all

    def forgetful(geometries, grid_size=None, **options):
        united = union_all(geometries, grid_size=grid_size, **options)
        if grid_size is None:  # as GEOS does now and then, without a word
            parts = [shapely.get_parts(one) for one in united]
            lost = [k for k, one in enumerate(parts) if len(one) > 1 and shapely.area(one).all()]
            united[lost] = [parts[k][0] for k in lost]
        return united

    monkeypatch.setattr(shapely, "union_all", forgetful)
    plain = rectangle((-5e6, 5e6), (-5e6, 5e6))
    result = exact.evaluate(plain, [above(x, fov=(40, 40)) for x in np.linspace(0.0, 20.0, 9)])
    assert result.area == pytest.approx(55 * 40, rel=1e-6)
    assert result.repairs > 0


def test_pieces_that_overlap_are_counted(monkeypatch):
    """Each cut may give a little more than there was; what adds up to more than the face is said, not hidden."""
    polygonize, plain = shapely.polygonize, rectangle((-50, 50), (-50, 50))
    cameras = [above(x, fov=(60, 60)) for x in np.arange(-6.0, 7.0)]
    assert exact.evaluate(plain, cameras, threshold=13).repairs == 0
    slightly = np.array([1 + 6e-11, 1.0])
    monkeypatch.setattr(
        shapely,
        "polygonize",
        lambda *lines, **options: shapely.transform(polygonize(*lines, **options), slightly.__mul__),
    )
    assert exact.evaluate(plain, cameras, threshold=13).repairs > 0


@pytest.mark.parametrize(
    ("name", "depth"), [(name, depth) for name, site in meshes.SITES.items() for depth in site.depths]
)
def test_sites_are_solid_though_some_of_their_faces_touch_in_points(name, depth):
    """Only then are backs and concave edges not looked at, which saves a fifth of the time."""
    surface = prepare(meshes.site(name, depth, "coarse"))
    assert surface.solid
    assert surface.intersections.is_point.all()


def test_a_body_that_cuts_itself_is_not_solid():
    tube = trimesh.creation.sweep_polygon(
        shapely.Point(0, 0).buffer(1.0, 8), [[-9, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 0], [0, -9, 0.3]]
    )
    surface = prepare(tube)
    assert surface.closed and not surface.solid
    assert not surface.intersections.is_point.all()
