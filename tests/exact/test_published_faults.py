"""Scenes that the program published with Wachter 2021 gets wrong, each with a value found in another way."""

import itertools

import numpy as np
import pytest
import shapely
import trimesh

import exact
from tests.support.scenes import HEIGHT, above, rectangle, together


def shadow_on_plane(points, camera_position, origin, one, two):
    """Shadow of a convex body on the plane origin + a one + b two (orthonormal): the hull of its corners' shadows."""
    normal = np.cross(one, two)
    direction = points - camera_position
    t = ((origin - camera_position) @ normal) / (direction @ normal)
    hits = camera_position + t[:, None] * direction - origin
    return shapely.MultiPoint(np.stack([hits @ one, hits @ two], axis=1)).convex_hull


def test_box_before_the_low_end_of_a_steep_face():
    # The face rises 5 mm per mm; its nearest vertex is far above the box that hides its low end.
    slope = 5.0
    face = rectangle((0, 20), (-10, 10), lambda x, y: slope * x)
    box = trimesh.creation.box((2, 4, 3)).apply_translation((3, 0, 25))
    camera = above(-60.0, fov=(900, 900))
    along = np.array([1.0, 0.0, slope]) / np.sqrt(1 + slope**2)
    shadow = shadow_on_plane(box.vertices, camera.position, np.zeros(3), along, np.array([0.0, 1.0, 0.0])).area
    facing = ((camera.position - box.triangles_center) * box.face_normals).sum(axis=1) > 0
    expected = 20 * 20 * np.sqrt(1 + slope**2) - shadow + box.area_faces[facing].sum()
    result = exact.evaluate(together(face, box), [camera], threshold=1)
    assert result.area == pytest.approx(expected, rel=1e-10)


def test_two_faces_that_share_their_nearest_vertex():
    # Both begin at the same point; the second dives away below the first.
    high = trimesh.Trimesh([(0, 0, 50), (40, -20, 40), (40, 20, 40)], [[0, 1, 2]], process=False)
    low = trimesh.Trimesh([(0, 0, 50), (40, -30, 0), (40, 30, 0)], [[0, 1, 2]], process=False)
    camera = above(fov=(400, 400))
    # From above the common point the far side of `high` is at plan scale H/(H-40), that of `low` at 1: both images are
    # triangles with the same apex and parallel far sides, `high` from 20/40 to either side, `low` from 30/40.
    k, centre = HEIGHT / (HEIGHT - 40), HEIGHT / (HEIGHT - 50)
    assert centre > 1  # the apex lies on the axis, at the image's centre
    # Depth of `low`'s far side in the plan at z = 0 is 40; that of `high` is 40 k > 40, so `high` covers the wedge
    # |y| <= x / 2 of `low`'s image entirely.
    assert 40 * k > 40
    expected = high.area + low.area * (1 - 20 / 30)
    result = exact.evaluate(together(high, low), [camera], threshold=1)
    assert result.area == pytest.approx(expected, rel=1e-10)


def test_three_views_are_not_pairs_of_views():
    # A post on a plate hides a strip from each of three cameras; pairs alone would count what two of them see.
    plate, post = rectangle((-30, 30), (-30, 30)), trimesh.creation.box((2, 2, 60)).apply_translation((1, 3, 30.5))
    ring = exact.Ring(diameter=200.0, fov=(300.0, 300.0))
    cameras = ring.cameras(ring.equidistant(3))
    exclude = np.arange(14) >= 2
    result = exact.evaluate(together(plate, post), cameras, threshold=3, exclude=exclude)
    x, y = np.eye(3)[:2]
    shadows = [shadow_on_plane(post.vertices, camera.position, np.zeros(3), x, y) for camera in cameras]
    assert result.area == pytest.approx(3600 - shapely.union_all(shadows).area, rel=1e-9)
    assert result.level_areas[0] == pytest.approx(3600 - shapely.intersection_all(shadows).area, rel=1e-9)
    pairs = [a & b for a, b in itertools.combinations(shadows, 2)]
    assert result.level_areas[1] == pytest.approx(3600 - shapely.union_all(pairs).area, rel=1e-9)


def test_open_sheet_turned_away_hides():
    sheet = rectangle((-5, 5), (-5, 5), 100.0, up=False)
    side = 10 * HEIGHT / (HEIGHT - 100)
    result = exact.evaluate(together(rectangle((-20, 20), (-20, 20)), sheet), [above()], threshold=1)
    assert result.area == pytest.approx(1600 - side**2, rel=1e-10)


def test_one_face_that_fills_the_field_of_view():
    ground = trimesh.Trimesh([(-900, -900, 0), (900, -900, 0), (0, 1800, 0)], [[0, 1, 2]], process=False)
    ring = exact.Ring()
    result = exact.evaluate(ground, ring.cameras([0.0, np.pi]), threshold=2)
    # The camera over +x sees a trapezoid of the ground: its radial half angle b widens the elevation a to either side,
    # and at the ground point x the tangential half width is 18/r times the depth there.
    r, a, b = np.hypot(15, 400), np.arctan2(15, 400), np.arctan2(12, np.hypot(15, 400))
    near, far = 15 - 400 * np.tan(a - b), 15 - 400 * np.tan(a + b)

    def half_width(x):
        return 18 / r * np.cos(np.arctan2(15 - x, 400) - a) * np.hypot(15 - x, 400)

    one = shapely.Polygon(
        [(near, -half_width(near)), (near, half_width(near)), (far, half_width(far)), (far, -half_width(far))]
    )
    other = shapely.Polygon(-np.array(one.exterior.coords))
    assert result.level_areas[0] == pytest.approx((one | other).area, rel=1e-10)
    assert result.area == pytest.approx((one & other).area, rel=1e-10)


def test_a_mesh_that_nothing_reconstructs():
    assert exact.evaluate(rectangle((-5, 5), (-5, 5), up=False), [above()], threshold=1).area == 0.0
