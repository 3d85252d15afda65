"""The numbers and the surface that the page is told: the same as those of the evaluator, whatever moves."""

import json
import struct
from dataclasses import replace

import numpy as np
import pytest

import exact
import placement
from experiments.design import searches
from experiments.design.design import Design
from experiments.design.exact_answers import COUNTED, RECONSTRUCTED, ExactAnswers
from experiments.design.sampled import SampledAreas
from experiments.layouts.layout_file import understood
from experiments.request import rig as rig_file
from experiments.request.request import request
from tests.support.ray_oracle import Samples

RING = exact.Ring()
NORMAL = exact.Demand(3, error="normal", limits=exact.Limits(max_incidence=1.3, min_pixel_density=300.0))
DEMANDS = {
    "plain": exact.Demand(),
    "one view": exact.Demand(1),
    "normal, limits": NORMAL,
    "baseline, error": exact.Demand(2, min_baseline=12.0, max_error=0.08),
    "disparity": exact.Demand(2, max_disparity_gradient=0.6),
}


@pytest.fixture(scope="module")
def asked(quick_search, tmp_path_factory):
    rig = tmp_path_factory.mktemp("rig") / "rig.toml"
    rig.write_text(quick_search, encoding="utf-8")
    return request(["circ_artery"], 50, "coarse", rig_file.rig(rig))


@pytest.fixture(scope="module")
def scene(asked):
    return asked.poses[0].scene


def design(demand=DEMANDS["plain"], angles=(0.3, 1.9, 3.4, 5.0), **constraints):
    return Design.of(RING, demand, placement.Constraints(**constraints), list(angles))


def unpacked(content):
    """Head, corners of the triangles in space, who sees each, and errors: as the page reads them."""
    (length,) = struct.unpack_from("<I", content)
    head, at = json.loads(content[4 : 4 + length]), 4 + length
    vertices = np.frombuffer(content, "<f4", 3 * head["vertices"], at).reshape(-1, 3)
    at += vertices.nbytes
    triangles = np.frombuffer(content, "<u4", 3 * head["triangles"], at).reshape(-1, 3)
    at += triangles.nbytes
    seen = np.frombuffer(content, "<u4", head["triangles"], at)
    errors = np.frombuffer(content, "<f4", head["triangles"], at + seen.nbytes)
    assert at + seen.nbytes + errors.nbytes == len(content)
    return head, vertices[triangles].astype(float), seen, errors


@pytest.mark.parametrize("name", DEMANDS)
def test_numbers_and_surface_are_those_of_the_evaluator(scene, name):
    answers, asked = ExactAnswers(scene), design(DEMANDS[name])
    for moved, angle in ((1, 2.2), (1, 2.6), (3, 5.5), (None, 0.0), (0, 0.1)):
        asked = asked if moved is None else asked.moved(moved, angle)
        told = dict(answers.of(asked, moved))
        seen = exact.evaluate(scene, RING.cameras(asked.angles), demand=asked.whole)
        # Where an error is bounded, areas are right to 1e-6 however pieces are cut, and those are cut in another order.
        same = 1e-12 if asked.whole.max_error is None else 1e-7
        assert told["area"] == told["exact"]["area"] == pytest.approx(seen.area, rel=same)
        if asked.whole.threshold == 1:
            assert told["exact"]["error"] is None
        else:
            assert told["exact"]["error"] == pytest.approx(seen.error_rms, rel=1e-9)
        even = exact.evaluate(scene, RING.cameras(RING.equidistant(4)), demand=asked.whole)
        assert told["equidistant"]["area"] == pytest.approx(even.area, rel=same)
        single = [
            exact.evaluate(scene, [camera], threshold=1, limits=asked.whole.limits, optics=asked.whole.optics).area
            for camera in RING.cameras(asked.angles)
        ]
        assert told["exact"]["cameras"] == pytest.approx(single, rel=1e-12)
        head, corners, who, errors = unpacked(told["surface"])
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
        for number, area in enumerate(single):
            assert areas[(who >> number) & 1 > 0].sum() == pytest.approx(area, rel=1e-4)
        met = who & RECONSTRUCTED > 0
        assert areas[met].sum() == pytest.approx(seen.area, rel=1e-4)
        assert areas[who & COUNTED > 0].sum() == pytest.approx(scene.surface.areas[scene.counted].sum(), rel=1e-4)
        if asked.whole.threshold > 1:
            mean = np.average(errors[met] ** 2, weights=areas[met]) ** 0.5
            assert mean == pytest.approx(seen.error_rms, rel=0.02)
        assert not np.isfinite(errors[~met]).any()
        assert head["threshold"] == asked.whole.threshold and len(head["shades"]) == head["most"] + 5


