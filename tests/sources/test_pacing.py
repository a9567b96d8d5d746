"""Frames at a camera's pace."""

import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

from lpslam.camera import PinholeCamera
from lpslam.frames import FrameFault, FrameSource, RgbdFrame
from lpslam.sources.pacing import Paced

INTERVAL = 0.05
BEGIN = 1_700_000_000.0  # recordings count seconds from 1970


class Recording:
    """Frames that are there as soon as they are asked for, or `seconds` later."""

    name = "recording"
    camera = PinholeCamera(4, 3, 1, 1, 1, 1)

    def __init__(self, frames: int, seconds: float = 0.0) -> None:
        self.frames, self.seconds = frames, seconds
        self.faults: list[FrameFault] = [FrameFault(7, 0.0, "torn")]
        self.began = 0.0

    def __len__(self) -> int:
        return self.frames

    def __iter__(self) -> Iterator[RgbdFrame]:
        for index in range(self.frames):
            time.sleep(self.seconds)
            image = np.zeros((3, 4, 3), np.uint8)
            self.began = self.began or time.perf_counter()
            yield RgbdFrame(index, BEGIN + index * INTERVAL, image, np.zeros((3, 4), np.float32))


def consume(paced: Paced, seconds: float) -> list[tuple[int, float]]:
    """Index of each frame and when it came, seconds after the source gave the first; each is worked on for so long."""
    assert isinstance(paced.source, Recording)
    came = []
    for frame in paced:
        came.append((frame.index, time.perf_counter()))
        time.sleep(seconds)
    return [(index, at - paced.source.began) for index, at in came]


def test_it_is_a_source_and_says_what_its_source_says() -> None:
    paced = Paced(Recording(12))
    assert isinstance(paced, FrameSource)
    assert (paced.name, len(paced), paced.camera) == ("recording", 12, Recording.camera)
    assert [fault.reason for fault in paced.faults] == ["torn"]


def test_no_frame_comes_before_its_time_and_a_quick_consumer_gets_them_all() -> None:
    paced = Paced(Recording(12))
    came = consume(paced, 0.0)
    # A busy machine may be late by several frames, and then drops some; it is never early.
    assert all(at >= index * INTERVAL - 0.002 for index, at in came)
    assert came[-1][0] == 11
    assert len(came) + paced.dropped == 12
    assert len(came) >= 8


def test_a_slow_consumer_gets_the_newest_frame_and_the_rest_are_counted() -> None:
    paced = Paced(Recording(24))
    came = consume(paced, 2.5 * INTERVAL)
    indices = [index for index, _ in came]
    assert indices == sorted(set(indices))
    assert indices[0] == 0
    assert indices[-1] == 23, "where the recording ends is always seen"
    assert len(indices) + paced.dropped == 24
    assert 11 <= paced.dropped <= 18
    for index, at in came[1:-1]:
        # What is given is the newest of those whose time had come: at most one interval old.
        assert index * INTERVAL - 0.002 <= at < (index + 1) * INTERVAL + 0.04


def test_a_consumer_that_hangs_once_goes_on_with_the_present() -> None:
    paced = Paced(Recording(20))
    indices = []
    for frame in paced:
        indices.append(frame.index)
        if frame.index == 3:
            time.sleep(8.4 * INTERVAL)
    assert indices[:4] == [0, 1, 2, 3]
    assert 11 <= indices[4] <= 13
    assert len(indices) + paced.dropped == 20


@pytest.mark.parametrize("frames", [0, 1])
def test_none_and_one(frames: int) -> None:
    paced = Paced(Recording(frames))
    started = time.perf_counter()
    assert [frame.index for frame in paced] == list(range(frames))
    assert time.perf_counter() - started < 0.5
    assert paced.dropped == 0


def test_a_backlog_bridges_a_delay_without_a_gap() -> None:
    paced = Paced(Recording(20), backlog=4)
    came = []
    for frame in paced:
        came.append((frame.index, time.perf_counter()))
        if frame.index == 3:
            time.sleep(3.2 * INTERVAL)
    # Four frames came in the meantime: with a place for one, two or three of them were lost.
    assert paced.dropped <= 1
    assert len(came) + paced.dropped == 20
    assert isinstance(paced.source, Recording)
    assert paced.source.began + came[-1][0] * INTERVAL - 0.002 <= came[-1][1]


def test_a_backlog_is_no_longer_than_it_was_made() -> None:
    paced = Paced(Recording(20), backlog=2)
    indices = []
    for frame in paced:
        indices.append(frame.index)
        if frame.index == 3:
            time.sleep(8.4 * INTERVAL)
    assert 10 <= indices[4] <= 12
    assert len(indices) + paced.dropped == 20


def test_a_queue_of_none_is_refused() -> None:
    with pytest.raises(ValueError, match="none"):
        Paced(Recording(1), backlog=0)


def test_a_pause_of_the_recording_is_no_wait_for_whoever_stops() -> None:
    stop = threading.Event()
    recording = Recording(3)
    paced = Paced(Pausing(recording, 60.0), should_stop=stop.is_set)
    frames = iter(paced)
    assert next(frames).index == 0
    threading.Timer(0.2, stop.set).start()
    started = time.perf_counter()
    assert next(frames).index == 1
    assert time.perf_counter() - started < 2.0


class Pausing:
    """A recording whose second frame comes so many seconds after the first."""

    name = "pausing"
    camera = Recording.camera
    faults: ClassVar[list[FrameFault]] = []

    def __init__(self, recording: Recording, seconds: float) -> None:
        self.recording, self.seconds = recording, seconds

    def __len__(self) -> int:
        return len(self.recording)

    def __iter__(self) -> Iterator[RgbdFrame]:
        for frame in self.recording:
            yield replace(frame, timestamp=frame.timestamp + self.seconds * (frame.index > 0))
