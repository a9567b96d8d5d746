"""A recording at the pace at which it was made, as a camera would give it."""

import time
from collections import deque
from collections.abc import Callable, Iterator

from lpslam.frames import FrameSource, PassedOn, RgbdFrame


class Paced(PassedOn):
    """A `FrameSource` that gives each frame when its time has come, and only the newest to a consumer that is late.

    Args:
        source: frames in order of time.
        backlog: frames whose time has come that may wait, as in a camera driver's queue: one that took long then costs
            the next ones a delay, and is no gap. The oldest is dropped when one more comes.
        should_stop: asked while waiting; when it says yes, no frame is waited for any longer.

    Attributes:
        dropped: frames that were over before the consumer asked.
    """

    def __init__(self, source: FrameSource, backlog: int = 1, should_stop: Callable[[], bool] = lambda: False) -> None:
        if backlog < 1:
            raise ValueError(f"a queue of {backlog} frames can hold none")
        super().__init__(source)
        self.dropped = 0
        self._backlog = backlog
        self._should_stop = should_stop

    def __iter__(self) -> Iterator[RgbdFrame]:
        """Yield frames at their times, counted from the first."""
        started: float | None = None
        waiting: deque[RgbdFrame] = deque()
        frames = iter(self.source)
        while True:
            asked = time.perf_counter()
            frame = next(frames, None)
            if frame is None:
                break
            now = time.perf_counter()
            if started is None:
                started = now - frame.timestamp
            # What a source takes beyond a frame's time is not the consumer's delay: the clock waits for it.
            started += max(0.0, now - max(asked, started + frame.timestamp))
            waiting.append(frame)
            if len(waiting) <= self._backlog:
                continue
            oldest = waiting.popleft()
            # The newest is there already: a camera would have overwritten the oldest.
            if asked - started >= frame.timestamp:
                self.dropped += 1
            else:
                self._wait_until(started + oldest.timestamp)
                yield oldest
        while waiting and started is not None:
            self._wait_until(started + waiting[0].timestamp)
            yield waiting.popleft()

    def _wait_until(self, due: float) -> None:
        # In pieces: a recording may pause for minutes.
        while (left := due - time.perf_counter()) > 0.0 and not self._should_stop():
            time.sleep(min(left, _PIECE))


_PIECE = 0.1
"""Seconds between two questions whether to stop."""
