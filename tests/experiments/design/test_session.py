"""What the page asks for is done, and nothing that breaks a constraint: without a browser."""

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import exact
import placement
from experiments.design.design import Design
from experiments.design.history import MOST_TRIED, History, Numbers
from experiments.design.session import Reader, Session
from experiments.design.settings import SETTINGS
from experiments.files.errors import InputError
from experiments.layouts import layout_file

RING, DEMAND = exact.Ring(), exact.Demand()
MESH = {"name": "a plate", "sha256": "0" * 64}
READER = Reader("a plate", MESH, placement.Constraints())
ARCS = ((0.4, 1.0), (6.0, 0.2))


def design(angles=(1.2, 2.5, 4.0), **constraints):
    return Design.of(RING, DEMAND, placement.Constraints(**constraints), list(angles))


def session(first=None):
    return Session(READER, History(design() if first is None else first, "start"))


moves = st.lists(
    st.one_of(
        st.tuples(st.just("drag"), st.integers(0, 5), st.floats(-50, 50)),
        st.tuples(st.just("add"), st.none() | st.floats(-50, 50), st.none()),
        st.tuples(st.just("remove"), st.integers(0, 5), st.none()),
        st.tuples(st.just("fix"), st.integers(0, 5), st.booleans()),
        st.tuples(st.sampled_from(["drop", "undo", "redo", "let go", "equidistant"]), st.none(), st.none()),
    ),
    max_size=30,
)
FIELDS = {"drag": ("camera", "angle"), "add": ("place",), "remove": ("camera",), "fix": ("camera", "fixed")}


@settings(max_examples=150, deadline=None)
@given(moves, st.sampled_from([0.0, 4.0, 7.5]), st.sampled_from([(), ARCS]))
def test_whatever_is_done_no_constraint_is_broken(done, separation, forbidden):
    asked = session(design(min_separation=separation, forbidden=forbidden))
    constraints = placement.Constraints(min_separation=separation, forbidden=forbidden)
    for what, *values in done:
        before = asked.shown
        message = {"do": what} | dict(zip(FIELDS.get(what, ()), values, strict=False))
        try:
            asked.act(message)
        except (InputError, placement.PlacementError, exact.ExactError):
            assert asked.shown == before
        found = asked.shown
        assert constraints.violations(found.ring, found.angles) == []
        assert len(found.angles) >= DEMAND.threshold == found.demand.threshold
        if what == "drag" and found != before:  # those that are held stay, and so do all others
            changed = [i for i, pair in enumerate(zip(before.angles, found.angles, strict=True)) if len(set(pair)) > 1]
            assert len(changed) == 1 and not found.fixed[changed[0]]


@pytest.mark.parametrize("degrees", [0.0004, 12.3456, 359.9999])
def test_a_camera_goes_where_it_is_shown_to_be(degrees):
    moved = design(min_separation=0.0).moved(0, math.radians(degrees)).angles[0]
    assert moved == np.radians(round(degrees, 3) % 360)


def test_a_camera_that_is_dragged_past_another_goes_to_the_near_side():
    asked = design((1.0, 2.0, 4.0), min_separation=5.0)
    gap = 2 * math.asin(5.0 / RING.diameter)
    near = [asked.moved(0, 2.0 + by).angles[0] - 2.0 for by in (-0.1, 0.1)]
    assert near == pytest.approx([-gap, gap], abs=3e-5)
    assert abs(near[0]) >= gap and near[1] >= gap


def test_history_goes_back_and_forth_and_forgets_the_oldest():
    asked = session()
    for number in range(MOST_TRIED + 20):
        asked.act({"do": "drag", "camera": 0, "angle": 1.0 + 1e-3 * number})
        asked.act({"do": "drop"})
    history = asked.history
    assert len(history.tried) == MOST_TRIED and history.at == max(history.tried)
    latest = asked.shown
    asked.act({"do": "undo"})
    asked.act({"do": "undo"})
    asked.act({"do": "redo"})
    assert history.at == max(history.tried) - 1
    asked.act({"do": "add", "place": None})
    assert not history.can_redo  # but what was undone is still there
    asked.act({"do": "go", "number": history.at - 1})
    assert asked.shown == latest
    while history.undo():
        pass
    assert history.at == min(history.tried)


