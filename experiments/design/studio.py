"""Brings together the windows, the session that they share, and the processes that compute for it."""

import asyncio
import json
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from experiments.design import exact_answers, searches, whole_ring
from experiments.design.curves import CURVES
from experiments.design.design import Design
from experiments.design.history import Numbers
from experiments.design.sampled import SampledAreas
from experiments.design.session import Session, nothing_seen
from experiments.design.settings import SETTINGS
from experiments.design.window import Window
from experiments.design.worker import Answer, Asked, Worker, refusal
from experiments.files.errors import InputError
from experiments.files.whole import written_whole
from experiments.request.request import Request
from placement.search.ring_maximum import unbased

DIED = "the process that computes was stopped from outside, most likely since memory ran out; it starts anew"
# What a layout is called that a search has found.
FOUND = {"improve": "improved", "optimise": "optimised", "one more": "one camera more", searches.PLACE: "ring placed"}
# A hand that has not moved for this long rests [s]: more than there is between two frames.
PAUSE = 0.04
# The ring maximum takes seconds; it is asked for when ring and demand have been the same for this long [s].
RING_PAUSE = 1.0
BUSY = "a search or a file is under way; wait, or stop it"


class Studio:
    """What the server does for the page.

    Parameters
    ----------
    asked : Request
        The mesh, and all that the page does not change.
    session : Session
    path : Path
        Where the session is kept.
    """

    def __init__(self, asked: Request, session: Session, path: Path):
        self._asked, self._session, self._path = asked, session, path
        self._first = session.shown
        self._windows: set[Window] = set()
        self._sampled = SampledAreas(asked.poses[0].scene)
        self._tasks: list[asyncio.Task] = []
        self._exact: Worker | None = None
        self._search: Worker | None = None
        self._number = 0  # of the question to the exact worker: of every layout that is looked at
        self._pause: asyncio.TimerHandle | None = None
        self._moved: int | None = None
        self._design: Design | None = None
        self._found: dict[str, Any] = {}
        self._surface: bytes | None = None
        self._ring: Worker | None = None
        self._ring_key: tuple | None = None  # all that the ring maximum of what is looked at depends on
        self._ring_areas: dict[tuple, float | None] = {}
        self._ring_number = 0
        self._ring_pause: asyncio.TimerHandle | None = None
        self._job: dict[str, Any] | None = None
        self._job_number = 0
        self._job_at = 0
        self._job_found: int | None = None  # the layout tried that the job under way has found
        self._curves: dict[str, dict[str, Any]] = {}
        self._file: asyncio.Future[bytes] | None = None

    async def start(self) -> None:
        """Begin; in the loop that serves."""
        self._loop = asyncio.get_running_loop()
        self._has_moved, self._has_changed = asyncio.Event(), asyncio.Event()
        self._tasks = [asyncio.create_task(one) for one in (self._paint(), self._keep())]
        self._look()

    async def close(self) -> None:
        """End all that was begun."""
        for task in self._tasks:
            task.cancel()
        for worker in (self._exact, self._search, self._ring):
            if worker is not None:
                worker.end()
        with suppress(InputError):
            self.keep()

    def keep(self) -> None:
        """Keep the session in its file now.

        Raises
        ------
        InputError
            If it cannot be written.
        """
        self._write(self._session.history.text(self._session.reader.mesh))

    def open_window(self) -> Window:
        """A window that is told everything from now on."""
        window = Window()
        self._windows.add(window)
        hello = {
            "name": self._session.reader.name,
            "settings": [setting.described(self._first) for setting in SETTINGS.values()],
            "faces": self._asked.poses[0].scene.n_faces,
            "give_up": self._asked.rig.give_up,
            "ring_cameras": self._asked.settings.ring_cameras,
        }
        window.put("hello", _text("hello", hello))
        window.put("history", _text("history", self._session.tried()))
        window.put("job", _text("job", {"job": self._job}))
        window.put("curves", _text("curves", {"curves": self._curves}))
        window.put("state", self._state())
        if self._surface is not None:
            window.put("surface", self._surface)
        return window

    def close_window(self, window: Window) -> None:
        """One window less; what a hand held in it is let go where it is."""
        self._windows.discard(window)
        if self._session.hand is not None:
            self.hear(window, '{"do": "drop"}')

    def hear(self, window: Window, text: str) -> None:
        """Do what a message of a window asks for; what is refused is told that window alone."""
        try:
            try:
                message = json.loads(text)
            except (ValueError, RecursionError):
                raise InputError("this message is no JSON") from None
            kind = message.get("do") if isinstance(message, dict) else None
            if kind == "stop" or (isinstance(kind, str) and kind in {*searches.SEARCHES, *CURVES}):
                if set(message) != {"do"}:
                    raise InputError(f"a message {kind!r} has nothing beside")
                _ = self._stop() if kind == "stop" else self._begin(kind, self._session.shown)
            elif self._session.act(message):
                self._has_changed.set()
                self._tell("history", self._session.tried())
                if self._session.remark:
                    window.put("said", _text("said", {"words": self._session.remark}))
        except Exception as error:
            window.put("said", _text("said", {"words": refusal(error)}))
            window.put("state", self._state())
        self._look()

    async def file(self, name: str) -> bytes:
        """The content of a file of the layout that is looked at.

        Raises
        ------
        InputError
            If something else is under way, or somebody presses stop.
        """
        self._begin(name, self._session.shown)
        self._file = self._loop.create_future()
        return await self._file

    # What is looked at.

    def _look(self) -> None:
        """Have the numbers of what is looked at computed, if it is something else than before."""
        design, moved = self._session.shown, self._session.moved
        if design != self._design:
            self._design, self._found, self._number = design, {}, self._number + 1
            if self._session.hand is None:  # of a hand that moves, the estimate comes along
                self._tell("state", None)
            self._has_moved.set()
            if self._pause is not None:
                self._pause.cancel()
            # Of a hand that moves on nobody would see the answer.
            self._pause = self._loop.call_later(PAUSE if self._session.hand else 0.0, self._ask)
            self._look_around(design)
        else:
            self._tell("state", None)
            if moved != self._moved:  # a hand on another camera: what the others see will be known when it moves
                self._ask()
            self._know()  # of what a hand held before it was let go
        self._moved = moved

    def _ask(self) -> None:
        if self._exact is None:
            scene = self._asked.poses[0].scene
            self._exact = Worker(exact_answers.answer, (scene,), self._from_thread(self._exactly))
        self._exact.ask(Asked(self._number, "", (self._design, self._session.moved)))

    def _look_around(self, design: Design) -> None:
        """Have the ring maximum computed, if ring or demand are others than before."""
        key = design.ring, unbased(design.whole)
        if key == self._ring_key:
            return
        self._ring_key, self._ring_number = key, self._ring_number + 1
        if self._ring_pause is not None:
            self._ring_pause.cancel()
        if self._ring is not None:  # what it may be at, nobody wants to know any more
            self._ring.end()
            self._ring = None
        if key not in self._ring_areas:
            self._ring_pause = self._loop.call_later(RING_PAUSE, self._ask_around, design)

    def _ask_around(self, design: Design) -> None:
        self._ring = Worker(whole_ring.serve, (self._asked,), self._from_thread(self._around))
        self._ring.ask(Asked(self._ring_number, "", (design,)))

    def _around(self, answer: Answer | None) -> None:
        """The ring maximum, or that there is none."""
        if answer is not None and answer.number != self._ring_number:
            return
        if self._ring_key is not None:
            area = answer.found if answer is not None and answer.kind == "ring area" else None
            self._ring_areas[self._ring_key] = area
        if self._ring is not None:
            self._ring.end()
            self._ring = None
        self._tell("state", None)

    async def _paint(self) -> None:
        """Tell of what is looked at as soon as the samples have been asked."""
        while True:
            await self._has_moved.wait()
            self._has_moved.clear()
            design = self._session.shown
            try:
                sampled = await asyncio.to_thread(self._sampled.area, design)
            except Exception as error:
                sampled = None
                self._tell("said", {"words": refusal(error)})
            if design == self._design:
                self._found["sampled"] = sampled
            self._tell("state", None)

    def _exactly(self, answer: Answer | None) -> None:
        """Part of an answer about a layout; if nobody looks at it any more, it is of no interest."""
        if answer is None:
            self._exact = None
            self._found["refused"] = DIED
        elif answer.number != self._number or self._design is None:
            return
        elif answer.kind == "surface":
            self._surface = answer.found
            self._send("surface", answer.found)
            return
        else:
            self._found[answer.kind] = answer.found
        self._tell("state", None)
        self._know()

    def _know(self) -> None:
        """Note the numbers of what is looked at, once all are there."""
        if {"exact", "equidistant"} <= set(self._found) and self._design is not None:
            ours, even = self._found["exact"], self._found["equidistant"]
            numbers = Numbers(ours["area"], ours["error"], even["area"], even["error"])
            if self._session.know(self._design, numbers):
                self._has_changed.set()
                self._tell("history", self._session.tried())

    def _state(self) -> str:
        exactly = self._found.get("exact") or {"area": self._found.get("area"), "error": None, "cameras": None}
        return _text(
            "state",
            self._session.state()
            | {
                "look": self._number,
                "sampled": self._found.get("sampled"),
                "exact": exactly | {"is_whole": "exact" in self._found},
                "equidistant": self._found.get("equidistant"),
                "ring": {"area": self._ring_areas[self._ring_key]} if self._ring_key in self._ring_areas else None,
                "refused": self._found.get("refused"),
                "nothing": self._nothing(),
            },
        )

    def _nothing(self) -> str | None:
        """What to say if no camera sees anything that counts; None if one does, or it is not known yet."""
        seen = self._found.get("exact")
        if self._design is None or seen is None or any(seen["cameras"]):
            return None
        return nothing_seen(self._asked.poses[0].scene, self._design.ring)

    # What helps along.

    def _begin(self, what: str, design: Design) -> None:
        if self._job is not None:
            raise InputError(BUSY)
        if what != searches.PLACE and (nothing := self._nothing()) is not None:
            raise InputError(nothing)
        if self._search is None:
            self._search = Worker(searches.serve, (self._asked,), self._from_thread(self._searched))
        self._job_number += 1
        self._job_at = self._session.history.at
        self._job_found = None
        self._job = {"what": what, "stage": "starting", "done": 0, "total": 0}
        if what in CURVES:
            n, diameter = len(design.angles), design.ring.diameter
            of = f"{n} cameras on a ring" if what == "trade-off" else "A ring"
            self._curves[what] = {"points": [], "words": f"{of} of {diameter:g} mm; {design.whole.words}"}
        self._search.ask(Asked(self._job_number, what, (design,)))
        self._tell("job", {"job": self._job})

    def _stop(self) -> None:
        if self._job is not None and self._search is not None:
            self._search.end()
            self._search = None
            self._over(InputError("stopped"))

    def _searched(self, answer: Answer | None) -> None:
        if answer is None:
            self._search = None
            self._over(InputError(DIED))
        elif answer.number != self._job_number or self._job is None:
            return
        elif answer.kind == "progress":
            stage, done, total = answer.found
            self._job = self._job | {"stage": stage, "done": done, "total": total}
            self._tell("job", {"job": self._job})
        elif answer.kind == "point":
            self._curves[self._job["what"]]["points"].append(answer.found)
            self._tell("curves", {"curves": self._curves})
        elif answer.kind == "refused":
            self._over(InputError(answer.found))
        elif isinstance(answer.found, Design):
            self._tried(answer.found)
            if answer.kind == "done":
                self._over(None)
        else:
            self._over(answer.found)

    def _tried(self, design: Design) -> None:
        """Note what a search has found; it is looked at if nobody has moved anything since."""
        session = self._session
        is_waited_for = session.hand is None and session.history.at == self._job_at
        why = FOUND[(self._job or {})["what"]]
        if self._job_found is not None:  # it goes on from there
            session.history.change(self._job_found, design)
        else:
            before = session.history.at
            number = session.history.add(design, why, look=is_waited_for)
            self._job_found = None if number == before else number
            if is_waited_for:
                self._job_at = number
        self._has_changed.set()
        self._tell("history", session.tried())
        self._look()

    def _over(self, found: bytes | InputError | None) -> None:
        self._job = None
        self._tell("job", {"job": None})
        file, self._file = self._file, None
        if isinstance(found, InputError):
            self._tell("said", {"words": str(found)})
        if file is not None and not file.done():
            if isinstance(found, bytes):
                file.set_result(found)
            else:
                file.set_exception(found or InputError("nothing came"))

    # What is told, and what is kept.

    def _tell(self, kind: str, content: dict[str, Any] | None) -> None:
        self._send(kind, self._state() if content is None else _text(kind, content))

    def _send(self, kind: str, message: str | bytes) -> None:
        for window in self._windows:
            window.put(kind, message)

    def _from_thread(self, function: Callable[[Answer | None], None]) -> Callable[[Answer | None], None]:
        def told(answer: Answer | None) -> None:
            with suppress(RuntimeError):  # the loop is closed
                self._loop.call_soon_threadsafe(function, answer)

        return told

    async def _keep(self) -> None:
        """Keep the session in its file, as it is after the last change."""
        while True:
            await self._has_changed.wait()
            self._has_changed.clear()
            try:
                await asyncio.to_thread(self._write, self._session.history.text(self._session.reader.mesh))
            except InputError as error:
                self._tell("said", {"words": f"the session is not kept: {error}"})

    def _write(self, text: str) -> None:
        with written_whole(self._path) as temporary:
            temporary.write_text(text, encoding="utf-8")


def _text(kind: str, content: dict[str, Any]) -> str:
    return json.dumps({"kind": kind} | content, allow_nan=False)
