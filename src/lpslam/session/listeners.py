"""Steps as an asynchronous iterator, for whoever runs an event loop."""

import asyncio
import threading
from collections.abc import AsyncIterator
from typing import Self
from weakref import WeakKeyDictionary

from lpslam.session.step import Step

_MOST_WAITING = 1000
"""Steps that wait for who iterates, half a minute at 30 a second; of more the newest are kept."""


class Listeners:
    """Hands every step to all who iterate, in whichever thread or event loop they are."""

    def __init__(self) -> None:
        # Who dropped the iterator listens no more.
        self._iterators: WeakKeyDictionary[_Steps, asyncio.AbstractEventLoop] = WeakKeyDictionary()
        self._changing = threading.Lock()
        self._ended = self._listened = False

    def listen(self) -> AsyncIterator[Step]:
        """The steps from now on, until `end`; call it in an event loop."""
        steps = _Steps()
        with self._changing:
            self._listened = True
            if self._ended:
                steps.put(None)
            else:
                self._iterators[steps] = asyncio.get_running_loop()
        return steps

    def tell(self, step: Step | None) -> None:
        """Hand a step on; None ends all."""
        if not self._listened and step is not None:
            return
        with self._changing:
            self._ended |= step is None
            for steps, loop in list(self._iterators.items()):
                try:
                    loop.call_soon_threadsafe(steps.put, step)
                except RuntimeError:
                    # Its event loop is gone without a word.
                    del self._iterators[steps]


class _Steps:
    """Steps in their order, until None comes."""

    def __init__(self) -> None:
        self._waiting: asyncio.Queue[Step | None] = asyncio.Queue()
        self._has_ended = False

    def put(self, step: Step | None) -> None:
        """Add a step; who does not keep up misses the oldest."""
        if self._waiting.qsize() >= _MOST_WAITING:
            self._waiting.get_nowait()
        self._waiting.put_nowait(step)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> Step:
        step = None if self._has_ended else await self._waiting.get()
        if step is None:
            self._has_ended = True
            raise StopAsyncIteration
        return step
