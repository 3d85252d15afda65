"""Where `meshes.place` puts a ring: as good a place as the one that the mesh was made in, however it lies."""

import numpy as np
import pytest
import trimesh

import exact
import meshes
from tests.meshes.defects import knob, sheet
from tests.meshes.placing.shapes import SHAPES, bump, lying, somewhere, trench


def ring_of(place: meshes.Place, **ring) -> exact.Ring:
    return exact.Ring(focus=place.focus, axis=place.axis, zero_towards=place.zero_towards, **ring)


def area(mesh, ring, n_cameras=16) -> float:
    """What cameras all around the ring reconstruct together, which does not depend on where ring angle 0 lies."""
    return exact.evaluate(mesh, ring.cameras(ring.equidistant(n_cameras))).area


@pytest.mark.parametrize("seed, name", list(enumerate(SHAPES)), ids=list(SHAPES))
def test_as_good_as_the_pose_it_was_made_in(seed, name):
    mesh = SHAPES[name]()
    moved = lying(mesh, somewhere(seed))
    assert area(moved, ring_of(meshes.place(moved))) == pytest.approx(area(mesh, exact.Ring()), rel=0.01)


@pytest.mark.parametrize("make", [trench, bump])
def test_the_estimate_is_near_the_exact_area(make):
    mesh = lying(make(), somewhere(5))
    place = meshes.place(mesh)
    assert place.area == pytest.approx(area(mesh, ring_of(place)), rel=0.04)
    assert place.share == pytest.approx(place.area / mesh.area, rel=1e-3)


def test_into_a_hollow_with_the_focus_on_its_floor():
    motion = somewhere(3)
    place = meshes.place(lying(trench(), motion))
    focus = trimesh.transform_points([place.focus], np.linalg.inv(motion))[0]
    turned_back = motion[:3, :3].T
    assert place.at == "the floor of a hollow" and focus == pytest.approx([0, 0, 0], abs=1.5)
    assert turned_back @ place.axis == pytest.approx([0, 0, 1], abs=0.05)
    # Ring angle 0 across the trench: the wide side of the image there lies along it. With a high image it is the other
    # way round.
    assert abs(turned_back @ place.zero_towards) == pytest.approx([0, 1, 0], abs=0.1)
    high = meshes.place(lying(trench(), motion), fov=(24.0, 36.0))
    assert abs(turned_back @ high.zero_towards) == pytest.approx([1, 0, 0], abs=0.1)
    ring = ring_of(place)
    assert ring.frame[:, 2] == pytest.approx(place.axis, abs=1e-4)
    assert ring.frame[:, 0] == pytest.approx(place.zero_towards, abs=1e-4)


def test_a_sheet_is_looked_at_from_its_front():
    motion = somewhere(8)
    mesh = lying(sheet(), motion)
    place = meshes.place(mesh)
    assert place.at == "the surface in view" and motion[:3, 2] @ place.axis > 0.98
    mesh.invert()
    assert motion[:3, 2] @ meshes.place(mesh).axis < -0.98


def test_a_body_without_a_hollow_is_looked_at_from_where_most_is_seen():
    mesh = knob()
    found = area(mesh, ring_of(meshes.place(mesh)))
    sides = [exact.Ring(axis=axis) for axis in np.vstack([np.eye(3), -np.eye(3)])]
    assert found > 0.95 * max(area(mesh, ring) for ring in sides)


def test_of_a_large_mesh_it_finds_what_is_worth_seeing():
    """A plate much larger than the field of view, with one hole far from its middle."""
    plate = trimesh.creation.box(bounds=[[-150, -150, -30], [150, 150, 0]])
    hole = trimesh.creation.cylinder(radius=7, height=40, sections=32)
    hole.apply_translation((95, -60, 0))
    mesh = trimesh.boolean.difference([plate, hole])
    place = meshes.place(mesh)
    assert place.focus[:2] == pytest.approx((95, -60), abs=4) and abs(place.axis[2]) > 0.99
    assert place.focus[2] == pytest.approx(-20, abs=1.5)


def test_it_is_the_same_each_time_and_leaves_the_mesh_as_it_is():
    mesh = sheet()
    before = mesh.vertices.copy()
    assert meshes.place(mesh) == meshes.place(mesh)
    assert (mesh.vertices == before).all() and set(mesh.face_attributes) == set()


def test_what_has_no_place_is_refused():
    cube = trimesh.creation.box()
    cube.invert()
    with pytest.raises(meshes.MeshError, match=r"seen from any side; it may be inside-out: .*repair=True"):
        meshes.place(cube)
    with pytest.raises(meshes.MeshError, match="fov width is -1; needed is a positive number of millimetres"):
        meshes.place(sheet(), fov=(-1, 24))
    with pytest.raises(meshes.MeshError, match="no faces"):
        meshes.place(trimesh.Trimesh())


@pytest.mark.parametrize("towards", [(0, 0, 1), (0, 0, -2.0)])
def test_ring_angle_0_along_the_axis_is_refused(towards):
    with pytest.raises(exact.ExactError, match=r"zero_towards is .* lies along the ring axis"):
        exact.Ring(zero_towards=towards)


def test_where_ring_angle_0_lies():
    ring = exact.Ring(axis=(0, 2, 0), zero_towards=(0, 1e-160, -1e-160))
    assert ring.positions([0.0, np.pi / 2]) == pytest.approx(np.array([[0, 400, -15], [-15, 400, 0]]))
    assert exact.Ring(zero_towards=(1, 0, 5)).frame == pytest.approx(np.eye(3))


def test_top_surface_of_a_mesh_that_lies_anywhere():
    mesh, motion = trench(), somewhere(2)
    moved = lying(mesh, motion)
    slanted = motion[:3, :3] @ [0.1, -0.05, 1]
    assert (meshes.top_surface(moved, slanted) == meshes.top_surface(mesh)).all()
    assert not meshes.top_surface(moved, motion[:3, :3] @ [0.6, 0.6, 0.6]).any()
