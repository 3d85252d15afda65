"""The derivative of the exact area: closed forms, central differences, and where there is none."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

import exact
from experiments.bench.generated_meshes import KINDS
from tests.support.scenes import AWKWARD, above, rectangle, together

RING = exact.Ring(diameter=60.0, working_distance=120.0, fov=(30.0, 22.0))
BLOCK = AWKWARD["channel"]()
FREE = {"position": 3, "rotation": 3, "half_extent": 2}
ON_RING = ("angle", "radius", "height", "roll")


def turned(vector):
    return trimesh.transformations.rotation_matrix(np.linalg.norm(vector), vector)[:3, :3] if np.any(vector) else 1.0


def shifted(camera, name, k, by):
    """The camera with one of its numbers changed."""
    position, rotation, half = camera.position.copy(), camera.rotation, camera.half_extent.copy()
    if name == "position":
        position[k] += by
    elif name == "rotation":
        rotation = rotation @ turned(by * np.eye(3)[k]).T
    else:
        half[k] += by
    return exact.Camera(position, rotation, camera.target_distance, 2 * camera.target_distance * half, (3600, 2400))


def on_ring(ring, angle, name, by):
    """The camera of a ring with one of the ring's numbers changed for it."""
    if name == "radius":
        ring = replace(ring, diameter=ring.diameter + 2 * by)
    elif name == "height":
        ring = replace(ring, working_distance=ring.working_distance + by)
    (camera,) = ring.cameras([angle + by if name == "angle" else angle])
    if name != "roll":
        return camera
    return exact.Camera(
        camera.position, camera.rotation @ turned(by * camera.rotation[2]).T, camera.target_distance, camera.fov,
        camera.resolution,
    )  # fmt: skip


def all_areas(scene, cameras, asked):
    found = exact.evaluate(scene, cameras, **asked)
    return np.append(found.area, found.level_areas)


def difference(scene, cameras, i, changed, step, asked):
    """Central difference of area and levels by one number of camera i, and what doubling the step changes of it."""

    def slope(step):
        high, low = (all_areas(scene, [*cameras[:i], changed(by), *cameras[i + 1 :]], asked) for by in (step, -step))
        return (high - low) / (2 * step)

    one, two = slope(step), slope(2 * step)
    return (4 * one - two) / 3, np.abs(one - two)


def compare(scene, angles, least_smooth=0.85, relative=1e-6, ring=RING, **asked):
    """Hold all derivatives by one camera against central differences wherever these agree among themselves."""
    cameras, i = ring.cameras(angles), 1
    found = exact.gradient(scene, cameras, **asked)
    every = [found, *found.by_level]
    around = [one.on_ring(ring) for one in every]
    areas = np.append(found.area, found.reconstruction.level_areas)
    parameters = [(name, k, lambda by, name=name, k=k: shifted(cameras[i], name, k, by))
                  for name, size in FREE.items() for k in range(size)]  # fmt: skip
    parameters += [(name, -1, lambda by, name=name: on_ring(ring, angles[i], name, by)) for name in ON_RING]
    smooth, asked_for = 0, 0
    for name, k, changed in parameters:
        have = [getattr(one, name)[i] if k < 0 else getattr(one, name)[i, k] for one in (around if k < 0 else every)]
        unit = {"position": 100.0, "radius": 100.0, "height": 100.0, "half_extent": 0.1}.get(name, 1.0)
        expected, change = difference(scene, cameras, i, changed, 3e-6 * unit, asked)
        scale = np.maximum(np.abs(expected), 1e-2 * areas / unit)
        good = change <= relative / 2 * scale
        assert (np.abs(have - expected) <= relative * scale)[good].all(), (name, k, have, expected)
        smooth, asked_for = smooth + good.sum(), asked_for + len(good)
    assert smooth >= least_smooth * asked_for
    return found


def crossing_boxes():
    """Three boxes that cut through each other."""
    boxes = [trimesh.creation.box((16, 9 + k, 7)) for k in range(3)]
    for k, box in enumerate(boxes):
        box.apply_transform(trimesh.transformations.rotation_matrix(0.3 + 0.7 * k, (1, k, 0.5)))
    return together(*boxes)


