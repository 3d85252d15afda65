import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import trimesh

import exact
from placement.layouts.arcs import TURN, LayoutSpace
from placement.layouts.constraints import Constraints
from placement.proof.certificate import cells_of
from placement.samples.profiles import RingProfiles, Visibility, ring_profiles
from placement.samples.sampled_site import faces_towards
from placement.samples.sampling import SurfaceSamples
from placement.surrogate.soft_coverage import Changes, signed_distances

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


class KnownArcs(Visibility):
    """Points that are seen from known arcs of the ring: each change is where visibility begins or ends."""

    def __init__(self, changes: list[np.ndarray], begins: list[bool]):
        self.changes, self.begins = changes, begins  # ring angles [rad], and whether the first of a point begins an arc

    def pairs(self, samples, ring, angles, points):
        seen = np.zeros(len(points), dtype=bool)
        for point in np.unique(points):
            seen[points == point] = self._seen(point, angles[points == point])
        return seen

    def from_angles(self, samples, ring, angles):
        return np.stack([self._seen(p, np.asarray(angles)) for p in range(len(self.changes))], axis=1)

    def _seen(self, point, angles):
        first = self.changes[point][0]
        passed = np.mod(angles - first, TURN)[:, None] >= np.mod(self.changes[point] - first, TURN)
        return self.begins[point] == (passed.sum(axis=1) % 2 == 1)

    def distance(self, angles):
        """(M, N) true signed angular distance [rad] to the nearest change."""
        turned = [np.mod(angles[:, None] - changes, TURN) for changes in self.changes]
        away = np.stack([np.minimum(turn, TURN - turn).min(axis=1) for turn in turned], axis=1)
        return np.where(self.from_angles(None, None, angles), away, -away)


def known_arcs(seed, n_angles):
    """Points with one to four arcs each and as many gaps, all at least 1.01 steps wide, many of them hardly wider."""
    rng = np.random.default_rng(seed)
    changes = []
    for evenness, n in itertools.product([0.02, 0.1, 1.0] * 5, [2, 4, 6, 8]):
        share = rng.dirichlet(np.full(n, evenness))
        widths = TURN / n_angles * (1.01 + (n_angles - 1.01 * n) * share)
        changes.append(np.mod(rng.uniform(0, TURN) + np.cumsum(widths), TURN))
    return KnownArcs(changes, (rng.random(len(changes)) < 0.5).tolist())


def nowhere(n):
    return SurfaceSamples(np.zeros((n, 3)), np.tile(UP, (n, 1)), np.ones(n), np.zeros(n, dtype=int))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("n_angles", "bisections"), [(24, 8), (24, 0), (121, 5)])
def test_arcs_and_gaps_wider_than_a_step_end_where_they_were_traced(seed, n_angles, bisections):
    arcs = known_arcs(seed, n_angles)
    profiles = ring_profiles(arcs, nowhere(60), exact.Ring(), n_angles, bisections)
    located_to = TURN / n_angles / 2 ** (bisections + 1) + 1e-9
    ends = np.concatenate(arcs.changes)
    angles = np.concatenate([ends - 1.01 * located_to, ends + 1.01 * located_to, np.linspace(-9, 9, 50)])
    distance = arcs.distance(angles)
    clear = np.abs(distance) > located_to
    assert (profiles.at(angles) == (distance > 0))[clear].all()
    changes = Changes(jnp.asarray(profiles.behind), jnp.asarray(profiles.ahead))
    traced = jax.jit(signed_distances)(jnp.asarray(angles), changes)
    assert np.abs(traced - distance).max() <= located_to
    grid = TURN / n_angles * np.arange(n_angles)
    assert np.abs(profiles.signed_distance - arcs.distance(grid)).max() <= located_to


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("n_cells", [4, 23, 24, 72, 100])
def test_a_cell_sees_what_is_seen_from_any_angle_in_it_and_no_more(seed, n_cells):
    arcs = known_arcs(seed, 24)
    profiles = ring_profiles(arcs, nowhere(60), exact.Ring(), 24, bisections=8)
    cells = cells_of(profiles, LayoutSpace(exact.Ring(), 3, Constraints()), exact.Demand(), n_cells)
    inside = (np.arange(n_cells)[:, None] + np.linspace(0, 1, 101)) * TURN / n_cells
    seen = profiles.at(inside.ravel()).reshape(n_cells, 101, -1).any(axis=1)
    assert not (seen & ~cells.seen).any()
    assert (cells.seen & ~seen).mean() < 0.01  # an arc may reach into the cell by less than 101 angles of it show


@pytest.mark.parametrize("steps", [1.01, 1.2, 1.5, 1.9])
@pytest.mark.parametrize("offset", [0.03, 0.4, 0.97])
def test_a_gap_hardly_wider_than_a_step_is_the_closed_form(steps, offset):
    """Hidden by a wall for `steps` steps of the profile, the middle of it anywhere between two grid angles."""
    n_angles, height = 40, 100.0
    half = steps * np.pi / n_angles
    distance = 15 * height / 400 * np.cos(half)
    turned = trimesh.transformations.rotation_matrix(offset * TURN / n_angles, (0, 0, 1))
    mesh = floor_with_wall(distance, height).apply_transform(turned)
    profiles = ring_profiles(mesh, points_up((0, 0, 0)), exact.Ring(), n_angles, bisections=8)
    from_middle = np.linspace(-3, 3, 601) * TURN / n_angles
    clear = np.abs(np.abs(from_middle) - half) > TURN / n_angles / 2**9 + 1e-4
    seen = profiles.at(from_middle + offset * TURN / n_angles)[:, 0]
    assert (seen == (np.abs(from_middle) > half))[clear].all()
    assert (~seen).sum() > 90
