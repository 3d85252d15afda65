"""One layout for several sites, weights of sites and faces, poses."""

import dataclasses

import numpy as np
import pytest
import trimesh

import exact
import placement
from placement import Constraints, PlacementError, Settings

RING = exact.Ring()
QUICK = Settings(
    n_samples=1200, least_samples=600, n_angles=48, n_starts=6, n_start_phases=2, exact_candidates=3, exact_phases=2,
    polish_candidates=1, polish_sweeps=1, ring_cameras=16, certificate_step=float(np.radians(15)),
)  # fmt: skip


def bar(turned):
    """A floor under one bar, seen best by cameras to both sides of it."""
    beam = trimesh.creation.box((40, 4, 3)).apply_translation((0, 0, 33))
    beam.apply_transform(trimesh.transformations.rotation_matrix(turned, (0, 0, 1)))
    return trimesh.util.concatenate([trimesh.creation.box((40, 40, 2)).apply_translation((0, 0, -1)), beam])


BARS = [bar(0.3), bar(1.4)]


def exact_fractions(meshes, angles, n_cameras=16):
    ring = RING.cameras(RING.equidistant(n_cameras))
    return [exact.evaluate(m, RING.cameras(angles)).area / exact.evaluate(m, ring).area for m in meshes]


@pytest.mark.parametrize("objective", ["mean", "worst"])
def test_figures_are_those_of_the_sites(objective):
    result = placement.optimise(BARS, RING, 3, settings=QUICK, site_weights=[1, 3], objective=objective, seed=1)
    fractions = exact_fractions(BARS, result.angles)
    combined = min(fractions) if objective == "worst" else 0.25 * fractions[0] + 0.75 * fractions[1]
    assert result.fraction == pytest.approx(combined, rel=1e-12)
    assert [site.fraction for site in result.sites] == pytest.approx(fractions, rel=1e-12)
    assert [site.share for site in result.sites] == [0.25, 0.75]
    most = result.most_area.fraction
    assert most >= result.best_equidistant_fraction >= result.equidistant_fraction
    assert result.candidates[0].fraction == most == max(found.fraction for found in result.candidates)
    assert most - result.give_up <= result.fraction <= most
    assert result.certificate.proven and result.certificate.gap > -result.certificate.sampling_error
    words = "at the worst of 2 sites" if objective == "worst" else "averaged over 2 sites"
    assert words in result.certificate.statement
    assert len(result.mesh_hash.split("+")) == 2


def test_the_worst_site_is_raised_at_the_cost_of_the_mean():
    mean, worst = (
        placement.optimise(BARS, RING, 2, settings=QUICK, objective=o, certify=False, give_up=0.0)
        for o in ("mean", "worst")
    )
    # The samples decide which layouts are scored: what is better on one objective may be so by their error only.
    assert worst.fraction >= min(site.fraction for site in mean.sites) - 2e-3
    assert mean.fraction >= np.mean([site.fraction for site in worst.sites]) - 2e-3


def test_a_site_without_weight_changes_nothing_and_one_alone_counts_fully():
    both = placement.optimise(BARS, RING, 3, settings=QUICK, site_weights=[1, 0], certify=False)
    assert both.fraction == pytest.approx(exact_fractions(BARS[:1], both.angles)[0], rel=1e-12)
    alone = placement.optimise(BARS[0], RING, 3, settings=QUICK, certify=False)
    assert both.fraction == pytest.approx(alone.fraction, abs=0.03)  # of as few samples as these


def test_a_problem_gives_what_optimise_gives():
    problem = placement.Problem(BARS[0], RING, settings=QUICK, seed=3)
    constraints = Constraints(min_separation=8.0)
    assert placement.place(problem, 3, constraints) == placement.optimise(
        BARS[0], RING, 3, constraints=constraints, settings=QUICK, seed=3
    )
    assert placement.place(problem, 2).n_cameras == 2  # and serves another count


def test_the_number_of_processes_changes_nothing():
    usual, alone, two = (placement.optimise(BARS[1], RING, 2, settings=QUICK, workers=n) for n in (None, 1, 2))
    assert usual == alone == two


def test_weights_of_faces_reach_every_figure():
    mesh = trimesh.util.concatenate(BARS[0], trimesh.creation.box((4, 4, 20)).apply_translation((8, 9, 10)))
    weights = placement.falloff(mesh, RING, distance=25.0)
    result = placement.optimise(mesh, RING, 3, settings=QUICK, face_weights=weights, certify=False)
    assert result.area == exact.evaluate(mesh, RING.cameras(result.angles), weights=weights).area
    assert result.sites[0].is_weighted
    assert result.candidates[0].sampled_fraction == pytest.approx(result.fraction, abs=0.03)
    only_top = np.where(mesh.face_normals[:, 2] > 0.5, 1.0, 0.0)
    same = placement.optimise(mesh, RING, 3, settings=QUICK, face_weights=only_top, certify=False)
    other = placement.optimise(mesh, RING, 3, settings=QUICK, exclude=only_top == 0, certify=False)
    assert same.area == pytest.approx(other.area, rel=1e-9) and same.ring_area == pytest.approx(other.ring_area)


def test_falloff_is_one_at_the_focus_half_at_the_distance_and_a_sixteenth_at_twice_that():
    corners = np.array([(-1, -1, 0), (1, -1, 0), (0, 2, 0)], dtype=float)
    faces = [corners * 0.01 + np.array([x, 0, 0]) for x in (0.0, 10.0, 20.0)]
    mesh = trimesh.Trimesh(np.concatenate(faces) + (1, 2, 3), np.arange(9).reshape(3, 3), process=False)
    ring = exact.Ring(focus=(1, 2, 3))
    assert placement.falloff(mesh, ring, distance=10.0) == pytest.approx([1, 1 / 2, 1 / 16])


