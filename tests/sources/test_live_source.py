"""Connected cameras: dropped frames are counted, unplugged ones are waited for, and Ctrl-C always ends."""

import errno
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from recordings import HEIGHT, WIDTH, picture

from lpslam import pipeline
from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.frames import FrameSource, RgbdFrame
from lpslam.sources.in_order import InOrder
from lpslam.sources.live.driver import Shot, UnpluggedError
from lpslam.sources.live.source import LiveSource, camera_in
from lpslam.sources.open import open_source
from lpslam.sources.writing.mcap_recording import McapSink
from lpslam.sources.writing.recordings import written


class Scripted:
    """A driver that does what a script says: a shot's number and time, None for silence, or "unplugged"."""

    def __init__(self, script: list[object], pause: float = 0.0, absent: int = 0) -> None:
        self.name = "scripted"
        self.camera = PinholeCamera(WIDTH, HEIGHT, 50.0, 50.0, 31.5, 23.5)
        self.starts = self.stops = 0
        self._script: Iterator[object] = iter(script)
        self._pause, self._absent = pause, absent

    def start(self) -> None:
        self.starts += 1
        if self.starts <= self._absent:
            raise UnpluggedError("it is not there")

    def wait(self, seconds: float) -> Shot | None:
        time.sleep(self._pause)
        step = next(self._script, None)
        if step is None:
            time.sleep(min(seconds, 0.02))
            return None
        if step == "unplugged":
            self._absent = self.starts + 1
            raise UnpluggedError("it is gone")
        assert isinstance(step, tuple)
        number, timestamp = step
        width, height = self.camera.width, self.camera.height
        return Shot(number, timestamp, picture(number, width, height), np.full((height, width), 2000, np.uint16))

    def registered(self, depth: np.ndarray) -> np.ndarray:
        return depth.astype(np.float32) / 1000

    def stop(self) -> None:
        self.stops += 1


def test_frames_come_as_the_camera_gives_them() -> None:
    driver = Scripted([(number, number / 30) for number in range(5)], pause=0.02)
    source = LiveSource(driver, backlog=10, max_frames=5)
    assert isinstance(source, FrameSource)
    assert camera_in(InOrder(source)) is source
    frames = list(source)
    assert [frame.index for frame in frames] == [0, 1, 2, 3, 4]
    assert [frame.timestamp for frame in frames] == [number / 30 for number in range(5)]
    np.testing.assert_array_equal(frames[3].rgb, picture(3))
    assert frames[3].depth.max() == 2.0
    assert source.dropped == 0
    assert (driver.starts, driver.stops) == (1, 1)


def test_what_comes_too_fast_and_what_the_camera_leaves_out_is_counted() -> None:
    script: list[object] = [(number, number / 30) for number in (0, 1, 2, 6, 7, 8, 9)]
    source = LiveSource(Scripted(script, pause=0.002), backlog=2, max_frames=3)
    found = []
    for frame in source:
        found.append(frame.timestamp)
        time.sleep(0.2)
    # Three that the camera left out, and of the four behind the first two those that had no room.
    assert found[1:] == [8 / 30, 9 / 30]
    assert source.dropped == 3 + 4


def test_a_camera_that_is_plugged_in_again_goes_on(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("lpslam.sources.live.source._RETRY", 0.05)
    script: list[object] = [(7, 100.0), (8, 100.033), "unplugged", (0, 0.0), (1, 0.033)]
    driver = Scripted(script, pause=0.01)
    source = LiveSource(driver, backlog=10, max_frames=4)
    times = [frame.timestamp for frame in source]
    assert times[:2] == [100.0, 100.033]
    assert times[2] - times[1] == pytest.approx(0.15, abs=0.15), "its clock began anew"
    assert times[3] - times[2] == pytest.approx(0.033, abs=1e-6)
    assert source.dropped == 0
    assert driver.starts == 3
    assert "it is gone; waiting for it to come back" in caplog.text
    assert "it is back" in caplog.text


def test_a_camera_that_is_silent_or_gone_can_be_stopped() -> None:
    for script in ([], [(0, 0.0), "unplugged"]):
        stopped = threading.Event()
        source = LiveSource(Scripted(script), backlog=2)
        source.stop_when(stopped.is_set)
        threading.Timer(0.3, stopped.set).start()
        begun = time.monotonic()
        assert len(list(source)) <= 1
        assert time.monotonic() - begun < 2.0


def test_a_camera_that_is_stopped_before_its_first_picture_is_no_mistake() -> None:
    stopped = threading.Event()
    threading.Timer(0.3, stopped.set).start()
    world = pipeline.run(LiveSource(Scripted([]), backlog=2), text=False, should_stop=stopped.is_set)
    assert world.trajectory.tracked_count == 0
    # One that ends by itself without any is.
    with pytest.raises(UserError, match="none of 0 frames"):
        pipeline.run(LiveSource(Scripted([]), backlog=2, max_frames=0), text=False)


def test_a_camera_that_is_not_there_is_one_line() -> None:
    with pytest.raises(UserError, match="scripted: it is not there; plug it in"):
        list(LiveSource(Scripted([], absent=1)))


@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()])
def test_a_recording_that_is_broken_off_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException
) -> None:
    add = McapSink.add

    def filling(sink: McapSink, frame: RgbdFrame) -> None:
        if frame.index == 4:
            raise error
        add(sink, frame)

    monkeypatch.setattr(McapSink, "add", filling)
    driver = Scripted([(number, number / 30) for number in range(6)], pause=0.02)
    driver.camera = PinholeCamera(640, 480, 500.0, 500.0, 319.5, 239.5)
    with pytest.raises((UserError, KeyboardInterrupt)):
        written(LiveSource(driver, backlog=10), tmp_path / "walk.mcap", keeps_part=True)
    assert [path.name for path in tmp_path.iterdir()] == ["walk.partial.mcap"]
    frames = list(open_source(tmp_path / "walk.partial.mcap"))
    assert 3 <= len(frames) <= 4
    np.testing.assert_array_equal(frames[2].rgb, picture(2, 640, 480))
    with pytest.raises(UserError, match="of a recording that was broken off"):
        written(LiveSource(driver, backlog=10), tmp_path / "walk.mcap", keeps_part=True)


def test_what_breaks_in_the_driver_reaches_the_consumer() -> None:
    source = LiveSource(Scripted([(0, 0.0), 5]), backlog=2)
    with pytest.raises(AssertionError):
        list(source)
