import dataclasses

import numpy as np
import pytest
import trimesh

import exact
import meshes
import placement
from placement import Constraints, PlacementError, Settings
from placement.layouts.arcs import LayoutSpace
from placement.samples.sampled_coverage import SampledCoverage
from placement.samples.sampled_site import sample_site
from placement.search.ring_maximum import RingMaximum
from placement.search.scoring import ExactScorer
from placement.search.steps import polish_by_steps
from placement.sites import checked_sites

RING = exact.Ring()
QUICK = Settings(
    n_samples=1200, n_angles=48, n_starts=6, n_start_phases=2, exact_candidates=3, exact_phases=2,
    polish_steps=(), ring_cameras=16, certificate_step=float(np.radians(15)),
)  # fmt: skip


@pytest.fixture(scope="module")
def bars():
    """A floor under crossed bars, away from every symmetry of the ring."""
    parts = []
    for size, place in [
        ((40, 40, 2), (0, 0, -1)),
        ((40, 3, 3), (0, 2, 32)),
        ((3, 30, 3), (-6, 0, 36)),
        ((4, 4, 30), (8, -6, 15)),
    ]:
        box = trimesh.creation.box(size)
        box.apply_translation(place)
        parts.append(box)
    mesh = trimesh.util.concatenate(parts)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(0.3, (0, 0, 1)))
    return mesh


@pytest.fixture(scope="module")
def placed(bars):
    return placement.optimise(bars, RING, n_cameras=4, settings=QUICK, seed=1)


def test_never_below_the_best_equidistant_phase_and_never_above_the_ring_maximum(placed):
    equidistant = [found for found in placed.candidates if found.origin == "equidistant"]
    assert len(equidistant) >= 2
    assert placed.most_area.area >= placed.best_equidistant_area >= placed.equidistant_area
    assert placed.fraction >= placed.most_area.fraction - placed.give_up
    assert placed.best_equidistant_area == max(found.area for found in equidistant)
    assert placed.area <= placed.most_area.area <= placed.ring_area
    assert placed.most_area.area > placed.equidistant_area * 1.01  # here placing pays


def test_reported_area_is_the_exact_area_of_the_reported_angles(bars, placed):
    for found in placed.candidates:
        again = exact.evaluate(bars, RING.cameras(found.angles), threshold=2).area
        assert again == found.area
    best = exact.evaluate(bars, RING.cameras(RING.equidistant(4, placed.best_equidistant_phase)), threshold=2).area
    assert best == pytest.approx(placed.best_equidistant_area, rel=1e-9)
    assert (placed.angles, placed.area) in [(found.angles, found.area) for found in placed.candidates]
    assert placed.most_area is placed.candidates[0]
    assert [found.area for found in placed.candidates] == sorted((f.area for f in placed.candidates), reverse=True)


def test_candidates_are_distinct_and_meet_the_constraints(placed):
    for found in placed.candidates:
        assert placed.constraints.violations(RING, found.angles) == []
        assert list(found.angles) == sorted(found.angles) and 0 <= found.angles[0] and found.angles[-1] < 2 * np.pi
        assert found.fraction == found.area / placed.ring_area
        assert abs(found.sampled_fraction - found.fraction) < 0.03
        assert abs(found.soft_coverage - found.fraction) < 0.06
    assert placed.smallest_separation >= 5.0
    assert len({found.angles for found in placed.candidates}) == len(placed.candidates)


def test_everything_needed_to_repeat_is_kept(bars, placed):
    again = placement.optimise(
        bars,
        placed.ring,
        placed.n_cameras,
        demand=placed.demand,
        constraints=placed.constraints,
        settings=placed.settings,
        seed=placed.seed,
    )
    assert again == placed  # bit for bit: angles, areas, candidates
    assert again.angles == placed.angles
    assert placed.versions["numpy"] == np.__version__ and len(placed.mesh_hash) == 64
    assert placed.search.n_starts == 6 and placed.search.n_exact > 5
    assert dataclasses.replace(placed, seed=2) != placed


def test_of_a_large_mesh_few_layouts_are_scored_and_none_is_polished(bars):
    usual = dataclasses.replace(QUICK, polish_steps=(0.02,), exact_candidates=4)
    asked = dict(n_cameras=4, seed=1, certify=False)
    small, large = (
        placement.optimise(bars, RING, settings=dataclasses.replace(usual, most_faces=n), **asked)
        for n in (len(bars.faces), len(bars.faces) - 1)
    )
    assert large.search.n_moves == 0 < small.search.n_moves
    assert large.search.n_exact < small.search.n_exact
    assert not any(one.origin == "polish" for one in large.candidates)
    assert large.best_equidistant_fraction <= large.most_area.fraction <= small.most_area.fraction
    assert large.ring_area == small.ring_area
    assert placement.optimise(bars, RING, settings=large.settings, **asked) == large


