"""A recording at the pace at which it was made, as a camera would give it."""

import time
from collections.abc import Iterator

from lpslam.camera import PinholeCamera
from lpslam.frames import FrameFault, FrameSource, RgbdFrame


class Paced:
    """A `FrameSource` that gives each frame when its time has come, and only the newest to a consumer that is late.

    Args:
        source: frames in order of time.

    Attributes:
        dropped: frames that were over before the consumer asked.
    """

    def __init__(self, source: FrameSource) -> None:
        self.source = source
        self.dropped = 0

    @property
    def name(self) -> str:
        """The source's name."""
        return self.source.name

    @property
    def camera(self) -> PinholeCamera:
        """The source's calibration."""
        return self.source.camera

    @property
    def faults(self) -> list[FrameFault]:
        """The source's faults."""
        return self.source.faults

    def __len__(self) -> int:
        return len(self.source)

    def __iter__(self) -> Iterator[RgbdFrame]:
        """Yield frames at their times, counted from the first."""
        started: float | None = None
        waiting: RgbdFrame | None = None
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
            if waiting is not None:
                # The next frame is there already: a camera would have overwritten this one.
                if asked - started >= frame.timestamp:
                    self.dropped += 1
                else:
                    yield from _when_due(waiting, started)
            waiting = frame
        if waiting is not None and started is not None:
            yield from _when_due(waiting, started)


def _when_due(frame: RgbdFrame, started: float) -> Iterator[RgbdFrame]:
    time.sleep(max(0.0, started + frame.timestamp - time.perf_counter()))
    yield frame
