"""Exact areas against ray sampling, on every built-in site and on awkward meshes."""

import numpy as np
import pytest

import exact
import meshes
from tests.support.ray_oracle import Samples
from tests.support.scenes import AWKWARD

N_POINTS = 1_000_000
STANDARD_ERRORS = 4.0
# What the rays themselves are off by, at most, in parts of the area: they start 0.02 µm above the surface and are
# single precision.
RAY_BIAS = 1e-5

RING = exact.Ring()
# Eight equidistant cameras, every second or fourth of which are equidistant too, and three more.
ANGLES = np.concatenate([RING.equidistant(8), RING.equidistant(3)])
LAYOUTS = {2: (3, 7), 3: (8, 9, 10), 4: (1, 3, 5, 7), 8: tuple(range(8))}


def check(mesh, exclude=None, n_points=N_POINTS):
    samples = Samples(mesh, ANGLES, n_points, exclude)
    for n_cameras, layout in LAYOUTS.items():
        cameras = RING.cameras(ANGLES[list(layout)])
        for threshold in (1, 2, 3):
            if threshold > n_cameras:
                continue
            result = exact.evaluate(mesh, cameras, threshold=threshold, exclude=exclude)
            estimate = samples.estimate(layout, threshold)
            slack = STANDARD_ERRORS * estimate.standard_error + RAY_BIAS * result.area
            assert abs(result.area - estimate.area) <= slack, (n_cameras, threshold, result.area, estimate)


@pytest.mark.parametrize(("name", "depth"), [(n, d) for n, s in meshes.SITES.items() for d in s.depths])
def test_sites(name, depth):
    mesh = meshes.site(name, depth=depth)
    check(mesh, meshes.top_surface(mesh))


@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_meshes(name):
    check(AWKWARD[name]())
