"""Exact areas with view limits, light, obstacles and bounds on the error, against ray sampling."""

import itertools

import numpy as np
import pytest
import trimesh

import exact
import meshes
from exact import Demand, Limits, Optics
from tests.support.ray_oracle import Samples
from tests.support.usable_oracle import deviations, disparity_gradients, usable

N_POINTS, FEW_POINTS = 1_000_000, 150_000
STANDARD_ERRORS = 4.0
RAY_BIAS = 1e-5  # see test_sites.py

RING = exact.Ring()
ANGLES = RING.equidistant(8)
LAYOUTS = {2: [2, 6], 4: [1, 3, 5, 7], 8: list(range(8))}
RESOLUTION, NOISE, PUPIL = (3000, 2000), 0.4, 2.0
OPTICS = Optics(RESOLUTION, match_noise=NOISE, pupil=PUPIL)
LIGHT = (40.0, 15.0, 500.0)
# Each with the same in the words of the oracle.
LIMITED = {
    "incidence": (dict(max_incidence=1.53), dict(incidence=1.53)),
    "pixel density": (dict(min_pixel_density=100.0), dict(density=100.0)),
    "depth of field": (dict(depth_of_field=(385.0, 425.0)), dict(depths=(385.0, 425.0))),
    "blur": (dict(max_blur=9.0), dict(blur=9.0, pupil=PUPIL)),
    "all": (
        dict(max_incidence=1.545, min_pixel_density=60.0, depth_of_field=(385.0, 440.0), max_blur=12.0),
        dict(incidence=1.545, density=60.0, depths=(385.0, 440.0), blur=12.0, pupil=PUPIL),
    ),
}


def agrees(scene, samples, layout, demand, counts):
    area = exact.evaluate(scene, RING.cameras(ANGLES[layout]), demand=demand).area
    estimate = samples.area_of(counts)
    slack = STANDARD_ERRORS * estimate.standard_error + RAY_BIAS * area
    assert abs(area - estimate.area) <= slack, (demand, layout, area, estimate)
    return area


SITES = ("circ_artery", 50), ("circ_overhang", 100), ("elliptical", 50), ("circ_angled", 100)


@pytest.mark.parametrize(
    ("name", "depth", "n_points"), [(*SITES[0], FEW_POINTS), *((*site, N_POINTS) for site in SITES)]
)
def test_sites_with_an_instrument_in_the_way(name, depth, n_points):
    mesh = meshes.site(name, depth=depth)
    top = meshes.top_surface(mesh)
    instrument = trimesh.creation.cylinder(2.0, segment=[(-2.0, 3.0, -5.0), (-15.0, 12.0, 40.0)], sections=12)
    samples = Samples(mesh, ANGLES, n_points, top, obstacle=instrument)
    scene = exact.Scene(mesh, exclude=top, obstacles=(instrument,))
    lit_scene = exact.Scene(mesh, exclude=top, obstacles=(instrument,), lights=(LIGHT,))
    lit = samples.lit_from(LIGHT)
    good = {
        name: np.array([usable(samples, camera, RESOLUTION, **same) for camera in range(len(ANGLES))])
        for name, (_, same) in LIMITED.items()
    }
    slopes = {pair: disparity_gradients(samples, *pair) for pair in itertools.combinations(range(len(ANGLES)), 2)}
    for layout in LAYOUTS.values():
        seen = samples.seen[layout]
        plain = agrees(scene, samples, layout, Demand(optics=OPTICS), seen.sum(axis=0) >= 2)
        dark = agrees(lit_scene, samples, layout, Demand(optics=OPTICS), (seen.sum(axis=0) >= 2) & lit)
        assert dark < 0.999 * plain
        for limit, (asked, _) in LIMITED.items():
            demand = Demand(limits=Limits(**asked), optics=OPTICS)
            counts = (seen & good[limit][layout]).sum(axis=0) >= 2
            assert 0 < agrees(scene, samples, layout, demand, counts) < 0.999 * plain
        for steepest, baseline in ((2.0, 0.0), (0.5, 12.0)):
            demand = Demand(max_disparity_gradient=steepest, min_baseline=baseline, optics=OPTICS)
            pairs = [
                (i, j) for i, j in itertools.combinations(layout, 2) if 30 * np.sin(np.pi / 8 * (j - i)) >= baseline
            ]
            matched = np.any([samples.seen[i] & samples.seen[j] & (slopes[i, j] <= steepest) for i, j in pairs], axis=0)
            assert 0 < agrees(scene, samples, layout, demand, matched) < 0.999 * plain
        both = deviations(samples, layout, RESOLUTION, NOISE)
        for kind, found, share in (("depth", both[0], 0.7), ("normal", both[1], 0.5)):
            bound = float(np.quantile(found[np.isfinite(found)], share))
            demand = Demand(max_error=bound, error=kind, optics=OPTICS)
            assert 0 < agrees(scene, samples, layout, demand, found <= bound) < 0.999 * plain
