"""The server of the page: on this machine alone, for the one who has started it."""

import asyncio
import secrets
import signal
import socket
import threading
import webbrowser
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from importlib.resources import files
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect

from experiments.design.guard import HOST, Guard
from experiments.design.searches import FILES
from experiments.design.studio import Studio
from experiments.files.errors import InputError

# A message of the page: at most a layout file.
LARGEST_MESSAGE = 1_000_000
MOST_WINDOWS = 16
TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}


def static_files() -> dict[str, tuple[bytes, str]]:
    """Content and type of each file of the page by its name, read once: no path of a request is ever opened."""
    found = {}
    for folder in (files("experiments.design") / "page", files("experiments.design") / "page" / "three"):
        for file in folder.iterdir():
            ending = file.name[file.name.rfind(".") :] if "." in file.name else ""
            if file.is_file() and ending in TYPES:
                found[file.name] = (file.read_bytes(), TYPES[ending])
    return found


def application(studio: Studio, secret: str, port: int) -> ASGIApp:
    """What the server answers with."""
    known, windows = static_files(), [0]

    async def page(request: Request) -> Response:
        content, kind = known["index.html"]
        return Response(content, media_type=kind)

    async def static(request: Request) -> Response:
        found = known.get(request.path_params["name"])
        return PlainTextResponse("not there\n", 404) if found is None else Response(found[0], media_type=found[1])

    async def save(request: Request) -> Response:
        name = request.path_params["name"]
        if name not in FILES:
            return PlainTextResponse("not there\n", 404)
        try:
            content = await studio.file(name)
        except InputError as error:
            return PlainTextResponse(f"{error}\n", 409)
        kept = {"content-disposition": f'attachment; filename="{name}"'}
        return Response(content, media_type=FILES[name][1], headers=kept)

    async def live(socket: WebSocket) -> None:
        if windows[0] >= MOST_WINDOWS:
            await socket.close(1013)
            return
        await socket.accept()
        windows[0] += 1
        window = studio.open_window()
        try:
            async with asyncio.TaskGroup() as both:
                both.create_task(_say(socket, window.next))
                both.create_task(_hear(socket, lambda text: studio.hear(window, text)))
        except* (WebSocketDisconnect, RuntimeError):  # the latter of sending to one that is gone
            pass
        finally:
            windows[0] -= 1
            studio.close_window(window)

    @asynccontextmanager
    async def lifespan(_: Starlette) -> AsyncIterator[None]:
        await studio.start()
        try:
            yield
        finally:
            await studio.close()

    routes = [
        Route("/", page),
        Route("/static/{name}", static),
        Route("/save/{name}", save),
        WebSocketRoute("/live", live),
    ]
    return Guard(Starlette(routes=routes, lifespan=lifespan), secret, port)


async def _say(socket: WebSocket, next_one: Callable[[], Any]) -> None:
    while True:
        message = await next_one()
        if isinstance(message, bytes):
            await socket.send_bytes(message)
        else:
            await socket.send_text(message)


async def _hear(socket: WebSocket, hear: Callable[[str], None]) -> None:
    while True:
        message = await socket.receive()
        if message["type"] == "websocket.disconnect":
            raise WebSocketDisconnect(message.get("code") or 1000)
        hear(message.get("text") or "")


class _Server(uvicorn.Server):
    """Stops serving when it is asked to end, and leaves it to the command line to say so."""

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """In place of uvicorn's own, which knows nothing of a terminal that is closed."""
        asked: list[int] = []

        def stop(number: int, _: object) -> None:
            asked.append(number)
            self.should_exit = True

        numbers = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
        if threading.current_thread() is not threading.main_thread():
            numbers = []
        before = {one: signal.getsignal(one) for one in numbers}
        heard = {one: handler for one, handler in before.items() if handler not in (signal.SIG_IGN, None)}
        for one in heard:
            signal.signal(one, stop)
        try:
            yield
        finally:
            for one, handler in heard.items():
                signal.signal(one, handler)
        for one in asked[:1]:
            signal.raise_signal(one)


def serve(studio: Studio, port: int, opened: Callable[[str], None]) -> None:
    """Serve until the program is interrupted.

    Parameters
    ----------
    studio : Studio
    port : int
        0 for any that is free.
    opened : callable
        Called with the address of the page once it can be opened.

    Raises
    ------
    InputError
        If the port is not free.
    """
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((HOST, port))
    except (OSError, OverflowError) as error:
        listener.close()
        raise InputError(f"--port {port} cannot be used: {error}; give another, or 0 for any that is free") from error
    port, secret = listener.getsockname()[1], secrets.token_urlsafe(24)
    listener.listen(64)
    opened(f"http://{HOST}:{port}/{secret}/")  # it is answered as soon as the loop runs
    config = uvicorn.Config(
        application(studio, secret, port), http="h11", ws="websockets-sansio", ws_max_size=LARGEST_MESSAGE,
        ws_per_message_deflate=False, log_config=None, access_log=False, server_header=False, lifespan="on",
        limit_concurrency=128, timeout_graceful_shutdown=1, timeout_keep_alive=30,
    )  # fmt: skip
    try:
        _Server(config).run(sockets=[listener])
    finally:
        listener.close()


def open_browser(address: str) -> None:
    """Open the page in the person's browser; without one the address is all there is."""
    try:
        webbrowser.open(address)
    except webbrowser.Error:
        pass
