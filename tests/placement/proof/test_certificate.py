import dataclasses
import itertools

import numpy as np
import pytest
import trimesh

import exact
import placement
from placement import Constraints, PlacementError, Settings
from placement.layouts.arcs import TURN, LayoutSpace
from placement.proof.branching import branch_and_bound
from placement.proof.certificate import cells_of, certify_samples, grid_of, measure
from placement.proof.enumeration import enumerate_all, enumerate_spread
from placement.proof.grid_program import GridProgram
from placement.proof.halving import halved
from placement.proof.solver import solve
from placement.samples.profiles import RingProfiles
from placement.samples.sampled_coverage import SampledCoverage

RING = exact.Ring()
QUICK = Settings(
    n_samples=600, n_angles=40, certificate_step=float(np.radians(15)), certificate_seconds=8.0, ring_cameras=120
)


def made_up_site(seed, n_points=120, n_angles=40, n_sites=1):
    """Profiles of one or two arcs, as on real sites, without a mesh; weights are shares of the ring maximum."""
    rng = np.random.default_rng(seed)
    grid = TURN * np.arange(n_angles) / n_angles
    middle, half_width = rng.uniform(0, TURN, n_points), rng.uniform(0.2, 2.0, n_points)

    def arc(middle, half_width):
        return half_width - np.abs(np.angle(np.exp(1j * (grid[:, None] - middle))))

    distance = np.maximum(
        arc(middle, half_width), np.where(rng.random(n_points) < 0.6, arc(middle + np.pi, half_width / 2), -1)
    )
    visible, weights = distance > 0, rng.uniform(0.5, 2.0, n_points)
    of = RingProfiles.of(distance, weights / weights[visible.sum(axis=0) >= 2].sum())
    return dataclasses.replace(of, site=np.arange(n_points) % n_sites)


def brute_force(program):
    best = -1.0
    for places in itertools.combinations_with_replacement(np.flatnonzero(program.allowed), program.n_free):
        steps = [
            min((a - b) % len(program.seen), (b - a) % len(program.seen)) for a, b in itertools.combinations(places, 2)
        ]
        if all(step >= program.window for step in steps):
            best = max(best, program.value(places))
    return best


def random_program(seed, n_sites, apart, n_places=None):
    rng = np.random.default_rng(seed)
    n_places, n_points = n_places or int(rng.integers(6, 12)), 25
    starts, lengths = rng.integers(0, n_places, n_points), rng.integers(0, n_places + 1, n_points)
    seen = (np.arange(n_places)[:, None] - starts) % n_places < lengths
    seen ^= (np.arange(n_places)[:, None] - rng.integers(0, n_places, n_points)) % n_places < 2
    return GridProgram(
        seen, rng.uniform(0.1, 3, n_points), fixed=rng.integers(0, 2, (1, n_points)) > 0, n_free=seed % 5,
        fixed_at=rng.uniform(0, n_places, 1), apart=float(apart) * rng.integers(0, 4, n_points), threshold=1 + seed % 3,
        window=int(rng.integers(0, 3)), allowed=rng.random(n_places) < 0.85, site=rng.integers(0, n_sites, n_points),
        n_sites=n_sites,
    )  # fmt: skip


@pytest.mark.parametrize("n_sites", [1, 3])
@pytest.mark.parametrize("seed", range(25))
def test_both_solvers_against_trying_every_choice(seed, n_sites):
    program = random_program(seed, n_sites, 0)
    best = brute_force(program)
    merged = program.merged()
    assert len(merged.weights) <= len(program.weights)
    for found in (enumerate_all(merged), branch_and_bound(merged, 20.0, 1e-7), solve(program, 20.0, 1e-7)):
        assert found is not None and found.finished
        if best < 0:
            assert found.places is None
        else:
            assert found.places is not None
            assert found.value == pytest.approx(best, rel=1e-6, abs=1e-9)
            assert program.value(found.places) == pytest.approx(found.value, rel=1e-9)
            assert found.bound >= best - 1e-9


