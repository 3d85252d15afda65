"""What helps along: a local search from a layout, the best layout, the best place for one camera more; and files.

All of it in a process of its own, which is ended if somebody presses stop.
"""

import io
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

import exact
import placement
from experiments.design.curves import CURVES, progress_of
from experiments.design.design import Design
from experiments.design.sampled import SampledAreas
from experiments.design.worker import Answer, Asked, latest, refusal
from experiments.exports import coverage_mesh, formats
from experiments.exports.cameras import named_cameras
from experiments.layouts import layout_content, layout_file
from experiments.report import page
from experiments.request.placing import moved_with, placed
from experiments.request.request import Request
from placement.layouts.arcs import LayoutSpace
from placement.search.ring_maximum import RingMaximum
from placement.search.scoring import ExactScorer
from placement.search.steps import polish_by_steps
from placement.sites import checked_sites

Tell = Callable[[str, Any], None]
# What puts the ring over the surface, and so does not need anything in sight.
PLACE = "place the ring"
# Falling steps of the local search [rad], and how often each camera gets its turn with one of them.
STEPS, MOST_SWEEPS = tuple(np.radians([4.0, 1.0, 0.25])), 12
# Places around the ring that samples are asked about for one camera more, and the best of them, which are scored.
N_PLACES, N_SCORED = 120, 6


def improve(asked: Request, design: Design, tell: Tell) -> Design:
    """Move one camera at a time on the exact area, as long as it grows; each better layout is told."""
    space = LayoutSpace(design.ring, len(design.angles), design.limits)
    scorer, theta = _scorer(asked.poses[0].scene, design), np.array(design.angles)
    for number, step in enumerate(STEPS):
        for _ in range(MOST_SWEEPS):
            tell("progress", (f"steps of {np.degrees(step):g}°", number, len(STEPS)))
            moved, _ = polish_by_steps(scorer, space, theta, (float(step),), 1)
            if (moved == theta).all():
                break
            theta = moved
            tell("try", _like(design, theta))
    return _like(design, theta)


def optimise(asked: Request, design: Design, tell: Tell) -> Design:
    """The layout that `camring optimise` proposes for the same request."""
    found = _problem(asked, design, tell).optimise(
        len(design.angles), design.limits, certify=False, give_up=asked.rig.give_up, progress=progress_of(tell)
    )
    return design.at(found.angles)


def one_more(asked: Request, design: Design, tell: Tell) -> Design:
    """The best place for one camera more, the others where they are: the best of many on samples, scored exactly."""
    scene = asked.poses[0].scene
    sampled, found = SampledAreas(scene), {}
    for number in range(N_PLACES):
        tell("progress", ("places on the ring", number, N_PLACES))
        more = design.with_one_more(2 * np.pi * number / N_PLACES)
        found[more.angles[-1]] = more, sampled.area(more)
    best = sorted(found.values(), key=lambda one: -one[1])[:N_SCORED]
    layouts = exact.OneMore(scene, design.ring.cameras(design.angles), demand=design.whole)
    scored = []
    for number, (more, _) in enumerate(best):
        tell("progress", ("scoring exactly", number, len(best)))
        scored.append((layouts.area(design.ring.cameras([more.angles[-1]])[0]), -number, more))
    return max(scored, key=lambda one: one[:2])[2]


def place(asked: Request, design: Design, tell: Tell) -> Design:
    """The ring over the surface, where `--place auto` puts it, with its cameras."""
    tell("progress", ("looking for a place", 0, 1))
    ring, _ = placed(asked.subjects[0].mesh, design.ring)
    return replace(design, ring=ring, demand=moved_with(design.demand, design.ring, ring))


def layout(asked: Request, design: Design, tell: Tell) -> bytes:
    """`layout.json`, as `camring optimise` writes it: what it compares with is worked out for this layout."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "layout.json"
        layout_content.write(path, _content(asked, design, tell))
        return path.read_bytes()


def report(asked: Request, design: Design, tell: Tell) -> bytes:
    """`report.html`."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "layout.json"
        layout_content.write(path, _content(asked, design, tell))
        tell("progress", ("writing the report", 0, 1))
        return page.page(layout_file.read(path), asked.poses[0].scene, Path(folder)).encode()