@pytest.mark.parametrize("make", [AWKWARD["channel"], crossing_boxes, AWKWARD["touching boxes"]])
def test_central_differences(make):
    rng = np.random.default_rng(4)
    compare(exact.Scene(make()), rng.uniform(0, 2 * np.pi, 3), threshold=3)


@pytest.mark.parametrize("roll", ["tangential", 0.0, 2.2])
def test_central_differences_of_rolled_cameras(roll):
    rng = np.random.default_rng(4)
    ring = replace(RING, roll=roll, axis=(0.1, -0.2, 0.9))
    compare(exact.Scene(AWKWARD["channel"]()), rng.uniform(0, 2 * np.pi, 3), ring=ring)


@pytest.mark.parametrize(
    "asked",
    [
        {"min_baseline": 45.0},
        {"limits": exact.Limits(depth_of_field=(112.0, 119.0))},
        {"limits": exact.Limits(min_pixel_density=9000.0)},
        {"limits": exact.Limits(max_blur=2.0), "optics": exact.Optics((3600, 2500), pupil=0.5)},
        {"limits": exact.Limits(max_blur=2.0), "optics": exact.Optics((3600, 2500), pupil=0.5, focus_distance=118.0)},
    ],
    ids=["baseline", "depth of field", "pixel density", "blur", "blur at a distance"],
)
def test_central_differences_whatever_counts(asked):
    scene, angles = exact.Scene(BLOCK), np.array([0.3, 1.7, 2.9])
    found = compare(scene, angles, threshold=2, **asked)
    assert 50 < found.area < 0.97 * exact.evaluate(BLOCK, RING.cameras(angles)).area


def test_central_differences_with_weights_light_and_an_obstacle():
    rng = np.random.default_rng(1)
    scene = exact.Scene(
        BLOCK, exclude=BLOCK.face_normals[:, 1] > 0.9, weights=rng.uniform(0.5, 2.0, len(BLOCK.faces)),
        obstacles=[trimesh.creation.box((3, 20, 2)).apply_translation((2, 1, 30))], lights=[(20.0, 5.0, 90.0)],
    )  # fmt: skip
    found = compare(scene, np.array([0.3, 1.7, 2.9]))
    assert found.area == exact.evaluate(scene, RING.cameras([0.3, 1.7, 2.9])).area > 100


def test_central_differences_with_a_greatest_incidence():
    # Circles are cut along chords, whose ends the derivative does not follow.
    cameras, asked = RING.cameras([0.3, 1.7, 2.9]), {"limits": exact.Limits(max_incidence=0.2)}
    found = exact.gradient(BLOCK, cameras, **asked).by_level[0]
    expected = [
        difference(BLOCK, cameras, 1, lambda by, k=k: shifted(cameras[1], "position", k, by), 1e-3, asked)[0][1]
        for k in range(3)
    ]
    assert found.position[1] == pytest.approx(expected, abs=1e-3)
    assert np.abs(found.position[1]).max() > 2


def test_a_camera_among_faces_that_reach_behind_it():
    camera = exact.Camera.look_at((1.0, 0.5, 8.0), (0, 0, 0), (0, 1, 0), fov=(12.0, 12.0))
    walls = [rectangle((-3.0, 3.0), (-30.0, 30.0), lambda x, y, z=z: z + 5 * x) for z in (10.0, -12.0)]
    mesh = together(rectangle((-20.0, 20.0), (-20.0, 20.0), -3.0), *walls)
    found = exact.gradient(mesh, [camera], threshold=1)
    for name, size in FREE.items():
        for k in range(size):
            expected, change = difference(
                mesh, (camera,), 0, lambda by, name=name, k=k: shifted(camera, name, k, by), 1e-5, {"threshold": 1}
            )
            assert change[0] < 1e-4 and getattr(found, name)[0, k] == pytest.approx(expected[0], rel=1e-6, abs=1e-5)