@pytest.mark.parametrize("n_sites", [1, 2])
@pytest.mark.parametrize("seed", range(24))
def test_cameras_that_must_lie_apart_against_trying_every_choice(seed, n_sites):
    program = random_program(seed, n_sites, 1 if seed % 2 else 0.7)
    best, merged = brute_force(program), program.merged()
    for found in (branch_and_bound(merged, 20.0, 1e-7), enumerate_spread(merged)):
        assert found is not None and found.finished and (found.places is None) == (best < 0)
        if best >= 0:
            assert found.value == pytest.approx(best, rel=1e-6, abs=1e-9)
            assert best - 1e-9 <= found.bound <= best + 1e-4 * program.weights.sum()
            assert program.value(found.places) == pytest.approx(merged.value(found.places))


@pytest.mark.parametrize("equal", [True, False])
@pytest.mark.parametrize("n_sites", [1, 3])
@pytest.mark.parametrize("seed", range(20))
def test_groups_against_trying_every_choice(seed, n_sites, equal, monkeypatch):
    monkeypatch.setattr("placement.proof.halving.FIRST_MULTIPLICATIONS", 1e3 if seed % 2 else 0.0)
    program = random_program(seed, n_sites, 0, n_places=(8, 12, 16)[seed % 3])
    if equal:
        program = dataclasses.replace(program, weights=np.random.default_rng(seed).integers(1, 7, 25) * 0.37)
    best, rounding = brute_force(program), 2e-4 * program.weights.sum()
    if program.n_free == 0:
        return
    known = enumerate_all(program).places
    for choice, least in ((None, -np.inf), (None, 0.7 * best), (known, -np.inf)):
        found = halved(program, choice, least, np.inf)
        assert found.finished and (found.places is None) == (best < 0)
        assert found.value == pytest.approx(max(best, 0.0), rel=1e-9 if equal else 1e-4)
        assert best - 1e-9 <= found.bound <= max(best, 0.0) + rounding
    assert halved(program, None, best + 1, np.inf).bound == best + 1
    assert (hurried := halved(program, None, -np.inf, 0.0)) is None or hurried.bound >= best
    monkeypatch.setattr("placement.proof.solver.is_quick", lambda program: False)
    found = solve(program, 20.0, 1e-3)
    assert found.finished and found.value == pytest.approx(max(best, 0.0), rel=1e-3)
    monkeypatch.setattr("placement.proof.halving.MOST_WAITING", 2)
    assert halved(program, None, -np.inf, np.inf).bound >= best


def test_blocks_of_halves_leave_nothing_out(monkeypatch):
    site = made_up_site(5)
    program = grid_of(site, LayoutSpace(RING, 4, Constraints(0.0)), exact.Demand(), 18)
    whole = enumerate_all(program)
    monkeypatch.setattr("placement.proof.enumeration.BLOCK", 7)
    assert enumerate_all(program) == whole


def test_enumeration_stops_at_its_time_and_the_bound_of_the_program_still_holds():
    program = grid_of(made_up_site(1), LayoutSpace(RING, 5, Constraints()), exact.Demand(), 72)
    assert enumerate_all(program, end=0.0) is None
    hurried = branch_and_bound(program.merged(), seconds=1e-3, gap=1e-6)
    assert hurried.bound >= enumerate_all(program.merged()).value - 1e-9


@pytest.mark.parametrize("seed", range(4))
def test_a_known_choice_changes_neither_optimum_nor_bound(seed):
    program = grid_of(made_up_site(seed), LayoutSpace(RING, 4, Constraints()), exact.Demand(), 12).merged()
    best = enumerate_all(program)
    for known in (best.places, (0, 3, 6, 9)):
        found = branch_and_bound(program, 20.0, 1e-7, known=known)
        assert found.value == pytest.approx(best.value, rel=1e-6) and found.finished
        assert best.value - 1e-9 <= found.bound <= best.value + 1e-3
    hurried = branch_and_bound(program, seconds=1e-3, gap=1e-7, known=best.places)
    assert hurried.places is not None and hurried.value >= best.value - 1e-9
    assert hurried.bound >= best.value - 1e-9


