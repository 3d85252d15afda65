"""A textured plane comes out as accurately as is predicted; and what a comparison says of points made up for it."""

import numpy as np
import pytest
import trimesh

import exact
from experiments.exports.cameras import named_cameras
from experiments.files.errors import InputError
from experiments.request.simulation import Simulation
from experiments.simulate.compare import Samples, compared
from experiments.simulate.rectify import Rectified
from experiments.simulate.simulation import Asked, named_pairs, simulate

SIZE = (360, 240)
OPTICS = exact.Optics(SIZE)


def plane(tilt, at=(0.0, 0.0, 0.0)):
    """A plate whose upper side goes through a point, turned about the x axis, and the normal of that side."""
    turn = trimesh.transformations.rotation_matrix(tilt, (1.0, 0.0, 0.0))
    plate = trimesh.creation.box((60.0, 60.0, 2.0)).apply_translation((0.0, 0.0, -1.0))
    plate.apply_transform(turn).apply_translation(at)
    return plate, turn[:3, 2]


@pytest.mark.parametrize(("n_cameras", "tilt_deg"), [(2, 0.0), (4, 35.0)])
def test_a_plane_comes_out_as_accurately_as_is_predicted(tmp_path, n_cameras, tilt_deg):
    mesh, normal = plane(np.radians(tilt_deg))
    ring = exact.Ring()
    scene = exact.Scene(mesh, exclude=mesh.face_normals @ normal < 0.5)
    angles = ring.equidistant(n_cameras)
    demand = exact.Demand(optics=OPTICS)
    quiet = Simulation(sensor_noise=0.0, rays=16)
    found = simulate(Asked("plane", scene, ring, angles, demand, quiet), tmp_path)
    # By hand: standard deviation of depth s z² / (f √S), along the normal its cosine; S = M (d / 2)².
    focal = 400.0 * SIZE[0] / 36.0
    sigma = found.noise * 400.0**2 / (focal * np.sqrt(n_cameras * 15.0**2)) * np.cos(np.radians(tilt_deg))
    off = found.comparison.points @ normal
    measured = 1.4826 * np.median(np.abs(off - np.median(off)))
    assert 0.02 < found.noise < 0.25
    assert 1 / 1.5 < measured / sigma < 1.5
    assert found.comparison.accuracy() == pytest.approx(measured, rel=1e-3)  # without the few that are 2 mm off
    assert found.comparison.predicted(found.noise) == pytest.approx(sigma, rel=0.03)
    assert np.abs(np.median(off)) < sigma
    # The noise that is measured is that of the depth maps, in pixels of each image.
    camera = found.asked.cameras[0].camera
    rays = np.linalg.inv(camera.intrinsic) @ [SIZE[0] / 2 + 0.5, SIZE[1] / 2 + 0.5, 1.0]
    depth = found.depths[0][SIZE[1] // 2, SIZE[0] // 2]
    centre = camera.position + depth * camera.rotation.T @ rays
    assert abs(centre @ normal) < 8 * sigma
    # All that both cameras see of the plane, but for a border that windows reach across.
    assert found.comparison.completeness(0.5, found.seen) > 0.93
    assert found.predicted.area == pytest.approx(found.comparison.samples.areas[found.seen].sum(), rel=0.01)


def test_rows_and_disparities_of_turned_images_are_those_of_the_geometry():
    cameras = [one.camera for one in named_cameras(exact.Ring(), np.radians([20.0, 170.0]), SIZE)]
    pair = Rectified.of(*cameras, (380.0, 420.0))
    points = np.random.default_rng(0).uniform((-8.0, -6.0, -20.0), (8.0, 6.0, 20.0), (200, 3))
    one, two = (pair.at(camera.project(points) - 0.5, which) for which, camera in enumerate(cameras))
    assert np.abs(one[:, 1] - two[:, 1]).max() < 1e-6
    disparity = one[:, 0] - two[:, 0]
    assert disparity.min() > 0 and disparity.max() < pair.n_disparities
    along = (points - cameras[0].position) @ pair.rotation[2]
    assert pair.depth(disparity) == pytest.approx(along, rel=1e-9)


@pytest.fixture(scope="module")
def flat():
    """Samples of a plate as four cameras see it."""
    mesh, normal = plane(np.radians(20.0), at=(3.0, 1.0, -4.0))
    scene = exact.Scene(mesh, exclude=mesh.face_normals @ normal < 0.5)
    ring = exact.Ring()
    cameras = [one.camera for one in named_cameras(ring, ring.equidistant(4), SIZE)]
    return scene, normal, cameras, Samples.of(scene, cameras, exact.Demand(optics=OPTICS), seed=1, n=20_000)


def test_samples_know_incidence_and_density(flat):
    _, normal, cameras, samples = flat
    camera, points = cameras[1], samples.points[:50]
    away = camera.position - points
    cosine = away @ normal / np.linalg.norm(away, axis=1)
    assert np.cos(samples.incidence[:50, 1]) == pytest.approx(cosine, rel=1e-9)
    # A small square on the surface, projected: its corners span so many pixels.
    side, across = 1e-3, np.cross(normal, (1.0, 0.0, 0.0))
    corners = [points, points + side * np.array([1.0, 0.0, 0.0]), points + side * across]
    here, right, up = (camera.project(corner) for corner in corners)
    one, two = (right - here) / side, (up - here) / side
    density = np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
    assert samples.density[:50, 1] == pytest.approx(density, rel=1e-4)
    second = np.sort(np.where(samples.seen, samples.density, 0.0), axis=1)[:, -2]
    assert samples.second_density == pytest.approx(second)


def test_disparity_gradient_is_by_how_much_disparities_differ(flat):
    """Of neighbouring points, by the projections of two cameras, over their mean distance in the images."""
    scene, normal, cameras, samples = flat
    one, two = cameras[0], cameras[2]
    # Near the middle of the images, where the line of sight is across them.
    chosen = np.flatnonzero(samples.seen[:, 0] & samples.seen[:, 2] & (np.linalg.norm(samples.points, axis=1) < 5))[:50]
    points = samples.points[chosen]
    steep = np.cross(np.cross((one.position + two.position) / 2 - points, normal), normal)
    near = points + 1e-3 * steep / np.linalg.norm(steep, axis=1)[:, None]
    # Turned about their optical axes so that the images of both are upright alike.
    pair = Rectified.of(one, two, (380.0, 420.0))
    shifts = [pair.at(camera.project(near) - 0.5, i) - pair.at(camera.project(points) - 0.5, i)
              for i, camera in enumerate((one, two))]  # fmt: skip
    gradient = np.linalg.norm(shifts[0] - shifts[1], axis=1) / np.linalg.norm((shifts[0] + shifts[1]) / 2, axis=1)
    of_pair, of_two_pairs = (samples.gradient(scene.surface, cameras, pairs) for pairs in (((0, 2),), ((0, 2), (0, 1))))
    assert of_pair[chosen] == pytest.approx(gradient, rel=0.03)
    assert (of_two_pairs <= of_pair).all()


def test_points_off_the_surface_are_off_by_as_much(flat):
    scene, normal, _, samples = flat
    inner = samples.points[np.linalg.norm(samples.points - [3.0, 1.0, -4.0], axis=1) < 8]
    lot = np.random.default_rng(2).normal(0.0, 0.05, len(inner))
    lot[::10] += 100.0  # astray
    found = compared(samples, scene, inner + (0.02 + lot)[:, None] * normal, seed=0)
    assert found.astray == pytest.approx(0.1, abs=0.001)
    assert np.median(found.error) == pytest.approx(0.02, abs=0.002)
    assert found.accuracy() == pytest.approx(0.05, rel=0.03)
    disc = np.pi * 8**2
    assert found.area(0.3) == pytest.approx(disc, rel=0.1)
    assert found.area(0.001) < 0.2 * disc
    assert compared(samples, scene, np.zeros((0, 3)), seed=0).area() == 0.0


def test_what_does_not_count_takes_no_points(flat):
    scene, normal, *_, samples = flat
    below = samples.points - 1.7 * normal  # nearer to the lower side, which is left out
    assert len(compared(samples, scene, below, seed=0).points) < 0.01 * len(below)


def test_pairs_are_those_that_a_layout_names():
    assert named_pairs({}, 4) is None
    assert named_pairs({"robustness": {"pairs": [{"cameras": [4, 2]}], "accurate_pairs": []}}, 4) == ((1, 3),)
    for pairs in ([{"cameras": [1, 5]}], [{"cameras": [2, 2]}], [{"cameras": [1]}], ["1 and 2"]):
        with pytest.raises(InputError, match='"pairs" of its "robustness" must'):
            named_pairs({"robustness": {"pairs": pairs}}, 4)


def test_only_the_pairs_that_are_named_are_matched(tmp_path):
    mesh, normal = plane(0.0)
    ring = exact.Ring()
    scene = exact.Scene(mesh, exclude=mesh.face_normals @ normal < 0.5)
    demand, rough = exact.Demand(optics=exact.Optics((120, 80))), Simulation(rays=1)
    angles, steps = ring.equidistant(3), []
    asked = Asked("plane", scene, ring, angles, demand, rough, pairs=((0, 2),))
    found = simulate(asked, tmp_path, steps.append)
    assert set(steps) == set(asked.steps()) and len(asked.matched) == 1
    assert np.isnan(found.depths[1]).all() and np.isfinite(found.depths[0]).any()
    with pytest.raises(InputError, match="1 camera gives no pair of images to match"):
        Asked("plane", scene, ring, angles[:1], demand, rough)
