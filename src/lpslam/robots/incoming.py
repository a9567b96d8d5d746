"""Pictures of a robot's camera, paired by time as they come, and the frames that they make."""

import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from queue import Empty, Full, Queue
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import PairingConfig
from lpslam.errors import LpSlamError
from lpslam.robots.types import BadBytesError, decoded
from lpslam.sources.bags.lenses import MILLIMETRES
from lpslam.sources.bags.messages import stamp_of
from lpslam.sources.bags.pictures import colour_of, depth_of, in_metres
from lpslam.sources.pairing import Paired, Stamped, paired

_WAIT = 0.1
"""Seconds between two questions whether to stop."""
_OUT_OF_ORDER = 10**9
"""Nanoseconds by which a picture may come too late: the network changes their order."""
_REASONS = 50
"""Reasons that are told apart; a hostile sender could give endlessly many."""


class Skipped:
    """What could not be used, counted by its reason; safe in threads."""

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()
        self._lock = threading.Lock()

    def note(self, reason: str) -> None:
        """Count one."""
        with self._lock:
            known = reason in self._counts or len(self._counts) < _REASONS
            self._counts[reason if known else "other reasons"] += 1

    @property
    def total(self) -> int:
        """How many, for whatever reason."""
        return self._counts.total()

    def said(self) -> str:
        """One line: how many for the most frequent reasons."""
        with self._lock:
            return "; ".join(f"{count} × {reason}" for reason, count in self._counts.most_common(3))


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """A message whose pixels are not unpacked yet."""

    message: Any
    nanoseconds: int


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """A frame of a robot's camera.

    Attributes:
        nanoseconds, frame_id: as its colour picture's header says.
        rgb: (height, width, 3) uint8.
        depth: (height, width) float32 metres; 0 where there is none.
    """

    nanoseconds: int
    frame_id: str
    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]


class Incoming:
    """Takes pictures from any thread and gives frames; of frames that come too fast the newest.

    Args:
        pairing: how far apart in time the two of a pair may be, and how many wait.
        backlog: pairs that may wait.

    Attributes:
        skipped: what could not be used.
        dropped: pairs that were left out because they came too fast.
        pairs: how many there were.
        heard: when a picture of a kind came last, by `time.monotonic`; by whether it is depth.
    """

    def __init__(self, pairing: PairingConfig, backlog: int) -> None:
        self.skipped, self.dropped, self.pairs = Skipped(), 0, 0
        self.heard: dict[bool, float] = {}
        self._newest: dict[bool, tuple[int, int]] = {}
        self._pairing = pairing
        self._arriving: Queue[Stamped[Picture]] = Queue(2 * self._pairing.buffer)
        self._waiting: deque[Paired[Picture]] = deque()
        self._backlog = backlog
        self._is_there = threading.Condition()
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._pair, name="pairing", daemon=True)
        self._thread.start()

    def put(self, data: bytes, kind: str, *, is_depth: bool) -> None:
        """Take the bytes of an `Image` or a `CompressedImage`."""
        self.heard[is_depth] = time.monotonic()
        try:
            message = decoded(data, kind)
            stamp = stamp_of(message)
        except BadBytesError as error:
            self.skipped.note(str(error))
            return
        if self._is_gone_by(stamp, is_depth):
            self.skipped.note("its time lies far before that of a picture before it: the clock went backwards")
            return
        try:
            self._arriving.put_nowait(Stamped(stamp / 1e9, is_depth, Picture(message, stamp)))
        except Full:
            self.dropped += 1

    def _is_gone_by(self, stamp: int, is_depth: bool) -> bool:
        """Whether a picture's time is long over; a clock that stays there is believed."""
        newest, old = self._newest.get(is_depth, (stamp, 0))
        if stamp >= newest - _OUT_OF_ORDER or old >= self._pairing.buffer:
            self._newest[is_depth] = (max(stamp, newest) if old < self._pairing.buffer else stamp, 0)
            return False
        self._newest[is_depth] = (newest, old + 1)
        return True

    def shots(self, camera: PinholeCamera, should_stop: Callable[[], bool]) -> Iterator[Shot | None]:
        """The frames, as they come; None now and then while none does."""
        while not should_stop() and not self._stopped.is_set():
            with self._is_there:
                if not self._waiting:
                    self._is_there.wait(_WAIT)
                pair = self._waiting.popleft() if self._waiting else None
            yield None if pair is None else self._shot(pair, camera)

    def close(self) -> None:
        """End the thread that pairs."""
        self._stopped.set()
        self._thread.join(timeout=5.0)

    def _pair(self) -> None:
        for pair in paired(self._pictures(), self._pairing):
            if pair.fault:
                self.skipped.note(_kind_of(pair.fault))
                continue
            with self._is_there:
                self.pairs += 1
                self._waiting.append(pair)
                if len(self._waiting) > self._backlog:
                    self._waiting.popleft()
                    self.dropped += 1
                self._is_there.notify()

    def _pictures(self) -> Iterator[Stamped[Picture]]:
        while not self._stopped.is_set():
            try:
                yield self._arriving.get(timeout=_WAIT)
            except Empty:
                continue

    def _shot(self, pair: Paired[Picture], camera: PinholeCamera) -> Shot | None:
        colour = pair.colour
        try:
            rgb = colour_of(colour.message)
            depth = (
                np.zeros(rgb.shape[:2], np.float32)
                if pair.depth is None
                else in_metres(depth_of(pair.depth.message), MILLIMETRES)
            )
        except (LpSlamError, cv2.error) as error:
            self.skipped.note(str(error).split(chr(10))[0])
            return None
        for what, found in (("colour", rgb.shape[:2]), ("depth", depth.shape)):
            if found != (camera.height, camera.width):
                size = f"{camera.width}×{camera.height}"
                self.skipped.note(f"its {what} is {found[1]}×{found[0]}; the camera is {size}")
                return None
        return Shot(colour.nanoseconds, str(colour.message.header.frame_id), rgb, depth)


def _kind_of(fault: str) -> str:
    """Faults that differ in a time are of one kind."""
    return "it repeats the time of the one before" if "timestamp" in fault else fault
