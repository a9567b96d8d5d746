import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from lpslam.frames import RgbdFrame
from lpslam.slam.state import TrackedFrame, TrackingState
from lpslam.text.reading.packing import PackedFrame
from lpslam.text.reading.reading_thread import ReadingThread


class Mapper:
    """Reads when it is let; fails at one frame if told to."""

    def __init__(self, fails_at: int = -1) -> None:
        self.read_frames: list[int] = []
        self.frames: list[RgbdFrame] = []
        self.threads: set[str] = set()
        self.let = threading.Semaphore(0)
        self.is_reading = threading.Event()
        self._fails_at = fails_at

    def wants(self, frame: RgbdFrame, tracked: TrackedFrame) -> bool:
        return tracked.is_tracked

    def read(self, frame: RgbdFrame, tracked: TrackedFrame) -> None:
        self.is_reading.set()
        assert self.let.acquire(timeout=10)
        self.threads.add(threading.current_thread().name)
        if frame.index == self._fails_at:
            raise ValueError("broken reader")
        self.read_frames.append(frame.index)
        self.frames.append(frame)


def frame(index: int, is_tracked: bool = True) -> tuple[RgbdFrame, TrackedFrame]:
    pose = np.eye(4) if is_tracked else None
    seen = RgbdFrame(index, index / 30, np.zeros((2, 2, 3), np.uint8), np.zeros((2, 2), np.float32))
    return seen, TrackedFrame(index, index / 30, TrackingState.TRACKING, 0, pose, pose, 100, False)


@contextmanager
def at_most(seconds: float) -> Iterator[None]:
    started = time.monotonic()
    yield
    assert time.monotonic() - started < seconds


@contextmanager
def while_the_first_is_read(mapper: Mapper, size: int, newest_first: bool = False) -> Iterator[ReadingThread]:
    """Frame 0 is being read and no longer queued; all that wait are let at the end."""
    with ReadingThread(mapper, size, newest_first=newest_first) as reader:
        reader.observe(*frame(0))
        assert mapper.is_reading.wait(10)
        yield reader
        mapper.let.release(100)


def test_every_frame_is_read_in_order_on_a_thread_of_its_own() -> None:
    mapper = Mapper()
    mapper.let.release(20)
    with ReadingThread(mapper, 20) as reader:
        for index in range(20):
            reader.observe(*frame(index))
    assert mapper.read_frames == list(range(20))
    assert mapper.threads == {"reading"}
    assert reader.dropped == 0


def test_a_full_queue_drops_the_oldest_counts_it_and_never_waits() -> None:
    mapper = Mapper()
    with while_the_first_is_read(mapper, 3) as reader, at_most(1.0):
        for index in range(1, 11):
            reader.observe(*frame(index))
    assert mapper.read_frames == [0, 8, 9, 10]
    assert reader.dropped == 7


def test_of_a_camera_the_newest_is_read_first_and_others_when_none_newer_comes() -> None:
    mapper = Mapper()
    with while_the_first_is_read(mapper, 4, newest_first=True) as reader:
        with at_most(1.0):
            for index in range(1, 5):
                reader.observe(*frame(index))
        mapper.is_reading.clear()
        mapper.let.release()
        assert mapper.is_reading.wait(10)
        mapper.let.release()
        while len(mapper.read_frames) < 2:
            time.sleep(0.01)
    assert mapper.read_frames[:2] == [0, 4]
    assert sorted(mapper.read_frames) == [0, 1, 2, 3, 4]
    assert reader.dropped == 0


def test_where_too_many_wait_those_stay_that_are_apart_and_all_are_read_at_the_end() -> None:
    mapper = Mapper()
    with while_the_first_is_read(mapper, 4, newest_first=True) as reader:
        for index in (10, 20, 21, 30, 40, 41, 50):
            reader.observe(*frame(index))
        reader._closing = True
    assert mapper.read_frames == sorted(mapper.read_frames)
    assert (mapper.read_frames[:2], mapper.read_frames[-1], reader.dropped) == ([0, 10], 50, 3)
    assert min(np.diff(mapper.read_frames)) >= 9


