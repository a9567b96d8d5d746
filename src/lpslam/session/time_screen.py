"""Frames whose times leap ahead wait for the next one, which tells whether their time was true."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from lpslam.config import TimesConfig
from lpslam.leaps import Leaps
from lpslam.session.step import Step
from lpslam.slam.state import TrackedFrame, TrackingState

Picture = tuple[float, NDArray[np.uint8], NDArray[np.float32]]
"""Seconds, colour and depth of a frame that is not taken yet."""


class TimeScreen:
    """Lets one wrong time cost one frame, and not all that follow, which would come too late.

    Args:
        config: thresholds.
        first: seconds; the time of the first frame, which is taken as it is.
    """

    def __init__(self, config: TimesConfig, first: float) -> None:
        self._leaps: Leaps[Picture] = Leaps(config.stepped_leap_s, config.slower, first)
        self._wrong = 0

    @property
    def left_out(self) -> int:
        """Frames that had a wrong time, or wait."""
        return self._wrong + (self._leaps.held is not None)

    def steps(self, picture: Picture, take: Callable[[Picture], Step], index: int) -> Step:
        """Take what can be taken now; what came of it, in one step.

        Args:
            picture: the frame at hand.
            take: called for each frame whose time is true.
            index: of the frame, should it wait.
        """
        ready, wrong = self._leaps.take(picture[0], picture)
        self._wrong += wrong is not None
        if not ready:
            return _waiting(index, picture[0], self._leaps.ahead)
        return joined([take(each) for each in ready])


def joined(steps: list[Step]) -> Step:
    """The last of some steps, with what is new since the first."""
    last = steps[-1]
    if len(steps) == 1:
        return last
    return Step(
        last.tracked,
        tuple(mark for step in steps for mark in step.new_landmarks),
        tuple(mark for step in steps for mark in step.renamed_landmarks),
        tuple(event for step in steps for event in step.events),
        tuple(reading for step in steps for reading in step.readings),
    )


def _waiting(index: int, timestamp: float, ahead: float) -> Step:
    reason = f"its time lies {ahead:.6g} s ahead of the frame before it; it waits for the next one to confirm that"
    return Step(TrackedFrame(index, timestamp, TrackingState.LOST, -1, None, None, 0, False, reason))
