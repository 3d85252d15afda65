"""Rendered images show each point where the camera projects it, and are the same each time."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from PIL import Image

import exact
from experiments.exports.cameras import named_cameras
from experiments.simulate.photographs import Photographer
from experiments.simulate.render import Renderer, Stage, best_variant
from experiments.simulate.sensor import exposed

SIZE = (180, 120)
# A ring that stands askew, away from the origin, so that nothing holds by symmetry.
RING = exact.Ring(40.0, 300.0, (36.0, 24.0), focus=(5.0, -3.0, 2.0), axis=(0.2, -0.1, 1.0))


def stage(mesh, ring=RING, colours=None, **optics):
    lamps = ring.positions(ring.equidistant(2))
    return Stage(mesh, colours, lamps, np.array(ring.focus), exact.Optics(SIZE, **optics), grain=0.4, rays=4, seed=3)


def balls():
    """Three small balls at different depths near the focus, and their centres."""
    axis = np.array(RING.axis) / np.linalg.norm(RING.axis)
    centres = np.array(RING.focus) + [[9.0, 4.0, 0.0], [-8.0, 5.0, 0.0], [2.0, -7.0, 0.0]]
    centres = centres + np.array([-12.0, 0.0, 15.0])[:, None] * axis
    parts = [trimesh.creation.icosphere(radius=1.2).apply_translation(centre) for centre in centres]
    return trimesh.util.concatenate(parts), centres


def centroids(light, near):
    """Mean pixel position [pixels] of what is bright within 12 pixels of each place."""
    bright = light.mean(axis=2) > 0.02
    row, column = np.nonzero(bright)
    found = np.stack([column, row], axis=1) + 0.5
    return np.array([found[np.linalg.norm(found - place, axis=1) < 12].mean(axis=0) for place in near])


@pytest.mark.parametrize("angle", [0.3, 2.0, 4.4])
def test_points_lie_where_the_camera_projects_them(angle):
    mesh, centres = balls()
    (camera,) = named_cameras(RING, np.array([angle]), SIZE)
    light = Renderer(stage(mesh), best_variant()).light(camera.camera, seed=1)
    # By hand, without `Camera.project`: along right and down, over the depth, half the image at half the field of view.
    right, down, look = camera.camera.rotation
    away = centres - camera.camera.position
    focal = SIZE[0] * np.linalg.norm(camera.camera.position - RING.focus) / RING.fov[0]
    expected = focal * np.stack([away @ right, away @ down], axis=1) / (away @ look)[:, None] + np.array(SIZE) / 2
    assert np.abs(centroids(light, expected) - expected).max() < 0.15


def test_every_variant_renders_the_same_picture():
    mesh, _ = balls()
    (camera,) = named_cameras(RING, np.array([1.0]), SIZE)
    one, other = (Renderer(stage(mesh), name).light(camera.camera, seed=1) for name in ("scalar_rgb", best_variant()))
    assert np.abs(one.mean() / other.mean() - 1) < 0.01
    assert np.corrcoef(one.ravel(), other.ravel())[0, 1] > 0.98


def test_a_wide_pupil_blurs_what_is_out_of_focus_as_the_optics_say():
    # An edge 40 mm nearer than the focus: a disc of D z' / z at the focus, here in pixels.
    plate = trimesh.creation.box((30.0, 60.0, 1.0)).apply_translation((15.0, 0.0, 40.0))
    ring, pupil = exact.Ring(), 6.0
    camera = replace(exact.Camera.look_at((0, 0, 400), (0, 0, 0), (0, 1, 0)), resolution=np.array(SIZE))
    sharp, blurred = (
        Renderer(stage(plate, ring, np.ones((12, 3)), pupil=one), best_variant()).light(camera, seed=0)[:, :, 1].mean(0)
        for one in (None, pupil)
    )
    middle = SIZE[0] // 2
    depth = 400.0 - 40.5
    disc = pupil * abs(depth - 400.0) / depth * SIZE[0] / 36.0
    # The edge of a disc-shaped blur is as steep as the disc's diameter across its middle.
    steepest = np.abs(np.diff(blurred[middle - 10 : middle + 10])).max() / blurred[middle + 15]
    assert steepest == pytest.approx(4 / np.pi / disc, rel=0.15)
    assert np.abs(np.diff(sharp[middle - 10 : middle + 10])).max() / sharp[middle + 15] > 0.95


def test_a_white_surface_at_the_focus_is_as_bright_as_is_said():
    plate = trimesh.creation.box((80.0, 80.0, 1.0)).apply_translation((0.0, 0.0, -0.5))
    ring = exact.Ring()
    (camera,) = ring.cameras([0.5])
    light = Renderer(stage(plate, ring, np.ones((12, 3))), best_variant()).light(camera, seed=0)
    assert light[SIZE[1] // 2, SIZE[0] // 2].mean() == pytest.approx(0.8, rel=0.01)


def test_noise_of_the_sensor_is_that_of_photons():
    for brightness in (0.1, 0.5):
        picture = exposed(np.full((200, 200, 3), brightness), noise=0.02, seed=5) / 255.0
        linear = ((picture + 0.055) / 1.055) ** 2.4
        assert linear.mean() == pytest.approx(brightness, rel=0.01)
        assert linear.std() == pytest.approx(0.02 * np.sqrt(brightness), rel=0.05)


def test_an_image_is_taken_once_and_again_when_anything_about_it_changes(tmp_path):
    mesh, _ = balls()
    cameras = named_cameras(RING, np.array([0.3, 2.0]), SIZE)
    taken = []
    first = Photographer(stage(mesh), 0.01).take(tmp_path, cameras, taken.append)
    assert taken == ["camera_01.png", "camera_02.png"]
    again = Photographer(stage(mesh), 0.01).take(tmp_path, cameras, taken.append)
    assert len(taken) == 2 and all((one == other).all() for one, other in zip(first, again, strict=True))
    (tmp_path / "camera_02.png").unlink()
    third = Photographer(stage(mesh), 0.01).take(tmp_path, cameras, taken.append)
    assert taken[2:] == ["camera_02.png"] and (third[1] == first[1]).all()
    image = tmp_path / "camera_01.png"
    image.write_bytes(image.read_bytes()[:1000])  # cut short by something else
    assert Photographer(stage(mesh), 0.01).missing(tmp_path, cameras) == ["camera_01.png"]
    Photographer(stage(mesh), 0.01).take(tmp_path, cameras)
    moved = mesh.copy().apply_translation((0.0, 0.0, 1e-3))
    others = (
        Photographer(stage(moved), 0.01), Photographer(stage(mesh), 0.02), Photographer(stage(mesh, pupil=1.0), 0.01),
        Photographer(replace(stage(mesh), seed=4), 0.01), Photographer(replace(stage(mesh), rays=5), 0.01),
        Photographer(replace(stage(mesh), lamps=np.zeros((1, 3))), 0.01),
        Photographer(replace(stage(mesh), colours=np.ones((len(mesh.faces), 3))), 0.01),
    )  # fmt: skip
    for other in others:
        assert len(other.missing(tmp_path, cameras)) == 2
    assert len(Photographer(stage(mesh), 0.01).missing(tmp_path, cameras[::-1])) == 0
    elsewhere = named_cameras(RING, np.array([0.3, 2.001]), SIZE)
    assert Photographer(stage(mesh), 0.01).missing(tmp_path, elsewhere) == ["camera_02.png"]
    with Image.open(tmp_path / "camera_01.png") as picture:
        assert picture.size == SIZE