def test_poses_are_rigid_within_their_limits_and_repeatable():
    mesh, focus = BARS[0], np.array([1.0, -2.0, 5.0])
    poses = placement.jitter(mesh, tilt_deg=5.0, shift_mm=2.0, n=40, seed=7, focus=tuple(focus))
    assert len(poses) == 40 and (poses[0].vertices == mesh.vertices).all()
    tilts, shifts = [], []
    for pose in poses[1:]:
        rigid, _, cost = trimesh.registration.procrustes(mesh.vertices, pose.vertices, reflection=False, scale=False)
        assert cost < 1e-12
        tilts.append(np.degrees(np.arccos(np.clip(rigid[2, 2], -1, 1))))
        shifts.append(np.linalg.norm(rigid[:3, :3] @ focus + rigid[:3, 3] - focus))
        assert abs(rigid[0, 1] - rigid[1, 0]) < 1e-9  # a tilt turns about a horizontal axis only
    assert 4 < max(tilts) <= 5 + 1e-6 and 1.5 < max(shifts) <= 2 + 1e-9
    again = placement.jitter(mesh, tilt_deg=5.0, shift_mm=2.0, n=40, seed=7, focus=tuple(focus))
    assert all((a.vertices == b.vertices).all() for a, b in zip(poses, again, strict=True))
    assert (placement.jitter(mesh, n=2, seed=8)[1].vertices != placement.jitter(mesh, n=2, seed=9)[1].vertices).any()


@pytest.mark.parametrize("axis", [(0, 0, 2), (1, 0, 0), (0.3, -0.4, -0.9)])
def test_poses_tilt_about_the_rings_axis(axis):
    """No pose turns about the axis, and the axis itself tilts towards all sides alike."""
    focus, unit = np.array([1.0, -2.0, 5.0]), np.array(axis) / np.linalg.norm(axis)
    poses = placement.jitter(BARS[0], tilt_deg=8.0, shift_mm=0.0, n=400, focus=tuple(focus), axis=axis)
    towards = []
    for pose in poses[1:]:
        rigid = trimesh.registration.procrustes(BARS[0].vertices, pose.vertices, reflection=False, scale=False)[0]
        assert rigid[:3, :3] @ focus + rigid[:3, 3] == pytest.approx(focus, abs=1e-9)
        turn = np.array([rigid[2, 1] - rigid[1, 2], rigid[0, 2] - rigid[2, 0], rigid[1, 0] - rigid[0, 1]])
        assert abs(turn @ unit) < 1e-9
        towards.append(turn / np.linalg.norm(turn))
    # Of uniform directions in the plane across the axis, each coordinate has a mean of 0 and a variance of 1/2.
    towards = np.array(towards)
    assert np.abs(towards.mean(axis=0)).max() < 0.15
    spread = 0.5 * (np.eye(3) - np.outer(unit, unit))
    assert towards.T @ towards / len(towards) == pytest.approx(spread, abs=0.1)


def test_a_layout_for_many_poses():
    poses = placement.jitter(BARS[0], tilt_deg=3.0, shift_mm=2.0, n=4)
    result = placement.optimise(poses, RING, 3, settings=QUICK, objective="worst", certify=False)
    assert len(result.sites) == 4
    assert result.fraction == min(site.fraction for site in result.sites) >= result.best_equidistant_fraction


@pytest.mark.usefixtures("unchecked")
@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (dict(mesh=[]), "there is no mesh"),
        (dict(mesh=[BARS[0], "scan.stl"]), "a mesh is a str"),
        (dict(objective="best"), "objective is 'best'"),
        (dict(site_weights=[1.0]), r"site_weights are \[1\.0\]; they must be 2 numbers"),
        (dict(site_weights=[0.0, 0.0]), "not all 0"),
        (dict(site_weights=[1.0, float("nan")]), "site_weights are"),
        (dict(exclude=[None]), "1 arrays are given for 2 meshes"),
        (dict(face_weights=np.ones(3)), r"weights has shape \(3,\)"),
        (dict(face_weights=np.zeros(len(BARS[0].faces))), "the weights of all 24 faces are 0; give some of them more"),
        (
            dict(face_weights=np.where(BARS[0].face_normals[:, 2] < -0.5, 1.0, 0.0)),
            "turned towards the ring has weight 0",
        ),
    ],
)
def test_errors(wrong, message):
    with pytest.raises(PlacementError, match=message):
        placement.optimise(**{"mesh": BARS, "ring": RING, "n_cameras": 2, "settings": QUICK, **wrong})


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (dict(tilt_deg=-1), "tilt_deg is -1"),
        (dict(shift_mm=float("inf")), "shift_mm is inf"),
        (dict(n=0), "number of poses is 0"),
        (dict(axis=(0, 0, 0)), "ring axis is the zero vector"),
        (dict(axis=(0, np.nan, 1)), "ring axis is .* 3 finite numbers"),
    ],
)
def test_poses_that_make_no_sense(wrong, message):
    with pytest.raises(PlacementError, match=message):
        placement.jitter(BARS[0], **wrong)
    with pytest.raises(PlacementError, match="distance is 0"):
        placement.falloff(BARS[0], RING, distance=0)


def test_few_samples_of_each_of_many_sites():
    settings = dataclasses.replace(QUICK, n_samples=900, least_samples=500)
    problem = placement.Problem(BARS, RING, settings=settings)
    weight = problem.profiles.weights
    assert 400 < len(weight) <= 1000 and weight.sum() == pytest.approx(1, abs=0.1)
