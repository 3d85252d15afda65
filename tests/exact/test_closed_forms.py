"""Scenes whose area can be worked out by hand. H is the camera's height, 400 mm unless said otherwise."""

import numpy as np
import pytest
import shapely
import trimesh
from hypothesis import example, given

import exact
from tests.support.random_requests import few, seeds
from tests.support.scenes import HEIGHT, above, rectangle, together

RELATIVE = 1e-10  # float64, and GEOS snapping lines together that coincide up to rounding


def area(mesh, cameras, threshold=1, **options):
    result = exact.evaluate(mesh, cameras, threshold=threshold, **options)
    assert result.to_mesh().area == pytest.approx(result.area, rel=1e-9, abs=1e-12)
    return result.area


def test_square_hovering_over_a_plane():
    # Similar triangles: at height z a square of side a casts a shadow of side a H / (H - z).
    scene = together(rectangle((-50, 50), (-50, 50)), rectangle((-5, 5), (-5, 5), 100.0))
    shadow = 10 * HEIGHT / (HEIGHT - 100)
    assert area(scene, [above()]) == pytest.approx(100**2 - shadow**2 + 10**2, rel=RELATIVE)


def test_square_hovering_seen_by_two_of_two():
    # Each camera sees its own shadow; both lie side by side, so two shadows are missing.
    scene = together(rectangle((-60, 60), (-50, 50)), rectangle((-5, 5), (-5, 5), 200.0))
    side = 10 * HEIGHT / (HEIGHT - 200)  # 20; the shadow of a camera at x is centred at -x
    cameras = [above(-15), above(15)]
    assert area(scene, cameras, 2) == pytest.approx(120 * 100 - 2 * side**2 + 100, rel=RELATIVE)
    # Seen by one at least: all, since the shadows do not overlap.
    assert area(scene, cameras, 1) == pytest.approx(120 * 100 + 100, rel=RELATIVE)


def test_crossed_rectangles():
    # z = x and z = -x: of each only the upper half is seen, sqrt(2) times its plan.
    scene = together(rectangle((-5, 5), (-5, 5), lambda x, y: x), rectangle((-5, 5), (-5, 5), lambda x, y: -x))
    assert area(scene, [above()]) == pytest.approx(100 * np.sqrt(2), rel=RELATIVE)


def test_visible_region_with_a_hole():
    # One triangle with the shadow of a square in its middle.
    ground = trimesh.Trimesh([(-60, -40, 0), (60, -40, 0), (0, 80, 0)], [[0, 1, 2]], process=False)
    scene = together(ground, rectangle((-5, 5), (-5, 5), 100.0))
    view = exact.view(scene, above())
    shadow = 10 * HEIGHT / (HEIGHT - 100)
    assert view.face_areas[0] == pytest.approx(0.5 * 120 * 120 - shadow**2, rel=RELATIVE)
    polygon = view.polygons[0]
    assert len(polygon.interiors) == 1
    assert shapely.Polygon(polygon.interiors[0]).area == pytest.approx(shadow**2, rel=1e-9)
    assert area(scene, [above()]) == pytest.approx(view.area, rel=RELATIVE)


def test_one_face_that_fills_the_field_of_view():
    ground = trimesh.Trimesh([(-900, -900, 0), (900, -900, 0), (0, 1800, 0)], [[0, 1, 2]], process=False)
    assert area(ground, [above(fov=(36, 24))]) == pytest.approx(36 * 24, rel=RELATIVE)


def test_field_of_view_on_a_slope():
    # z = m x under half angles of tangent t: -tH/(1-tm) <= x <= tH/(1+tm), |y| <= t (H - m x).
    t, m = 0.05, 0.7
    low, high = -t * HEIGHT / (1 - t * m), t * HEIGHT / (1 + t * m)
    plan = 2 * t * (HEIGHT * (high - low) - m * (high**2 - low**2) / 2)
    slope = rectangle((-90, 90), (-90, 90), lambda x, y: m * x)
    assert area(slope, [above(fov=(2 * t * HEIGHT,) * 2)]) == pytest.approx(plan * np.sqrt(1 + m**2), rel=RELATIVE)


