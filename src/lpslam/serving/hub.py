"""Events for many listeners, none of whom can hold up another, or whoever tells."""

import asyncio
from collections import deque
from collections.abc import AsyncIterator
from dataclasses import dataclass
from typing import Any

from lpslam.errors import LpSlamError


class TooManyListenersError(LpSlamError):
    """As many listen as may."""


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened.

    Attributes:
        id: counted from 1.
        kind: `map`, `job` or `missed`.
        data: as JSON can hold it.
    """

    id: int
    kind: str
    data: dict[str, Any]


class Hub:
    """Tells all listeners of one event loop what happens; `tell` is called in that loop.

    Args:
        listeners: at once.
        waiting: events that wait for a listener, and that one who comes back can be told; the oldest go first.
    """

    def __init__(self, listeners: int, waiting: int) -> None:
        self._most, self._waiting = listeners, waiting
        self._count = 0
        self._past: deque[Event] = deque(maxlen=waiting)
        self._queues: dict[asyncio.Event, deque[Event]] = {}

    @property
    def listeners(self) -> int:
        """How many listen."""
        return len(self._queues)

    def tell(self, kind: str, data: dict[str, Any]) -> None:
        """Say what happened."""
        self._count += 1
        event = Event(self._count, kind, data)
        self._past.append(event)
        for woken, queue in self._queues.items():
            queue.append(event)
            woken.set()

    async def listen(self, after: int | None = None, heartbeat: float = 15.0) -> AsyncIterator[Event | None]:
        """The events from now on, or after one that was heard before; None every `heartbeat` seconds of silence.

        Raises:
            TooManyListenersError: as many listen as may.
        """
        if len(self._queues) >= self._most:
            raise TooManyListenersError("as many listen to events as may; come back later")
        woken = asyncio.Event()
        queue: deque[Event] = deque(maxlen=self._waiting)
        # A number from before a restart is larger than all: what there is, is told.
        last = self._count if after is None else after if after <= self._count else 0
        queue.extend(event for event in self._past if event.id > last)
        self._queues[woken] = queue
        try:
            while True:
                while queue:
                    event = queue.popleft()
                    if event.id > last + 1:
                        yield Event(event.id - 1, "missed", {"events": event.id - last - 1})
                    last = event.id
                    yield event
                woken.clear()
                try:
                    async with asyncio.timeout(heartbeat):
                        await woken.wait()
                except TimeoutError:
                    yield None
        finally:
            del self._queues[woken]