def test_the_ring_maximum_of_a_large_mesh_is_that_of_fewer_cameras(bars):
    of_large = dataclasses.replace(QUICK, most_faces=len(bars.faces) - 1, ring_cameras=100)
    found = placement.optimise(bars, RING, 2, settings=of_large, certify=False)
    assert found.settings.ring_cameras == 72
    assert found.ring_area == exact.evaluate(bars, RING.cameras(RING.equidistant(72))).area


def test_another_seed_gives_other_samples_and_still_a_good_layout(bars, placed):
    other = placement.optimise(bars, RING, n_cameras=4, settings=QUICK, seed=2)
    assert other.angles != placed.angles
    assert other.area > other.equidistant_area


def test_excluded_faces_hide_but_do_not_count(bars):
    exclude = bars.face_normals[:, 2] > 0.5
    result = placement.optimise(bars, RING, n_cameras=2, exclude=exclude, settings=QUICK)
    assert result.n_excluded == exclude.sum()
    assert result.area == exact.evaluate(bars, RING.cameras(result.angles), exclude=exclude).area


CASES = [
    (1, 1, Constraints()),
    (3, 3, Constraints()),
    (5, 2, Constraints(min_separation=17.0)),
    (3, 2, Constraints(fixed=(0.5,), forbidden=((1.0, 2.5), (4.0, 4.5)))),
    (2, 2, Constraints(fixed=(0.5, 3.0))),
    (3, 2, Constraints(min_baseline=20.0)),
    (3, 2, Constraints(min_separation=0.0, min_angle=np.radians(2.0))),
]


@pytest.mark.parametrize(("n_cameras", "threshold", "constraints"), CASES)
def test_constraints_hold(bars, n_cameras, threshold, constraints):
    settings = dataclasses.replace(QUICK, polish_steps=(0.02,), polish_candidates=1, polish_sweeps=1, n_starts=4)
    result = placement.optimise(bars, RING, n_cameras, threshold=threshold, constraints=constraints, settings=settings)
    assert len(result.angles) == n_cameras
    assert constraints.violations(RING, result.angles) == []
    baseline = constraints.baseline(RING)
    checked = exact.evaluate(bars, RING.cameras(result.angles), threshold=threshold, min_baseline=baseline)
    assert result.area == checked.area
    allowed = [f for f in result.candidates if f.origin == "equidistant"]
    assert all(result.area >= found.area for found in allowed)


def test_moving_one_camera_never_loses_sampled_area(bars):
    site = sample_site(exact.Scene(bars), RING, exact.Demand(), settings=QUICK)
    coverage, rng = SampledCoverage(site.profiles, exact.Demand(), RING, n_grid=120), np.random.default_rng(0)
    space = LayoutSpace(RING, 4, Constraints(fixed=(1.0,)))
    for _ in range(5):
        start = space.random(rng)
        once = coverage.improve(space, start)
        twice = coverage.improve_pairs(space, once)
        assert coverage.fraction(start) <= coverage.fraction(once) <= coverage.fraction(twice)
        assert space.allows(once) and space.allows(twice)


def scorer_of(bars, objective="mean", min_baseline=0.0):
    sites = checked_sites(bars, objective=objective)
    demand = exact.Demand(min_baseline=min_baseline)
    return ExactScorer(sites, RING, demand, RingMaximum(sites, RING, demand, n_cameras=16))


def test_polish_by_steps_only_climbs(bars):
    scorer = scorer_of(bars)
    space = LayoutSpace(RING, 3, Constraints(fixed=(0.2,)))
    start = RING.equidistant(3, 0.2)
    end, n_moves = polish_by_steps(scorer, space, start, steps=(0.1, 0.03), max_sweeps=2)
    assert scorer.fraction(end) > scorer.fraction(start) and n_moves > 4
    assert space.allows(end)


def test_moving_one_camera_is_scored_as_the_whole_layout_is(bars):
    scorer = scorer_of([bars, bars], objective="worst", min_baseline=9.0)
    layout = np.array([0.3, 1.9, 4.0, 5.0])
    fraction = scorer.moving(layout, 2)
    for angle in (3.0, 3.3):
        moved = np.array([0.3, 1.9, angle, 5.0])
        assert fraction(angle) == pytest.approx(scorer.fraction(moved), abs=1e-12)


def test_progress_counts_up_to_its_total(bars):
    told = []
    settings = dataclasses.replace(QUICK, polish_steps=(), n_starts=2)
    placement.optimise(
        bars, RING, n_cameras=2, settings=settings, progress=lambda what, done, total: told.append((what, done, total))
    )
    stages = [
        "tracing ring profiles", "searching", "searching accurate layouts", "bounding any layout", "scoring exactly",
        "ring maximum", "polishing",
    ]  # fmt: skip
    assert list(dict.fromkeys(what for what, _, _ in told)) == stages
    assert all(0 <= done <= total for _, done, total in told)
    assert told[-1][1] == told[-1][2]


