"""View limits, lights and obstacles: closed forms derived by hand, laws, and what is refused."""

import numpy as np
import pytest
import trimesh

import exact
from exact import Camera, Limits, Optics
from exact.predicted.reconstructed import piece_areas

WIDE = (400.0, 400.0)  # a field of view that limits nothing here


def plane(corners):
    """A rectangle by its four corners, counter-clockwise as seen from its front."""
    return trimesh.Trimesh(np.array(corners, dtype=float), [[0, 1, 2], [0, 2, 3]], process=False)


def floor(half=100.0, z=0.0):
    return plane([[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]])


def above(x=0.0, y=0.0, height=400.0):
    """A camera that looks straight down."""
    return Camera.look_at((x, y, height), (x, y, 0.0), up=(0, 1, 0), fov=WIDE)


def area(mesh, cameras, **asked):
    return exact.evaluate(mesh, cameras, **asked).area


@pytest.mark.parametrize("subdivisions", [0, 3])
def test_incidence_leaves_a_disc_of_a_plane(subdivisions):
    mesh = floor()
    for _ in range(subdivisions):
        mesh = mesh.subdivide()
    radius = 400 * np.tan(np.radians(8.0))  # 56.2 mm
    found = area(mesh, [above(3.0, -5.0)], threshold=1, limits=Limits(max_incidence=np.radians(8.0)))
    assert found == pytest.approx(np.pi * radius**2, rel=1e-6)


def test_a_depth_of_field_leaves_a_strip_of_a_tilted_plane():
    slope = np.radians(30.0)
    turn = trimesh.transformations.rotation_matrix(slope, (0, 1, 0))
    mesh = floor(50.0)
    mesh.apply_transform(turn)
    # Along the slope depth changes by sin(30°) a millimetre: 10 mm of depth are 20 mm of it, 100 mm wide.
    found = area(mesh, [above()], threshold=1, limits=Limits(depth_of_field=(395.0, 405.0)))
    assert found == pytest.approx(20.0 * 100.0, rel=1e-9)


def test_blur_limits_depth_as_the_lens_does():
    slope = np.radians(30.0)
    mesh = floor(50.0)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(slope, (0, 1, 0)))
    optics = Optics(resolution=(4000, 4000), pupil=4.0)  # 10 px/mm at 400 mm
    # A disc of 2 px is 0.2 mm at the focus: 4 |z - 400| / z = 0.2 at z = 400 / 1.05 and 400 / 0.95.
    depth = 400 / 0.95 - 400 / 1.05
    found = area(mesh, [above()], threshold=1, limits=Limits(max_blur=2.0), optics=optics)
    assert found == pytest.approx(2 * depth * 100.0, rel=1e-9)


def test_pixel_density_ends_at_a_line_on_a_wall():
    wall = plane([[30, -20, -200], [30, 20, -200], [30, 20, 0], [30, -20, 0]])
    wall.invert()
    wall = wall if wall.face_normals[0, 0] < 0 else wall.copy()
    if wall.face_normals[0, 0] > 0:
        wall.invert()
    optics = Optics(resolution=(40_000, 40_000))  # f = 400 mm × 100 px/mm
    # f² h / z³ ≥ 500 at a height of h = 30 mm over the wall's plane: z ≤ (40 000² × 30 / 500)^(1/3) = 457.9 mm.
    deepest = np.cbrt(40_000.0**2 * 30 / 500) - 400
    found = area(wall, [above()], threshold=1, limits=Limits(min_pixel_density=500.0), optics=optics)
    assert 50 < deepest < 70
    assert found == pytest.approx(40.0 * deepest, rel=1e-9)


def test_an_edge_throws_a_shadow():
    # A screen over x < 0 at a height of 10 mm; a light at height 50 over x = -20 shines past its edge down to x = 5.
    screen = plane([[-90, -90, 10], [0, -90, 10], [0, 90, 10], [-90, 90, 10]])
    scene = exact.Scene(floor(50.0), obstacles=(screen,), lights=((-20.0, 0.0, 50.0),))
    cameras = [above(40.0), above(45.0)]
    assert area(scene, cameras) == pytest.approx(45.0 * 100.0, rel=1e-9)
    # A second light from the other side lights what cameras see under the screen too: all that one of them sees.
    both = exact.Scene(floor(50.0), obstacles=(screen,), lights=((-20.0, 0.0, 50.0), (80.0, 0.0, 50.0)))
    one = exact.Scene(floor(50.0), obstacles=(screen,))
    assert area(both, cameras) == pytest.approx(area(one, cameras), rel=1e-9)


def test_light_from_within_a_box_and_from_outside():
    box = trimesh.creation.box((10, 10, 10))
    box.invert()
    inside = exact.Scene(trimesh.util.concatenate([box, floor(200.0, -20.0)]), lights=((0.0, 0.0, 0.0),))
    whole = inside.surface.areas[inside.lit.whole_seen.any(axis=1)].sum()
    pieces = inside.lit.pieces.take(inside.lit.pieces.seen.any(axis=1))
    assert whole + piece_areas(inside.surface, pieces).sum() == pytest.approx(600.0, rel=1e-9)


def test_an_obstacle_throws_a_shadow_and_does_not_count():
    # A square of 4 mm at 100 mm below the camera hides four times as much in each direction at 400 mm.
    obstacle = floor(2.0, 300.0)
    for turned in (False, True):  # whichever way its front looks
        mesh = obstacle.copy()
        if turned:
            mesh.invert()
        found = area(floor(), [above()], threshold=1, obstacles=(mesh,))
        assert found == pytest.approx(200.0**2 - 16.0**2, rel=1e-9)
        assert exact.evaluate(floor(), [above()], threshold=1, obstacles=(mesh,)).face_areas.shape == (2,)