def test_all_but_the_newest_wait_packed_and_are_read_as_they_were() -> None:
    mapper = Mapper()
    with while_the_first_is_read(mapper, 20, newest_first=True) as reader:
        for index in range(1, 11):
            reader.observe(*frame(index))
        mapper.is_reading.clear()
        mapper.let.release()
        # The next one is being read: what waited beside it has been packed.
        assert mapper.is_reading.wait(10)
        kinds = [type(each) for each, _ in reader._queue]
    assert kinds == [PackedFrame] * 6 + [RgbdFrame] * 3
    assert sorted(mapper.read_frames) == list(range(11))
    assert {each.rgb.shape for each in mapper.frames} == {(2, 2, 3)}


def test_what_waits_takes_no_more_than_it_may() -> None:
    mapper = Mapper()
    seen, _ = frame(0)
    three = 3 * (seen.rgb.nbytes + seen.depth.nbytes)
    with ReadingThread(mapper, 100, newest_first=True, queue_bytes=three) as reader:
        reader.observe(*frame(0))
        assert mapper.is_reading.wait(10)
        for index in range(1, 11):
            reader.observe(*frame(index))
        assert len(reader._queue) == 3
        assert reader.dropped == 7
        mapper.let.release(100)


def test_frames_that_are_not_worth_reading_take_no_place() -> None:
    mapper = Mapper()
    mapper.let.release(10)
    with ReadingThread(mapper, 1) as reader:
        for index in range(10):
            reader.observe(*frame(index, is_tracked=False))
    assert mapper.read_frames == []
    assert reader.dropped == 0


def test_an_error_is_raised_at_the_next_frame_and_not_only_after_hours() -> None:
    mapper = Mapper(fails_at=0)
    mapper.let.release(10)
    offered: list[int] = []

    def run() -> None:
        with ReadingThread(mapper, 1000) as reader:
            for index in range(1000):
                reader.observe(*frame(index))
                offered.append(index)
                time.sleep(0.005)

    with pytest.raises(ValueError, match="broken reader"):
        run()
    assert len(offered) < 1000


def test_an_error_in_the_last_frame_is_raised_on_leaving() -> None:
    mapper = Mapper(fails_at=0)

    def run() -> None:
        with ReadingThread(mapper, 3) as reader:
            reader.observe(*frame(0))
            mapper.let.release()

    with pytest.raises(ValueError, match="broken reader"):
        run()


def test_an_exception_on_its_way_abandons_the_queue_and_waits_for_nobody() -> None:
    mapper = Mapper()

    def run() -> None:
        with ReadingThread(mapper, 3) as reader:
            for index in range(3):
                reader.observe(*frame(index))
            assert mapper.is_reading.wait(10)
            raise KeyboardInterrupt

    with at_most(5.0), pytest.raises(KeyboardInterrupt):
        run()
    mapper.let.release(10)
    time.sleep(0.1)
    assert mapper.read_frames == [0], "what was queued is not read"


def test_entering_and_leaving_without_a_frame_ends_the_thread() -> None:
    before = threading.active_count()
    for _ in range(20):
        with at_most(2.0), ReadingThread(Mapper(), 1):
            pass
    assert threading.active_count() == before


def test_who_waits_for_a_place_loses_no_frame() -> None:
    mapper = Mapper()
    with ReadingThread(mapper, 3) as reader:
        reader.observe(*frame(0))
        assert mapper.is_reading.wait(10)
        for index in range(1, 4):
            reader.observe(*frame(index))
        threading.Timer(0.2, mapper.let.release, [100]).start()
        started = time.monotonic()
        reader.wait_for_place()
        assert time.monotonic() - started > 0.1
        reader.observe(*frame(4))
    assert mapper.read_frames == [0, 1, 2, 3, 4]
    assert reader.dropped == 0


def test_nobody_waits_for_a_place_with_a_reader_that_broke() -> None:
    mapper = Mapper(fails_at=0)
    reader = ReadingThread(mapper, 1)
    reader.__enter__()
    reader.observe(*frame(0))
    assert mapper.is_reading.wait(10)
    reader.observe(*frame(1))
    mapper.let.release()
    with at_most(5.0):
        reader.wait_for_place()
    with pytest.raises(ValueError, match="broken reader"):
        reader.observe(*frame(2))


def test_what_is_abandoned_is_not_read_and_counted() -> None:
    mapper = Mapper()
    with ReadingThread(mapper, 5) as reader:
        for index in range(4):
            reader.observe(*frame(index))
        assert mapper.is_reading.wait(10)
        reader.abandon()
        mapper.let.release(100)
    assert mapper.read_frames == [0]
    assert reader.dropped == 3
