import numpy as np
import pytest
import trimesh

import exact
from placement.samples.profiles import RingProfiles, Visibility, ring_profiles
from placement.samples.sampled_site import faces_towards
from placement.samples.sampling import SurfaceSamples

UP = np.array([0.0, 0.0, 1.0])


def points_up(*points):
    points = np.array(points, dtype=float)
    n = len(points)
    return SurfaceSamples(points, np.tile(UP, (n, 1)), np.ones(n), np.zeros(n, dtype=int))


def floor_with_wall(distance=1.0, height=100.0):
    """A floor at z = 0 and a wide thin wall whose inner side stands at x = `distance`."""
    floor = trimesh.creation.box((200, 200, 2))
    floor.apply_translation((0, 0, -1))
    wall = trimesh.creation.box((2, 180, height))
    wall.apply_translation((distance + 1, 0, height / 2))
    return trimesh.util.concatenate([floor, wall])


def closed_form(theta, distance, height, ring=exact.Ring()):  # noqa: B008 - frozen
    """The ray from the origin reaches the wall's height at x = d/2 cos(theta) height / h: visible if short of it."""
    return ring.diameter / 2 * np.cos(theta) * height / ring.working_distance < distance


def test_profile_of_a_point_beside_a_wall_is_the_closed_form():
    distance, height = 1.0, 100.0
    profiles = ring_profiles(floor_with_wall(distance, height), points_up((0, 0, 0)), exact.Ring(), n_angles=72)
    grid = 2 * np.pi * np.arange(72) / 72
    assert (profiles.visible[:, 0] == closed_form(grid, distance, height)).all()
    edge = np.arccos(distance * 400 / (15 * height))  # hidden for |theta| < edge
    from_edge = np.abs(np.angle(np.exp(1j * grid))) - edge
    expected = np.where(from_edge < 0, from_edge, np.minimum(from_edge, 2 * np.pi - 2 * edge - from_edge))
    located_to = 2 * np.pi / 72 / 2**6
    assert np.abs(profiles.signed_distance[:, 0] - expected).max() <= located_to + 1e-6


def test_interpolated_profile_changes_where_rays_do():
    mesh = floor_with_wall()
    samples = points_up((0, 0, 0), (-0.5, 3, 0), (0.3, -2, 0))
    profiles = ring_profiles(mesh, samples, exact.Ring(), n_angles=60, bisections=8)
    angles = np.random.default_rng(0).uniform(-20, 20, 300)
    traced = Visibility(mesh).from_angles(samples, exact.Ring(), angles)
    assert (profiles.at(angles) == traced).mean() > 0.995


def test_always_and_never_visible_rows_are_finite():
    mesh = floor_with_wall()
    samples = points_up((-50, 0, 0), (-6, 0, 0), (5, 0, -3))  # outside the view, free, inside the floor
    profiles = ring_profiles(mesh, samples, exact.Ring(), n_angles=24)
    assert (profiles.signed_distance[:, 0] == -np.pi).all()
    assert (profiles.signed_distance[:, 2] == -np.pi).all()
    assert (profiles.signed_distance[:, 1] > 0).all()
    assert np.isfinite(profiles.signed_distance).all()


def test_a_face_does_not_hide_itself_even_edge_on():
    """Walls of a channel are seen under one or two degrees; self-hits would hide them."""
    wall = trimesh.creation.box((2, 10, 40))
    wall.apply_translation((-10, 0, 20))
    x_face = wall.face_normals[:, 0] > 0.5
    from placement.samples.sampling import sample_surface

    samples = sample_surface(wall, 2000, exclude=~x_face)
    seen = Visibility(wall).from_angles(samples, exact.Ring(), [0.0])[0]
    assert seen.all()


@pytest.mark.parametrize("shift", [(0, 0, 0), (1000, -700, 300)])
def test_moving_mesh_and_ring_together_changes_nothing(shift):
    samples = points_up((0, 0, 0), (-0.5, 3, 0), (0.3, -2, 0), (-12, 4, 0))
    here = ring_profiles(floor_with_wall(), samples, exact.Ring(), n_angles=36)
    moved_mesh = floor_with_wall()
    moved_mesh.apply_translation(shift)
    moved = SurfaceSamples(samples.points + shift, samples.normals, samples.weights, samples.faces)
    there = ring_profiles(moved_mesh, moved, exact.Ring(focus=shift), n_angles=36)
    assert np.abs(here.signed_distance - there.signed_distance).max() < 0.02


def test_field_of_view_turns_with_the_ring_angle():
    """36 mm wide along the tangent, 24 mm along the radius: a point at (0, 15, 0) is seen from angle 0, not 90."""
    plate = trimesh.creation.box((60, 60, 2))
    plate.apply_translation((0, 0, -1))
    seen = Visibility(plate).from_angles(points_up((0, 15, 0)), exact.Ring(), [0.0, np.pi / 2, np.pi])
    assert seen[:, 0].tolist() == [True, False, True]


def test_one_step_narrow_arcs_survive():
    visible = np.zeros((8, 1), dtype=bool)
    visible[3] = True
    distance = np.where(visible, 0.1, -0.5)
    assert RingProfiles.of(distance, np.ones(1)).at([2 * np.pi * 3 / 8 + 4 * np.pi])[0, 0]


def test_faces_towards_finds_every_face_a_camera_can_see():
    ball = trimesh.creation.icosphere(subdivisions=3, radius=60)
    ball.apply_translation((5, -3, 10))
    ring = exact.Ring(diameter=80, working_distance=100, axis=(0.3, -0.2, 1.0))
    positions = ring.positions(np.linspace(0, 2 * np.pi, 2000))
    offset = positions[None] - ball.triangles[:, :1]
    dense = (np.einsum("fai,fi->fa", offset, ball.face_normals) > 0).any(axis=1)
    closed = faces_towards(ball, ring)
    assert not (dense & ~closed).any()
    assert (dense != closed).mean() < 0.002


def test_more_angles_can_be_asked_about_than_a_ring_holds_cameras():
    distance, height = 1.0, 100.0
    visibility = Visibility(floor_with_wall(distance, height))
    angles = 2 * np.pi * np.random.default_rng(0).permutation(20_100) / 20_100 + 1e-4
    seen = visibility.pairs(points_up((0, 0, 0)), exact.Ring(), angles, np.zeros(len(angles), dtype=int))
    assert (seen == closed_form(angles, distance, height)).all() and seen.any() and not seen.all()
