"""What one frame brought."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.slam.state import SlamEvent, TrackedFrame, TrackingState
from lpslam.text.types import FrameReading, Landmark


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """What one frame brought.

    Attributes:
        tracked: what tracking says of the frame.
        new_landmarks: those that were not told of before. Live, reading is some frames behind.
        renamed_landmarks: those whose name has changed since they were told of.
        events: what happened to tracking and to the map since the step before.
        readings: what was read since the step before, boxes and all; beside tracking, of frames before this one.
    """

    tracked: TrackedFrame
    new_landmarks: tuple[Landmark, ...] = ()
    renamed_landmarks: tuple[Landmark, ...] = ()
    events: tuple[SlamEvent, ...] = ()
    readings: tuple[FrameReading, ...] = ()

    @property
    def index(self) -> int:
        """Of the frame, counted from 0; a map that is continued counts on."""
        return self.tracked.index

    @property
    def timestamp(self) -> float:
        """Of the frame, seconds."""
        return self.tracked.timestamp

    @property
    def pose(self) -> NDArray[np.float64] | None:
        """`world_from_camera`, 4×4, metres, map frame, as known now; None where it is not known: see `reason`."""
        return self.tracked.world_from_camera

    @property
    def state(self) -> TrackingState:
        """How far the pose can be trusted."""
        return self.tracked.state

    @property
    def reason(self) -> str:
        """Why there is no pose, or a weak one, in a few words; empty when all is well."""
        return self.tracked.reason
