"""The ring maximum of what is looked at, in a process of its own that gives way to all others."""

import os
from contextlib import suppress
from multiprocessing.connection import Connection

from experiments.design.worker import Answer, Asked, latest, refusal
from experiments.request.exact_work import ring_maximum
from experiments.request.request import Request

# How much less important than the numbers of the hand it is, to the system.
NICE = 10


def serve(pipe: Connection, asked: Request) -> None:
    """Answer questions that come through a pipe until it is closed: the ring maximum [mm²] of a design each."""
    with suppress(AttributeError, OSError):
        os.nice(NICE)
    scene, n_cameras = asked.poses[0].scene, asked.settings.ring_cameras
    while True:
        question: Asked = latest(pipe)
        (design,) = question.about
        try:
            maximum = ring_maximum(scene, (design.ring,), design.whole, n_cameras, workers=1)
            pipe.send(Answer(question.number, "ring area", maximum))
        except Exception as error:
            pipe.send(Answer(question.number, "refused", refusal(error)))
