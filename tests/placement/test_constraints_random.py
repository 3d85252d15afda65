"""Random requests: what is given meets every constraint, what is refused is infeasible, and offers are kept.

Requests are made of whole degrees, so that a search over whole degrees decides them: if any layout meets one, pushing
its cameras back until each touches a neighbour or the end of an arc gives a layout in whole degrees that does. The
separation asked for is a millionth less than the chord of those degrees, so that no request is within rounding of
being infeasible.
"""

import re
from dataclasses import dataclass, replace
from itertools import combinations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import trimesh
from hypothesis import event, given, settings
from hypothesis import strategies as st

import exact
import placement
from placement import Constraints, PlacementError, Settings
from placement.layouts.arcs import LayoutSpace
from placement.layouts.layout import angles_from_arcs, angles_from_gaps

RING = exact.Ring(diameter=26.0, working_distance=350.0)
SAFE = 1 - 1e-6
from_gaps, from_arcs = jax.jit(angles_from_gaps), jax.jit(angles_from_arcs)


def chord(degrees):
    return float(RING.diameter * np.sin(np.radians(degrees) / 2))


@dataclass(frozen=True)
class Asked:
    """A request in whole degrees: cameras at least `gap` apart, forbidden arcs as (start, width)."""

    n_cameras: int
    gap: int
    fixed: tuple[int, ...]
    forbidden: tuple[tuple[int, int], ...]

    @property
    def constraints(self):
        arcs = tuple((np.radians(start), np.radians(start + width)) for start, width in self.forbidden)
        return Constraints(SAFE * chord(self.gap), fixed=tuple(np.radians(self.fixed)), forbidden=arcs)


def open_degrees(asked):
    """The whole degrees that lie inside no forbidden arc; the ends of an arc are open."""
    return [p for p in range(360) if not any(0 < (p - start) % 360 < width for start, width in asked.forbidden)]


def apart(first, second):
    return min((first - second) % 360, (second - first) % 360)


def most_cameras(asked, gap):
    """Greatest number of cameras that fit `gap` degrees apart, by trying every first place; -1 if no fixed ones do."""
    allowed = set(open_degrees(asked))
    for i, one in enumerate(asked.fixed):
        if one % 360 not in allowed or any(apart(one, other) < gap for other in asked.fixed[:i]):
            return -1
    room = [p for p in sorted(allowed) if all(apart(p, one) >= gap for one in asked.fixed)]
    if gap == 0:
        return len(asked.fixed) + (asked.n_cameras if room else 0)
    best = 0
    for first in room:
        places = [first]
        for place in [p for p in room if p > first] + [p + 360 for p in room if p < first]:
            if place - places[-1] >= gap and first + 360 - place >= gap:
                places.append(place)
        best = max(best, len(places))
    return len(asked.fixed) + best


