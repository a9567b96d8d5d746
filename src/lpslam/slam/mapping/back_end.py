"""What happens to a keyframe after tracking: at once, or in threads beside it."""

import queue
import sys
import threading
import time
from collections.abc import Callable
from typing import Protocol

from lpslam.priority import MAPPING, yield_to_others
from lpslam.slam.mapping.local_mapping import LocalMapper


class BackEnd(Protocol):
    """Takes keyframes in the order in which they are made.

    Attributes:
        abandoned: keyframes that were left as tracking made them, since `finish` could not wait.
    """

    abandoned: int

    @property
    def is_idle(self) -> bool:
        """Whether no keyframe waits to be worked into the map."""

    def take(self, keyframe: int) -> None:
        """Work a keyframe into the map, now or soon."""

    def finish(self) -> None:
        """Come to an end; nothing of the map is touched any more afterwards."""


class InStep:
    """Maps and closes loops before the next frame: deterministic."""

    abandoned = 0

    def __init__(self, mapper: LocalMapper, close_loops: Callable[[int], None]) -> None:
        self._mapper = mapper
        self._close_loops = close_loops

    @property
    def is_idle(self) -> bool:
        """Always: nothing waits."""
        return True

    def take(self, keyframe: int) -> None:
        """Work a keyframe into the map."""
        self._mapper.process(keyframe)
        self._close_loops(keyframe)

    def finish(self) -> None:
        """Nothing is under way."""


class Beside:
    """Maps in one thread and closes loops in another, beside tracking.

    An error in a thread is raised by the next `take` or by `finish`: going on would lose the map in silence.

    Args:
        mapper: local mapping.
        close_loops: called with each keyframe after local mapping.
        interrupt: asks a running loop correction to end early.
    """

    def __init__(self, mapper: LocalMapper, close_loops: Callable[[int], None], interrupt: Callable[[], None]) -> None:
        self._mapper = mapper
        self._close_loops = close_loops
        self._interrupt = interrupt
        self._to_map: queue.SimpleQueue[int | None] = queue.SimpleQueue()
        self._to_close: queue.SimpleQueue[int | None] = queue.SimpleQueue()
        self._abandon = False
        self._mapped = self._taken = self.abandoned = 0
        self._error: Exception | None = None
        self._threads = [
            threading.Thread(target=self._work, args=work, name=name, daemon=True)
            for name, work in (
                ("local mapping", (self._to_map, self._map)),
                ("loop closing", (self._to_close, close_loops)),
            )
        ]
        self._switch_interval = sys.getswitchinterval()
        sys.setswitchinterval(_SWITCH_INTERVAL)
        for thread in self._threads:
            thread.start()

    @property
    def is_idle(self) -> bool:
        """Whether no keyframe waits or is being worked into the map."""
        return self._mapped == self._taken

    def take(self, keyframe: int) -> None:
        """Queue a keyframe; an adjustment that is running ends early."""
        if self._error is not None:
            raise self._error
        if not self._to_map.empty():
            self._mapper.hurry()
        self._taken += 1
        self._to_map.put(keyframe)

    def finish(self) -> None:
        """Finish what is queued, or abandon it when that takes too long."""
        sys.setswitchinterval(self._switch_interval)
        self._to_map.put(None)
        self._wait()
        if any(thread.is_alive() for thread in self._threads):
            self._abandon = True
            self._mapper.hurry()
            self._interrupt()
            self._wait()
        self.abandoned = self._taken - self._mapped
        if self._error is not None:
            raise self._error

    def _wait(self) -> None:
        deadline = time.monotonic() + _PATIENCE
        for thread in self._threads:
            thread.join(max(0.0, deadline - time.monotonic()))

    def _map(self, keyframe: int) -> None:
        self._mapper.process(keyframe)
        self._mapped += 1
        self._to_close.put(keyframe)

    def _work(self, keyframes: "queue.SimpleQueue[int | None]", work: Callable[[int], None]) -> None:
        yield_to_others(MAPPING)
        while (keyframe := keyframes.get()) is not None and not self._abandon:
            try:
                work(keyframe)
            except Exception as error:
                self._error = error
                break
        if keyframes is self._to_map:
            self._to_close.put(None)


_SWITCH_INTERVAL = 0.0005
"""Seconds that a thread may keep the interpreter while tracking waits for it; the usual 5 ms would be paid at every
kernel that tracking comes back from, and double its 95th percentile."""

_PATIENCE = 1.0
"""Seconds that queued work is given at the end, and again to abandon what is under way."""
