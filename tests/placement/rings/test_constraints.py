"""Whatever is asked, every layout that comes back keeps it: between rings too."""

from dataclasses import replace

import numpy as np
import pytest

import exact
import placement
from tests.placement.rings.by_hand import QUICK, bound_of, cameras, wall

SETTINGS = placement.Settings(
    n_samples=300, n_angles=24, n_starts=4, n_start_phases=1, temperatures=(0.2,), n_phases=2, exact_phases=1,
    exact_candidates=2, n_pair_searches=1, ring_cameras=12, certificate_step=float(np.radians(30)), polish_sweeps=1,
    polish_candidates=1,
)  # fmt: skip


@pytest.mark.parametrize("seed", range(6))
def test_random_requests(seed):
    rng = np.random.default_rng(seed)
    n_rings, n_cameras = int(rng.integers(2, 4)), int(rng.integers(2, 6))
    rings = tuple(
        exact.Ring(diameter=float(rng.uniform(8, 40)), working_distance=float(rng.uniform(300, 420)),
                   focus=tuple(rng.uniform(-2, 2, 3).tolist()))
        for _ in range(n_rings)
    )  # fmt: skip
    most = tuple(None if rng.random() < 0.4 else int(rng.integers(1, 4)) for _ in rings)
    each = []
    for _ in rings:
        start = float(rng.uniform(0, 6))
        forbidden = ((start, start + float(rng.uniform(0.3, 2.0))),) if rng.random() < 0.5 else ()
        each.append(placement.Constraints(float(rng.uniform(0, 9)), float(rng.uniform(0, 8)), forbidden=forbidden))
    if rng.random() < 0.5:
        angle = float(rng.uniform(0, 6)) if not each[0].forbidden else each[0].forbidden[0][1] + 0.1
        each[0] = placement.Constraints(each[0].min_separation, fixed=(angle,), forbidden=each[0].forbidden)
    mesh = wall()
    try:
        found = placement.optimise_rings(
            mesh, rings, n_cameras, most=most, constraints=each, settings=SETTINGS, seed=seed, workers=1
        )
    except placement.PlacementError as error:
        assert "cameras" in str(error) and seed != 0  # most of them can be met
        return
    baseline = max(one.min_baseline for one in each)
    assert found.demand.min_baseline == baseline
    for one in (found, *found.candidates):
        ring_of, angles = np.array(one.ring_of), np.array(one.angles)
        assert len(ring_of) == n_cameras and (np.diff(ring_of) >= 0).all()
        numbers = np.bincount(ring_of, minlength=n_rings)
        assert all(limit is None or number <= limit for number, limit in zip(numbers, most, strict=True))
        own = cameras(rings, ring_of, angles)
        for i in range(n_cameras):
            for j in range(i):
                least = max(each[ring_of[i]].min_separation, each[ring_of[j]].min_separation)
                assert np.linalg.norm(own[i].position - own[j].position) >= least - 1e-9
        for k, limits in enumerate(each):
            here = angles[ring_of == k]
            for start, end in limits.forbidden:
                inside = np.mod(here - start, 2 * np.pi)
                assert ((inside <= 1e-9) | (inside >= end - start - 1e-9)).all()
            for angle in limits.fixed:
                assert np.abs(np.sin((here - angle) / 2)).min() < 1e-9
        area = exact.evaluate(mesh, own, min_baseline=baseline).area
        assert one.area == pytest.approx(area, rel=1e-9)
    assert found.smallest_separation == pytest.approx(
        min(np.linalg.norm(a.position - b.position) for i, a in enumerate(found.cameras) for b in found.cameras[:i])
    )


