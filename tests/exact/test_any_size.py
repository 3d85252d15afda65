"""Meshes of any size and shape: work in blocks, slender faces, what lies hidden behind a sheet of faces."""

import numpy as np
import pytest
import trimesh

import exact
from exact.visibility import close_pairs, screen, sight_depth, silhouettes
from experiments.bench.generated_meshes import KINDS
from tests.support.ray_oracle import Samples
from tests.support.scenes import above, rectangle, soup, tilted_tori, together

RING = exact.Ring()
CLOSED = ("sphere", "brain", "skull", "cylinders")


def cameras(n=4):
    return RING.cameras(RING.equidistant(n))


@pytest.mark.parametrize("kind", CLOSED)
def test_meshes_of_the_benchmark_are_closed_and_of_the_size_asked_for(kind):
    mesh = KINDS[kind](4000)
    assert mesh.is_watertight
    assert mesh.volume > 0
    assert abs(len(mesh.faces) / 4000 - 1) < 0.05
    assert np.array_equal(mesh.vertices, KINDS[kind](4000).vertices)


@pytest.mark.parametrize("kind", ["brain", "skull", "cylinders", "channel"])
def test_areas_are_those_of_rays(kind):
    mesh = KINDS[kind](1500)
    angles = [0.3, 1.9, 4.0]
    samples = Samples(mesh, angles, 200_000)
    for threshold in (1, 2, 3):
        area = exact.evaluate(mesh, RING.cameras(angles), threshold=threshold).area
        estimate = samples.estimate(range(3), threshold)
        assert abs(area - estimate.area) <= 4 * estimate.standard_error


@pytest.mark.parametrize("kind", ["brain", "cylinders"])
def test_the_size_of_blocks_changes_no_bit(kind, monkeypatch):
    mesh = KINDS[kind](300)
    before = exact.evaluate(mesh.copy(), cameras())
    for module in (close_pairs, screen, sight_depth, silhouettes):
        monkeypatch.setattr(module, "PAIRS", 3)
    after = exact.evaluate(mesh.copy(), cameras())
    assert np.array_equal(before.face_areas, after.face_areas)


def test_a_fan_of_slender_faces_is_worth_what_a_few_are():
    # A tall block over a floor; its top is a fan of 600 faces, up to 400 times as long as wide, or just two.
    corner = np.array([[-5.0, -5], [5, -5], [5, 5], [-5, 5]])
    fine = np.concatenate([corner[1] + np.linspace(0, 1, 301)[:, None] * (corner[2] - corner[1]),
                           corner[2] + np.linspace(0, 1, 301)[1:, None] * (corner[3] - corner[2])])  # fmt: skip
    blocks = []
    for top in (fine, corner[1:]):
        outline = np.concatenate([corner[:1], top])
        n = len(outline)
        i, j = np.arange(n), np.roll(np.arange(n), -1)
        fan = np.stack([np.zeros(n - 2, dtype=int), i[1:-1], j[1:-1]], axis=1)
        sides = np.concatenate([np.stack([i, j, j + n], axis=1), np.stack([i, j + n, i + n], axis=1)])
        points = np.concatenate([np.column_stack([outline, np.full(n, z)]) for z in (0.0, 20.0)])
        blocks.append(trimesh.Trimesh(points, np.concatenate([fan[:, ::-1], sides, fan + n]), process=False))
    turn = trimesh.transformations.rotation_matrix(0.4, (1, 2, 3))
    areas = []
    for block in blocks:
        assert block.is_watertight
        scene = together(block, rectangle((-30, 30), (-30, 30), z=-1.0))
        areas.append([
            exact.evaluate(mesh, [camera.moved(pose) for camera in cameras()]).area
            for mesh, pose in ((scene, np.eye(4)), (scene.copy().apply_transform(turn), turn))
        ])  # fmt: skip
    assert np.allclose(areas, areas[1][0], rtol=1e-10, atol=0)


def test_faces_that_meet_in_no_point_do_not_cut_each_other():
    # Each has a corner in the plane of the other, at opposite ends.
    one = trimesh.Trimesh([[0, 0, 0], [4, 0, 1], [4, 0, -1]], [[0, 1, 2]], process=False)
    two = trimesh.Trimesh([[1, 0, 0], [3, 3, 0.0], [1, 3, 0]], [[0, 1, 2]], process=False)
    apart = trimesh.Trimesh([[-1, 0.5, 0], [-1, 4, 1], [-1, 4, -1]], [[0, 1, 2]], process=False)
    assert len(exact.Scene(together(one, two)).surface.intersections.face) == 2
    assert len(exact.Scene(together(two, apart)).surface.intersections.face) == 0


