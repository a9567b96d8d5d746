"""What tracking says of one frame."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray


class TrackingState(StrEnum):
    """How far the pose of a frame can be trusted."""

    INITIALISING = "initialising"
    TRACKING = "tracking"
    WEAK = "weak"
    LOST = "lost"


class EventKind(StrEnum):
    """What can happen to tracking and to the map."""

    INITIALISED = "initialised"
    TRACKING = "tracking"
    WEAK = "weak"
    LOST = "lost"
    RELOCALISED = "relocalised"
    NEW_SUBMAP = "new sub-map"
    LOOP = "loop"
    MERGE = "merge"
    DEPTH_DELAY = "depth delay"
    DEPTH_RANGES = "depth ranges"


@dataclass(frozen=True, slots=True)
class SlamEvent:
    """A change of state, with its reason.

    Attributes:
        kind: what happened.
        frame, timestamp: index of the frame and its time in seconds.
        reason: why, in a few words with figures.
    """

    kind: EventKind
    frame: int
    timestamp: float
    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class TrackedFrame:
    """The result of tracking one frame.

    Attributes:
        index, timestamp: those of the `RgbdFrame`.
        state: how far the pose can be trusted.
        keyframe: id of the reference keyframe; -1 before the first.
        keyframe_from_camera: 4×4, this frame's camera in its reference keyframe's; None unless tracked.
        world_from_camera: 4×4 in the map frame as known now; later corrections move it through its keyframe. None
            unless tracked, and in a sub-map that has not been joined to the map.
        matches: map points matched and kept by the pose optimisation.
        is_keyframe: whether this frame became a keyframe (then `keyframe` is its own id).
        reason: why the state is what it is, in a few words with figures; empty when all is well.
        is_doubted: whether the camera was found again in a place whose signs are not checked yet: nothing is mapped.
        is_coasted: whether the frame shows too little, and has the pose that the motion predicts for now.
    """

    index: int
    timestamp: float
    state: TrackingState
    keyframe: int
    keyframe_from_camera: NDArray[np.float64] | None
    world_from_camera: NDArray[np.float64] | None
    matches: int
    is_keyframe: bool
    reason: str = ""
    is_doubted: bool = False
    is_coasted: bool = False

    @property
    def is_tracked(self) -> bool:
        """Whether the frame has a pose, if only in a sub-map."""
        return self.keyframe_from_camera is not None


@dataclass(frozen=True, slots=True, eq=False)
class Beginning:
    """Where a camera was last before it began a sub-map, though it saw all the time.

    Attributes:
        keyframe, keyframe_from_camera: its last pose (4×4).
        metres: that it may have moved from there until the sub-map began.
    """

    keyframe: int
    keyframe_from_camera: NDArray[np.float64]
    metres: float