def test_spanning_artery_four_cameras():
    """The main job at reduced size: placing beats spacing evenly."""
    mesh = meshes.site("circ_artery", depth=50)
    settings = dataclasses.replace(QUICK, n_samples=3000, polish_steps=(), ring_cameras=16)
    result = placement.optimise(mesh, RING, n_cameras=4, exclude=meshes.top_surface(mesh), settings=settings)
    assert result.most_area.area >= result.best_equidistant_area
    assert result.most_area.fraction - result.equidistant_fraction >= 0.02


def test_triangulation_of_a_layout(bars):
    found = placement.triangulation(bars, RING, RING.equidistant(4), n_samples=3000)
    assert found.smallest_separation == pytest.approx(30 / np.sqrt(2))
    widest = 2 * np.arctan(15 / (400 - 37.5))  # two opposite cameras and a point on the highest bar
    assert np.radians(4.0) < found.mean_best_angle < found.widest_angle <= widest
    reconstructed = exact.evaluate(bars, RING.cameras(RING.equidistant(4))).area
    assert found.weights.sum() == pytest.approx(reconstructed, rel=0.02)


def test_triangulation_by_pairs_far_enough_apart(bars):
    layout, baseline = [0.0, 0.4, np.pi], 20.0
    found = placement.triangulation(bars, RING, layout, n_samples=3000, min_baseline=baseline)
    every = placement.triangulation(bars, RING, layout, n_samples=3000)
    least = 2 * np.arcsin(baseline / 2 / 403)  # no farther than from a ring camera to anything here
    assert found.best_angles.min() > least > every.best_angles.min() > 0
    reconstructed = exact.evaluate(bars, RING.cameras(layout), min_baseline=baseline).area
    assert found.weights.sum() == pytest.approx(reconstructed, rel=0.06)


def test_triangulation_where_there_is_none(bars):
    alone = placement.triangulation(bars, RING, [0.3], threshold=1, n_samples=500)
    assert alone.smallest_separation == np.inf and alone.widest_angle == 0.0 and len(alone.weights) > 0
    below = placement.triangulation(bars, exact.Ring(axis=(0, 0, -1), fov=(0.01, 0.01), focus=(90, 0, 0)), [0.0, 1.0])
    assert below.mean_best_angle == 0.0 and len(below.weights) == 0


def error_cases(bars):
    n_faces = len(bars.faces)
    low = bars.copy()
    low.apply_translation((500, 0, 0))
    return {
        "T > M": (dict(n_cameras=2, threshold=3), "threshold is 3 with 2 cameras"),
        "T = 0": (dict(threshold=0), "threshold is 0; it must be a whole number, at least 1"),
        "T = 1.5": (dict(threshold=1.5), "threshold is 1.5"),
        "no camera": (dict(n_cameras=0), "number of cameras is 0"),
        "too many": (
            dict(n_cameras=12, constraints=Constraints(min_separation=10.0)),
            r"12 cameras at 10 mm need a ring of at least 38\.6 mm; this one takes 9",
        ),
        "mask": (
            dict(exclude=np.zeros(3, dtype=bool)),
            rf"exclude is an array of bool with shape \(3,\).* each of the {n_faces} faces",
        ),
        "all excluded": (dict(exclude=np.ones(n_faces, dtype=bool)), f"all {n_faces} faces are excluded"),
        "outside": (
            dict(mesh=low),
            "no camera on this ring sees anything: what is turned towards it lies outside the field of view",
        ),
        "from behind": (
            dict(ring=exact.Ring(axis=(0, 0, -1)), exclude=bars.face_normals[:, 2] < 0.5),
            "is turned towards it",
        ),
        "one camera": (dict(n_cameras=1, threshold=1, constraints=Constraints(min_baseline=5.0)), "has no baseline"),
    }


@pytest.mark.usefixtures("unchecked")
@pytest.mark.parametrize("case", error_cases(trimesh.creation.box()))
def test_errors(bars, case):
    request, message = error_cases(bars)[case]
    with pytest.raises(PlacementError, match=message):
        placement.optimise(**{"mesh": bars, "ring": RING, "settings": QUICK, **request})


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (dict(n_samples=0), "n_samples is 0; it must be a whole number >= 1"),
        (dict(temperatures=()), "temperatures are"),
        (dict(temperatures=(0.1, 0.0)), "all positive"),
        (dict(polish_steps=(-0.1,)), "polish_steps must be positive"),
        (dict(polish_candidates=0), "polish_candidates is 0; it must be a whole number >= 1"),
    ],
)
def test_settings_that_make_no_sense(wrong, message):
    with pytest.raises(PlacementError, match=message):
        Settings(**wrong)