@pytest.mark.parametrize("size", [0.01, 0.3, 5.0])
def test_through_a_hole_of_any_size_a_camera_sees_what_perspective_says(size):
    # A fine grid at height 100 with one square hole off the middle of all its cells, over a fine floor, 400 below.
    side = np.concatenate([np.linspace(-20, 1.003, 30), np.linspace(1.003 + size, 20, 30)])
    x, y = np.meshgrid(side, side, indexing="ij")
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.stack([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)], axis=2)
    full = faces.reshape(-1, 3)
    faces = np.delete(faces.reshape(59 * 59, 2, 3), 29 * 59 + 29, axis=0).reshape(-1, 3)
    sheet = trimesh.Trimesh(np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 100.0)]), faces, process=False)
    floor = trimesh.Trimesh(np.column_stack([2 * x.ravel(), 2 * y.ravel(), np.zeros(x.size)]), full, process=False)
    camera = above(height=400.0, fov=(30.0, 30.0))
    seen = exact.evaluate(together(sheet, floor), [camera], threshold=1)
    # At 300 in front of the camera the field of view is 22.5 wide; what the hole shows is 4/3 as wide at 400.
    hole = min(1.003 + size, 11.25) - 1.003
    assert seen.face_areas[: len(faces)].sum() == pytest.approx(22.5**2 - hole**2, rel=1e-10)
    assert seen.face_areas[len(faces) :].sum() == pytest.approx((hole * 4 / 3) ** 2, rel=1e-9)


def test_what_a_sheet_hides_changes_no_area():
    # A slab wider than the field of view, in faces of 1 mm: whatever lies below is never seen.
    slab = trimesh.creation.box((40.0, 40.0, 1.0))
    for _ in range(5):
        slab = slab.subdivide()
    below = KINDS["brain"](2000)
    below.apply_translation([0, 0, -30])
    alone, both = (exact.evaluate(mesh, cameras()) for mesh in (slab, together(slab, below)))
    assert np.array_equal(both.face_areas[: len(slab.faces)], alone.face_areas)
    assert not both.face_areas[len(slab.faces) :].any()
    assert exact.evaluate(below, cameras()).area > 0


def under_a_slit(of_floor=3, of_plates=0):
    """A floor under two plates, of which each camera sees a strip, and no two the same; halved so many times."""
    floor, plate = trimesh.creation.box((30, 30, 1)), trimesh.creation.box((14.8, 40, 1))
    for _ in range(of_floor):
        floor = floor.subdivide()
    for _ in range(of_plates):
        plate = plate.subdivide()
    return together(floor, *(plate.copy().apply_translation((x, 0, 15)) for x in (-7.5, 7.5)))


NEIGHBOURS = {
    "channel": (lambda: KINDS["channel"](600), RING.cameras(RING.equidistant(60))),
    "brain": (lambda: KINDS["brain"](300), RING.cameras(RING.equidistant(60))),
    "slit": (under_a_slit, RING.cameras(RING.equidistant(60))),
    "slit in small faces": (lambda: under_a_slit(0, 3), RING.cameras(RING.equidistant(60))),
    "slit, wide and narrow ring": (
        under_a_slit,
        [
            *exact.Ring(diameter=160, working_distance=250).cameras(RING.equidistant(30)),
            *exact.Ring(diameter=8).cameras(RING.equidistant(30)),
        ],
    ),
    "triangles everywhere": (soup, RING.cameras(np.sort(np.random.default_rng(3).uniform(0, 1, 57)))),
    "tori, cameras at any height": (
        lambda: together(*tilted_tori()),
        [above(*place) for place in np.random.default_rng(4).uniform((-9, -9, 300), (9, 9, 303), (57, 3))],
    ),
}


@pytest.mark.parametrize("scene", NEIGHBOURS)
def test_many_neighbouring_cameras_see_what_each_sees_alone(scene):
    mesh, cameras = NEIGHBOURS[scene][0](), NEIGHBOURS[scene][1]
    sets = exact.view_sets(mesh, cameras)
    of_sets = sets.areas @ sets.seen
    alone = [exact.view(mesh, camera).area for camera in cameras]
    assert of_sets == pytest.approx(alone, rel=1e-9)
    assert len(set(np.round(alone, 6))) > 1
    # Sets are cut by every camera, without a thought to what still waits for how many views.
    for threshold in (1, 2, 4):
        area = exact.evaluate(mesh, cameras, threshold=threshold).area
        assert area == pytest.approx(sets.area(threshold=threshold), rel=1e-10)


def test_many_neighbouring_cameras_with_a_limit_see_what_each_sees_alone():
    mesh, ring = KINDS["brain"](300), RING.cameras(RING.equidistant(57))
    limits = exact.Limits(max_incidence=np.radians(50.0))
    sets = exact.view_sets(mesh, ring, limits=limits)
    alone = [exact.view(mesh, camera, limits=limits).area for camera in ring]
    assert sets.areas @ sets.seen == pytest.approx(alone, rel=1e-9)
    assert max(alone) < 0.9 * exact.view(mesh, ring[0]).area
    area = exact.evaluate(mesh, ring, limits=limits).area
    assert area == pytest.approx(sets.area(), rel=1e-10)
