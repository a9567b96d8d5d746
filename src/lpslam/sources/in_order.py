"""Frames in order of time, each once, whatever a camera or a recording delivers."""

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from lpslam.config import TimesConfig
from lpslam.errors import UserError
from lpslam.frames import FrameFault, FrameSource, PassedOn, RgbdFrame
from lpslam.leaps import Leaps


class InOrder(PassedOn):
    """A `FrameSource` that leaves out frames of another one that come late, twice, without a time or misshapen.

    Tracking predicts from the frame before: time that runs backwards or stands still has no velocity. A colour picture
    that is repeated byte for byte again and again is a camera that hangs: no sensor is free of noise, and its pose
    would be that of a moment gone by. Repeated once, it was only a little slow; recordings are full of such. What is
    left out is a fault like any other.

    Args:
        source: where the frames come from.
        config: thresholds; defaults without.
    """

    def __init__(self, source: FrameSource, config: TimesConfig | None = None) -> None:
        super().__init__(source)
        self._config = config or TimesConfig()
        self._own_faults: list[FrameFault] = []

    @property
    def faults(self) -> list[FrameFault]:
        """The source's faults and those found here, by index."""
        return sorted([*self.source.faults, *self._own_faults], key=lambda fault: fault.index)

    def __iter__(self) -> Iterator[RgbdFrame]:
        """Yield the frames that follow the one before in time.

        Raises:
            UserError: at the end, if the source gave frames and not one could be used.
        """
        faults: list[FrameFault] = []
        self._own_faults = faults
        latest = -np.inf
        shown: NDArray[np.uint8] | None = None
        repeats = 0
        for frame in _without_leaps(self.source, self._config, faults):
            defect = self._shape_defect(frame) or _time_defect(frame.timestamp, latest)
            if not defect:
                repeats = repeats + 1 if shown is not None and _is_repeated(frame.rgb, shown) else 0
                if repeats > self._config.repeats:
                    defect = f"its colour repeats the frames before, byte for byte, {repeats} times: the camera hangs"
            if defect:
                faults.append(FrameFault(frame.index, frame.timestamp, defect))
                continue
            latest, shown = frame.timestamp, frame.rgb
            yield frame
        if faults and latest == -np.inf:
            raise UserError(f"{self.name}: none of its {len(faults)} frames can be used; the first: {faults[0].reason}")

    def _shape_defect(self, frame: RgbdFrame) -> str:
        wanted = (self.camera.height, self.camera.width)
        for kind, found in (("colour", frame.rgb.shape[:2]), ("depth", frame.depth.shape)):
            if found != wanted:
                return f"its {kind} is {'×'.join(map(str, found[::-1]))}; the camera is {wanted[1]}×{wanted[0]}"
        return ""


def _without_leaps(frames: Iterable[RgbdFrame], config: TimesConfig, faults: list[FrameFault]) -> Iterator[RgbdFrame]:
    """Frames but those whose time lies far ahead of what is before and after: all that follow would come too late."""
    leaps: Leaps[RgbdFrame] = Leaps(config.recorded_leap_s, config.slower)
    for frame in frames:
        if not np.isfinite(frame.timestamp):
            yield frame
            continue
        ready, wrong = leaps.take(frame.timestamp, frame)
        if wrong is not None:
            apart = wrong.timestamp - frame.timestamp
            where = "ahead of" if apart > 0 else "before"
            faults.append(_fault(wrong, f"its time lies {abs(apart):.6g} s {where} the frame after it"))
        yield from ready
    if leaps.held is not None:
        last = leaps.held[1]
        if config.last_leap_s < leaps.ahead < np.inf:
            reason = f"its time lies {leaps.ahead:.6g} s after the frame before it, and none follows that confirms it"
            faults.append(_fault(last, reason))
        else:
            yield last


def _fault(frame: RgbdFrame, reason: str) -> FrameFault:
    return FrameFault(frame.index, frame.timestamp, reason)


def _is_repeated(rgb: NDArray[np.uint8], before: NDArray[np.uint8]) -> bool:
    """Whether a picture is the one before; of one colour all over, it may be a new one of a covered lens."""
    is_same = np.array_equal(rgb[::16, ::16], before[::16, ::16]) and np.array_equal(rgb, before)
    return is_same and bool(np.ptp(rgb, axis=(0, 1)).any())


def _time_defect(timestamp: float, latest: float) -> str:
    if not np.isfinite(timestamp):
        return f"its time is {timestamp}"
    if timestamp == latest:
        return f"it repeats the time {timestamp:.6f} s of the frame before"
    if timestamp < latest:
        return f"it comes {latest - timestamp:.3f} s too late: a frame of {latest:.6f} s was there before"
    return ""
