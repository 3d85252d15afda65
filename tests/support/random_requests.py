"""Requests made up at random: an awkward mesh, a ring close to it, and cameras on that."""

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st

import exact
from tests.support.scenes import AWKWARD

RELATIVE = 1e-9
MESHES = {name: make() for name, make in AWKWARD.items() if name != "slivers"}
few = settings(max_examples=12, deadline=None, derandomize=True)
mesh_names = st.sampled_from(sorted(MESHES))
seeds = st.integers(0, 2**32 - 1)


def ring_of(rng, mesh):
    """A ring close enough for perspective to matter, whose field of view cuts most of the meshes."""
    size = float(np.abs(mesh.vertices).max())
    fov = tuple(size * rng.uniform(0.3, 3.0, 2))
    return exact.Ring(diameter=size * rng.uniform(0.5, 4), working_distance=size * rng.uniform(2.5, 8), fov=fov)


def request(seed, name, n_cameras=4):
    rng = np.random.default_rng(seed)
    mesh = MESHES[name]
    ring = ring_of(rng, mesh)
    return rng, mesh, ring.cameras(rng.uniform(0, 2 * np.pi, n_cameras))


def close(a, b, mesh):
    """Equal to 1e-9, relative to what could be seen."""
    return np.allclose(a, b, rtol=0, atol=RELATIVE * mesh.area)