def test_a_limit_holds_in_every_way_of_asking():
    ring, mesh = exact.Ring(), trimesh.creation.icosphere(subdivisions=3, radius=9.0)
    cameras = ring.cameras(np.radians([10.0, 80.0, 150.0, 300.0]))
    limits = Limits(max_incidence=np.radians(50.0), min_pixel_density=6000.0, depth_of_field=(390.0, 398.0))
    scene = exact.Scene(mesh, lights=((5.0, 0.0, 300.0),), obstacles=(floor(1.0, 50.0),))
    found = area(scene, cameras, limits=limits)
    assert 0 < found < 0.9 * area(scene, cameras)
    assert exact.areas(scene, [cameras], limits=limits)[0] == found
    assert exact.areas(scene, [cameras] * 2, limits=limits, workers=2).tolist() == [found] * 2
    assert area(scene, cameras, limits=limits, workers=2) == pytest.approx(found, rel=1e-12)
    assert exact.view_sets(scene, cameras, limits=limits).area() == pytest.approx(found, rel=1e-12)
    assert exact.OneMore(scene, cameras[1:], limits=limits).area(cameras[0]) == pytest.approx(found, rel=1e-12)
    alone = area(scene, cameras[:1], threshold=1, limits=limits)
    assert exact.view(scene, cameras[0], limits=limits).face_areas[: len(mesh.faces)].sum() == pytest.approx(alone)
    part = exact.evaluate(scene, cameras, limits=limits).to_mesh()
    assert part.area == pytest.approx(found, rel=1e-9)
    none = exact.evaluate(scene, cameras, limits=limits).to_mesh(level=0)
    some = [exact.evaluate(scene, cameras, limits=limits).to_mesh(level=level).area for level in (1, 2)]
    assert none.area + sum(some) == pytest.approx(mesh.area, rel=1e-9)


@pytest.mark.parametrize(
    "limit", [{"max_incidence": 0.9}, {"min_pixel_density": 5000.0}, {"depth_of_field": (391, 399)}]
)
def test_laws_hold_with_limits(limit):
    limits, mesh = Limits(**limit), trimesh.creation.torus(6.0, 2.5)
    ring, angles = exact.Ring(), np.radians([20.0, 120.0, 260.0])
    found = area(mesh, ring.cameras(angles), limits=limits)
    assert 0 < found < area(mesh, ring.cameras(angles))
    # Moved together.
    rigid = trimesh.transformations.rotation_matrix(0.7, (1, 2, 3), (4, 5, 6))
    moved = mesh.copy()
    moved.apply_transform(rigid)
    cameras = [camera.moved(rigid) for camera in ring.cameras(angles)]
    assert area(moved, cameras, limits=limits) == pytest.approx(found, rel=1e-9)
    # In another order, and with split faces.
    assert area(mesh, ring.cameras(angles[::-1]), limits=limits) == pytest.approx(found, rel=1e-9)
    tolerance = 1e-6 if "max_incidence" in limit else 1e-9
    assert area(mesh.subdivide(), ring.cameras(angles), limits=limits) == pytest.approx(found, rel=tolerance)
    # Twice as large: lengths double, and a square millimetre gets a quarter of the pixels.
    large = mesh.copy()
    large.apply_scale(2.0)
    scaled = {
        "max_incidence": limits.max_incidence,
        "min_pixel_density": limits.min_pixel_density and limits.min_pixel_density / 4,
        "depth_of_field": limits.depth_of_field and tuple(2 * depth for depth in limits.depth_of_field),
    }
    twice = exact.Ring(60.0, 800.0, (72.0, 48.0))
    assert area(large, twice.cameras(angles), limits=Limits(**scaled)) == pytest.approx(4 * found, rel=1e-9)


def test_what_makes_no_sense_is_refused():
    for wrong, words in (
        ({"max_incidence": 2.0}, "max_incidence is 2.0; it must be above 0 and below pi / 2"),
        ({"min_pixel_density": 0}, "min_pixel_density is 0; it must be a number, positive"),
        ({"depth_of_field": (5, 4)}, "the first must be at least 0 and less than the second"),
        ({"depth_of_field": 4}, "it must be two depths, near and far"),
        ({"max_blur": np.nan}, "max_blur is nan"),
    ):
        with pytest.raises(exact.ExactError, match=words.replace("(", r"\(")):
            Limits(**wrong)
    with pytest.raises(exact.ExactError, match="give the optics a pupil"):
        exact.Demand(limits=Limits(max_blur=1.0))
    with pytest.raises(exact.ExactError, match="limits is a dict; an exact.Limits is needed"):
        exact.Demand(limits={})
    with pytest.raises(exact.ExactError, match="resolution is"):
        Optics(resolution=(0, 5))
    with pytest.raises(exact.ExactError, match="obstacle 1 is a str"):
        exact.Scene(floor(), obstacles=("instrument.stl",))
    with pytest.raises(exact.ExactError, match="light 2 is"):
        exact.Scene(floor(), lights=((0, 0, 1), (0, 0)))
    sets = exact.view_sets(floor(), [above(), above(3.0)])
    with pytest.raises(exact.ExactError, match="made with other limits"):
        sets.area(limits=Limits(max_incidence=1.0))