def test_history_is_kept_whole(tmp_path):
    asked = session(design((1.2, 2.5, 4.0), forbidden=ARCS, fixed=(2.5,)))
    turned = {
        "max_error": 0.2,
        "max_disparity_gradient": 0.5,
        "depth_near": 350.0,
        "max_incidence": 80.0,
        "min_baseline": 3.0,
        "min_angle": 1.5,
    }
    for name, value in turned.items():
        asked.act({"do": "turn", "name": name, "value": value})
    asked.act({"do": "drop"})
    asked.act({"do": "add", "place": None})
    asked.act({"do": "undo"})
    known = Numbers(1.25, None, 1.0, 0.5)
    assert asked.history.know(asked.shown, known) and not asked.history.know(asked.shown, known)
    path = tmp_path / "session.json"
    path.write_text(asked.history.text(MESH), encoding="utf-8")
    found = History.read(path, READER.design)
    assert found.tried == asked.history.tried and found.at == asked.history.at
    assert found.undo() and not found.undo()
    assert History.read(tmp_path / "nothing.json", READER.design) is None
    # Each of them is a layout that any other command reads.
    for one in json.loads(path.read_text(encoding="utf-8"))["tried"]:
        made = layout_file.understood(json.dumps(one["layout"]), path)
        assert READER.design(made) == asked.history.tried[one["number"]].design


def test_every_setting_is_put_and_read_back():
    seen_through = exact.Demand(optics=exact.Optics(pupil=1.5))  # a limit on blur takes a pupil
    first = Design.of(RING, seen_through, placement.Constraints(), [1.2, 2.5, 4.0])
    values = {"threshold": 3, "min_separation": 2.0, "min_baseline": 12.0, "min_angle": 2.0, "depth_near": 10.0}
    for name, setting in SETTINGS.items():
        value = values.get(name, 45.0)
        changed = setting.put(first, value)
        assert setting.value(changed) == value != setting.value(first), name
        assert changed != first
        assert json.dumps(changed.content(MESH), allow_nan=False)
        if setting.optional:
            assert setting.value(first) is None and setting.put(changed, None) == first
        told = setting.described(first)
        assert told["least"] < told["most"]
    both = SETTINGS["depth_far"].put(SETTINGS["depth_near"].put(first, 300.0), 500.0)
    assert both.demand.limits.depth_of_field == (300.0, 500.0)
    assert SETTINGS["min_angle"].put(first, 2.0).whole.min_baseline > 13.9  # 2 degrees at 400 mm
    with pytest.raises(exact.ExactError, match="the pupil is not known"):
        SETTINGS["max_blur"].put(design(), 2.0)
    with pytest.raises(exact.ExactError, match="depth_of_field"):
        SETTINGS["depth_far"].put(both, 200.0)


def test_a_layout_of_another_mesh_or_one_that_breaks_its_constraints_is_refused():
    asked = session()
    content = asked.shown.content(MESH)
    for change, words in (
        ({"mesh": {"name": "a ball", "sha256": "1" * 64}}, "was made for 'a ball', and this is a plate"),
        ({"angles_rad": [0.0, 0.01, 2.0], "angles_deg": np.degrees([0.0, 0.01, 2.0]).tolist()}, "do not meet"),
        ({"constraints": {"fixed": [3.0]}}, "no camera sits at the fixed angle of 171.887 degrees"),
    ):
        with pytest.raises(InputError, match=words):
            asked.act({"do": "open", "text": json.dumps(content | change)})
    # One written by hand need say no more than a ring and angles.
    little = {name: content[name] for name in ("format", "version", "ring", "angles_deg")}
    asked.act({"do": "open", "text": json.dumps(little | {"angles_deg": [10, 130, 250]})})
    assert np.degrees(asked.shown.angles) == pytest.approx([10, 130, 250])


def test_more_cameras_than_there_is_room_for_are_refused():
    asked = session(design((0.0, 2.0, 4.0), min_separation=14.0))
    asked.act({"do": "add", "place": None})
    before = asked.shown
    for _ in range(3):
        try:
            asked.act({"do": "add", "place": None})
        except InputError as error:
            assert "there is no room for another camera at 14 mm" in str(error)
            break
        before = asked.shown
    else:
        raise AssertionError("a ring of 30 mm does not hold seven cameras 14 mm apart")
    assert asked.shown == before
    with pytest.raises(InputError, match="at most 24"):
        design(np.linspace(0, 6, 25), min_separation=0.0)
