"""Pictures of what each camera sees: what is seen whole, in part, and not at all is told apart."""

import re

import matplotlib.image
import numpy as np
import pytest
import trimesh

import exact
from experiments.figures.camera_images import CLIPPED_COLOUR, WHOLE_COLOUR, write_camera_images


def plate(side):
    half = side / 2
    corners = [[-half, -half, 0], [half, -half, 0], [half, half, 0], [-half, half, 0]]
    return trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]])


def shares(path):
    """Parts of the picture in the hue of faces seen whole and of faces seen in part."""
    picture = matplotlib.image.imread(path)[..., :3]
    hue = picture / np.maximum(picture.max(axis=2, keepdims=True), 1e-6)
    wanted = (np.array(colour) / max(colour) for colour in (WHOLE_COLOUR, CLIPPED_COLOUR))
    return [float((np.abs(hue - colour).max(axis=2) < 0.05).mean()) for colour in wanted]


def draw(folder, mesh, angles=(0.5,)):
    cameras = exact.Ring().cameras(angles)
    names = write_camera_images(folder, "plate", mesh, cameras, [f"at {angle:g}" for angle in angles], True)
    return [shares(folder / name) for name in names]


def test_what_fits_is_seen_whole_and_what_does_not_is_clipped(tmp_path):
    ((whole, clipped),) = draw(tmp_path, plate(16.0))
    assert 0.1 < whole < 0.5
    assert clipped < 0.01  # the patch in the legend
    ((none, all_of_it),) = draw(tmp_path, plate(100.0))
    assert none < 0.01
    # The field of view is as much larger than the small plate as its area is.
    assert all_of_it / whole == pytest.approx(36 * 24 / 16**2, rel=0.1)


def test_back_faces_are_not_drawn(tmp_path):
    ((whole, clipped),) = draw(tmp_path, trimesh.Trimesh(plate(16.0).vertices, plate(16.0).faces[:, ::-1]))
    assert whole < 0.01 and clipped < 0.01


def test_a_picture_for_each_camera(tmp_path):
    draw(tmp_path, plate(16.0), angles=(0.0, 1.0, 2.0))
    assert sorted(file.name for file in tmp_path.iterdir()) == ["camera_01.png", "camera_02.png", "camera_03.png"]


def test_command_draws_any_layout(tmp_path, camring):
    path = tmp_path / "plate.stl"
    plate(16.0).export(path)
    command = ("evaluate", path, "--angles-deg", "10,200", "--images", tmp_path / "images")
    status, _, said = camring(*command)
    assert status == 0
    assert re.search(r"wrote .*camera_01\.png to camera_02\.png", said)
    assert len(list((tmp_path / "images").iterdir())) == 2
    status, _, said = camring(*command)
    assert status == 2
    assert re.search(r"already holds camera_01\.png, camera_02\.png; .*--force", said)
