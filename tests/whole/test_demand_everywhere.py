"""What makes a point count is declared once, and no function, picture or title knows a part of it only."""

import ast
import inspect
from dataclasses import fields

import numpy as np
import pytest
import trimesh

import exact
import exact.demand
import placement
from exact.requests import demand_keywords, scene_keywords
from experiments.figures import coverage
from placement import Constraints, PlacementError, Settings
from placement.sites import RENAMED
from tests.support import ROOT
from tests.support.further_demand import Demand

RING = exact.Ring()
QUICK = Settings(
    n_samples=600, n_angles=48, n_starts=3, n_start_phases=1, exact_candidates=2, exact_phases=1, polish_steps=(),
    ring_cameras=16, certificate_step=float(np.radians(15)),
)  # fmt: skip
LAYOUT = np.radians([20.0, 60.0, 200.0, 240.0])  # neighbours are 10.3 mm apart, others more than 28 mm
# What functions about one layout ask for beside mesh and ring.
OF_LAYOUTS = {
    "triangulation": {"angles": LAYOUT},
    "refine_ring": {"angles": LAYOUT, "diameter": (20.0, 40.0), "working_distance": (300.0, 500.0)},
}


@pytest.fixture(scope="module")
def wall():
    """Cameras to one side of it see that side alone."""
    parts = [trimesh.creation.box((30, 30, 2)), trimesh.creation.box((4, 30, 20))]
    return trimesh.boolean.union(parts, engine="manifold")


@pytest.fixture
def wider(monkeypatch):
    monkeypatch.setattr("exact.demand.Demand", Demand)


def test_a_further_field_works_in_every_evaluation(wall, wider):
    cameras, more, less = RING.cameras(LAYOUT), {"min_chord_cm": 2.0}, {"min_baseline": 20.0}
    area = exact.evaluate(wall, cameras, **less).area
    assert exact.evaluate(wall, cameras, **more).area == area < 0.9 * exact.evaluate(wall, cameras).area
    assert exact.areas(wall, [cameras], **more).tolist() == [area]
    assert exact.gradient(wall, cameras, **more).area == area
    assert exact.OneMore(wall, cameras[:3], **more).area(cameras[3]) == pytest.approx(area, rel=1e-12)
    seen = exact.OneMoreView(wall, cameras[:3], **more).seen(cameras[3])
    assert seen.sets.area() == pytest.approx(area, rel=1e-12) == seen.errors.weights.sum()
    assert exact.view_sets(wall, cameras).area(**more) == pytest.approx(area, rel=1e-12)
    one, other = (placement.triangulation(wall, RING, LAYOUT, n_samples=2000, **asked) for asked in (more, less))
    assert one.mean_best_angle == other.mean_best_angle > placement.triangulation(wall, RING, [0.0]).mean_best_angle


def test_a_further_field_works_in_every_search(wall, wider):
    more, less = {"min_chord_cm": 2.9}, {"min_baseline": 29.0}
    found = placement.optimise(wall, RING, 3, settings=QUICK, **more)
    same = placement.optimise(wall, RING, 3, settings=QUICK, **less)
    without = placement.optimise(wall, RING, 3, settings=QUICK, certify=False)
    assert found.angles == same.angles and found.area == same.area < without.area
    assert found.demand.baseline == 29.0 and not found.certificate.ignores_baseline
    assert found.certificate.layout_fraction == same.certificate.layout_fraction
    bound = placement.certify(wall, RING, 3, settings=QUICK, layout=found.angles, **more)
    assert bound.layout_fraction == found.certificate.layout_fraction
    count = placement.recommend_count(wall, RING, 0.5, settings=QUICK, certify=False, max_cameras=3, **more)
    assert [one.placement.demand.baseline for one in count.counts] == [29.0] * len(count.counts)
    problem = placement.Problem(wall, RING, settings=QUICK, **more)
    assert problem.optimise(3, certify=False).area == found.area
    kept = placement.robustness(problem, found.angles, n_mountings=1)
    assert kept.fraction == pytest.approx(found.fraction, rel=1e-12)


def test_a_further_field_works_in_searches_for_rings(wall, wider):
    more, less = {"min_chord_cm": 2.9}, {"min_baseline": 29.0}
    still = {"diameter": (30.0, 30.0), "working_distance": (400.0, 400.0)}
    one, other = (placement.refine_ring(wall, RING, LAYOUT, **still, **asked) for asked in (more, less))
    assert one.angles == other.angles and one.area == other.area
    rings = (RING, exact.Ring(20.0))
    options = {"settings": QUICK, "certify": False}
    one, other = (placement.optimise_rings(wall, rings, 3, **options, **asked) for asked in (more, less))
    assert one.angles == other.angles and one.area == other.area and one.demand.baseline == 29.0


