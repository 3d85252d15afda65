"""What is shared or left out to bound and average errors quickly changes neither areas nor averages."""

import numpy as np
import pytest
import trimesh

import exact
import meshes
from tests.support.random_requests import MESHES, request

RING = exact.Ring()


def sigma(cameras, points, seen, axis):
    """Errors (N,) of points from the cameras that see them, by central differences of where they are imaged."""
    total = np.zeros((len(points), 3, 3))
    for camera, sees in zip(cameras, seen.T, strict=True):
        focal = camera.target_distance * np.array([3600, 2400]) / camera.fov

        def image(at, camera=camera, focal=focal):
            local = (at - camera.position) @ camera.rotation.T
            return focal * local[:, :2] / local[:, 2:]

        slopes = np.stack([image(points + 1e-3 * e) - image(points - 1e-3 * e) for e in np.eye(3)], axis=2) / 2e-3 / 0.5
        total += sees[:, None, None] * np.einsum("nki,nkj->nij", slopes, slopes)
    return np.sqrt(np.einsum("i,nij,j->n", axis, np.linalg.inv(total), axis))


def divided(sets, times):
    """Centres and areas of the triangles of sets of cameras, quartered so often, and the rows of the sets."""
    mesh = sets.to_mesh()
    chosen = mesh.face_attributes["set"] >= 0
    corner, row = mesh.triangles[chosen], mesh.face_attributes["set"][chosen]
    for _ in range(times):
        a, b, c = corner.transpose(1, 0, 2)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        corner = np.concatenate(
            [np.stack(part, axis=1) for part in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        )
        row = np.tile(row, 4)
    cross = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    return corner.mean(axis=1), np.linalg.norm(cross, axis=1) / 2, row


def holed_floor():
    """A floor on which boxes that float above it cast shadows, one of them with a hole in it."""
    corners = np.array([[-9, -7, 0], [9, -7, 0], [9, 7, 0], [-9, 7, 0]], dtype=float)
    box = trimesh.creation.box((4, 3, 1)).apply_translation((1, 0.5, 20))
    frame = trimesh.creation.annulus(1.0, 2.0, 0.5, sections=12).apply_translation((-5, 1, 15))
    return exact.Scene(trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False), obstacles=(box, frame))


@pytest.mark.parametrize("name", ["floor", "artery"])
def test_averages_of_errors_are_those_of_many_small_triangles(name):
    if name == "floor":
        scene, times = holed_floor(), 4
    else:
        mesh = meshes.site("circ_artery", depth=50)
        scene, times = exact.Scene(mesh, exclude=meshes.top_surface(mesh)), 2
    cameras = RING.cameras(RING.equidistant(5, 0.3))
    found, sets = exact.evaluate(scene, cameras), exact.view_sets(scene, cameras)
    points, areas, row = divided(sets, times)
    enough = sets.seen[row].sum(axis=1) >= 2
    assert areas[enough].sum() == pytest.approx(found.area, rel=1e-9)
    errors = sigma(cameras, points[enough], sets.seen[row[enough]], np.array([0.0, 0.0, 1.0]))
    assert np.sqrt(np.average(errors**2, weights=areas[enough])) == pytest.approx(found.error_rms, rel=5e-5)
    shares = [0.05, 0.5, 0.95]
    for share, value in zip(shares, found.error_quantiles(shares), strict=True):
        assert areas[enough][errors <= value * (1 + 3e-3)].sum() >= share * found.area * (1 - 1e-9)
        assert areas[enough][errors < value * (1 - 3e-3)].sum() <= share * found.area * (1 + 1e-9)
    assert found.errors.weights.sum() == pytest.approx(found.area, rel=1e-12)


