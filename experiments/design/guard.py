"""Who may talk to the server: the page that it has opened, and nobody else."""

import hmac
from typing import Any

from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

HOST = "127.0.0.1"


class Guard:
    """Refuses whatever does not come from the page itself, before anything of it is read.

    Every request must name this server in `Host`, as none does that was led here by another name (DNS rebinding); must
    have the secret in its path, which no other page knows; must come from this page, if it says from where, and a
    socket has to; and must only want to get something.

    Parameters
    ----------
    app : ASGI application
        What is behind it; sees paths without the secret.
    secret : str
    port : int
    """

    def __init__(self, app: ASGIApp, secret: str, port: int):
        self._app, self._secret = app, secret.encode()
        self._host, self._origin = f"{HOST}:{port}".encode(), f"http://{HOST}:{port}".encode()
        policy = (
            "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
            f"connect-src 'self' ws://{HOST}:{port}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        )
        self._headers = [
            (b"content-security-policy", policy.encode()),
            (b"x-content-type-options", b"nosniff"),
            (b"referrer-policy", b"no-referrer"),
            (b"cross-origin-opener-policy", b"same-origin"),
            (b"cross-origin-resource-policy", b"same-origin"),
            (b"cache-control", b"no-store"),
        ]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Hand on what may pass, refuse the rest."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                message = {**message, "headers": [*message.get("headers", ()), *self._headers]}
            await send(message)

        path = self._path_behind(scope)
        if path is not None:
            await self._app({**scope, "path": path, "raw_path": path.encode()}, receive, with_headers)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})  # before it is accepted: 403
        else:
            await PlainTextResponse("not for you\n", 403, {"connection": "close"})(scope, receive, with_headers)

    def _path_behind(self, scope: Scope) -> str | None:
        """The path without the secret; None for what may not pass."""
        given: dict[bytes, list[bytes]] = {}
        for name, value in scope["headers"]:
            given.setdefault(name.lower(), []).append(value)
        is_socket = scope["type"] == "websocket"
        origins = given.get(b"origin", [])
        _, secret, *rest = (*scope["path"].split("/"), "")
        may_pass = (
            given.get(b"host") == [self._host]
            and (origins == [self._origin] or (not origins and not is_socket))
            and (is_socket or scope["method"] == "GET")
            and _is_from_here(given)
            and hmac.compare_digest(secret.encode(errors="replace"), self._secret)
            and len(rest) > 1
        )
        return "/" + "/".join(rest[:-1]) if may_pass else None


def _is_from_here(given: dict[bytes, list[Any]]) -> bool:
    """Whether a browser says of a request that its own page, or the person, asks; others say nothing."""
    return given.get(b"sec-fetch-site", [b"none"]) in ([b"none"], [b"same-origin"])
