"""Reading beside tracking: a thread of its own behind a bounded queue.

Of a camera the newest frame is read first, and the others when none newer waits, and at the end. Where too many wait,
one goes that has others soon before and after it. All but the newest wait packed.
"""

import threading
import time
from collections import deque
from math import inf
from types import TracebackType
from typing import Self

from lpslam.frames import RgbdFrame
from lpslam.priority import yield_to_others
from lpslam.slam.state import TrackedFrame
from lpslam.text.mapper import TextMapper
from lpslam.text.reading.packing import PackedFrame

_PATIENCE = 1.0
"""Seconds that an exception on its way waits for the frame that is being read."""

_UNPACKED = 4
"""Of the newest that wait, so many as they are: they are read next."""

Waiting = tuple[RgbdFrame | PackedFrame, TrackedFrame]


class ReadingThread:
    """Feeds a `TextMapper` from a thread; offering it a frame never waits.

    Use it as a context manager: leaving reads what is still queued, or abandons it when an exception is on its way.
    An error of the mapper is raised by the next `observe`, or on leaving.

    Args:
        mapper: reads and remembers.
        queue_size: frames that may wait.
        queue_bytes: that they may take.
        newest_first: whether the newest is read first while frames come, rather than the oldest.
        share: of the time, 0 to 1, that may be spent reading.
        niceness: how far the thread stands back behind others.

    Attributes:
        dropped: frames that were worth reading but were not read for lack of time.
    """

    def __init__(
        self,
        mapper: TextMapper,
        queue_size: int,
        share: float = 1.0,
        niceness: int = 0,
        newest_first: bool = False,
        queue_bytes: float = inf,
    ) -> None:
        self._mapper = mapper
        self._niceness = niceness
        self._share = share
        self._queue: deque[Waiting] = deque()
        self._queue_size, self._queue_bytes, self._newest_first = queue_size, queue_bytes, newest_first
        self._changed = threading.Condition()
        self._closing = False
        self._error: Exception | None = None
        self._thread = threading.Thread(target=self._work, name="reading", daemon=True)
        self.dropped = 0

    def observe(self, frame: RgbdFrame, tracked: TrackedFrame) -> None:
        """Queue a frame if it is worth reading."""
        # Nobody would take the frames: going on would lose every text in silence.
        if self._error is not None:
            raise self._error
        if not self._mapper.wants(frame, tracked):
            return
        with self._changed:
            while self._is_full(frame):
                times = [each.timestamp for each, _ in self._queue] if self._newest_first else []
                gaps = [after - before for before, after in zip(times, times[2:], strict=False)]
                del self._queue[1 + gaps.index(min(gaps)) if gaps else 0]
                self.dropped += 1
            self._queue.append((frame, tracked))
            self._changed.notify_all()

    def _is_full(self, frame: RgbdFrame) -> bool:
        taken = sum(_bytes_of(each) for each, _ in self._queue)
        return bool(self._queue) and (
            len(self._queue) >= self._queue_size or taken + _bytes_of(frame) > self._queue_bytes
        )

    def wait_for_place(self) -> None:
        """Wait until one frame more would drop none: a recording can wait, a camera cannot."""
        with self._changed:
            self._changed.wait_for(lambda: len(self._queue) < self._queue_size or self._error is not None)

    def abandon(self) -> None:
        """Leave what is queued unread: whoever stops early does not wait for it."""
        with self._changed:
            self.dropped += len(self._queue)
            self._queue.clear()

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._changed:
            self._closing = True
            if kind is not None:
                self._queue.clear()
            self._changed.notify_all()
        # Whoever is in a hurry does not wait for a frame that is being read, or for a language model's answer.
        self._thread.join(_PATIENCE if kind is not None else None)
        if self._error is not None and kind is None:
            raise self._error

    def _work(self) -> None:
        yield_to_others(self._niceness)
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._queue or self._closing)
                if not self._queue:
                    return
                # At the end all that is left is read in its order.
                is_newest = self._newest_first and not self._closing
                frame, tracked = self._queue.pop() if is_newest else self._queue.popleft()
                self._changed.notify_all()
            before = time.perf_counter()
            try:
                self._mapper.read(frame.unpacked() if isinstance(frame, PackedFrame) else frame, tracked)
                if self._newest_first:
                    self._pack()
            except Exception as error:
                with self._changed:
                    self._error = error
                    self._changed.notify_all()
                return
            taken = time.perf_counter() - before
            with self._changed:
                self._changed.wait_for(lambda: self._closing, taken * (1.0 / self._share - 1.0))

    def _pack(self) -> None:
        """Pack what waits but for the newest; while one is packed, others may come and go."""
        while True:
            with self._changed:
                older = list(self._queue)[:-_UNPACKED]
            frame = next((each for each, _ in older if isinstance(each, RgbdFrame)), None)
            if frame is None:
                return
            packed = PackedFrame.of(frame)
            with self._changed:
                for row, (each, tracked) in enumerate(self._queue):
                    if each is frame:
                        self._queue[row] = packed, tracked
                        break


def _bytes_of(frame: RgbdFrame | PackedFrame) -> int:
    return frame.nbytes if isinstance(frame, PackedFrame) else frame.rgb.nbytes + frame.depth.nbytes
