"""Frames of a connected camera, until somebody says stop."""

import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from lpslam.errors import UserError
from lpslam.frames import FrameFault, PassedOn, RgbdFrame
from lpslam.sources.live.driver import Driver, Shot, UnpluggedError

logger = logging.getLogger(__name__)

_WAIT = 0.1
"""Seconds between two questions whether to stop."""
_RETRY = 0.5
"""Seconds between two looks whether the camera is plugged in again."""
_SILENCE = 5.0
"""Seconds without a picture after which it is said that none comes."""


class LiveSource:
    """A `FrameSource` over a connected camera; each iteration begins when it is asked for.

    A thread of its own takes what the camera delivers. A consumer that is late gets the newest frames; older ones are
    dropped and counted, and so are those that the camera itself left out. When the camera is unplugged, frames go on
    as soon as it is plugged in again, with times that rise on.

    Args:
        driver: the camera.
        backlog: frames that may wait; one more drops the oldest.
        max_frames: end after so many; endless without.

    Attributes:
        backlog: as given.
        dropped: frames that were left out, in the running (or last) iteration.
        faults: none: what cannot be used is not delivered.
        timestamps: none is known beforehand.
        notes, listed_times: nothing is assumed.
    """

    def __init__(self, driver: Driver, backlog: int = 2, max_frames: int | None = None) -> None:
        self.name, self.camera = driver.name, driver.camera
        self.dropped = 0
        self.faults: list[FrameFault] = []
        self.timestamps: list[float] = []
        self.notes: tuple[str, ...] = ()
        self.listed_times: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None
        self.backlog = backlog
        self._driver, self._max_frames = driver, max_frames
        self._should_stop: Callable[[], bool] = lambda: False

    def __len__(self) -> int:
        """How many will come: not known, 0, without a limit."""
        return self._max_frames or 0

    def stop_when(self, asked: Callable[[], bool]) -> None:
        """End an iteration when this says yes, also while no picture comes."""
        self._should_stop = asked

    def __iter__(self) -> Iterator[RgbdFrame]:
        """Yield frames as they come.

        Raises:
            UserError: the camera is not there when it begins.
        """
        self.dropped = 0
        try:
            self._driver.start()
        except UnpluggedError as error:
            raise UserError(f"{self.name}: {error}; plug it in and try again") from error
        intake = _Intake(self._driver, self.backlog)
        try:
            index = 0
            while (self._max_frames is None or index < self._max_frames) and not self._should_stop():
                shot = intake.next(_WAIT)
                self.dropped = intake.dropped
                if shot is None:
                    continue
                yield RgbdFrame(index, shot.timestamp, shot.rgb, self._driver.registered(shot.depth))
                index += 1
        finally:
            intake.close()
            self._driver.stop()

    def frame(self, index: int) -> RgbdFrame | None:
        """None: what is over is over."""
        return None

    def sample_depths(self, count: int) -> list[NDArray[np.float32]]:
        """None yet."""
        return []


class _Intake:
    """The thread that takes what a camera delivers."""

    def __init__(self, driver: Driver, backlog: int) -> None:
        self.dropped = 0
        self._driver = driver
        self._waiting: deque[Shot] = deque()
        self._backlog = backlog
        self._is_there = threading.Condition()
        self._stopped = threading.Event()
        self._error: BaseException | None = None
        self._offset = 0.0
        self._latest: tuple[int, float, float] | None = None
        self._thread = threading.Thread(target=self._run, name=f"camera {driver.name}", daemon=True)
        self._thread.start()

    def next(self, seconds: float) -> Shot | None:
        """The oldest shot that waits; None where none comes in time."""
        with self._is_there:
            if not self._waiting:
                self._is_there.wait(seconds)
            if self._waiting:
                return self._waiting.popleft()
            if self._error is not None:
                raise self._error
            return None

    def close(self) -> None:
        """End the thread."""
        self._stopped.set()
        self._thread.join(timeout=5.0)

    def _run(self) -> None:
        try:
            self._take()
        except BaseException as error:
            # Whatever it is belongs to the consumer, who would otherwise wait for ever.
            with self._is_there:
                self._error = error
                self._is_there.notify()

    def _take(self) -> None:
        heard = time.monotonic()
        while not self._stopped.is_set():
            try:
                shot = self._driver.wait(_WAIT)
            except UnpluggedError as error:
                logger.warning("%s: %s; waiting for it to come back", self._driver.name, error)
                self._come_back()
                heard = time.monotonic()
                continue
            if shot is not None:
                heard = time.monotonic()
                self._put(shot)
            elif time.monotonic() - heard > _SILENCE:
                logger.warning("%s: no picture for %.0f s", self._driver.name, _SILENCE)
                heard = time.monotonic() + 3600.0

    def _come_back(self) -> None:
        self._driver.stop()
        while not self._stopped.wait(_RETRY):
            try:
                self._driver.start()
            except UnpluggedError:
                continue
            logger.warning("%s: it is back", self._driver.name)
            if self._latest is not None:
                # Its clock and its count may begin anew.
                self._latest = (-1, *self._latest[1:])
            return

    def _put(self, shot: Shot) -> None:
        now = time.monotonic()
        if self._latest is not None:
            number, timestamp, taken = self._latest
            if number < 0:
                self._offset = timestamp + (now - taken) - shot.timestamp
            else:
                self.dropped += max(shot.number - number - 1, 0)
        shot = Shot(shot.number, shot.timestamp + self._offset, shot.rgb, shot.depth)
        self._latest = (shot.number, shot.timestamp, now)
        with self._is_there:
            self._waiting.append(shot)
            if len(self._waiting) > self._backlog:
                self._waiting.popleft()
                self.dropped += 1
            self._is_there.notify()


def camera_in(source: object) -> LiveSource | None:
    """The camera behind a source and all that is around it; None where it is a recording."""
    while isinstance(source, PassedOn):
        source = source.source
    return source if isinstance(source, LiveSource) else None
