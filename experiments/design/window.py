"""One window of the page, as the server sees it."""

import asyncio


class Window:
    """One window: of each kind of message only the latest is still to be sent."""

    def __init__(self) -> None:
        self._due: dict[str, str | bytes] = {}
        self._is_due = asyncio.Event()

    def put(self, kind: str, message: str | bytes) -> None:
        """Have a message sent, in place of one of the same kind that has not been yet."""
        self._due.pop(kind, None)
        self._due[kind] = message
        self._is_due.set()

    async def next(self) -> str | bytes:
        """The next message; waits for one."""
        while not self._due:
            self._is_due.clear()
            await self._is_due.wait()
        return self._due.pop(next(iter(self._due)))
