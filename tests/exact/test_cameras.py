"""Ring and camera geometry against the paper's text (Wachter 2021, section 2.2)."""

import numpy as np
import pytest
import trimesh

import exact
from tests.support.ray_oracle import ring_camera


def test_ring_camera_axes_are_tangential_and_radial():
    ring = exact.Ring()
    for angle in (0.0, 0.7, 3.0, -2.0):
        camera = ring.cameras([angle])[0]
        centre, tangential, radial, look = ring_camera(angle)
        assert camera.position == pytest.approx(centre, abs=1e-12)
        assert camera.rotation[2] == pytest.approx(look, abs=1e-15)
        assert abs(camera.rotation[0] @ tangential) == pytest.approx(1, abs=1e-15)
        assert abs(camera.rotation[1] @ radial) == pytest.approx(1, abs=1e-15)
        assert np.linalg.det(camera.rotation) == pytest.approx(1, abs=1e-14)


def test_up_vector_points_to_the_axis():
    # The paper's up vector ends at (0, 0, r / sin(elevation)), elevation = pi/2 - atan((d/2)/h).
    camera = exact.Ring().cameras([1.1])[0]
    r, elevation = np.hypot(400, 15), np.pi / 2 - np.arctan2(15, 400)
    up = np.array([0, 0, r / np.sin(elevation)]) - camera.position
    assert -camera.rotation[1] == pytest.approx(up / np.linalg.norm(up), abs=1e-14)


def test_field_of_view_is_measured_at_the_focus():
    camera = exact.Ring(fov=(36.0, 24.0)).cameras([0.4])[0]
    corner = camera.rotation.T @ np.array([18.0, 12.0, np.hypot(400, 15)]) + camera.position
    assert camera.project([corner])[0] == pytest.approx(camera.resolution, abs=1e-9)
    assert camera.project([[0.0, 0.0, 0.0]])[0] == pytest.approx(camera.resolution / 2, abs=1e-9)


def test_projection_is_intrinsic_times_extrinsic():
    camera = exact.Camera.look_at((3, -7, 90), (1, 2, 4), (0.2, 1, 0), fov=(20, 30), resolution=(640, 960))
    points = np.random.default_rng(0).uniform(-5, 5, (20, 3))
    homogeneous = np.c_[points, np.ones(20)] @ camera.projection.T
    assert camera.project(points) == pytest.approx(homogeneous[:, :2] / homogeneous[:, 2:], rel=1e-12)
    assert np.isnan(camera.project([[3, -7, 95]])).all()  # behind