@pytest.mark.parametrize(("threshold", "hidden"), [(1, 0.0), (2, 8.0), (3, 16.0)])
def test_staggered_strips_seen_by_three(threshold, hidden):
    # Strips across y at height 200 cast shadows twice as wide, shifted by the camera: x_ground = 2 x - x_camera.
    # From -10, 0 and 10 a strip over [-1, 1] hides [8, 12], [-2, 2] and [-12, -8], one over [4, 6] hides [18, 22],
    # [8, 12] and [-2, 2]. So on [8, 12] and [-2, 2] two cameras are blind, on [-12, -8] and [18, 22] one: 8 mm are seen
    # by less than two and 16 mm by less than three.
    length, width = 40.0, 60.0
    ground = rectangle((-width, width), (-length / 2, length / 2))
    strips = [rectangle(x, (-length, length), 200.0) for x in ((-1, 1), (4, 6))]
    scene = together(ground, *strips)
    exclude = np.arange(6) >= 2
    cameras = [above(x, fov=(4000, 4000)) for x in (-10.0, 0.0, 10.0)]
    assert area(scene, cameras, threshold, exclude=exclude) == pytest.approx(
        (2 * width - hidden) * length, rel=RELATIVE
    )


def test_wall_that_crosses_the_plane_of_the_camera():
    # A wall at x = 5 from the ground to twice the camera's height. It is inside the field of view where it lies
    # deeper than 5 / t below the camera; the rest, up to behind the camera, is not.
    t, half = 0.25, 4.0
    corners = [(5, -half, 0), (5, half, 0), (5, half, 2 * HEIGHT), (5, -half, 2 * HEIGHT)]
    wall = trimesh.Trimesh(corners, [[0, 2, 1], [0, 3, 2]], process=False)
    assert wall.face_normals[0][0] < 0  # towards the camera
    expected = 2 * half * (HEIGHT - 5 / t)
    assert area(wall, [above(fov=(2 * t * HEIGHT,) * 2)]) == pytest.approx(expected, rel=RELATIVE)


def test_wall_behind_hides_nothing():
    scene = together(rectangle((-5, 5), (-5, 5)), rectangle((-500, 500), (-500, 500), HEIGHT + 1.0))
    assert area(scene, [above()]) == pytest.approx(100, rel=RELATIVE)


def test_face_through_the_camera_plane_hides():
    # A slope from the ground up past the camera, z = 100 + 2 (x - 60) for x <= 300, hides nothing of the ground left of
    # where its image begins: its lower edge x = 10 at z = 0 is on the ground.
    slope = rectangle((10, 300), (-300, 300), lambda x, y: 2 * (x - 10), up=False)
    ground = rectangle((-20, 100), (-10, 10))
    scene = together(ground, slope)
    assert area(scene, [above()], exclude=np.array([False, False, True, True])) == pytest.approx(30 * 20, rel=RELATIVE)


def test_camera_inside_a_room():
    # A room of side 20 without ceiling, normals inwards; from its middle a field of view of 90 degrees shows the floor
    # exactly, one of half that tangent a quarter of it.
    room = trimesh.creation.box((20, 20, 20))
    room.update_faces(room.face_normals[:, 2] < 0.5)
    room.invert()
    middle = exact.Camera.look_at((0, 0, 0), (0, 0, -10), up=(0, 1, 0), fov=(20, 20))
    assert area(room, [middle]) == pytest.approx(400, rel=1e-9)
    assert area(room, [exact.Camera.look_at((0, 0, 0), (0, 0, -10), (0, 1, 0), fov=(10, 10))]) == pytest.approx(100)
    # Of each wall of height 20 a field of view of tangent 2 shows what is deeper than 10 / 2 below the camera.
    wide = exact.Camera.look_at((0, 0, 0), (0, 0, -10), (0, 1, 0), fov=(40, 40))
    assert area(room, [wide]) == pytest.approx(400 + 4 * 20 * 5, rel=1e-9)


def test_nested_shells_hide_the_inner_one():
    outer, inner = trimesh.creation.box((10, 10, 10)), trimesh.creation.box((6, 6, 6))
    assert area(together(outer, inner), [above()]) == pytest.approx(100, rel=RELATIVE)


def test_duplicate_and_coplanar_faces_count_once_each():
    plate = rectangle((-5, 5), (-5, 5))
    assert area(together(plate, plate), [above()]) == pytest.approx(200, rel=RELATIVE)
    overlapping = together(plate, rectangle((0, 10), (-5, 5)))
    assert area(overlapping, [above()]) == pytest.approx(200, rel=RELATIVE)