def exports(asked: Request, design: Design, tell: Tell) -> bytes:
    """All formats of `camring export`, and the reconstructable part as meshes, in one ZIP file."""
    packed = io.BytesIO()
    with tempfile.TemporaryDirectory() as name:
        folder, cameras = Path(name), named_cameras(design.ring, np.array(design.angles))
        tell("progress", ("exporting", 0, 1))
        for file in [folder / file for one in formats.FORMATS.values() for file in one.files]:
            file.parent.mkdir(parents=True, exist_ok=True)
        formats.write(folder, formats.FORMATS, cameras, asked.subjects[0])
        seen = exact.evaluate(asked.poses[0].scene, [one.camera for one in cameras], demand=design.whole)
        coverage_mesh.write(folder, seen)
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as file:
            for path in sorted(folder.rglob("*")):
                if path.is_file():
                    file.write(path, path.relative_to(folder))
    return packed.getvalue()


SEARCHES: dict[str, Callable[[Request, Design, Tell], Design]] = {
    "improve": improve,
    "optimise": optimise,
    "one more": one_more,
    PLACE: place,
}
FILES: dict[str, tuple[Callable[[Request, Design, Tell], bytes], str]] = {
    "layout.json": (layout, "application/json"),
    "report.html": (report, "text/html"),
    "exports.zip": (exports, "application/zip"),
}


def serve(pipe: Connection, asked: Request) -> None:
    """Do what comes through a pipe, one after another, until it is closed."""
    while True:
        question: Asked = latest(pipe)

        (design,) = question.about

        def tell(kind: str, found: Any, number: int = question.number) -> None:
            pipe.send(Answer(number, kind, found))

        try:
            if question.what in SEARCHES:
                tell("done", SEARCHES[question.what](asked, design, tell))
            elif question.what in CURVES:
                tell("done", CURVES[question.what](_problem(asked, design, tell), design, tell))
            else:
                tell("done", FILES[question.what][0](asked, design, tell))
        except Exception as error:
            tell("refused", refusal(error))


def _request(asked: Request, design: Design) -> Request:
    """The request that this design is an answer to."""
    rig = replace(
        asked.rig, n_cameras=len(design.angles), demand=design.demand, constraints=design.limits, certify=False
    )
    return replace(asked, ring=design.ring, rig=rig)


def _problem(asked: Request, design: Design, tell: Tell) -> placement.Problem:
    return _request(asked, design).problem(progress_of(tell), workers=1)  # of a process that may be ended at any time


def _content(asked: Request, design: Design, tell: Tell) -> dict[str, Any]:
    """What stands in a layout file: with all cameras fixed, the search finds this layout and compares it."""
    all_fixed = replace(design.limits, fixed=design.angles)
    found = _problem(asked, design, tell).optimise(
        len(design.angles), all_fixed, certify=False, give_up=asked.rig.give_up, progress=progress_of(tell)
    )
    return layout_content.placement_content(
        replace(found, constraints=design.limits), _request(asked, design)
    )  # fmt: skip


def _like(design: Design, angles: np.ndarray) -> Design:
    """The same cameras, in their order, at other angles [rad]."""
    return replace(design, angles=tuple(np.mod(angles, 2 * np.pi).tolist()))


class _Whole:
    """Takes the area of the whole surface for the ring maximum, which a comparison of layouts does not need."""

    def __init__(self, area: float):
        self._area = area

    def get(self, key: str) -> float | None:
        return self._area

    def __setitem__(self, key: str, area: float) -> None:
        raise AssertionError("it is known")


def _scorer(scene: exact.Scene, design: Design) -> ExactScorer:
    sites = checked_sites(scene)
    whole = _Whole(float(scene.surface.areas[scene.counted].sum()))
    maximum = RingMaximum(sites, design.ring, design.whole, n_cameras=1, memory=whole)
    return ExactScorer(sites, design.ring, design.whole, maximum)
