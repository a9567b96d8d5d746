"""Going on for a moment without the map, where a frame shows too little to say where in it it was taken."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.slam.kernels.geometry import exponential, logarithm
from lpslam.slam.tracking.carrying_on import Doubtful, Told
from lpslam.slam.tracking.motion import FARTHEST_AHEAD

_Matrix = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class _Passed:
    """A frame that was passed over: its number, its time in seconds, and its pose (4×4, camera from keyframe)."""

    index: int
    timestamp: float
    camera_from_keyframe: _Matrix


@dataclass(slots=True, eq=False)
class Coasting:
    """The frames that are passed over since the last one with a place in the map.

    Args:
        seconds: for which the motion alone is believed; by then the camera may be anywhere.
        held_seconds: for which it is while something tells it.
        metres: by which a position may be wrong.

    Attributes:
        since: time of the first such frame; None while there is none.
        guessed_since: time of the first to which only the motion tells the way; None once surfaces tell it again.
    """

    seconds: float
    held_seconds: float
    metres: float
    since: float | None = None
    guessed_since: float | None = None
    _frames: list[_Passed] = field(default_factory=list)

    def goes_on(self, timestamp: float, last: float, told: Told, doubtful: Doubtful) -> bool:
        """Whether a frame that shows too little may be passed over, as doubtful as its way is.

        Args:
            timestamp, last: of the frame and of the last one with a place, seconds.
            told, doubtful: what is known of the way between them.
        """
        if self.since is None:
            # Frames may be missing from the recording: the motion is not believed for longer over those.
            return self.seconds > 0.0 and (told is not Told.NOTHING or timestamp - last <= self.seconds)
        if doubtful.seconds > self.seconds:
            return False
        # For a moment the motion is believed whatever its pace.
        return told is Told.NOTHING or (timestamp - self.since <= self.held_seconds and doubtful.metres <= self.metres)

    def is_guess(self, timestamp: float) -> bool:
        """Whether only the motion has told the way for longer than constant velocity is believed."""
        return self.guessed_since is not None and timestamp - self.guessed_since >= FARTHEST_AHEAD

    def pass_over(self, index: int, timestamp: float, camera_from_keyframe: _Matrix, told: Told) -> None:
        """Take a frame with the pose that it has until it is known better."""
        if self.since is None:
            self.since = timestamp
        if told is Told.WAY:
            self.guessed_since = None
        elif told is Told.NOTHING and self.guessed_since is None:
            self.guessed_since = timestamp
        self._frames.append(_Passed(index, timestamp, camera_from_keyframe))

    def end(self) -> None:
        """Forget them: the camera was found again, or is lost."""
        self.since = self.guessed_since = None
        self._frames.clear()

    def bridged(self, started: float, ended: float, expected: _Matrix, found: _Matrix) -> dict[int, _Matrix]:
        """Poses (4×4, keyframe from camera) by frame index, bent so that the way leads to where the camera was found.

        Args:
            started, ended: seconds of the last frame with a place and of the next one.
            expected, found: camera from keyframe (4×4) of the next one, where the way led and where it is.
        """
        astray = logarithm(found @ inverse_transform(expected)) / max(ended - started, 1e-6)
        return {
            passed.index: inverse_transform(
                exponential(astray * (passed.timestamp - started)) @ passed.camera_from_keyframe
            )
            for passed in self._frames
        }