@pytest.mark.parametrize(
    "function",
    [exact.evaluate, exact.areas, exact.gradient, exact.OneMore, exact.OneMoreView, placement.optimise,
     placement.certify, placement.recommend_count, placement.Problem, placement.triangulation, placement.refine_ring,
     placement.optimise_rings],
)  # fmt: skip
def test_help_shows_every_keyword_and_no_other_is_taken(wall, function):
    shown = inspect.signature(function).parameters
    expected = {*demand_keywords(), "demand"}
    of_scenes = set(scene_keywords())
    in_placement = function.__module__.startswith("placement") and function is not placement.triangulation
    expected |= {RENAMED.get(name, name) for name in of_scenes} if in_placement else of_scenes
    assert expected <= set(shown)
    with pytest.raises(TypeError, match=r"unexpected keyword argument 'treshold'; did you mean 'threshold'\?"):
        function(wall, *([RING.cameras(LAYOUT)] if function.__module__.startswith("exact") else [RING]), treshold=2,
                 **OF_LAYOUTS.get(function.__name__, {}))  # fmt: skip


def test_a_demand_or_a_scene_is_given_whole_or_in_keywords(wall):
    cameras, demand = RING.cameras(LAYOUT), exact.Demand(2, 20.0)
    top = wall.face_normals[:, 2] > 0.5
    scene = exact.Scene(wall, exclude=top)
    area = exact.evaluate(wall, cameras, exclude=top, threshold=2, min_baseline=20.0).area
    assert exact.evaluate(scene, cameras, demand=demand).area == area
    with pytest.raises(exact.ExactError, match="threshold: part of a Demand; give it to the Demand"):
        exact.evaluate(wall, cameras, demand=demand, threshold=2)
    with pytest.raises(exact.ExactError, match="exclude: part of a Scene; give it to the Scene"):
        exact.evaluate(scene, cameras, exclude=top)
    with pytest.raises(exact.ExactError, match=r"demand is a int; an exact\.Demand is needed"):
        exact.evaluate(wall, cameras, demand=2)


# Where part of a request stands alone, and why that is right.
ALONE = {
    "exact.scene": "declares it",
    "exact.results": "asks what another bound on the error gives",
    "exact.predicted.errors": "weights of a mean, of the faces of its scene",
    "exact.usable.information": "what one camera measures, whatever counts",
    "exact.usable.limits": "limits and optics are two parts of one demand, and each needs the other",
    "exact.visibility.light": "what is lit, whatever counts",
    "experiments.report.drawings": "the limits of an axis",
    "experiments.simulate.cloud": "weights of a mean, of the pixels of depth maps",
    "experiments.simulate.compare": "limits and errors that are tried out on what came out, beside the demand",
    "experiments.simulate.render": "whether pixels are square, whatever counts",
    "experiments.study.simulated_report": "rows of a table of limits that were tried out",
    "experiments.study.simulated_tasks": "limits and errors that are tried out, one after another",
    "exact.show": "colours: from which number of views on they are others",
    "experiments.exports.coverage_mesh": "the same",
    "placement.samples.profiles": "weights of points, not of faces",
    "placement.samples.sampling": "a mask of faces to put no sample on, whatever counts",
    "placement.surrogate.soft_coverage": "kernels of JAX: the number is static, the baseline comes beside it",
    "placement.surrogate.descent": "the same",
    "experiments.bench.surrogate_statistics": "the same",
    "experiments.bench.exact_areas": "measures plain requests",
    "experiments.bench.sites": "the same",
    "experiments.cli.usage.report": "the text of an option",
    "experiments.cli.commands.report": "the same",
}


def test_no_function_takes_a_part_of_a_request_without_the_rest():
    """A threshold, a baseline, a mask or weights that travel alone are forgotten somewhere."""
    # An error is also what is raised and what a fit leaves: alone it tells nothing.
    parts = {field.name for field in (*fields(exact.Demand), *fields(exact.Scene)) if field.init} - {"mesh", "error"}
    parts |= {"excluded", "face_weights"}
    found = {}
    for package in ("meshes", "exact", "placement", "experiments"):
        for file in sorted((ROOT / package).rglob("*.py")):
            module = ".".join(file.relative_to(ROOT).with_suffix("").parts)
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                if isinstance(node, ast.FunctionDef | ast.Lambda):
                    names = {one.arg for one in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)}
                    if names & parts:
                        found.setdefault(module, []).append((getattr(node, "name", "lambda"), names & parts))
    assert {module: taken for module, taken in found.items() if module not in ALONE} == {}
    assert set(ALONE) - set(found) == set(), "these need no exception any more"


def test_the_gap_of_a_certificate_is_under_the_baseline_asked_for(wall):
    problem, layout = placement.Problem(wall, RING, settings=QUICK), np.radians([0.0, 60.0, 200.0])
    certificate = problem.certify(3, Constraints(min_baseline=28.0), layout=layout)
    seen = problem.profiles.at(layout)
    far = RING.separations(layout) >= 28.0 * (1 - 1e-9)
    paired = np.array([far[np.ix_(one, one)].any() for one in seen.T])
    counted = float(problem.profiles.weights[(seen.sum(axis=0) >= 2) & paired].sum())
    alone = float(problem.profiles.weights[seen.sum(axis=0) >= 2].sum())
    assert counted < alone
    assert certificate.layout_fraction == pytest.approx(counted, rel=1e-12)
    assert certificate.gap == pytest.approx(certificate.bound_fraction - counted, rel=1e-12)


