"""Predicted errors against triangulations with noise, closed forms, and independent integrals."""

import numpy as np
import pytest
import trimesh
from scipy.optimize import brentq

import exact
import meshes
from exact import Camera, Optics
from exact.usable.information import information, variance

OPTICS = Optics(resolution=(3600, 2400), match_noise=0.5)


def floor(half=100.0):
    corners = [[-half, -half, 0], [half, -half, 0], [half, half, 0], [-half, half, 0]]
    return trimesh.Trimesh(np.array(corners, dtype=float), [[0, 1, 2], [0, 2, 3]], process=False)


def pixels(camera, points, resolution=(3600, 2400)):
    """Image of points, written from the pinhole's definition."""
    local = (points - camera.position) @ camera.rotation.T
    focal = camera.target_distance * np.array(resolution) / camera.fov
    return focal * local[:, :2] / local[:, 2:]


def triangulated(cameras, truth, noise, rng, n):
    """(n, 3) least-squares triangulations of a point from images with noise, by Gauss and Newton."""
    seen = np.stack([pixels(camera, truth[None])[0] for camera in cameras])
    images = seen + noise * rng.standard_normal((n, *seen.shape))
    found = np.tile(truth, (n, 1))
    for _ in range(6):
        rows, misses = [], []
        for i, camera in enumerate(cameras):
            here, step = pixels(camera, found), 1e-4
            slopes = [(pixels(camera, found + step * axis) - here) / step for axis in np.eye(3)]
            rows.append(np.stack(slopes, axis=2))
            misses.append(images[:, i] - here)
        jacobian, miss = np.concatenate(rows, axis=1), np.concatenate(misses, axis=1)
        normal = np.einsum("nki,nkj->nij", jacobian, jacobian)
        found = found + np.linalg.solve(normal, np.einsum("nki,nk->ni", jacobian, miss)[..., None])[..., 0]
    return found


@pytest.mark.parametrize("seed", range(50))
def test_scatter_of_triangulations(seed):
    rng = np.random.default_rng(seed)
    n_cameras = int(rng.integers(2, 7))
    positions = rng.normal(0, 30, (n_cameras, 3)) + [0, 0, 300]
    cameras = [Camera.look_at(p, rng.normal(0, 3, 3), (0, 1, 0.1), (36, 24)) for p in positions]
    truth, normal = rng.normal(0, 5, 3), rng.normal(0, 1, 3)
    normal /= np.linalg.norm(normal)
    total = information(truth[None], cameras, OPTICS).sum(axis=1)
    scatter = triangulated(cameras, truth, 0.5, rng, 20_000) - truth
    for direction in (normal, np.array([0.0, 0.0, 1.0])):
        predicted = float(np.sqrt(variance(total, direction)[0]))
        assert np.std(scatter @ direction) == pytest.approx(predicted, rel=0.03)


def test_on_a_ring_as_the_closed_form_says():
    ring, rng = exact.Ring(), np.random.default_rng(1)
    for _ in range(50):
        theta = rng.uniform(0, 2 * np.pi, int(rng.integers(2, 9)))
        point = rng.uniform(-8, 8, 3) * [1, 1, 3]
        total = information(point[None], ring.cameras(theta), OPTICS).sum(axis=1)
        spread = 15.0**2 * (len(theta) - abs(np.exp(1j * theta).sum()) ** 2 / len(theta))
        if spread < 1:
            continue
        depth = 400 - point[2]
        closed = 0.5 * depth**2 / (np.hypot(400, 15) * 100) / np.sqrt(spread)
        assert float(np.sqrt(variance(total, np.array([0.0, 0.0, 1.0]))[0])) == pytest.approx(closed, rel=3e-3)


def parallel(baseline):
    """Two cameras side by side that both look straight down from 400 mm."""
    return [
        Camera.look_at((x, 0, 400), (x, 0, 0), (0, 1, 0), (300, 300), (3600, 2400))
        for x in (-baseline / 2, baseline / 2)
    ]


def test_the_textbook_error_of_two_parallel_cameras_and_its_contour():
    # √2 s z² / (f b): at 0.5 px, f = 12 px/mm × 400 mm along x, b = 30 mm.
    slope = np.radians(30.0)
    mesh = floor(50.0)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(slope, (0, 1, 0)))
    focal = 400 * 3600 / 300
    deepest = 405.0
    largest = np.sqrt(2) * 0.5 * deepest**2 / (focal * 30)
    asked = {"max_error": largest, "depth_axis": (0, 0, 1)}
    found = exact.evaluate(mesh, parallel(30.0), **asked)
    # 5 mm below the middle, along a slope on which depth changes by half a millimetre a millimetre.
    assert found.area == pytest.approx((50 + 10) * 100, rel=1e-6)
    whole = exact.evaluate(mesh, parallel(30.0), depth_axis=(0, 0, 1))
    assert whole.area_to(largest) == found.area
    # The mean square over the slope, by hand: the fourth power of the depth.
    depths = 400 + np.array([-25.0, 25.0])
    mean_fourth = np.diff(depths**5)[0] / 5 / 50
    assert whole.error_rms == pytest.approx(np.sqrt(2) * 0.5 * np.sqrt(mean_fourth) / (focal * 30), rel=1e-6)


