import dataclasses
import time

import numpy as np
import pytest
import trimesh

import exact
import placement
from placement.search.ring_maximum import RingMaximum
from placement.sites import checked_sites

RING = exact.Ring()
BLOCK = trimesh.creation.box((30, 30, 9))


def maximum(memory, mesh=BLOCK, ring=RING, threshold=2, n_cameras=8, exclude=None, face_weights=None):
    sites = checked_sites(mesh, exclude=exclude, face_weights=face_weights)
    return RingMaximum(sites, ring, exact.Demand(threshold), n_cameras=n_cameras, memory=memory)


def test_what_is_remembered_is_not_evaluated_again():
    memory = {}
    area = maximum(memory).areas[0]
    assert area == exact.evaluate(BLOCK, RING.cameras(RING.equidistant(8))).area
    assert list(memory.values()) == [area]
    memory[next(iter(memory))] = 123.0  # stands in for it, so that asking it shows
    assert maximum(memory).areas == (123.0,)


@pytest.mark.parametrize(
    "changes",
    [
        dict(mesh=BLOCK.copy().apply_translation((0, 0, 1e-6))),
        dict(ring=exact.Ring(diameter=30.000000001)),
        dict(ring=exact.Ring(focus=(0, 0, 1e-12))),
        dict(threshold=3),
        dict(n_cameras=9),
        dict(exclude=np.arange(len(BLOCK.faces)) == 0),
        dict(face_weights=np.ones(len(BLOCK.faces))),
        dict(face_weights=np.full(len(BLOCK.faces), 1 + 1e-15)),
    ],
    ids=lambda changes: next(iter(changes)),
)
def test_another_request_is_another_area(changes):
    memory = {}
    maximum(memory).areas  # noqa: B018 - fills the memory
    maximum(memory, **changes).areas  # noqa: B018
    assert len(memory) == 2


def test_a_placement_with_a_memory_is_the_same_as_without():
    quick = dataclasses.replace(
        placement.Settings(), n_samples=500, n_angles=36, n_starts=4, n_start_phases=2, ring_cameras=16
    )
    memory, areas = {}, []
    for kept in (None, memory, memory):
        problem = placement.Problem(BLOCK, RING, settings=quick, memory=kept)
        found = placement.place(problem, 3, certify=False)
        areas.append((found.angles, found.area, found.ring_area))
    assert areas[0] == areas[1] == areas[2] and len(memory) == 1


def test_who_wants_no_layout_waits_for_no_ring_maximum():
    """Nor leaves processes at work on one: they would take cores from whatever the program does next."""
    quick = placement.Settings(n_samples=500, n_angles=36, ring_cameras=16, certificate_step=0.2, certify_on="samples")
    memory = {}
    problem = placement.Problem(BLOCK, RING, settings=quick, workers=2, memory=memory)
    assert problem.certify(2).proven
    time.sleep(3)  # it takes less than one
    assert memory == {}
    assert problem.ring_maximum.areas == tuple(memory.values())