def test_two_sided_sheet_shows_its_front():
    sheet = together(rectangle((-5, 5), (-5, 5)), rectangle((-5, 5), (-5, 5), up=False))
    assert area(sheet, [above()]) == pytest.approx(100, rel=RELATIVE)


def test_faces_edge_on_and_without_area_are_not_seen():
    wall = trimesh.Trimesh([(0, -5, 0), (0, 5, 0), (0, 0, 50)], [[0, 1, 2]], process=False)
    needle = trimesh.Trimesh([(3, 0, 0), (4, 0, 0), (5, 0, 0)], [[0, 1, 2]], process=False)
    scene = together(rectangle((-5, 5), (-5, 5), -10.0), wall, needle)
    assert area(scene, [above()]) == pytest.approx(100, rel=RELATIVE)


def test_nothing_is_reconstructable():
    result = exact.evaluate(rectangle((-5, 5), (-5, 5), up=False), [above(), above(1.0)], threshold=2)
    assert result.area == 0.0
    assert result.to_mesh().area == 0.0
    assert len(result.to_mesh().faces) == 0
    outside = exact.evaluate(rectangle((900, 905), (-5, 5)), [above(), above(1.0)], threshold=2)
    assert outside.area == 0.0


def test_min_baseline_asks_for_two_cameras_far_apart():
    # The strip at height 200 hides [2 - x, ...] as above. Cameras at -10, -9 and 10: where the last one is blind, the
    # other two are only 1 mm apart.
    ground = rectangle((-60, 60), (-20, 20))
    scene = together(ground, rectangle((-1, 1), (-40, 40), 200.0))
    exclude = np.arange(4) >= 2
    cameras = [above(x, fov=(4000, 4000)) for x in (-10.0, -9.0, 10.0)]
    # Shadows: [8, 12], [7, 11], [-12, -8]. Two views everywhere but on [8, 11].
    assert area(scene, cameras, 2, exclude=exclude) == pytest.approx((120 - 3) * 40, rel=RELATIVE)
    # Two far ones: not on [-12, -8] either, nor on [8, 11]; on [7, 8] and [11, 12] one of the near pair is left.
    far = area(scene, cameras, 2, exclude=exclude, min_baseline=5.0)
    assert far == pytest.approx((120 - 3 - 4) * 40, rel=RELATIVE)


def test_weights_scale_areas():
    scene = together(rectangle((-5, 5), (-5, 5)), rectangle((20, 30), (-5, 5)))
    weights = np.array([1.0, 1.0, 0.25, 0.25])
    result = exact.evaluate(scene, [above()], threshold=1, weights=weights)
    assert result.area == pytest.approx(100 + 25, rel=RELATIVE)
    assert result.face_areas.sum() == pytest.approx(200, rel=RELATIVE)
    assert result.level_areas.tolist() == [result.area]


# Scenes that once came out wrong, by up to all there is: what hid the edge of a shadow ended beyond the field of view.
@example(3691)
@example(3804)
@example(3899)
@few
@given(seeds)
def test_sheets_that_reach_beyond_the_field_of_view(seed):
    # Level triangles at height z cast shadows that are H / (H - z) times as large; what they leave of the floor in the
    # field of view is seen.
    rng, half = np.random.default_rng(seed), 10.0
    n = rng.integers(2, 7)
    corners = [np.array([[-120.0, -120.0], [120.0, -120.0], [0.0, 130.0]])]
    for _ in range(n):
        corner = rng.normal(size=2) * 12 + rng.normal(size=(3, 2)) * rng.choice([8, 30, 80])
        corners.append(corner if shapely.LinearRing(corner).is_ccw else corner[::-1])
    heights = [0.0, *rng.permutation(n) + 1.0]
    vertices = np.concatenate(
        [np.column_stack([corner, np.full(3, z)]) for corner, z in zip(corners, heights, strict=True)]
    )
    mesh = trimesh.Trimesh(vertices, np.arange(len(vertices)).reshape(-1, 3), process=False)
    scaled = [corner * HEIGHT / (HEIGHT - z) for corner, z in zip(corners, heights, strict=True)]
    floor, *shadows = (shapely.Polygon(corner) for corner in scaled)
    left = shapely.box(-half, -half, half, half).intersection(floor).difference(shapely.union_all(shadows))
    camera = exact.Camera.look_at((0, 0, HEIGHT), (0, 0, 0), up=(0, 1, 0), fov=(2 * half, 2 * half))
    assert exact.view(mesh, camera).face_areas[0] == pytest.approx(left.area, abs=1e-7)
