"""The bound is never below any layout on the grid, whatever is asked, and by whichever way it is found."""

import numpy as np
import pytest

import exact
import placement
from placement.rings import rings_program
from tests.placement.rings.by_hand import QUICK, bound_of, cameras, choices, grid, pit, wall

RINGS = exact.Ring(), exact.Ring(diameter=14.0, working_distance=390.0)
SETTINGS = placement.Settings(
    **{name: getattr(QUICK, name) for name in ("n_samples", "n_angles", "n_starts", "temperatures", "ring_cameras")},
    polish_steps=(), n_start_phases=1, n_phases=2, exact_phases=1, exact_candidates=1,
    certificate_step=float(np.radians(30)), n_pair_searches=0,
)  # fmt: skip
ASKED = [
    (wall, 2, {}, {}),
    (pit, 3, {}, {}),
    (wall, 3, {"most": (2, 1)}, {"min_separation": 7.5}),
    (pit, 3, {"threshold": 3}, {"min_separation": 1.0}),
    (wall, 3, {"min_baseline": 12.0}, {}),
    (pit, 2, {"min_baseline": 20.0}, {}),
    (wall, 3, {"threshold": 1, "most": (None, 0)}, {}),
]


WAYS = [("enumeration", *one) for one in ASKED] + [("mixed-integer program", *ASKED[i]) for i in (0, 2, 3, 4, 6)]


@pytest.mark.parametrize(("way", "site", "n_cameras", "asked", "limits"), WAYS)
def test_no_layout_on_the_grid_is_better(way, site, n_cameras, asked, limits, monkeypatch):
    if way != "enumeration":
        monkeypatch.setattr(rings_program, "QUICK_MULTIPLICATIONS", 0.0)
    mesh, constraints = site(), placement.Constraints(**limits)
    found = placement.optimise_rings(
        mesh, RINGS, n_cameras, settings=SETTINGS, constraints=constraints, workers=1, give_up=0.0, **asked
    )
    ring_of, angles = grid(RINGS, 12)
    sets = exact.view_sets(mesh, cameras(RINGS, ring_of, angles))
    of = {name: value for name, value in asked.items() if name != "most"}
    best = 0.0
    for chosen in choices(RINGS, ring_of, angles, n_cameras, constraints.min_separation, asked.get("most")):
        mask = np.zeros(len(ring_of), dtype=bool)
        mask[chosen] = True
        best = max(best, sets.area(cameras=mask, **of))
    bound = bound_of(found)
    assert bound.fraction is not None and bound.ring_of is not None and bound.angles is not None
    assert bound.method == way and bound.n_places == 24 and np.degrees(bound.step) == pytest.approx(30)
    assert bound.bound_fraction * found.maximum_area >= best * (1 - 1e-9)
    assert bound.fraction * found.maximum_area <= best * (1 + 1e-9)
    if "min_baseline" not in asked or way == "enumeration":
        # The program stops when its bound is nearer than 0.2 %.
        assert bound.fraction * found.maximum_area >= best * (1 - (3e-5 if way == "enumeration" else 2e-3))
        assert bound.proven
    own = exact.evaluate(mesh, cameras(RINGS, bound.ring_of, bound.angles), **of)
    assert bound.fraction == pytest.approx(own.area / found.maximum_area, rel=1e-9)
    assert f"{bound.bound_fraction:.2%}" in bound.statement and "30 degrees" in bound.statement


def test_fixed_cameras_and_forbidden_arcs_are_known_to_it():
    mesh = wall()
    constraints = (
        placement.Constraints(forbidden=((np.radians(80), np.radians(200)),)),
        placement.Constraints(fixed=(np.radians(30),)),
    )
    found = placement.optimise_rings(mesh, RINGS, 3, settings=SETTINGS, constraints=constraints, workers=1)
    ring_of, angles = grid(RINGS, 12)
    sets, best = exact.view_sets(mesh, cameras(RINGS, ring_of, angles)), 0.0
    degrees = np.degrees(angles)
    inside = (ring_of == 0) & (degrees > 80.1) & (degrees < 199.9)
    (held,) = np.flatnonzero((ring_of == 1) & np.isclose(degrees, 30))
    for chosen in choices(RINGS, ring_of, angles, 3, fixed=(held,)):
        if not inside[chosen].any():
            mask = np.zeros(len(ring_of), dtype=bool)
            mask[chosen] = True
            best = max(best, sets.area(cameras=mask))
    assert bound_of(found).bound_fraction * found.maximum_area >= best * (1 - 1e-9)
    assert bound_of(found).fraction == pytest.approx(best / found.maximum_area, rel=3e-5)