def test_moved_camera_sees_the_moved_world():
    camera = exact.Camera.look_at((3, -7, 90), (1, 2, 4), (0.2, 1, 0))
    turn, rigid = np.radians(35), np.eye(4)
    rigid[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    rigid[:3, 3] = (10, 20, 30)
    points = np.random.default_rng(0).uniform(-5, 5, (20, 3))
    moved = points @ rigid[:3, :3].T + rigid[:3, 3]
    assert camera.moved(rigid).project(moved) == pytest.approx(camera.project(points), rel=1e-9)


@pytest.mark.parametrize("axis", [(0, 0, 1), (1, 0, 0), (0, 0, -2), (0.3, -0.4, -0.9), (1e-12, 0, -1)])
def test_ring_along_any_axis(axis):
    focus = np.array([5.0, -3.0, 2.0])
    ring = exact.Ring(diameter=20.0, working_distance=50.0, focus=tuple(focus), axis=axis)
    unit = np.array(axis) / np.linalg.norm(axis)
    positions = ring.positions(ring.equidistant(5, phase=0.2)) - focus
    assert positions @ unit == pytest.approx(np.full(5, 50.0), abs=1e-12)
    assert np.linalg.norm(np.cross(positions, unit), axis=1) == pytest.approx(np.full(5, 10.0), abs=1e-12)
    # Counter-clockwise seen against the axis.
    assert np.cross(positions[0], positions[1]) @ unit > 0
    camera = ring.cameras([0.0])[0]
    assert camera.rotation[2] @ (focus - camera.position) == pytest.approx(np.hypot(50, 10), abs=1e-12)


def test_equidistant_is_the_papers():
    assert exact.Ring().equidistant(4) == pytest.approx(np.pi / 2 * np.arange(1, 5), abs=1e-15)
    assert exact.Ring().equidistant(2, phase=0.1) == pytest.approx([np.pi + 0.1, 2 * np.pi + 0.1])


def test_separations_are_chords():
    chords = exact.Ring(diameter=30).separations([0, np.pi, np.pi / 3])
    assert chords == pytest.approx(
        np.array([[0, 30, 15], [30, 0, 30 * np.sin(np.pi / 3)], [15, 30 * np.sin(np.pi / 3), 0]])
    )


def test_resolution_changes_no_area():
    ball = trimesh.creation.icosphere(2, radius=30)
    coarse, fine = (
        exact.Camera.look_at((0, 0, 400), (0, 0, 0), (0, 1, 0), resolution=size) for size in ((36, 24), (9999, 17))
    )
    assert exact.view(ball, coarse).area == exact.view(ball, fine).area


def test_cameras_cannot_be_changed_by_accident():
    camera = exact.Ring().cameras([0.0])[0]
    with pytest.raises(ValueError, match="read-only"):
        camera.position[0] = 1.0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: exact.Ring(diameter=0), r"ring diameter is 0; it must be positive"),
        (lambda: exact.Ring(working_distance=-1), r"working distance is -1; it must be positive"),
        (lambda: exact.Ring(fov=(36, 0)), r"fov height is 0\.0; it must be positive"),
        (lambda: exact.Ring(fov=(36,)), r"fov is \(36,\); it must be 2 finite numbers"),
        (lambda: exact.Ring(fov="wide"), r"fov is 'wide'; it must be 2 numbers"),
        (lambda: exact.Ring(focus=(0, np.nan, 0)), r"focus is .* must be 3 finite numbers"),
        (lambda: exact.Ring(axis=(0, 0, 0)), r"ring axis is the zero vector"),
        (lambda: exact.Ring(diameter="x"), r"ring diameter is 'x'; it must be a number \[mm\]"),
        (lambda: exact.Ring().equidistant(0), r"number of cameras is 0; it must be a whole number, at least 1"),
        (lambda: exact.Ring().equidistant(2.5), r"number of cameras is 2\.5"),
        (lambda: exact.Ring().cameras([0.0, np.inf]), r"are not all finite"),
        (lambda: exact.Ring().cameras([]), r"at least one angle"),
        (lambda: exact.Camera.look_at((0, 0, 1), (0, 0, 1), (0, 1, 0)), r"they must differ"),
        (lambda: exact.Camera.look_at((0, 0, 1), (0, 0, 0), (0, 0, 5)), r"parallel to the optical axis"),
        (lambda: exact.Camera.look_at((0, 0, 1), (0, 0, 0), (0, 0, 0)), r"zero or parallel"),
        (lambda: exact.Camera.look_at((0, 0, 1), (0, 0, 0), (0, 1, 0), resolution=(0, 5)), r"pixels must be positive"),
        (lambda: exact.Ring().equidistant(3, phase=np.nan), r"phase is nan; it must be from -1e\+06 to 1e\+06 \[rad\]"),
        (lambda: exact.Ring().equidistant(3, phase=-np.inf), r"phase is -inf; it must be from"),
        (lambda: exact.Ring().equidistant(3, phase="x"), r"phase is 'x'; it must be a number \[rad\]"),
        (lambda: exact.Ring().positions(["x"]), r"ring angles are \['x'\]; they must be one row of numbers"),
        (lambda: exact.Ring().positions([0.0, 2e6]), r"ring angle 2 is 2e\+06 rad; it must be .* at most 1e\+06"),
        (lambda: exact.Camera.look_at((0, 0, 5e9), (0, 0, 0), (0, 1, 0)), r"position is .* at most 4e\+09 \[mm\]"),
        (lambda: exact.Camera.look_at((0, 0, 1), (0, 0, 0), (0, 1, 0), fov=(-3, 2)), r"fov width is -3\.0"),
        (lambda: exact.Ring().cameras([0.0])[0].moved("turn it"), r"needs a rigid \(4, 4\) matrix"),
        (lambda: exact.Ring().cameras([0.0])[0].moved(2 * np.eye(4)), r"needs a rigid \(4, 4\) matrix"),
        (lambda: exact.Ring().cameras([0.0])[0].moved(np.diag([1, 1, -1, 1])), r"needs a rigid"),
    ],
)
def test_impossible_rings_and_cameras(make, message):
    with pytest.raises(exact.ExactError, match=message):
        make()


DOWN = [[1, 0, 0], [0, -1, 0], [0, 0, -1]]
BY_HAND = dict(position=[0, 0, 400], rotation=DOWN, target_distance=400, fov=[36, 24], resolution=[3600, 2400])