@pytest.mark.parametrize("error", ["depth", "normal"])
@pytest.mark.parametrize("subdivisions", [0, 4])
def test_a_contour_on_a_tilted_plane(error, subdivisions):
    mesh = floor(50.0)
    tilt = trimesh.transformations.rotation_matrix(0.02, (1, 0.3, 0))
    mesh.apply_transform(tilt)
    for _ in range(subdivisions):
        mesh = mesh.subdivide()
    ring = exact.Ring(diameter=300.0, working_distance=200.0, fov=(300.0, 300.0))
    cameras = ring.cameras([0.2, 1.9, 3.7])
    direction = np.array([0.0, 0.0, 1.0]) if error == "depth" else tilt[:3, :3] @ [0, 0, 1]

    def sigma(x, y):
        point, step = tilt[:3, :3] @ np.array([x, y, 0.0]), 1e-3
        rows = []
        for camera in cameras:
            ahead, back = (pixels(camera, point + sign * step * np.eye(3)) for sign in (1, -1))
            rows.append((ahead - back).T / (2 * step))
        jacobian = np.concatenate(rows) / 0.5
        return float(np.sqrt(direction @ np.linalg.inv(jacobian.T @ jacobian) @ direction))

    # The error falls with y: the contour through the middle is met once on each line of one x.
    largest = sigma(0.0, 0.0)
    nodes, weights = np.polynomial.legendre.leggauss(30)
    beyond = [50 - brentq(lambda y, x=x: sigma(x, y) - largest, -50, 50) for x in 50 * nodes]
    assert 10 < min(beyond) < max(beyond) < 90
    found = exact.evaluate(mesh, cameras, threshold=3, max_error=largest, error=error, depth_axis=(0, 0, 1)).area
    assert found == pytest.approx(50 * float(weights @ beyond), rel=1e-6)


def test_a_bound_on_the_error_holds_in_every_way_of_asking():
    mesh = meshes.site("circ_artery", depth=50)
    ring, top = exact.Ring(), meshes.top_surface(mesh)
    cameras = ring.cameras(np.radians([139.719, 159.573, 236.573, 258.714]))
    asked = {"max_error": 0.2, "depth_axis": (0.0, 0.0, 1.0)}
    scene = exact.Scene(mesh, exclude=top)
    plain = exact.evaluate(scene, cameras, depth_axis=(0.0, 0.0, 1.0))
    found = exact.evaluate(scene, cameras, **asked)
    assert 0.4 < found.area / plain.area < 0.6
    assert plain.area_to(0.2) == pytest.approx(found.area, rel=1e-6)
    assert plain.area_to(1e3) == pytest.approx(plain.area, rel=1e-9)
    assert exact.areas(scene, [cameras], **asked)[0] == found.area
    assert exact.view_sets(scene, cameras).area(**asked) == pytest.approx(found.area, rel=1e-6)
    assert exact.OneMore(scene, cameras[1:], **asked).area(cameras[0]) == pytest.approx(found.area, rel=1e-6)
    assert found.to_mesh().area == pytest.approx(found.area, rel=1e-9)
    assert found.errors.depth.max() <= 0.2 * (1 + 1e-3)
    shown, _, _ = exact.seen_from(found, cameras[0])
    assert len(shown)
    # Without one camera: the sets of the others, cut anew.
    kept = np.array([False, True, True, True])
    alone = exact.evaluate(scene, cameras[1:], **asked).area
    assert exact.view_sets(scene, cameras).area(cameras=kept, **asked) == pytest.approx(alone, rel=1e-6)


def test_errors_of_triangles_and_quantiles():
    ring = exact.Ring()
    found = exact.evaluate(floor(8.0), ring.cameras(ring.equidistant(4)), depth_axis=(0, 0, 1))
    mesh = found.to_mesh(errors=True)
    depth = mesh.face_attributes["depth_error"]
    assert np.sqrt(np.average(depth**2, weights=mesh.area_faces)) == pytest.approx(found.error_rms, rel=1e-3)
    least, half, most = found.error_quantiles([0.0, 0.5, 1.0])
    assert least < half < most
    assert found.area_to(half) == pytest.approx(found.area / 2, rel=0.02)
    np.testing.assert_allclose(mesh.face_attributes["normal_error"], depth, rtol=1e-9)  # the floor is level
    with pytest.raises(exact.ExactError, match="either level or errors"):
        found.to_mesh(level=1, errors=True)


def test_what_makes_no_sense_is_refused():
    for wrong, words in (
        ({"max_error": 0.0}, "max_error is 0.0; it must be a number, positive"),
        ({"error": "lateral"}, 'error is \'lateral\'; it must be "depth" or "normal"'),
        ({"depth_axis": (0, 0, 0)}, "depth axis is the zero vector"),
    ):
        with pytest.raises(exact.ExactError, match=words):
            exact.Demand(**wrong)
    with pytest.raises(exact.ExactError, match="one camera reconstructs no depth"):
        exact.evaluate(floor(), exact.Ring().cameras([0.0]), threshold=1, max_error=0.1)


def test_one_camera_has_no_error_that_is_finite():
    found = exact.evaluate(floor(8.0), exact.Ring().cameras([0.0]), threshold=1)
    assert np.isinf(found.error_rms)
    nothing = exact.evaluate(floor(8.0), Camera.look_at((0, 0, -400), (0, 0, 0), (0, 1, 0)) and exact.Ring(
        axis=(0, 0, -1)).cameras([0.0, 1.0]))  # fmt: skip
    assert nothing.area == 0.0
    assert np.isnan(nothing.error_rms)