REQUESTS = [
    (2, 2, Constraints()),
    (3, 2, Constraints(min_separation=0.0)),
    (4, 3, Constraints(min_separation=11.0)),
    (4, 2, Constraints(fixed=(0.4,), forbidden=((1.0, 2.2), (5.5, 6.5)))),
    (3, 1, Constraints(forbidden=((3.0, 3.1),))),
    (9, 2, Constraints(min_separation=9.9)),
    (2, 2, Constraints(fixed=(0.4, 3.0))),
]
DEMANDS = [
    exact.Demand(2, min_baseline=15.0),
    exact.Demand(3, min_baseline=22.0),
    exact.Demand(2, max_error=0.1),
    exact.Demand(2, min_baseline=10.0, max_error=0.08),
]


@pytest.mark.parametrize(("n_cameras", "threshold", "constraints"), REQUESTS)
@pytest.mark.parametrize(("seed", "n_sites"), [(0, 1), (1, 1), (2, 3)])
def test_no_layout_exceeds_the_bounds(n_cameras, threshold, constraints, seed, n_sites):
    check_bounds(made_up_site(seed, n_sites=n_sites), n_cameras, exact.Demand(threshold), constraints, seed)


@pytest.mark.parametrize("demand", DEMANDS)
@pytest.mark.parametrize(
    ("n_cameras", "constraints"), [(3, Constraints()), (4, Constraints(fixed=(0.4, 2.0))), (6, Constraints())]
)
def test_nor_where_cameras_must_lie_apart_or_errors_are_bounded(n_cameras, demand, constraints):
    site = made_up_site(7, n_sites=1 + n_cameras % 2)
    # Errors of 0.03 to 0.11 mm from cameras at opposite sides of the ring, as on real sites.
    noise = np.random.default_rng(7).uniform(0.5, 6.0, len(site.weights))
    check_bounds(dataclasses.replace(site, noise=noise), n_cameras, demand, constraints, n_cameras)


def check_bounds(site, n_cameras, demand, constraints, seed):
    """No layout reconstructs more than the bounds of its certificate allow."""
    space = LayoutSpace(RING, n_cameras, constraints)
    certificate = certify_samples(site, space, demand, QUICK)
    coverage = SampledCoverage(site, demand, RING, n_grid=120)
    rng = np.random.default_rng(seed)
    layouts = [space.random(rng) for _ in range(150)]
    layouts += [coverage.improve(space, layout) for layout in layouts[:5]]
    best = max(coverage.fraction(layout) for layout in layouts)
    assert best <= certificate.bound_fraction + 1e-12
    if certificate.grid_angles is not None:
        assert certificate.grid_fraction <= certificate.grid_bound_fraction
        assert certificate.grid_fraction <= certificate.bound_fraction + 1e-12
        assert coverage.fraction(certificate.grid_angles) == pytest.approx(certificate.grid_fraction)
        assert constraints.violations(RING, certificate.grid_angles) == []


@pytest.mark.parametrize(("n_cameras", "baseline"), [(1, 0.0), (2, 0.0), (3, 0.0), (2, 15.0), (3, 15.0)])
def test_grid_bound_is_the_best_of_all_layouts_on_the_grid(n_cameras, baseline):
    site, demand = made_up_site(3), exact.Demand(min(2, n_cameras), min_baseline=baseline)
    space = LayoutSpace(RING, n_cameras, Constraints())
    certificate = certify_samples(site, space, demand, QUICK)
    coverage = SampledCoverage(site, demand, RING)
    grid = np.radians(15) * np.arange(24)
    every = [list(layout) for layout in itertools.combinations(grid, n_cameras) if space.allows(layout)]
    best = max(coverage.fraction(layout) for layout in every)
    assert certificate.grid_fraction == pytest.approx(best, rel=1e-12)
    assert best <= certificate.grid_bound_fraction <= best + 1e-4
    assert certificate.proven and certificate.method == "enumeration"


def test_cells_are_never_less_than_what_any_angle_in_them_sees():
    site, space = made_up_site(2), LayoutSpace(RING, 3, Constraints())
    angles = np.random.default_rng(0).uniform(0, TURN, 500)
    for n_cells in (7, 24, 72, 144):
        cells = cells_of(site, space, exact.Demand(), n_cells)
        inside = cells.seen[np.floor(angles / TURN * n_cells).astype(int)]
        assert not (site.at(angles) & ~inside).any()


