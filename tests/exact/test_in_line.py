"""Cameras exactly in line with faces, edges and corners, as they are over machined parts and symmetric channels."""

import os

import numpy as np
import pytest
import shapely
import trimesh

import exact
from tests.support.scenes import together

# Besides, those of former faults.
N_SCENES = int(os.environ.get("CAMRING_IN_LINE", "40"))
SCENES = sorted({*range(N_SCENES), 202, 232, 1181, 2366, 2700})
FLOOR = shapely.box(-9, -9, 9, 9)
# A face far off, of an open sheet: then backs hide too, as they do not on solids seen from outside.
APART = trimesh.Trimesh([[900, 900, 0], [901, 900, 0], [900, 901, 0]], [[0, 1, 2]])


def shadow(box, position):
    """What a box hides of the floor: the hull of the shadows of its corners."""
    corners = np.array(np.meshgrid(*box.T)).reshape(3, -1).T
    stretched = position[2] / (position[2] - corners[:, 2:])
    return shapely.MultiPoint(position[:2] + (corners[:, :2] - position[:2]) * stretched).convex_hull


@pytest.mark.parametrize("seed", SCENES)
def test_boxes_over_a_floor(seed):
    """Corners, cameras and borders of views are at whole or half millimetres, before all is scaled."""
    rng = np.random.default_rng(seed)
    low = np.column_stack([rng.integers(-6, 5, (5, 2)), rng.integers(0, 4, 5)])
    boxes = np.stack([low, low + rng.integers(1, 4, (5, 3))], axis=1)[: rng.integers(1, 6)].astype(float)
    parts = [trimesh.creation.box(bounds=box) for box in ([(-9, -9, -1), (9, 9, 0)], *boxes)]
    mesh = together(*parts, *[APART] * int(rng.integers(0, 2)))
    if rng.random() < 0.3:
        mesh = mesh.subdivide()
    factor = rng.choice([1.0, 7.0, 1e-3, 1 / 3, 0.1])
    n_cameras = int(rng.choice([1, 2, 3, 5, 9, 60], p=[0.15, 0.25, 0.25, 0.2, 0.1, 0.05]))
    threshold = int(rng.integers(1, min(n_cameras, 3) + 1))
    cameras, seen_by = [], [FLOOR, *[shapely.Polygon()] * threshold]
    for _ in range(n_cameras):
        x, y, z = (*rng.integers(-16, 17, 2) / 2, float(rng.integers(10, 20)))
        width, height = rng.integers(2, 26, 2).astype(float)
        above = np.array([x, y, z])
        size = (width * factor, height * factor)
        cameras.append(exact.Camera.look_at(above * factor, above * [factor, factor, 0], up=(0, 1, 0), fov=size))
        in_view = shapely.box(x - width / 2, y - height / 2, x + width / 2, y + height / 2)
        view = FLOOR.intersection(in_view).difference(shapely.union_all([shadow(box, above) for box in boxes]))
        for k in range(threshold, 0, -1):
            seen_by[k] = seen_by[k].union(seen_by[k - 1].intersection(view))
    mesh.apply_scale(factor)
    face_areas = exact.evaluate(mesh, cameras, threshold=threshold).face_areas / factor**2
    centre = mesh.triangles_center / factor
    is_floor = (np.abs(centre[:, 2]) < 1e-9) & (mesh.face_normals[:, 2] > 0.5) & (centre[:, 0] < 100)
    assert face_areas[is_floor].sum() == pytest.approx(seen_by[threshold].area, abs=1e-7)
