"""What is known of where the camera is: what each frame leaves to the next."""

from collections.abc import Callable
from dataclasses import dataclass, field

from lpslam.frames import RgbdFrame
from lpslam.slam.map import SlamMap
from lpslam.slam.places.relocalising import LastSeen
from lpslam.slam.state import EventKind, SlamEvent, TrackedFrame, TrackingState
from lpslam.slam.tracking.guesses import LastFrame
from lpslam.slam.tracking.motion import ConstantVelocity


@dataclass(slots=True, eq=False)
class Whereabouts:
    """The state of tracking.

    Attributes:
        map: in which the camera is.
        on_event: told every change of state.
        state: how far the pose is trusted.
        reference: the keyframe nearest to the camera; -1 before the first.
        last: the last frame with a pose; None while there is none that leads from there to here.
        last_seen: where the camera was when that was last known; None before the first frame.
        motion: how the camera has moved.
    """

    map: SlamMap
    on_event: Callable[[SlamEvent], None]
    state: TrackingState
    reference: int
    last: LastFrame | None = None
    last_seen: LastSeen | None = None
    motion: ConstantVelocity = field(default_factory=ConstantVelocity)

    def forget(self) -> None:
        """Nothing leads from where the camera was before to where it is."""
        self.last_seen = self.seen()
        self.last = None
        self.motion.forget()

    def seen(self) -> LastSeen | None:
        """Where the camera was last."""
        last = self.last
        return self.last_seen if last is None else LastSeen(last.reference, last.camera_from_reference, last.timestamp)

    def tell(self, kind: EventKind, frame: RgbdFrame, reason: str) -> None:
        """Say that something has happened at a frame, and why."""
        self.on_event(SlamEvent(kind, frame.index, frame.timestamp, reason))

    def unknown(self, frame: RgbdFrame, reason: str) -> TrackedFrame:
        """What is said of a frame without a pose."""
        return TrackedFrame(frame.index, frame.timestamp, self.state, self.reference, None, None, 0, False, reason)
