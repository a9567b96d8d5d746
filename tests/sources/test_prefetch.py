import gc
import threading
import time
from collections.abc import Iterator

import numpy as np
import pytest

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.frames import FrameFault, FrameSource, RgbdFrame
from lpslam.sources.prefetch import Prefetched


class Counted:
    """A source that counts what was asked of it and may fail at a frame."""

    name = "counted"
    camera = PinholeCamera(4, 3, 1, 1, 1, 1)

    def __init__(self, n: int, fail_at: int | None = None) -> None:
        self.n, self.fail_at = n, fail_at
        self.produced, self.closed = 0, False
        self.faults: list[FrameFault] = []

    def __len__(self) -> int:
        return self.n

    def __iter__(self) -> Iterator[RgbdFrame]:
        self.produced, self.closed = 0, False
        try:
            for i in range(self.n):
                if i == self.fail_at:
                    raise UserError("the disk is gone")
                self.produced += 1
                yield RgbdFrame(i, i / 30, np.zeros((3, 4, 3), np.uint8), np.zeros((3, 4), np.float32))
        finally:
            self.closed = True


def decoders() -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name == "decode counted"]


def wait_until(condition: object) -> None:
    deadline = time.monotonic() + 5
    while not condition() and time.monotonic() < deadline:  # type: ignore[operator]
        time.sleep(0.005)
    assert condition()  # type: ignore[operator]


def test_all_frames_come_in_order_each_time() -> None:
    source = Prefetched(Counted(50), depth=3)
    assert isinstance(source, FrameSource)
    for _ in range(2):
        assert [frame.index for frame in source] == list(range(50))
    assert len(source) == 50
    assert decoders() == []


def test_it_reads_ahead_but_only_so_far() -> None:
    counted = Counted(100)
    frames = iter(Prefetched(counted, depth=4))
    next(frames)
    wait_until(lambda: counted.produced == 6)  # one consumed, four queued, one in hand
    time.sleep(0.1)
    assert counted.produced == 6
    frames.close()  # type: ignore[attr-defined]


def test_an_error_comes_where_the_frame_would_have_come() -> None:
    frames = iter(Prefetched(Counted(10, fail_at=6), depth=2))
    assert [next(frames).index for _ in range(6)] == [0, 1, 2, 3, 4, 5]
    with pytest.raises(UserError, match="disk is gone"):
        next(frames)
    assert decoders() == []


def test_breaking_off_stops_the_thread_and_closes_the_source() -> None:
    counted = Counted(1000)
    for frame in Prefetched(counted, depth=2):
        if frame.index == 3:
            break
    gc.collect()
    wait_until(lambda: decoders() == [])
    assert counted.closed
    assert counted.produced < 10


def test_an_empty_source_and_a_queue_of_none() -> None:
    assert list(Prefetched(Counted(0))) == []
    with pytest.raises(ValueError, match="hold none"):
        Prefetched(Counted(1), depth=0)
