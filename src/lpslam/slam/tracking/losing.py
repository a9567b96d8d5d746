"""Frames that fit nothing: coasted over for a moment, then lost, and after a while the first of a sub-map."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.config import SlamConfig
from lpslam.slam.state import EventKind, TrackedFrame, TrackingState
from lpslam.slam.tracking.anchoring import Anchoring
from lpslam.slam.tracking.backtracking import Placed
from lpslam.slam.tracking.coasting import Coasting
from lpslam.slam.tracking.guesses import LastFrame
from lpslam.slam.tracking.guessing import Guesser
from lpslam.slam.tracking.picture import Picture
from lpslam.slam.tracking.quality import Quality
from lpslam.slam.tracking.whereabouts import Whereabouts
from lpslam.slam.trajectory import Trajectory


@dataclass(slots=True, eq=False)
class Hindsight:
    """What a frame tells of those before it, until the trajectory has taken it.

    Attributes:
        disowned_since: seconds from which poses are taken back, since they were of another place.
        bridged: frames by index, with a better keyframe from camera (4×4).
        placed: frames by index that had no pose, with their reference keyframe and keyframe from camera (4×4).
    """

    disowned_since: float | None = None
    bridged: dict[int, NDArray[np.float64]] = field(default_factory=dict)
    placed: Placed = field(default_factory=dict)

    def disown(self, trajectory: Trajectory) -> None:
        """Take poses back."""
        if self.disowned_since is not None:
            trajectory.disown(self.disowned_since)
            self.disowned_since = None

    def revise(self, trajectory: Trajectory) -> None:
        """Mend poses, and give poses to frames that had none."""
        trajectory.revise(self.bridged)
        trajectory.place(self.placed)
        self.bridged, self.placed = {}, {}


class Losing:
    """Says what becomes of a frame without a place of its own, and of those before it.

    Args:
        where: the camera is; follows what happens.
        guesser: predicts poses.
        anchoring: knows how far the picture moves.
        quality: says what a frame shows.
        config: thresholds.
        grows: whether new places are mapped.
    """

    def __init__(
        self,
        where: Whereabouts,
        guesser: Guesser,
        anchoring: Anchoring,
        quality: Quality,
        config: SlamConfig,
        grows: bool,
    ) -> None:
        self._where = where
        self._guesser = guesser
        self._anchoring = anchoring
        self._quality = quality
        self._submap_after = config.tracking.submap_after
        self._min_depths = config.keyframes.min_start_depths
        self._grows = grows
        self._coasting = Coasting(config.tracking.coast_seconds)
        self._unknown_since: float | None = None
        self.hindsight = Hindsight()

    @property
    def coasted_since(self) -> float | None:
        """Seconds at which the first frame was coasted over since the last that was seen; None while there is none."""
        return self._coasting.since

    def seen(self) -> None:
        """A frame has a pose of its own: what is in view is known."""
        self._unknown_since = None

    def coast(self, picture: Picture) -> TrackedFrame | None:
        """Give a frame that fits nothing the pose that the motion predicts; None if that is not believed any more."""
        where, frame = self._where, picture.frame
        last = where.last
        if last is None or where.state is TrackingState.LOST or not self._coasting.goes_on(frame.timestamp):
            return None
        self._coasting.pass_over(frame.index, frame.timestamp)
        if self._unknown_since is None and picture.depths >= self._min_depths:
            self._unknown_since = frame.timestamp
        reason = f"coasting: {self._quality.shown(picture)}"
        if where.state is not TrackingState.WEAK:
            where.tell(EventKind.WEAK, frame, reason)
        where.state = TrackingState.WEAK
        world_from_camera = inverse_transform(self._guesser.predicted(last, frame.timestamp))
        return TrackedFrame(
            frame.index,
            frame.timestamp,
            where.state,
            last.reference,
            where.map.camera_from_world(last.reference) @ world_from_camera,
            world_from_camera if where.map.is_home(last.reference) else None,
            0,
            False,
            reason,
            is_coasted=True,
        )

    def lose(self, picture: Picture) -> TrackedFrame | None:
        """Say why a frame is lost; None if usable views were unknown for so long that a sub-map begins with it."""
        where, frame = self._where, picture.frame
        reason = f"no place in the map matched, {self._quality.shown(picture)}"
        if self._coasting.since is not None:
            self.disown(self._coasting.since)
        if where.state is not TrackingState.LOST:
            where.tell(EventKind.LOST, frame, reason)
        where.state = TrackingState.LOST
        where.forget()
        if picture.depths < self._min_depths or not self._grows:
            self._unknown_since = None
        elif self._unknown_since is None:
            self._unknown_since = frame.timestamp
        elif frame.timestamp - self._unknown_since >= self._submap_after:
            where.tell(EventKind.NEW_SUBMAP, frame, f"unknown for {self._submap_after:g} s ({reason})")
            return None
        return where.unknown(frame, reason)

    def bridge(self, before: LastFrame | None, since: float) -> bool:
        """The camera is seen again: what was coasted over lies on the way here, if both ends are of one world.

        Args:
            before: the last frame that was seen before.
            since: seconds at which the first one was coasted over.

        Returns:
            Whether the frames that were coasted over have poses now.
        """
        now, slam_map = self._where.last, self._where.map
        submaps = slam_map.submaps()
        self.hindsight.disowned_since = since
        if before is not None and now is not None and submaps[before.reference] == submaps[now.reference]:
            seen_before, seen_now = before.camera_from_world(slam_map), now.camera_from_world(slam_map)
            if self._anchoring.may_be_one_way(seen_before, seen_now):
                self.hindsight.disowned_since = None
                self.hindsight.bridged = self._coasting.bridged(
                    slam_map, before.reference, (before.timestamp, seen_before), (now.timestamp, seen_now)
                )
        self._coasting.end()
        return self.hindsight.disowned_since is None

    def disown(self, since: float) -> None:
        """The poses from a time on, in seconds, are not where the camera was."""
        self.hindsight.disowned_since = since
        self._coasting.end()

    def finish(self) -> None:
        """The last frame has come: what was only predicted is not confirmed any more."""
        self.hindsight.disowned_since = self._coasting.since
        self._coasting.end()