@pytest.mark.parametrize(("n_cameras", "error"), [(3, "normal"), (20, "depth")])
def test_what_is_accurate_enough_is_a_part_of_the_sets_of_all_cameras(n_cameras, error):
    # More cameras than are looked through at once, and bounds that some parts meet early and others never.
    mesh = meshes.site("circ_artery", depth=50)
    scene = exact.Scene(mesh, exclude=meshes.top_surface(mesh), weights=np.linspace(0, 2, len(mesh.faces)))
    cameras = RING.cameras(RING.equidistant(n_cameras, 0.2))
    sets, plain = exact.view_sets(scene, cameras), exact.evaluate(scene, cameras, error=error)
    for largest in plain.error_quantiles([0.1, 0.6, 0.97]):
        found = exact.evaluate(scene, cameras, max_error=largest, error=error)
        assert 0.02 * plain.area < found.area < 0.995 * plain.area
        assert found.area == pytest.approx(sets.area(max_error=largest, error=error), rel=2e-6)
        assert found.area == pytest.approx(plain.area_to(largest), rel=2e-6)
        np.testing.assert_allclose(found.level_areas, plain.level_areas, rtol=1e-9)
        assert found.area_to(2 * largest) == found.area
        assert found.errors.weights.sum() == pytest.approx(found.area, rel=1e-9)


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("bounded", [False, True])
@pytest.mark.parametrize("name", sorted(MESHES))
def test_all_views_at_once_change_no_number(name, bounded, workers):
    rng, mesh, cameras = request(1, name, 5)
    scene = exact.Scene(mesh, weights=rng.random(len(mesh.faces)), exclude=rng.random(len(mesh.faces)) < 0.1)
    asked = {"threshold": 2 + bounded, "limits": exact.Limits(max_incidence=1.4)}
    if bounded:
        asked["min_baseline"] = 0.01 * cameras[0].target_distance
        asked["max_error"] = exact.evaluate(scene, cameras, **asked).error_quantiles([0.5])[0]
    found, again = (
        exact.evaluate(scene, cameras, all_views=all_views, workers=workers, **asked) for all_views in (False, True)
    )
    assert found.area > 0 and again.area == pytest.approx(found.area, rel=2e-6 if bounded else 1e-9)
    np.testing.assert_allclose(again.level_areas, found.level_areas, rtol=1e-9, atol=1e-12)
    assert again.error_rms == pytest.approx(found.error_rms, rel=1e-6)
    assert again.error_quantiles([0.2, 0.8]) == pytest.approx(found.error_quantiles([0.2, 0.8]), rel=1e-3)
    largest = 0.9 * found.error_quantiles([0.5])[0]
    assert again.area_to(largest) == pytest.approx(found.area_to(largest), rel=1e-5, abs=1e-6 * mesh.area)
    for level in (None, 0, 1):
        assert again.to_mesh(level).area == pytest.approx(found.to_mesh(level).area, rel=2e-6, abs=1e-9 * mesh.area)
    triangles = again.to_mesh(errors=True)
    assert triangles.area == pytest.approx(found.to_mesh(errors=True).area, rel=2e-6)


@pytest.mark.parametrize("name", sorted(MESHES))
def test_areas_to_an_error_by_many_small_triangles(name):
    rng, mesh, cameras = request(1, name, 12)
    plain = exact.evaluate(mesh, cameras, threshold=2)
    assert plain.area > 0
    sets = exact.view_sets(mesh, cameras)
    points, areas, row = divided(sets, 3)
    axis = -np.sum([camera.rotation[2] for camera in cameras], axis=0)
    enough = sets.seen[row].sum(axis=1) >= 2
    errors = sigma(cameras, points[enough], sets.seen[row[enough]], axis / np.linalg.norm(axis))
    largest = float(np.quantile(errors, 0.4, weights=areas[enough], method="inverted_cdf")) * 1.0001
    found = exact.evaluate(mesh, cameras, threshold=2, max_error=largest)
    assert found.area == pytest.approx(areas[enough][errors <= largest].sum(), rel=0.02, abs=1e-3 * plain.area)
