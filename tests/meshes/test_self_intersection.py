"""Does a mesh cut through itself? Every pair of faces that come near each other, edge against face, in float64.

It knows nothing of how the mesh was made: the solids of manifold3d are manifold by construction, but not by
construction free of faces that pass through each other.
"""

import numpy as np
import pytest
import shapely
import trimesh

import meshes

EVERY = [(name, depth) for name, site in meshes.SITES.items() for depth in site.depths]
ROUNDING = 1e-10  # six-fold volumes smaller than this, relative to the cube of the size, count as touching


def crossing_faces(mesh) -> np.ndarray:
    """(N, 2) pairs of faces of which an edge of one passes through the inside of the other."""
    corners = np.asarray(mesh.vertices)[mesh.faces]
    low, high = corners.min(axis=1), corners.max(axis=1)
    boxes = shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1])
    first, second = shapely.STRtree(boxes).query(boxes)
    near = (first < second) & (low[first, 2] <= high[second, 2]) & (low[second, 2] <= high[first, 2])
    first, second = first[near], second[near]
    hit = _edges_cross(mesh.faces, corners, first, second) | _edges_cross(mesh.faces, corners, second, first)
    return np.column_stack([first[hit], second[hit]])


def _edges_cross(faces, corners, edged, pierced) -> np.ndarray:
    """Whether an edge of face `edged` that has no end in common with face `pierced` passes through it."""
    crossed = np.zeros(len(edged), dtype=bool)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        ends = faces[edged][:, [i, j]]
        apart = ~(ends[:, :, None] == faces[pierced][:, None, :]).any(axis=(1, 2))
        pairs = np.flatnonzero(apart)
        p, q = corners[edged[pairs], i], corners[edged[pairs], j]
        a, b, c = (corners[pierced[pairs], k] for k in range(3))
        size = np.abs(corners).max() ** 3 * ROUNDING

        def sign(u, v, w, x, size=size):
            volume = np.einsum("ij,ij->i", np.cross(v - u, w - u), x - u)
            return np.where(np.abs(volume) <= size, 0, np.sign(volume))

        opposite = sign(a, b, c, p) * sign(a, b, c, q) < 0
        inside = np.abs(sign(p, q, a, b) + sign(p, q, b, c) + sign(p, q, c, a)) == 3
        crossed[pairs] |= opposite & inside
    return crossed


def folded_edges(mesh) -> np.ndarray:
    """Pairs of neighbouring faces that lie on top of each other, turned by half a turn about their edge."""
    # cos of the angle between normals; closer to -1 than this is a fold of less than 0.03 degrees.
    flat = np.einsum("ij,ij->i", *(mesh.face_normals[mesh.face_adjacency[:, k]] for k in (0, 1))) < -1 + 1e-7
    return mesh.face_adjacency[flat]


@pytest.mark.parametrize(("name", "depth"), EVERY)
def test_site_does_not_cut_through_itself(name, depth):
    mesh = meshes.site(name, depth)
    assert len(crossing_faces(mesh)) == 0
    assert len(folded_edges(mesh)) == 0


def test_a_finer_site_does_not_cut_through_itself():
    mesh = meshes.site("circ_artery", 50, "middle")  # arteries are joined to the wall by a boolean
    assert len(crossing_faces(mesh)) == 0
    assert len(folded_edges(mesh)) == 0


def test_the_self_intersection_test_sees_self_intersections():
    box = trimesh.creation.box((2, 2, 2))
    turned = trimesh.transformations.rotation_matrix(0.3, (1, 2, 3))
    through = trimesh.util.concatenate([box, trimesh.creation.box((1, 1, 9), transform=turned)])
    assert len(crossing_faces(through)) > 0
    assert len(crossing_faces(box)) == 0
    vertices = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, 1], [1, 1, -1], [9, 9, 3.0]])
    # Face 1 goes through face 0, with which it shares no vertex, and through face 2, with which it shares one.
    spike = trimesh.Trimesh(vertices, [[0, 1, 2], [3, 4, 5], [2, 1, 5]], process=False)
    assert crossing_faces(spike).tolist() == [[0, 1], [1, 2]]
    fold = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.3, 0.6, 0]], [[0, 1, 2], [1, 0, 3]], process=False)
    assert len(folded_edges(fold)) == 1
    assert len(folded_edges(box)) == 0
