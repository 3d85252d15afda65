"""The bound on the surface itself is never below the exact area of a layout on the grid, and is reached by one."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
import trimesh

import exact
import placement
from placement import Constraints, PlacementError, Settings

RING = exact.Ring()
QUICK = Settings(
    n_samples=300, n_angles=36, n_starts=2, n_start_phases=1, n_pair_searches=1, exact_candidates=1, exact_phases=1,
    n_phases=1, ring_cameras=24, polish_steps=(), certificate_step=float(np.radians(15)), certificate_seconds=20.0,
)  # fmt: skip


@pytest.fixture(scope="module")
def walls():
    parts = [trimesh.creation.box((30, 30, 1))]
    parts += [trimesh.creation.box((1, 12, 14)).apply_translation((x, y, 8)) for x, y in ((-6, 4), (1, -3), (7, 5))]
    return trimesh.util.concatenate(parts)


@pytest.fixture(scope="module")
def bars():
    parts = [trimesh.creation.box((26, 26, 1))]
    parts += [trimesh.creation.box((16, 1, 11)).apply_translation((0, y, 6)) for y in (-7, 0, 6)]
    return trimesh.util.concatenate(parts)


def every_layout(n_free, separation=5.0, fixed=(), step_deg=15):
    """All choices of grid angles with the fixed ones that keep the separation."""
    layouts = []
    for chosen in itertools.combinations(np.radians(np.arange(0, 360, step_deg)), n_free):
        layout = np.array([*chosen, *fixed])
        apart = [RING.diameter * abs(np.sin((a - b) / 2)) for a, b in itertools.combinations(layout, 2)]
        if min(apart) >= separation - 1e-9:
            layouts.append(layout)
    return layouts


def exact_fractions(mesh, layouts, **asked):
    """Each by an evaluation of its own."""
    whatever_the_baseline = {name: value for name, value in asked.items() if name != "min_baseline"}
    ring_area = exact.evaluate(mesh, RING.cameras(RING.equidistant(24)), **whatever_the_baseline).area
    return exact.areas(mesh, [RING.cameras(one) for one in layouts], workers=1, **asked) / ring_area


def surface_of(mesh, n_cameras, step_deg=15, **asked):
    settings = replace(QUICK, certificate_step=float(np.radians(step_deg)))
    return placement.certify(mesh, RING, n_cameras, settings=settings, **asked).surface


@pytest.mark.parametrize("n_cameras", [2, 3])
def test_no_layout_on_the_grid_exceeds_it_and_one_reaches_it(walls, n_cameras):
    found = surface_of(walls, n_cameras)
    best = exact_fractions(walls, every_layout(n_cameras)).max()
    assert best <= found.bound_fraction <= best + found.small_fraction + 1e-4
    assert found.fraction == pytest.approx(best, abs=found.small_fraction + 1e-9) and found.proven
    assert found.fraction == pytest.approx(exact_fractions(walls, [found.angles])[0], rel=1e-12)
    assert 0 <= found.small_fraction <= 1e-4 and found.n_sets > 20


@pytest.mark.parametrize(
    "asked",
    [
        dict(min_baseline=24.0),
        dict(threshold=3),
        dict(constraints=Constraints(8.0, fixed=(0.3,))),
        dict(constraints=Constraints(8.0, fixed=(0.3, 2.5), min_baseline=20.0)),
        dict(limits=exact.Limits(max_incidence=float(np.radians(75)))),
        dict(max_error=0.06),
    ],
    ids=["baseline", "three views", "a fixed camera", "fixed ones and a baseline", "incidence", "a bound on the error"],
)
def test_it_knows_what_is_asked(walls, asked):
    limits = asked.get("constraints", Constraints())
    demand = {name: value for name, value in asked.items() if name != "constraints"}
    if limits.min_baseline:
        demand["min_baseline"] = limits.min_baseline
    layouts = every_layout(3 - len(limits.fixed), limits.min_separation, limits.fixed, step_deg=30)
    best = exact_fractions(walls, layouts, **demand).max()
    found = surface_of(walls, 3, step_deg=30, **asked)
    assert found.bound_fraction >= best
    if "max_error" in asked:
        assert found.ignores_error and found.bound_fraction > best
        return
    assert found.fraction == pytest.approx(best, abs=found.small_fraction + 1e-9) and found.proven
    assert set(limits.fixed) <= set(found.angles)


@pytest.mark.parametrize("objective", ["mean", "worst"])
def test_several_sites(walls, bars, objective):
    found = placement.certify([walls, bars], RING, 2, settings=QUICK, objective=objective, site_weights=[1, 3]).surface
    of_sites = np.stack([exact_fractions(one, every_layout(2)) for one in (walls, bars)])
    combined = of_sites.min(axis=0) if objective == "worst" else np.array([0.25, 0.75]) @ of_sites
    assert combined.max() <= found.bound_fraction <= combined.max() + found.small_fraction + 1e-4
    assert found.fraction == pytest.approx(combined.max(), abs=found.small_fraction + 1e-9)


def test_it_stands_in_the_placement_with_the_gap_of_what_is_proposed(walls):
    found = placement.optimise(walls, RING, 3, settings=QUICK, workers=1)
    surface = found.certificate.surface
    assert surface.layout_fraction == found.fraction
    assert surface.gap == pytest.approx(surface.bound_fraction - found.fraction, abs=1e-12)
    assert found.most_area.fraction >= surface.fraction
    words = found.certificate.statement
    assert f"at multiples of 15 degrees reconstructs more than {surface.bound_fraction:.2%} of the ring" in words
    assert "On the surface itself" in words and f"{found.fraction:.2%} of the surface" in words


def test_it_is_done_as_the_settings_say(walls):
    on_samples = placement.certify(walls, RING, 2, settings=replace(QUICK, certify_on="samples"))
    assert on_samples.surface is None and "On the surface" not in on_samples.statement
    large = trimesh.Trimesh(*trimesh.remesh.subdivide(walls.vertices, walls.faces))
    for _ in range(5):
        large = large.subdivide()
    assert len(large.faces) * 24 > 500_000
    assert placement.certify(large, RING, 2, settings=QUICK).surface is None
    with pytest.raises((PlacementError, TypeError), match="certify_on"):
        replace(QUICK, certify_on="all")
