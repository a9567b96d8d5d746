"""Frames from a file of messages, read as a stream."""

import logging
from bisect import bisect_left
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import PairingConfig
from lpslam.errors import UserError
from lpslam.frames import FrameFault, RgbdFrame
from lpslam.sources.bags import realsense
from lpslam.sources.bags.containers.container import Container, Message
from lpslam.sources.bags.messages import BadMessageError, decoded, stamp_of
from lpslam.sources.bags.pictures import colour_of, depth_of, in_metres
from lpslam.sources.bags.rig import BagRig, rig_of
from lpslam.sources.bags.topics import TopicChoice, chosen_topics
from lpslam.sources.clocks import power_of_ten_between
from lpslam.sources.images import BadImageError
from lpslam.sources.pairing import Paired, Stamped, paired
from lpslam.sources.registering.registration import DepthRegistration

logger = logging.getLogger(__name__)

_AROUND = (12 * 10**7, 10**9)
"""Nanoseconds around a frame in which its pictures were recorded, usually and at most, where one frame is sought."""
_SECOND = 10**9


class BagSource:
    """A `FrameSource` over a container.

    Memory does not grow with the recording: pictures are decoded when their frame's turn has come, and at most
    `PairingConfig.buffer` of a kind wait.

    Args:
        container: the file.
        choice: topics that a user asked for.
        camera_file: a calibration to use instead of the recording's.
        start, end: seconds from the recording's first colour picture; all of it without.
        max_frames: use only so many frames, from the first.
        pairing: how colour and depth are paired; the defaults without.

    Raises:
        UserError: there is no colour or no depth, they cannot be registered, or nothing lies between start and end.
    """

    def __init__(
        self,
        container: Container,
        choice: TopicChoice | None = None,
        camera_file: Path | None = None,
        *,
        start: float | None = None,
        end: float | None = None,
        max_frames: int | None = None,
        pairing: PairingConfig | None = None,
    ) -> None:
        if max_frames is not None and max_frames < 1:
            raise UserError(f"{container.path}: the number of frames is limited to {max_frames}; it must be at least 1")
        self._container = container
        self._topics = chosen_topics(container, choice or TopicChoice())
        self._colour, self._depth = self._topics.colour.name, self._topics.depth.name
        self._max_frames, self._pairing = max_frames, pairing or PairingConfig()
        self._rig: BagRig = rig_of(container, self._topics, camera_file)
        self._register = DepthRegistration(self._rig.splat) if self._rig.splat is not None else None
        self._metadata = realsense.capture_times(container, (self._colour, self._depth))
        self._faults: list[FrameFault] = []
        times = container.times(self._colour)
        self._start, self._end = self._bounds(times, start, end)
        self._logged = times[bisect_left(times, self._start) : bisect_left(times, self._end)][:max_frames]
        if not self._logged:
            raise UserError(f"{container.path}: no colour picture lies between --from and --to ({len(times)} in all)")
        self._by_log = self._stamps_are_missing()
        self._too_fast = Fraction(1) if self._by_log or self._metadata else self._speed_of_stamps()
        self.camera: PinholeCamera = replace(self._rig.colour, fps=self._rate())
        self.notes = tuple(self._rig.notes)
        self.listed_times: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None
        for note in self.notes:
            logger.warning("%s: %s", self.name, note)

    @property
    def name(self) -> str:
        """The file's name."""
        return self._container.path.stem if self._container.path.is_file() else self._container.path.resolve().name

    @property
    def faults(self) -> list[FrameFault]:
        """Frames skipped so far in the running (or last) iteration."""
        return self._faults

    @property
    def timestamps(self) -> list[float]:
        """Seconds, when the colour picture of each frame was recorded, in order."""
        return [logged / _SECOND for logged in self._logged]

    def __len__(self) -> int:
        return len(self._logged)

    def __iter__(self) -> Iterator[RgbdFrame]:
        """Yield the frames that can be decoded, as far as the file can be read.

        Raises:
            UserError: at the end, if not one frame could be used.
        """
        self._faults = faults = []
        count = with_depth = 0
        for index, pair in enumerate(paired(self._stamped(self._start, self._end), self._pairing)):
            if self._max_frames is not None and index >= self._max_frames:
                break
            count += 1
            with_depth += not pair.fault
            try:
                yield self._decoded(index, pair)
            except (BadImageError, BadMessageError) as error:
                faults.append(FrameFault(index, pair.timestamp, str(error)))
        if len(faults) == count:
            first = f"; the first: {faults[0].reason}" if faults else ""
            apart = self._apart() if faults and not with_depth else ""
            raise UserError(f"{self.name}: none of its {count} frames can be used{first}{apart}")

    def _apart(self) -> str:
        """How far apart colour and depth begin, where no picture of one is near one of the other."""
        firsts: dict[bool, float] = {}
        for picture in self._stamped(self._start, self._end):
            firsts.setdefault(picture.is_depth, picture.timestamp)
            if len(firsts) == 2:
                seconds = abs(firsts[True] - firsts[False])
                return f"; colour and depth begin {seconds:.3f} s apart and must use the same clock"
        return ""

    def frame(self, index: int) -> RgbdFrame | None:
        """The frame whose colour picture was recorded as the index-th; None if it cannot be used."""
        if not 0 <= index < len(self._logged):
            return None
        logged = self._logged[index]
        for around in _AROUND:
            for pair in paired(self._stamped(logged - around, logged + around), self._pairing):
                if pair.colour.logged == logged and (not pair.fault or around == _AROUND[-1]):
                    try:
                        return self._decoded(index, pair)
                    except (BadImageError, BadMessageError):
                        return None
        return None

    def sample_depths(self, count: int) -> list[NDArray[np.float32]]:
        """Depth images (height, width) in metres, spread over the recording, as they come before registration."""
        depths = []
        for row in np.unique(np.linspace(0, len(self._logged) - 1, count).astype(int)):
            logged = self._logged[row]
            message = next(self._container.messages([self._depth], logged, logged + _AROUND[-1]), None)
            try:
                if message is not None:
                    depths.append(in_metres(depth_of(decoded(message)), self._rig.depth_scale))
            except (BadImageError, BadMessageError):
                continue
        return depths

    def _bounds(self, times: list[int], start: float | None, end: float | None) -> tuple[int, int]:
        first = times[0] if times else 0
        begin = -(1 << 62) if start is None else first + round(start * _SECOND)
        return begin, (1 << 62) if end is None else first + round(end * _SECOND) + 1

    def _stamped(self, start: int, end: int) -> Iterator[Stamped[Message]]:
        """Pictures of both kinds with the times at which they were taken."""
        names = [self._colour, self._depth, *self._metadata]
        messages = self._container.messages(names, start, end)
        timed = (
            realsense.with_capture_times(messages, self._metadata) if self._metadata else ((m, None) for m in messages)
        )
        for message, taken in timed:
            stamp = self._stamp(message) if taken is None else taken
            yield Stamped(stamp / _SECOND, message.topic.name == self._depth, message)

    def _stamp(self, message: Message) -> int:
        if self._by_log:
            return message.logged
        try:
            return round(stamp_of(decoded(message)) / self._too_fast)
        except (BadMessageError, AttributeError):
            return message.logged

    def _speed_of_stamps(self) -> Fraction:
        """How many times faster than the clock of the recording the headers count, in powers of a thousand."""
        stamps: list[int] = []
        logged: list[int] = []
        for message in islice(self._container.messages([self._colour], self._start, self._end), _COMPARED):
            with suppress(BadMessageError, AttributeError):
                stamps.append(stamp_of(decoded(message)))
                logged.append(message.logged)
        power = power_of_ten_between(stamps, logged)
        if power:
            logger.warning("%s: its pictures' times are in another unit; they are taken times 1e%d", self.name, -power)
        return Fraction(10) ** power

    def _stamps_are_missing(self) -> bool:
        """Whether the headers of the first pictures carry no time, or all the same: then recording times stand in."""
        stamps: list[int] = []
        for name in (self._colour, self._depth):
            of_topic: list[int] = []
            for message in self._container.messages([name]):
                try:
                    of_topic.append(stamp_of(decoded(message)))
                except (BadMessageError, AttributeError):
                    continue
                if len(of_topic) == _STAMPS:
                    break
            stamps.append(len(set(of_topic)) if len(of_topic) > 1 else 2)
        is_missing = min(stamps) == 1
        if is_missing and not self._metadata:
            logger.warning("%s: its pictures carry no time of their own; the times of recording are used", self.name)
        return is_missing

    def _rate(self) -> float:
        """Frames a second, by what lies between the first ones; 30 where that is no camera's."""
        colours = (each for each in self._stamped(self._start, self._end) if not each.is_depth)
        stamps = [each.timestamp for each in islice(colours, _RATED)]
        between = float(np.median(np.diff(stamps))) if len(stamps) > 2 else 0.0
        return round(1 / between, 3) if 1 / 300 < between < 2 else 30.0

    def _decoded(self, index: int, pair: Paired[Message]) -> RgbdFrame:
        if pair.fault:
            raise BadImageError(pair.fault)
        wanted = (self.camera.height, self.camera.width)
        rgb = colour_of(decoded(pair.colour))
        _refuse_size("colour", rgb.shape[:2], wanted)
        if pair.depth is None:
            return RgbdFrame(index, pair.timestamp, rgb, np.zeros(wanted, np.float32))
        depth = in_metres(depth_of(decoded(pair.depth)), self._rig.depth_scale)
        if self._register is not None and self._rig.splat is not None:
            expected = self._rig.splat.depth_camera
            _refuse_size("depth", depth.shape, (expected.height, expected.width))
            depth = self._register(depth)
        _refuse_size("depth", depth.shape, wanted)
        return RgbdFrame(index, pair.timestamp, rgb, depth)


_COMPARED = 30
"""Pictures whose stamps are compared with when they were recorded: a second."""
_STAMPS = 3
"""Pictures whose stamps are compared."""
_RATED = 9
"""Frames that tell how many come in a second."""


def _refuse_size(what: str, found: tuple[int, ...], wanted: tuple[int, int]) -> None:
    if found != wanted:
        raise BadImageError(f"its {what} is {found[1]}×{found[0]}; the camera is {wanted[1]}×{wanted[0]}")