def test_the_surface_is_seen_by_those_that_rays_say(scene, asked):
    """Triangles' own middles, by rays that share no code with the evaluator."""
    one = design()
    _, corners, who, _ = unpacked(dict(ExactAnswers(scene).of(one))["surface"])
    rays = Samples(scene.mesh, one.angles, 40_000, ~scene.counted)
    weight = rays.areas[rays.face] / rays.number[rays.face]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    for number in range(4):
        by_rays = weight[rays.seen[number]].sum()
        assert areas[(who >> number) & 1 > 0].sum() == pytest.approx(by_rays, rel=0.02)


@pytest.mark.parametrize("name", DEMANDS)
def test_the_estimate_is_near(scene, name):
    areas, asked = SampledAreas(scene), design(DEMANDS[name])
    for turn in (0.0, 0.5, 1.0):
        asked = replace(asked, ring=exact.Ring(diameter=30.0 + 4 * turn)).moved(2, 3.0 + turn)
        found = exact.evaluate(scene, asked.ring.cameras(asked.angles), demand=asked.whole).area
        assert areas.area(asked) == pytest.approx(found, rel=0.03, abs=0.01 * scene.surface.areas[scene.counted].sum())


def test_searches_keep_to_the_constraints_and_gain(asked, scene):
    start = design(angles=(0.3, 0.8, 1.3), fixed=(0.8,), forbidden=((3.0, 3.5),))
    told = []
    better = searches.improve(asked, start, lambda kind, found: told.append((kind, found)))
    more = searches.one_more(asked, start, lambda kind, found: None)
    best = searches.optimise(asked, start, lambda kind, found: None)

    def area(one):
        return exact.evaluate(scene, RING.cameras(one.angles), demand=one.whole).area

    for found in (better, more, best):
        assert found.limits.violations(RING, found.angles) == [] and found.limits.fixed == (0.8,)
        assert area(found) > area(start)
    tried = [found for kind, found in told if kind == "try"]
    assert tried[-1] == better and np.all(np.diff([area(start), *map(area, tried)]) > 0)
    # No other place of a fine grid is better for one camera more by much.
    places = [start.with_one_more(angle) for angle in np.arange(0, 6.28, 0.1)]
    assert area(more) > max(map(area, places)) - 0.005 * area(start)
    assert more.angles[:3] == start.angles


def test_a_layout_that_is_saved_tells_of_this_layout(asked, scene):
    one = design(angles=(0.3, 2.0, 4.0), fixed=(2.0,), min_baseline=10.0)
    content = searches.layout(asked, one, lambda kind, found: None).decode()
    made = understood(content, None)
    assert sorted(made.angles) == pytest.approx(sorted(one.angles), abs=1e-12)
    told = json.loads(content)
    seen = exact.evaluate(scene, RING.cameras(one.angles), demand=one.whole)
    assert told["areas_mm2"]["optimised"] == pytest.approx(seen.area, rel=1e-12)
    assert told["rms_errors_mm"]["optimised"] == pytest.approx(seen.error_rms, rel=1e-9)
    assert told["constraints"]["fixed"] == [2.0] and told["certificate"] is None
    assert made.demand == one.whole