def test_smaller_cells_give_a_tighter_bound():
    site, space = made_up_site(4), LayoutSpace(RING, 3, Constraints())
    bounds = [solve(cells_of(site, space, exact.Demand(), n), 20.0, 1e-6).bound for n in (12, 24, 48)]
    assert bounds[0] >= bounds[1] >= bounds[2]


def test_gap_of_a_layout_and_the_statement():
    site, space = made_up_site(6), LayoutSpace(RING, 4, Constraints())
    certificate = certify_samples(site, space, exact.Demand(), QUICK)
    assert certificate.gap is None and certificate.layout_fraction is None
    measured = measure(certificate, site, certificate.grid_angles, exact.Demand(), RING)
    assert measured.layout_fraction == pytest.approx(certificate.grid_fraction)
    assert measured.gap == pytest.approx(certificate.bound_fraction - certificate.grid_fraction)
    assert 0 <= measured.grid_gap < 1e-4 and measured.gap >= 0
    for words in ("at multiples of 15 degrees", "at any angles", "Not proven", f"{measured.bound_fraction:.2%}"):
        assert words in measured.statement
    assert not measured.ignores_error and "bound on the error" not in measured.statement
    with_error = certify_samples(site, LayoutSpace(RING, 4, Constraints()), exact.Demand(max_error=1.0), QUICK)
    assert with_error.ignores_error and "only the baseline that it implies" in with_error.statement


def test_optimise_carries_a_certificate_and_never_stays_below_its_layout():
    bars = [trimesh.creation.box((40, 40, 2)), trimesh.creation.box((40, 3, 3)), trimesh.creation.box((3, 30, 3))]
    for bar, height in zip(bars, (-1, 32, 36), strict=True):
        bar.apply_translation((height / 10, 1, height))
    mesh = trimesh.util.concatenate(bars)
    settings = dataclasses.replace(QUICK, n_starts=4, n_start_phases=2, polish_steps=(), ring_cameras=16)
    result = placement.optimise(mesh, RING, n_cameras=3, settings=settings, seed=4)
    certificate = result.certificate
    assert certificate is not None and certificate.proven
    assert certificate.layout_fraction <= certificate.bound_fraction + 1e-12
    grid_area = exact.evaluate(mesh, RING.cameras(certificate.grid_angles)).area
    assert result.area >= grid_area * (1 - 1e-9) or certificate.grid_gap <= 0.003
    alone = placement.certify(mesh, RING, n_cameras=3, settings=settings, seed=4, layout=result.angles)
    assert alone == certificate
    assert placement.optimise(mesh, RING, 3, settings=settings, seed=4, certify=False).certificate is None


def test_errors():
    plate = trimesh.creation.box((10, 10, 1))
    with pytest.raises(PlacementError, match="threshold is 3 with 2 cameras"):
        placement.certify(plate, RING, n_cameras=2, threshold=3, settings=QUICK)
    with pytest.raises(PlacementError, match=r"need a ring of at least 38\.6 mm"):
        placement.certify(plate, RING, n_cameras=12, constraints=Constraints(10.0), settings=QUICK)
    with pytest.raises(PlacementError, match="certificate_step must be within"):
        Settings(certificate_step=0.0)


def test_the_standard_error_is_the_scatter_over_seeds_also_where_most_samples_are_seen_from_everywhere():
    plate = trimesh.creation.box((40, 40, 8)).apply_translation((0, 0, -4))
    hole = trimesh.creation.box((5, 5, 16)).apply_translation((3, 2, 0))
    mesh = plate.difference(hole, engine="manifold")
    settings = Settings(
        n_samples=600, n_angles=36, bisections=2, certificate_step=float(np.radians(45)), certificate_seconds=0.5,
        certify_on="samples", ring_cameras=24,
    )  # fmt: skip
    found = [
        placement.certify(mesh, RING, 3, settings=settings, seed=seed, layout=[0.3, 2.0, 4.1]) for seed in range(12)
    ]
    scatter = np.std([certificate.layout_fraction for certificate in found], ddof=1)
    told = np.sqrt(np.mean([certificate.sampling_error**2 for certificate in found]))
    assert scatter / 1.5 < told < 3 * scatter, (scatter, told)
