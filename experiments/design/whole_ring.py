"""The ring maximum of what is looked at, in a process of its own that gives way to all others."""

import os
from contextlib import suppress
from multiprocessing.connection import Connection

from experiments.design.worker import Answer, Asked, latest, refusal
from experiments.files.ring_maximum_cache import RememberedAreas
from experiments.request.request import Request
from placement.search.ring_maximum import RingMaximum
from placement.sites import checked_sites

# How much less important than the numbers of the hand it is, to the system.
NICE = 10


def serve(pipe: Connection, asked: Request) -> None:
    """Answer questions that come through a pipe until it is closed: the ring maximum [mm²] of a design each."""
    with suppress(AttributeError, OSError):
        os.nice(NICE)
    sites, n_cameras = checked_sites(asked.poses[0].scene), asked.rig.settings.ring_cameras
    while True:
        question: Asked = latest(pipe)
        (design,) = question.about
        try:
            maximum = RingMaximum(sites, design.ring, design.whole, n_cameras=n_cameras, memory=RememberedAreas())
            pipe.send(Answer(question.number, "ring area", maximum.areas[0]))
        except Exception as error:
            pipe.send(Answer(question.number, "refused", refusal(error)))