def test_a_plate_that_fills_the_view():
    """Its area is 4 hx hy z² for the height z."""
    plate, height = rectangle((-90, 90), (-80, 80)), 100.0
    camera = above(1.0, 2.0, height, fov=(20.0, 10.0))
    found = exact.gradient(plate, [camera], threshold=1)
    assert found.area == pytest.approx(200.0, rel=1e-12)
    assert np.allclose(found.position, [[0, 0, 4.0]], atol=1e-12)
    assert np.allclose(found.half_extent, [[200 / 0.1, 200 / 0.05]], rtol=1e-12)
    assert np.allclose(found.rotation, 0, atol=1e-10)
    assert found.target_distance.tolist() == [0.0] and found.in_plane.tolist() == [0]


def test_a_disc_of_least_incidence():
    """On a plate it has the area π h² tan² β, wherever the camera is."""
    plate, camera = rectangle((-90, 90), (-80, 80)), above(43.0, -44.0, 50.0)
    found = exact.gradient(plate, [camera], threshold=1, limits=exact.Limits(max_incidence=0.5))
    assert found.area == pytest.approx(np.pi * (50 * np.tan(0.5)) ** 2, rel=1e-9)
    assert np.allclose(found.position, [[0, 0, 2 * found.area / 50]], rtol=1e-9, atol=1e-9)
    assert np.allclose(found.rotation, 0) and np.allclose(found.half_extent, 0)


def test_levels_of_two_overlapping_views():
    plate = rectangle((-90, 90), (-80, 80))
    cameras = [above(x, 0.0, 100.0, fov=(20.0, 10.0)) for x in (0.0, 6.0)]
    found = exact.gradient(plate, cameras)
    # Moved apart, both lose height times way; a side that the other does not see gains as much for one of them.
    assert found.position[:, 0] == pytest.approx([10.0, -10.0])
    assert found.by_level[0].position[:, 0] == pytest.approx([-10.0, 10.0])
    assert found.by_level[1].position[:, 0].tolist() == found.position[:, 0].tolist()


