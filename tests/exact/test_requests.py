"""What `evaluate` and `view` refuse, and what their results offer."""

import numpy as np
import pytest
import shapely
import trimesh

import exact
from tests.support.scenes import above, block_with_channel, rectangle, together

RING = exact.Ring()
CAMERAS = RING.cameras(RING.equidistant(3))
BOX = trimesh.creation.box((10, 10, 10))


def box_with(**changes):
    box = BOX.copy()
    for name, value in changes.items():
        setattr(box, name, value)
    return box


def flipped_face():
    faces = BOX.faces.copy()
    faces[4] = faces[4, ::-1]
    return trimesh.Trimesh(BOX.vertices, faces, process=False)


def with_nan():
    vertices = np.array(BOX.vertices)
    vertices[3, 1] = np.nan
    return trimesh.Trimesh(vertices, BOX.faces, process=False)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"threshold": 4}, r"threshold is 4 with 3 cameras"),
        ({"threshold": 0}, r"threshold is 0; it must be a whole number, at least 1"),
        ({"threshold": 1.5}, r"threshold is 1\.5"),
        ({"cameras": []}, r"there are no cameras"),
        ({"cameras": [RING]}, r"a camera is a Ring; exact\.Camera is needed"),
        ({"exclude": np.zeros(3, dtype=bool)}, r"exclude is an array of bool with shape \(3,\)"),
        ({"exclude": np.zeros(12)}, r"exclude is an array of float64"),
        ({"weights": -np.ones(12)}, r"weights has shape \(12,\); it must be finite, not negative"),
        ({"min_baseline": -1.0}, r"min_baseline is -1\.0"),
        ({"depth_order": "random"}, r"depth_order is 'random'"),
        ({"workers": 0}, r"workers is 0"),
        ({"mesh": "scan.stl"}, r"mesh is a str; a trimesh\.Trimesh is needed"),
        ({"mesh": trimesh.Trimesh()}, r"the mesh has no faces"),
        ({"mesh": with_nan()}, r"face \d+ has a vertex that is not finite"),
        ({"mesh": flipped_face()}, r"mixed winding.*repair=True"),
        ({"mesh": trimesh.Trimesh([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [[0, 1, 2]], process=False)}, r"has an area"),
    ],
)
def test_impossible_requests(options, message):
    arguments = {"mesh": BOX, "cameras": CAMERAS, **options}
    with pytest.raises(exact.ExactError, match=message):
        exact.evaluate(**arguments)


def test_inside_out_is_refused():
    box = BOX.copy()
    box.invert()
    with pytest.raises(exact.ExactError, match=r"closed and inside out.*repair=True"):
        exact.view(box, CAMERAS[0])


def test_reconstruction_as_a_mesh():
    mesh = block_with_channel()
    result = exact.evaluate(mesh, CAMERAS, threshold=2)
    part = result.to_mesh()
    assert part.area == pytest.approx(result.area, rel=1e-9)
    parent = part.face_attributes["parent"]
    assert np.bincount(parent, weights=part.area_faces, minlength=len(mesh.faces)) == pytest.approx(
        result.face_areas, abs=1e-9
    )
    sizeable = part.area_faces > 1e-9
    turned = (part.face_normals[sizeable] * mesh.face_normals[parent[sizeable]]).sum(axis=1)
    assert turned == pytest.approx(np.ones(sizeable.sum()), abs=1e-6)
    # Every corner lies in the plane of the face it comes from.
    offset = (part.triangles - mesh.triangles[parent][:, :1]) @ mesh.face_normals[parent][:, :, None]
    assert np.abs(offset).max() < 1e-9


def test_views_in_the_image_and_in_space():
    mesh = block_with_channel()
    view = exact.view(mesh, CAMERAS[0])
    assert view.to_mesh().area == pytest.approx(view.area, rel=1e-9)
    image = shapely.box(-18, -12, 18, 12)
    seen = view.polygons[view.face_areas > 0]
    assert shapely.is_valid(seen).all()
    assert shapely.area(shapely.difference(seen, image.buffer(1e-9))).max() == 0
    # What is seen tiles the image where the block is: the regions do not overlap.
    assert shapely.area(seen).sum() == pytest.approx(shapely.union_all(seen).area, rel=1e-9)
    assert shapely.is_empty(view.polygons[view.face_areas == 0]).all()


def test_view_polygons_in_space_lie_on_their_faces():
    mesh = block_with_channel()
    view = exact.view(mesh, CAMERAS[0])
    polygons = view.polygons_3d
    points, face = shapely.get_coordinates(polygons, include_z=True, return_index=True)
    assert set(face) == set(np.flatnonzero(view.face_areas > 0))
    offset = ((points - mesh.triangles[face, 0]) * mesh.face_normals[face]).sum(axis=1)
    assert np.abs(offset).max() < 1e-9
    # Projected, they are the polygons of the image.
    image = view.camera.project(points) / view.camera.resolution * view.camera.fov - view.camera.fov / 2
    assert image == pytest.approx(shapely.get_coordinates(view.polygons), abs=1e-9)


def test_view_polygons_match_projected_corners():
    plate = rectangle((-5, 5), (-4, 4))
    camera = above(3.0, -2.0, height=200.0, fov=(60, 60))
    view = exact.view(plate, camera)
    half = camera.fov / 2
    pixels = camera.project(plate.vertices) / camera.resolution * camera.fov - half
    assert sorted(map(tuple, shapely.get_coordinates(shapely.union_all(view.polygons))[:-1].round(9))) == sorted(
        map(tuple, pixels.round(9))
    )


def test_drawing_tiles_the_picture_with_view_counts():
    mesh = block_with_channel()
    result = exact.evaluate(mesh, CAMERAS, threshold=3, exclude=mesh.face_normals[:, 2] > 0.9)
    camera = exact.Camera.look_at((5, 4, 60), (0, 0, 10), (0, 1, 0), fov=(25, 25))
    polygons, n_views, face = exact.seen_from(result, camera)
    assert shapely.area(polygons).sum() == pytest.approx(
        shapely.area(exact.view(mesh, camera).polygons).sum(), rel=1e-9
    )
    assert set(n_views) <= {exact.NOT_COUNTED, 0, 1, 2, 3}
    assert ((n_views == exact.NOT_COUNTED) == (mesh.face_normals[face, 2] > 0.9)).all()


def test_excluded_faces_hide_all_the_same():
    scene = together(rectangle((-50, 50), (-50, 50)), rectangle((-5, 5), (-5, 5), 100.0))
    exclude = np.array([False, False, True, True])
    counted = exact.evaluate(scene, [above()], threshold=1, exclude=exclude)
    assert counted.area == pytest.approx(exact.evaluate(scene, [above()], threshold=1).area - 100, rel=1e-10)
    assert counted.face_areas[2:].tolist() == [0.0, 0.0]


def test_progress_reports_every_camera():
    steps = []
    exact.evaluate(block_with_channel(), RING.cameras(RING.equidistant(20)), threshold=20, report=steps.append)
    assert sum(steps) == 20


def test_the_same_bits_from_any_number_of_workers():
    mesh = block_with_channel()
    cameras = RING.cameras(RING.equidistant(11))
    areas = {exact.evaluate(mesh, cameras, threshold=3, workers=workers).area for workers in (1, 2, 3)}
    assert len(areas) == 1