@st.composite
def requests(draw):
    """Often without fixed cameras or without arcs; about half of them impossible."""
    fixed = draw(st.one_of(st.just([]), st.lists(st.integers(-360, 720), max_size=3)))
    arcs = st.tuples(st.integers(-360, 720), st.integers(0, 359))
    forbidden = draw(st.one_of(st.just([]), st.lists(arcs, max_size=4)))
    n_cameras = draw(st.integers(max(1, len(fixed)), 8))
    gap = draw(st.one_of(st.integers(0, 30), st.integers(0, 180), st.just(360 // max(n_cameras, 2))))
    return Asked(n_cameras, gap, tuple(fixed), tuple(forbidden))


def broken(asked, angles):
    """What a layout of ring angles [rad] breaks, by plain geometry and none of the library's."""
    found = []
    places = RING.diameter / 2 * np.exp(1j * np.asarray(angles))
    distances = np.abs(places[:, None] - places[None, :])[~np.eye(len(places), dtype=bool)]
    if len(places) != asked.n_cameras:
        found.append("number")
    if len(distances) and distances.min() < asked.constraints.min_separation - 1e-9:
        found.append("separation")
    for one in asked.fixed:
        if np.abs(places - RING.diameter / 2 * np.exp(1j * np.radians(one))).min() > 1e-9:
            found.append("fixed")
    for start, width in asked.forbidden:
        inside = np.mod(np.degrees(angles) - start, 360)
        if ((inside > 1e-9) & (inside < width - 1e-9) & (inside < 360 - 1e-9)).any():
            found.append("forbidden")
    return found


@settings(max_examples=300, deadline=None, derandomize=True)
@given(requests(), st.integers(0, 2**32 - 1))
def test_a_request_is_refused_if_and_only_if_no_layout_meets_it(asked, seed):
    most = most_cameras(asked, asked.gap if asked.n_cameras > 1 else 0)
    feasible = most >= asked.n_cameras
    event(f"feasible: {feasible}")
    try:
        space = LayoutSpace(RING, asked.n_cameras, asked.constraints)
    except PlacementError as refusal:
        assert not feasible, refusal
        check_offer(asked, most, str(refusal))
        return
    assert feasible
    rng = np.random.default_rng(seed)
    for _ in range(4):
        layout = space.random(rng)
        assert broken(asked, layout) == []
        assert space.allows(layout)
    if space.n_free == 0:
        return
    parameters, arcs = space.parameters(layout)

    def to_angles(parameters):
        gap = jnp.asarray(space.minimum_gap)
        return from_gaps(parameters, gap) if arcs is None else from_arcs(parameters, arcs, gap)

    # Order aside, the parameters give the layout back, and any others give a layout that meets the request too.
    again = np.exp(1j * np.asarray(to_angles(jnp.asarray(parameters))))
    assert np.abs(again[:, None] - np.exp(1j * layout)[None, :]).min(axis=0).max() < 1e-5
    for scale in (1.0, 30.0, 1000.0):
        elsewhere = to_angles(jnp.asarray(rng.normal(scale=scale, size=parameters.shape)))
        assert broken(asked, elsewhere) == []


def check_offer(asked, most, message):
    """What a refusal says would be feasible is feasible, and no more than that is."""
    if number := re.search(r"takes (\d+)|: (\d+) do", message):
        offered = int(number[1] or number[2])
        assert offered == most, message
    if separation := re.search(r"or \d+ at ([\d.]+) mm", message):
        offered = float(separation[1])
        LayoutSpace(RING, asked.n_cameras, replace(asked.constraints, min_separation=offered))
        with pytest.raises(PlacementError):
            LayoutSpace(RING, asked.n_cameras, replace(asked.constraints, min_separation=offered + 0.011))


def widest_pair(asked):
    """Greatest angle [degrees] between two cameras, by trying every pair of places."""
    gap, fixed = asked.gap, [one % 360 for one in asked.fixed]
    if not asked.fixed and not asked.forbidden:  # the others sit on both sides of the pair
        return max(p for p in range(181) if gap == 0 or p // gap + (360 - p) // gap >= asked.n_cameras)
    room = [p for p in open_degrees(asked) if all(apart(p, one) >= gap for one in fixed)]
    pairs = [(a, b) for i, a in enumerate(fixed) for b in fixed[:i]]
    if asked.n_cameras > len(fixed):
        pairs += [(a, b) for a in fixed for b in room]
    if asked.n_cameras > len(fixed) + 1:
        pairs += [(a, b) for a in room for b in room]
    return max(apart(a, b) for a, b in pairs)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(requests().filter(lambda asked: asked.n_cameras > 1 and most_cameras(asked, asked.gap) >= asked.n_cameras))
def test_a_baseline_is_refused_if_no_two_cameras_can_be_that_far_apart(asked):
    widest = widest_pair(asked)
    LayoutSpace(RING, asked.n_cameras, replace(asked.constraints, min_baseline=SAFE * chord(widest)))
    if widest < 180:
        with pytest.raises(PlacementError, match=r"no two of \d cameras can be .* mm apart.* at most .* mm") as refusal:
            LayoutSpace(RING, asked.n_cameras, replace(asked.constraints, min_baseline=chord(widest + 0.5)))
        offered = float(re.findall(r"at most (.*) mm", str(refusal.value))[0])
        assert chord(widest) - 0.011 <= offered <= chord(widest) * (1 + 1e-5)
        LayoutSpace(RING, asked.n_cameras, replace(asked.constraints, min_baseline=offered))


@pytest.fixture(scope="module")
def step():
    """A floor with a wall across, off every symmetry of the ring."""
    wall = trimesh.creation.box((2, 14, 16)).apply_translation((3, 1, 8))
    return trimesh.util.concatenate([trimesh.creation.box((24, 18, 1)), wall])


TINY = Settings(
    n_samples=300, n_angles=24, n_starts=3, n_start_phases=1, n_phases=4, exact_phases=1, exact_candidates=2,
    polish_candidates=1, polish_sweeps=1, ring_cameras=8,
)  # fmt: skip


# Few, since each number of cameras and each kind of constraint is compiled anew.
END_TO_END = {
    "separation and baseline": Asked(3, 50, (), ()),
    "fixed and forbidden too": Asked(3, 40, (200,), ((300, 90), (100, 60))),
}


@pytest.mark.parametrize("name", END_TO_END)
def test_the_layout_returned_meets_the_request(step, name):
    asked = END_TO_END[name]
    constraints = replace(asked.constraints, min_baseline=chord(100))
    result = placement.optimise(step, RING, asked.n_cameras, constraints=constraints, settings=TINY, certify=False)
    for candidate in result.candidates:
        assert broken(asked, candidate.angles) == []
    cameras = RING.cameras(result.angles)
    with_baseline = exact.evaluate(step, cameras, min_baseline=chord(100)).area
    assert result.area == with_baseline
    # What counts is what some pair at least that far apart sees: each pair by itself, put together, is no more.
    wide = [pair for pair in combinations(range(3), 2) if RING.separations(result.angles)[pair] >= chord(100)]
    assert wide
    pairs = [exact.evaluate(step, [cameras[i], cameras[j]]).area for i, j in wide]
    assert max(pairs) - 1e-9 <= with_baseline <= sum(pairs) + 1e-9
    assert with_baseline <= exact.evaluate(step, cameras).area
