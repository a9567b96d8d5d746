"""Steps as an asynchronous iterator, for whoever runs an event loop."""

import asyncio
import threading
from collections.abc import AsyncIterator

from lpslam.session.step import Step


class Listeners:
    """Hands every step to all who iterate, in whichever thread or event loop they are."""

    def __init__(self) -> None:
        self._queues: dict[asyncio.Queue[Step | None], asyncio.AbstractEventLoop] = {}
        self._changing = threading.Lock()
        self._ended = False

    def listen(self) -> AsyncIterator[Step]:
        """The steps from now on, until `end`; call it in an event loop."""
        queue: asyncio.Queue[Step | None] = asyncio.Queue()
        with self._changing:
            if self._ended:
                queue.put_nowait(None)
            else:
                self._queues[queue] = asyncio.get_running_loop()
        return self._steps(queue)

    async def _steps(self, queue: "asyncio.Queue[Step | None]") -> AsyncIterator[Step]:
        try:
            while (step := await queue.get()) is not None:
                yield step
        finally:
            with self._changing:
                self._queues.pop(queue, None)

    def tell(self, step: Step | None) -> None:
        """Hand a step on; None ends all."""
        if not self._queues and step is not None:
            return
        with self._changing:
            self._ended |= step is None
            for queue, loop in list(self._queues.items()):
                try:
                    loop.call_soon_threadsafe(queue.put_nowait, step)
                except RuntimeError:
                    # Its event loop is gone without a word.
                    del self._queues[queue]
