"""The newest of everything that watchers are shown. Who is slow misses what lies between, and holds up nobody."""

import asyncio
from collections.abc import AsyncIterator, Callable


class Board:
    """Parts by name, each with its newest content, in one event loop; nothing waits in a queue.

    Args:
        most: watchers at once.
        on_count: called with how many watch, when that changes.
    """

    def __init__(self, most: int, on_count: Callable[[int], None] = lambda count: None) -> None:
        self._most, self._on_count = most, on_count
        self._parts: dict[str, tuple[int, bytes]] = {}
        self._count = 0
        self._woken: set[asyncio.Event] = set()

    def put(self, name: str, content: bytes) -> None:
        """Show this content of a part from now on; one line of JSON."""
        self._count += 1
        self._parts[name] = self._count, b"event: " + name.encode("ascii") + b"\ndata: " + content + b"\n\n"
        for each in self._woken:
            each.set()

    @property
    def is_full(self) -> bool:
        """Whether as many watch as may."""
        return len(self._woken) >= self._most

    @property
    def watchers(self) -> int:
        """How many watch."""
        return len(self._woken)

    async def watch(self, heartbeat: float, last: str) -> AsyncIterator[bytes]:
        """Server-sent events: every part as it is, then as it becomes.

        Args:
            heartbeat: seconds of silence after which a sign of life is sent.
            last: the part after which it ends.
        """
        woken = asyncio.Event()
        self._woken.add(woken)
        self._on_count(len(self._woken))
        sent: dict[str, int] = {}
        try:
            # A browser that has lost the page asks again after a second.
            yield b"retry: 1000\n\n"
            while True:
                woken.clear()
                for name, (version, event) in list(self._parts.items()):
                    if sent.get(name) != version:
                        sent[name] = version
                        yield event
                if last in sent:
                    return
                try:
                    async with asyncio.timeout(heartbeat):
                        await woken.wait()
                except TimeoutError:
                    yield b": alive\n\n"
        finally:
            self._woken.discard(woken)
            self._on_count(len(self._woken))
