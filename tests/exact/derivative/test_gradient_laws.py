"""What moving or scaling all of a scene does to the area is known; half of it is the cameras', half the mesh's own.

The mesh's half is worked out here, by brute force: each side of each triangle of what is reconstructed is held against
all silhouettes of all cameras.
"""

import numpy as np
import pytest
import trimesh

import exact
from meshes import site, top_surface
from tests.support.scenes import AWKWARD, together

# Nearer to a plane than this part of its distance from the camera a point is on it.
ON = 1e-10


def silhouettes(mesh, centre):
    """(S, 2, 3) ends of the edges between faces that look at the camera and others."""
    front = np.einsum("fi,fi->f", mesh.face_normals, centre - mesh.triangles[:, 0]) > 0
    one, other = mesh.face_adjacency.T
    return mesh.vertices[mesh.face_adjacency_edges[front[one] != front[other]]]


def planes_of(mesh, camera):
    """Planes through the camera that may part what it sees: two vectors each, first those of silhouettes, so many."""
    edges = silhouettes(mesh, camera.position) - camera.position
    x, y = camera.half_extent
    corners = np.array([[x, y, 1], [-x, y, 1], [-x, -y, 1], [x, -y, 1]]) @ camera.rotation
    return np.concatenate([edges, np.stack([corners, np.roll(corners, 1, axis=0)], axis=1)]), len(edges)


def gained_by_the_mesh(mesh, part, cameras, motion):
    """By how much the area of `part` grows when the mesh alone moves by a linear `motion` (3, 3), per unit of it."""
    face = part.face_attributes["parent"]
    corner, normal = part.triangles, mesh.face_normals[face]
    start, end = corner.reshape(-1, 3), corner[:, [1, 2, 0]].reshape(-1, 3)
    face, normal = np.repeat(face, 3), np.repeat(normal, 3, axis=0)
    inside = ~on_a_side(mesh, face, start, end)
    start, end, normal = start[inside], end[inside], normal[inside]
    best, speed = np.full(len(start), ON), np.zeros(len(start))
    for camera in cameras:
        a, b, middle = start - camera.position, end - camera.position, (start + end) / 2 - camera.position
        planes, n_edges = planes_of(mesh, camera)
        for number, (one, other) in enumerate(planes):
            m = np.cross(one, other)
            unit = m / np.linalg.norm(m)
            off = np.maximum(np.abs(a @ unit) / np.linalg.norm(a, axis=1), np.abs(b @ unit) / np.linalg.norm(b, axis=1))
            on = off < best
            # Between the rays through both ends, and, for a silhouette, behind it.
            basis = np.linalg.pinv(np.stack([one, other], axis=1))
            share = middle[on] @ basis.T
            on[on] = (share > -ON).all(axis=1) & ((share.sum(axis=1) > 1 - ON) | (number >= n_edges))
            best[on] = off[on]
            moved = (middle[on] + camera.position) @ motion.T @ m
            if number < n_edges:
                ends = [(v + camera.position) @ motion.T for v in (one, other)]
                moved = moved + middle[on] @ (np.cross(ends[0], other) + np.cross(one, ends[1]))
            outwards = np.cross(end[on] - start[on], normal[on])
            across = m - normal[on] * (normal[on] @ m)[:, None]
            # Beside the face itself, which moves too; outwards is as long as the side.
            size = np.einsum("ni,ni->n", across, across)
            speed[on] = -moved * np.einsum("ni,ni->n", outwards, across) / size
    stretch = np.trace(motion) - np.einsum("fi,ij,fj->f", part.face_normals, motion, part.face_normals)
    return float(part.area_faces @ stretch + speed.sum())


def on_a_side(mesh, face, start, end):
    found = np.zeros(len(face), dtype=bool)
    for k in range(3):
        at, along = mesh.triangles[face, k], mesh.triangles[face, (k + 1) % 3] - mesh.triangles[face, k]
        length = np.linalg.norm(along, axis=1)
        off = [np.linalg.norm(np.cross(along, p - at), axis=1) / length**2 for p in (start, end)]
        found |= np.maximum(*off) < ON
    return found


def ball_over_a_plate():
    ball = trimesh.creation.icosphere(2, radius=4.0).apply_translation((1, 2, 14))
    return together(trimesh.creation.box((30, 30, 2)), ball)


def scene(name):
    if name == "channel":
        return AWKWARD["channel"](), None, exact.Ring(60.0, 120.0, (30.0, 22.0))
    if name == "ball over a plate":
        return ball_over_a_plate(), None, exact.Ring(60.0, 120.0, (24.0, 22.0))
    mesh = site(name, 50)
    return mesh, top_surface(mesh), exact.Ring()


@pytest.mark.parametrize("name", ["channel", "ball over a plate", "circ_flat"])
def test_turning_all_changes_nothing_and_scaling_all_scales_by_the_square(name):
    mesh, exclude, ring = scene(name)
    rng = np.random.default_rng(2)
    cameras = ring.cameras(rng.uniform(0, 2 * np.pi, 3))
    found = exact.gradient(mesh, cameras, exclude=exclude)
    part = found.reconstruction.to_mesh()
    position = np.array([camera.position for camera in cameras])
    scaled = (found.position * position).sum()
    assert abs(scaled) > 0.01 * found.area
    growth = scaled + gained_by_the_mesh(mesh, part, cameras, np.eye(3))
    assert growth == pytest.approx(2 * found.area, rel=1e-9)
    for turn in np.eye(3):
        by_cameras = (found.position * np.cross(turn, position)).sum() + (found.rotation @ turn).sum()
        by_mesh = gained_by_the_mesh(mesh, part, cameras, np.cross(turn, np.eye(3)).T)
        assert abs(by_cameras + by_mesh) < 1e-9 * found.area
        assert abs(by_mesh) > 1e-4 * found.area
