"""Cameras on rings built by hand, and areas of all choices from the sets of cameras that see each part."""

import itertools

import numpy as np
import trimesh

import exact
import placement

QUICK = placement.Settings(
    n_samples=800, n_angles=36, n_starts=6, n_start_phases=2, temperatures=(0.2,),
    n_phases=4, exact_phases=1, exact_candidates=3, n_pair_searches=2, ring_cameras=24, polish_steps=(),
    certificate_step=float(np.radians(15)), polish_candidates=1, polish_sweeps=1,
)  # fmt: skip


def wall() -> trimesh.Trimesh:
    """A plate with a wall across it: cameras to one side see that side alone."""
    parts = [trimesh.creation.box((30, 22, 2)), trimesh.creation.box((3, 14, 18)).apply_translation((2, 1, 8))]
    return trimesh.boolean.union(parts, engine="manifold")


def pit() -> trimesh.Trimesh:
    """A block with a deep square pit, and a bar across it."""
    hole = trimesh.creation.box((12, 9, 60))
    hole.apply_translation((1, 0, 26))
    hole.apply_transform(trimesh.transformations.rotation_matrix(0.05, (1, 0.3, 0)))
    block = trimesh.boolean.difference([trimesh.creation.box((34, 30, 40)), hole], engine="manifold")
    bar = trimesh.creation.box((36, 2, 2))
    bar.apply_translation((0, 3, 10))
    return trimesh.boolean.union([block, bar], engine="manifold")


def alone(found):
    """What each ring does alone that can."""
    return [one.placement for one in found.alone if one.placement is not None]


def bound_of(found) -> placement.RingsBound:
    """The certificate, which was asked for."""
    assert found.certificate is not None
    return found.certificate


def camera(ring, angle):
    """The camera of an upright ring at a ring angle [rad], from the formulas of the paper."""
    radius, height, focus = ring.diameter / 2, ring.working_distance, np.array(ring.focus)
    position = focus + [radius * np.cos(angle), radius * np.sin(angle), height]
    apex = focus + [0, 0, (height**2 + radius**2) / height]
    return exact.Camera.look_at(position, focus, up=apex - position, fov=ring.fov)


def cameras(rings, ring_of, angles):
    """The cameras of a layout on upright rings."""
    return [camera(rings[k], angle) for k, angle in zip(ring_of, angles, strict=True)]


def grid(rings, n_angles):
    """Rings and ring angles of every place."""
    ring_of = np.repeat(np.arange(len(rings)), n_angles)
    return ring_of, np.tile(2 * np.pi * np.arange(n_angles) / n_angles, len(rings))


def choices(rings, ring_of, angles, n_cameras, separation=5.0, most=None, fixed=()):
    """Every choice of places that keeps the separation, and rings that take no more than they do; `fixed` among all."""
    centres = np.array([one.position for one in cameras(rings, ring_of, angles)])
    apart = np.linalg.norm(centres[:, None] - centres[None, :], axis=2) >= separation - 1e-9
    most = [n_cameras if one is None else one for one in (most or [None] * len(rings))]
    for chosen in itertools.combinations(range(len(ring_of)), n_cameras):
        index = np.array(chosen)
        pairs = apart[np.ix_(index, index)] | np.eye(n_cameras, dtype=bool)
        if (
            pairs.all()
            and (np.bincount(ring_of[index], minlength=len(rings)) <= most).all()
            and set(fixed) <= {*chosen}
        ):
            yield index


def best_of_three(sets, every):
    """Greatest area [mm²] that two of three cameras see, over all these choices of three.

    From the areas that each two, and all three, see: A_ij + A_ik + A_jk - 2 A_ijk.
    """
    seen = sets.seen.astype(float)
    two = seen.T @ (seen * sets.areas[:, None])
    three = np.stack([seen.T @ (seen * (seen[:, i] * sets.areas)[:, None]) for i in range(seen.shape[1])])
    i, j, k = np.array(every).T
    return float((two[i, j] + two[i, k] + two[j, k] - 2 * three[i, j, k]).max())