RINGS = exact.Ring(), exact.Ring(diameter=16.0)
REFUSED = [
    ({"rings": ()}, "there is no ring; give at least one"),
    ({"rings": (exact.Ring(), 30.0)}, r"ring 2 is a float; an exact\.Ring is needed"),
    ({"rings": (exact.Ring(), exact.Ring(roll="free"))}, 'the rolls of ring 2 are free.*ask with roll="radial"'),
    ({"n_cameras": 0}, "number of cameras is 0"),
    ({"n_cameras": 2.5}, r"number of cameras is 2\.5"),
    ({"n_cameras": float("nan")}, "number of cameras is nan"),
    ({"most": (1, 1)}, "3 cameras do not fit on these rings: ring 1 1, ring 2 1; ask for fewer"),
    ({"most": (1,)}, "it must give a number or None for each of the 2 rings"),
    ({"most": (None, -1)}, "most is .* it must give a whole number"),
    ({"most": (None, float("nan"))}, "most is .* it must give a whole number"),
    ({"constraints": placement.Constraints(40.0)}, "3 cameras do not fit on these rings: ring 1 1, ring 2 1"),
    ({"constraints": placement.Constraints(fixed=(0.0,))}, "give one Constraints for each"),
    ({"constraints": [placement.Constraints()]}, "one Constraints for all rings, or 2 of them"),
    ({"constraints": placement.Constraints(min_angle=0.01)}, "min_angle is known for one ring only"),
    ({"constraints": placement.Constraints(min_baseline=31.0)}, "ask for a baseline of at most 30 mm"),
    ({"constraints": [placement.Constraints(fixed=(0.0,)), placement.Constraints(fixed=(0.0,), min_separation=9.0)]},
     r"the fixed cameras contradict the constraints: two cameras are 7 mm apart, less than 9 mm"),
    ({"constraints": [placement.Constraints(), placement.Constraints(fixed=(0.0, 2.0))], "most": (None, 1)},
     "ring 2 takes 1 cameras, and 2 are fixed there"),
    ({"threshold": 4}, "threshold is 4 with 3 cameras"),
    ({"give_up": float("nan")}, "give_up is nan"),
    ({"seed": -1}, "seed is -1"),
    ({"n_cameras": 10**9}, "number of cameras is 1000000000; it must be at most 10000"),
    ({"settings": placement.Settings(certify_on="samples")}, "bounded on the surface alone: ask for"),
    ({"rings": (exact.Ring(focus=(900, 0, 0)), exact.Ring(focus=(0, 900, 0)))}, "no camera on this ring sees anything"),
]  # fmt: skip


@pytest.mark.parametrize(("asked", "words"), REFUSED)
def test_what_cannot_be_is_refused(asked, words, unchecked):
    asked = {"rings": RINGS, "n_cameras": 3, "workers": 1, "settings": QUICK} | asked
    with pytest.raises(placement.PlacementError, match=words):
        placement.optimise_rings(wall(), **asked)


def test_a_word_that_is_not_known_is_refused():
    with pytest.raises(TypeError, match=r"unexpected keyword argument 'treshold'; did you mean 'threshold'\?"):
        placement.optimise_rings(wall(), RINGS, 3, treshold=2)


def test_all_cameras_fixed_are_taken_as_they_are():
    constraints = placement.Constraints(fixed=(0.3, 2.0)), placement.Constraints(fixed=(1.0,))
    found = placement.optimise_rings(
        wall(), RINGS, 3, most=(2, 1), constraints=constraints, settings=SETTINGS, workers=1
    )  # fmt: skip
    assert found.ring_of == (0, 0, 1) and found.angles == pytest.approx((0.3, 2.0, 1.0))
    assert bound_of(found).bound_fraction == pytest.approx(found.fraction, rel=3e-4)


def test_one_camera_sits_where_it_sees_the_most():
    found = placement.optimise_rings(wall(), RINGS, 1, threshold=1, settings=SETTINGS, workers=1, certify=False)
    places = [ring.cameras([angle]) for ring in RINGS for angle in np.radians(range(0, 360, 30))]
    assert found.area >= max(exact.areas(wall(), places, threshold=1)) * (1 - 5e-3)
    assert found.smallest_separation == np.inf and found.error_rms == np.inf


def test_a_bound_that_would_take_long_is_left_out_unless_asked_for(monkeypatch):
    monkeypatch.setattr("placement.proof.surface.USUAL_WORK", 100)
    found = placement.optimise_rings(wall(), RINGS, 2, workers=1, settings=SETTINGS)
    assert found.certificate is None
    settings = replace(SETTINGS, certify_on="surface")
    found = placement.optimise_rings(wall(), RINGS, 2, workers=1, settings=settings)
    assert bound_of(found).proven


def test_two_rings_in_one_place_are_kept_apart():
    """Twice the same ring: cameras of one are kept off those of the other, and five at 10 mm do not fit twice."""
    ring = exact.Ring(diameter=20.0)
    found = placement.optimise_rings(
        wall(), (ring, ring), 4, constraints=placement.Constraints(10.0), settings=SETTINGS, workers=1, certify=False
    )
    assert found.smallest_separation >= 10.0 - 1e-9
    with pytest.raises(placement.PlacementError, match="keeps cameras of different rings apart"):
        placement.optimise_rings(
            wall(), (ring, ring), 8, constraints=placement.Constraints(10.0), settings=SETTINGS, workers=1
        )