@pytest.mark.parametrize("sunk", [0.0, 0.5])
@pytest.mark.parametrize("n_cameras", [1, 4])
def test_a_post_on_a_floor(sunk, n_cameras):
    """Where it stands its corners touch the floor's faces, or its edges pierce them; three cameras are in line with it.

    Points where faces touch took the place of all borders of their faces, and borders that two cameras cast on one line
    were not the same for both pieces there.
    """
    post = trimesh.creation.box((4, 4, 20), transform=trimesh.transformations.rotation_matrix(np.pi / 4, (0, 0, 1)))
    mesh = together(rectangle((-60, 60), (-60, 60)), post.apply_translation((0, 0, 10 - sunk)))
    cameras = [above(33.0, 0.0, 100.0), above(61.0, 0.0, 100.0), above(47.0, 0.0, 100.0), above(-20.0, 31.0, 100.0)]
    cameras, asked = tuple(cameras[:n_cameras]), {"threshold": (n_cameras + 1) // 2}
    found = exact.gradient(mesh, cameras, **asked)
    assert found.in_plane.sum() == 0
    for camera in range(n_cameras):
        for k in range(3):
            expected, change = difference(
                mesh, cameras, camera, lambda by, camera=camera, k=k: shifted(cameras[camera], "position", k, by), 1e-3,
                asked,
            )  # fmt: skip
            if change[0] < 1e-3:
                assert found.position[camera, k] == pytest.approx(expected[0], rel=1e-6, abs=1e-6)


def test_the_shadow_of_a_square():
    """A square of side a at height z hides (a H / (H - z))² of the floor from height H, and shows its own top."""
    height, level, side = 100.0, 20.0, 6.0
    mesh = together(rectangle((-40, 40), (-40, 40)), rectangle((-3, 3), (-3, 3), level))
    found = exact.gradient(mesh, [above(0.5, -0.25, height)], threshold=1)
    scale = height / (height - level)
    assert found.area == pytest.approx(80**2 + side**2 - (side * scale) ** 2, rel=1e-12)
    by_height = -2 * side**2 * scale * (-level / (height - level) ** 2)
    assert np.allclose(found.position, [[0, 0, by_height]], atol=1e-9)


def test_the_area_is_that_of_evaluate_and_processes_may_share_it():
    rng = np.random.default_rng(8)
    cameras = RING.cameras(rng.uniform(0, 2 * np.pi, 4))
    plain, found = exact.evaluate(BLOCK, cameras), exact.gradient(BLOCK, cameras)
    assert found.area == plain.area and (found.reconstruction.face_areas == plain.face_areas).all()
    shared = exact.gradient(BLOCK, cameras, workers=2)
    assert np.allclose(shared.position, found.position, rtol=1e-11, atol=1e-11)
    assert np.allclose(shared.rotation, found.rotation, rtol=1e-11, atol=1e-9)


def test_faces_in_whose_plane_a_camera_is_are_counted():
    box = trimesh.creation.box((10, 10, 10))
    cameras = [above(5.0, 1.0, 100.0), above(5.0, -5.0, 100.0), above(5.1, 1.0, 100.0)]
    found = exact.gradient(box, cameras)
    assert found.in_plane.tolist() == [2, 4, 0]
    assert found.position.dtype == np.float64 and not found.position.any()  # it sees all that looks at it
    beside = [exact.evaluate(box, [above(5 + by, 1.0, 100.0)], threshold=1).area for by in (-1e-6, 1e-6)]
    assert beside == pytest.approx([100, 200])  # it jumps


def test_what_has_no_derivative_is_refused():
    cameras = RING.cameras([0.0, 2.0])
    with pytest.raises(exact.ExactError, match="without such a bound only: leave max_error out"):
        exact.gradient(BLOCK, cameras, max_error=0.1)
    found = exact.gradient(BLOCK, cameras)
    with pytest.raises(exact.ExactError, match="camera . of 2 is none of this ring; give the ring whose"):
        found.on_ring(replace(RING, working_distance=121.0))
    rolled = exact.Camera(
        cameras[0].position, turned(0.4 * cameras[0].rotation[2]) @ cameras[0].rotation, cameras[0].target_distance,
        cameras[0].fov, cameras[0].resolution,
    )  # fmt: skip
    with pytest.raises(exact.ExactError, match="none of this ring"):
        exact.gradient(BLOCK, [rolled, cameras[1]]).on_ring(RING)


def test_one_more_camera_alone():
    cameras = RING.cameras([0.3, 1.7, 2.9, 4.0])
    asked = {"min_baseline": 20.0, "weights": np.linspace(0.5, 2.0, len(BLOCK.faces))}
    whole = exact.gradient(BLOCK, cameras, **asked)
    area, alone = exact.OneMore(BLOCK, cameras[:3], **asked).gradient(cameras[3])
    assert area == pytest.approx(whole.area, rel=1e-12)
    for name in FREE:
        assert np.allclose(getattr(alone, name), getattr(whole, name)[3:], rtol=1e-10, atol=1e-9)
    with pytest.raises(exact.ExactError, match="leave max_error out"):
        exact.OneMore(BLOCK, cameras[:1], max_error=0.1).gradient(cameras[1])


def test_one_camera_of_many_neighbours():
    """Which look at a part of the surface only; one more camera by itself looks at all of it."""
    mesh, cameras = KINDS["brain"](300), RING.cameras(np.sort(np.random.default_rng(0).uniform(0, 6.28, 57)))
    whole = exact.gradient(mesh, cameras, threshold=20)
    size = np.abs(whole.position).max(axis=1)
    for k in np.argsort(size)[-3:].tolist():
        alone = exact.OneMore(mesh, [*cameras[:k], *cameras[k + 1 :]], threshold=20)
        area, derivative = alone.gradient(cameras[k])
        assert area == pytest.approx(whole.area, rel=1e-12)
        assert size[k] > 1e-3
        for name in FREE:
            assert np.allclose(getattr(derivative, name)[0], getattr(whole, name)[k], rtol=1e-8, atol=1e-8)
