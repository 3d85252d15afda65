"""Closed shells that cut each other look from outside like their union, which manifold3d computes independently."""

import numpy as np
import pytest
import trimesh
from manifold3d import Manifold, Mesh64

import exact
from tests.support.scenes import tilted_tori, together


def union(parts):
    """Boolean union in double precision."""
    solids = [
        Manifold(Mesh64(vert_properties=np.array(part.vertices), tri_verts=np.array(part.faces, dtype=np.uint64)))
        for part in parts
    ]
    made = sum(solids[1:], solids[0]).to_mesh64()
    return trimesh.Trimesh(made.vert_properties[:, :3], made.tri_verts, process=False)


def turned(mesh, angle, axis, shift):
    mesh.apply_transform(trimesh.transformations.rotation_matrix(angle, axis))
    return mesh.apply_translation(shift)


def boxes():
    rng = np.random.default_rng(3)
    return [
        turned(
            trimesh.creation.box(rng.uniform(3, 12, 3)), rng.uniform(0, 3), rng.normal(size=3), rng.uniform(-4, 4, 3)
        )
        for _ in range(5)
    ]


def ball_in_a_block():
    return [trimesh.creation.box((30, 30, 10)), trimesh.creation.icosphere(3, radius=7).apply_translation((1, 2, 4))]


def axis_parallel_boxes():
    """A bar sticks out of a block on two sides; its sides end on the diagonals and in corners of the block's faces."""
    return [trimesh.creation.box((12, 12, 12)), trimesh.creation.box((4, 20, 4)).apply_translation((2, 0, 2))]


@pytest.mark.parametrize("parts", [tilted_tori, boxes, ball_in_a_block, axis_parallel_boxes], ids=lambda f: f.__name__)
@pytest.mark.parametrize(("n_cameras", "threshold"), [(1, 1), (3, 2), (8, 3)])
def test_intersecting_shells_equal_their_union(parts, n_cameras, threshold):
    ring = exact.Ring(diameter=120.0, working_distance=200.0)
    cameras = ring.cameras(ring.equidistant(n_cameras, phase=0.3))
    shells = exact.evaluate(together(*parts()), cameras, threshold=threshold)
    merged = exact.evaluate(union(parts()), cameras, threshold=threshold)
    assert merged.area > 10
    assert shells.area == pytest.approx(merged.area, rel=1e-9)
    assert shells.repairs == merged.repairs == 0