def test_a_certificate_compares_like_with_like(wall):
    certify = {"mesh": wall, "ring": RING, "settings": QUICK}
    with pytest.raises(PlacementError, match=r"the bound is for 2 cameras.*ask for n_cameras=3"):
        placement.certify(**certify, n_cameras=2, layout=[0.0, 1.0, 2.0])
    with pytest.raises(PlacementError, match=r"meet the constraints, and two cameras are 1\.49938"):
        placement.certify(**certify, n_cameras=2, layout=[0.0, 0.1])
    with pytest.raises(PlacementError, match="the bound is for 2 cameras"):
        placement.certify(**certify, n_cameras=2, layout=[0.0, np.nan])


@pytest.mark.parametrize("away", [(0.0, 0.0, 0.0), (300.0, -200.0, 1000.0)])
@pytest.mark.parametrize("diameter", [30.0, 41.7])
def test_far_enough_apart_is_the_same_everywhere(away, diameter):
    """A baseline that is the very chord of two cameras: by angles and by positions, with the camera or without."""
    ring = exact.Ring(diameter=diameter, focus=away)
    plate = trimesh.creation.box((10, 10, 1)).apply_translation(away)
    problem = placement.Problem(plate, ring, settings=QUICK)
    rng = np.random.default_rng(3)
    for _ in range(12):
        angles = np.sort(rng.uniform(0, 2 * np.pi, 3))
        chords = ring.separations(angles)
        for one, other in ((0, 1), (1, 2), (0, 2)):
            demand = exact.Demand(2, float(chords[one, other]))
            cameras = ring.cameras(angles)
            assert demand.far(cameras)[one, other] and demand.apart(chords)[one, other]
            limits = Constraints(min_separation=0.0, min_baseline=demand.min_baseline)
            kept = placement.robustness(problem, angles, limits, n_mountings=1)
            assert max(kept.failed_fractions) <= kept.fraction + 1e-12
            assert kept.fraction == pytest.approx(exact.evaluate(plate, cameras, demand=demand).area
                                                  / problem.ring_maximum.areas[0], rel=1e-9)  # fmt: skip


def test_titles_and_pictures_tell_baseline_and_weights(wall, tmp_path, monkeypatch):
    cameras, weights = RING.cameras(LAYOUT), np.full(len(wall.faces), 1.2)
    found = exact.evaluate(wall, cameras, min_baseline=20.0, weights=weights)
    title = found.plot().get_title()
    assert title == f"{found.area:.2f} mm² seen by at least 2 cameras, two of them at least 20 mm apart, faces weighted"
    assert "two of them at least 20 mm apart, faces weighted" in found._repr_html_()
    drawn = [text.get_text() for text in found.plot().get_legend().get_texts()]
    assert "enough cameras, no two 20 mm apart" in drawn
    asked = []
    true_evaluate = exact.evaluate

    def evaluate(scene, cameras, **keywords):
        asked.append((scene, keywords["demand"]))
        return true_evaluate(scene, cameras, **keywords)

    monkeypatch.setattr(coverage.exact, "evaluate", evaluate)
    scene = exact.Scene(wall, weights=weights)
    panels = [coverage.Panel("one", LAYOUT, "")]
    coverage.write_coverage(tmp_path / "coverage.png", "a wall", scene, RING, panels, exact.Demand(2, 20.0))
    assert asked == [(scene, exact.Demand(4, 20.0))]  # as many views as are told apart


def test_a_layout_can_see_more_than_the_ring_maximum():
    """The ring maximum is what equidistant cameras see, and no bound: these two look through a slit between them."""
    strip = trimesh.creation.box((0.1, 8, 1)).apply_translation((0, 0, -0.5))
    chip = trimesh.creation.box((1, 1, 0.2)).apply_translation((5, 0, 21))
    lids = [trimesh.creation.box((30, 60, 1)).apply_translation((x, 0, 20)) for x in (-15.15, 15.15)]
    mesh = trimesh.util.concatenate([strip, chip, *lids])
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.radians(22.5), (0, 0, 1)))
    exclude = np.arange(len(mesh.faces)) >= len(strip.faces) + len(chip.faces)
    along = np.radians([112.5, 292.5])
    seen = exact.evaluate(mesh, RING.cameras(along), exclude=exclude).area
    ring = exact.evaluate(mesh, RING.cameras(RING.equidistant(8)), exclude=exclude).area
    assert seen > ring > 0.9
    few = Settings(n_samples=400, n_angles=144, n_starts=6, n_start_phases=2, ring_cameras=8, polish_steps=())
    found = placement.optimise(mesh, RING, 2, exclude=exclude, settings=few)
    assert found.fraction > 1 and found.certificate.bound_fraction >= found.certificate.layout_fraction > 1
    assert f"{100 * found.fraction:.2f} %" in found._repr_html_()
    problem = placement.Problem(mesh, RING, exclude=exclude, settings=few)
    assert placement.robustness(problem, found.angles, n_mountings=1).fraction > 1