def test_a_camera_made_by_hand_of_lists_sees_what_look_at_sees():
    plate = trimesh.creation.box((100, 100, 1))
    by_hand, usual = exact.Camera(**BY_HAND), exact.Camera.look_at((0, 0, 400), (0, 0, 0), (0, 1, 0))
    assert exact.view(plate, by_hand).area == exact.view(plate, usual).area
    assert (by_hand.projection == usual.projection).all()


def test_a_camera_made_by_hand_keeps_its_arrays_to_itself():
    given = {name: np.array(value, dtype=float) for name, value in BY_HAND.items() if name != "target_distance"}
    camera = exact.Camera(target_distance=400.0, **given)
    for name, array in given.items():
        array += 1.0
        assert getattr(camera, name).tolist() == BY_HAND[name]
        with pytest.raises(ValueError, match="read-only"):
            getattr(camera, name)[0] = 1.0


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (dict(position=[0, 0]), r"camera position is \[0, 0\]; it must be 3 finite numbers"),
        (dict(position=[0, np.nan, 0]), r"camera position is .*; it must be 3 finite numbers"),
        (dict(position=[0, 0, 1e300]), r"camera position is .*; each coordinate must be at most 4e\+09"),
        (dict(position="above"), r"camera position is 'above'; it must be 3 numbers"),
        (dict(rotation=np.eye(4)), r"camera rotation is an array of shape \(4, 4\), .* it must be a \(3, 3\) rotation"),
        (dict(rotation=np.full((3, 3), np.nan)), r"camera rotation is an array of shape \(3, 3\), .*look_at makes one"),
        (dict(rotation=2 * np.eye(3)), r"camera rotation is"),
        (dict(rotation=np.diag([1, 1, -1])), r"camera rotation is"),  # a mirror
        (dict(rotation=np.full((3, 3), 1e200)), r"camera rotation is"),
        (dict(rotation="down"), r"camera rotation is"),
        (dict(target_distance=np.nan), r"target distance is nan; it must be positive and finite \[mm\]"),
        (dict(target_distance=0), r"target distance is 0; it must be positive"),
        (dict(target_distance=[400]), r"target distance is \[400\]; it must be a number \[mm\]"),
        (dict(target_distance=1e200), r"target distance is 1e\+200 mm; it must be at most 4e\+09"),
        (dict(fov=36), r"fov is 36; it must be 2 finite numbers"),
        (dict(fov=[36, -24]), r"fov height is -24\.0; it must be positive"),
        (dict(resolution=[3600, np.inf]), r"resolution is .*; it must be 2 finite numbers"),
        (dict(resolution=[0, 2400]), r"resolution is \(0\.0, 2400\.0\); both numbers of pixels must be positive"),
    ],
)
def test_impossible_cameras_made_by_hand(wrong, message):
    with pytest.raises(exact.ExactError, match=message):
        exact.Camera(**BY_HAND | wrong)


def test_the_frame_of_a_ring_holds_its_axis_and_the_first_quarter():
    ring = exact.Ring(diameter=2.0, working_distance=5.0, axis=(0.3, -0.4, 0.9))
    local = ring.positions([0.0, np.pi / 2]) @ ring.frame
    assert local == pytest.approx(np.array([[1, 0, 5], [0, 1, 5]]), abs=1e-12)


@pytest.mark.parametrize("axis", [(0, 0, 1), (0.3, -0.2, 0.9)])
def test_a_ring_gives_the_cameras_that_look_at_gives_one_by_one_to_the_last_bit(axis):
    ring = exact.Ring(diameter=41.7, working_distance=311.3, fov=(30.0, 21.0), focus=(3.3, -7.1, 12.9), axis=axis)
    angles = np.linspace(-7.0, 7.0, 57)
    focus, frame = np.array(ring.focus), ring.frame
    apex = focus + frame[:, 2] * ((311.3**2 + (41.7 / 2) ** 2) / 311.3)
    for camera, position in zip(ring.cameras(angles), ring.positions(angles), strict=True):
        alone = exact.Camera.look_at(position, ring.focus, up=apex - position, fov=ring.fov)
        assert camera.position.tobytes() == alone.position.tobytes()
        assert camera.rotation.tobytes() == alone.rotation.tobytes()
        assert camera.target_distance == alone.target_distance
        assert np.array_equal(camera.fov, alone.fov) and np.array_equal(camera.resolution, alone.resolution)
