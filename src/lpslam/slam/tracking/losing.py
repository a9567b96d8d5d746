"""Frames that fit nothing: coasted over for a moment, then lost, and after a while the first of a sub-map."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.config import KeyframeConfig, SlamConfig
from lpslam.slam.state import Beginning, EventKind, TrackedFrame, TrackingState
from lpslam.slam.tracking.anchoring import Anchoring
from lpslam.slam.tracking.backtracking import Placed
from lpslam.slam.tracking.carrying_on import CarryingOn, Doubtful, Told
from lpslam.slam.tracking.coasting import Coasting
from lpslam.slam.tracking.guesses import LastFrame
from lpslam.slam.tracking.picture import Picture
from lpslam.slam.tracking.quality import Quality
from lpslam.slam.tracking.refinding import Refinding
from lpslam.slam.tracking.whereabouts import Whereabouts
from lpslam.slam.trajectory import Trajectory

_Matrix = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class Hindsight:
    """What a frame tells of those before it, until the trajectory has taken it.

    Attributes:
        disowned_since: seconds from which poses are taken back, since they were of another place.
        bridged: frames by index, with a better keyframe from camera (4×4).
        placed: frames by index that had no pose, with their reference keyframe and keyframe from camera (4×4).
    """

    disowned_since: float | None = None
    bridged: dict[int, _Matrix] = field(default_factory=dict)
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


def start_depths(config: KeyframeConfig, waited: float) -> int:
    """Keypoints with depth that the first keyframe of a map needs after so many seconds of waiting for it."""
    return config.min_start_depths if waited < config.start_patience else config.patient_start_depths


class Losing:
    """Says what becomes of a frame without a place of its own, and of those before it.

    Args:
        where: the camera is; follows what happens.
        anchoring: knows how far the picture moves.
        quality: says what a frame shows.
        carrying_on: follows the camera where the map does not tell its way.
        refinding: lays what a frame shows on the map.
        config: thresholds.
        grows: whether new places are mapped.
    """

    def __init__(
        self,
        where: Whereabouts,
        anchoring: Anchoring,
        quality: Quality,
        carrying_on: CarryingOn,
        refinding: Refinding,
        config: SlamConfig,
        grows: bool,
    ) -> None:
        self._carrying_on = carrying_on
        self._refinding = refinding
        self._where = where
        self._anchoring = anchoring
        self._quality = quality
        self._submap_after = config.tracking.submap_after
        self._untold = Doubtful(config.surfaces.untold_metres, config.surfaces.untold_seconds)
        self._beginnings = config.keyframes
        self._grows = grows
        self._coasting = Coasting(
            config.tracking.coast_seconds, config.surfaces.held_seconds, config.tracking.coast_metres
        )
        self._unknown_since: float | None = None
        self._was_blind = False
        self._carried_speed = config.tracking.carried_speed
        self.hindsight = Hindsight()

    @property
    def coasted_since(self) -> float | None:
        """Seconds at which the first frame was coasted over since the last that was seen; None while there is none."""
        return self._coasting.since

    def expected(self, timestamp: float) -> _Matrix | None:
        """Camera from world (4×4) at a time in seconds, while frames are coasted over."""
        last = self._where.last
        ahead = None if last is None else self._carrying_on.ahead(last, timestamp)
        return None if last is None or ahead is None else ahead @ self._where.map.camera_from_world(last.reference)

    @property
    def is_way_told(self) -> bool:
        """Whether the way of the frames that were coasted over is told, all but a little."""
        return self._coasting.since is not None and self._carrying_on.is_told(self._untold)

    def seen(self) -> None:
        """A frame has a pose of its own: what is in view is known."""
        self._unknown_since = None
        self._was_blind = False

    def beginning(self, timestamp: float) -> Beginning | None:
        """Whence the camera came to a view at a time in seconds, if it saw all the way; a blind one may be anywhere."""
        seen = self._where.seen()
        if seen is None or self._was_blind:
            return None
        metres = self._carried_speed * max(timestamp - seen.timestamp, 0.0)
        return Beginning(seen.keyframe, inverse_transform(seen.camera_from_keyframe), metres)

    def coast(self, picture: Picture) -> TrackedFrame | None:
        """Give a frame that fits nothing a pose by surfaces, its keypoints or the motion; None if none is believed."""
        where, frame = self._where, picture.frame
        last = where.last
        # Asked of every frame that fits nothing, whatever becomes of it.
        self._was_blind |= not self._shows_enough(picture)
        if last is None or where.state is TrackingState.LOST or not self._coasting.seconds:
            return None
        camera_from_keyframe = self._carrying_on.follow(last, picture)
        told = self._carrying_on.told
        if told is Told.WAY:
            camera_from_keyframe = self._mended(last, picture, camera_from_keyframe)
        if not self._coasting.goes_on(frame.timestamp, last.timestamp, told, self._carrying_on.doubtful):
            return None
        if told is Told.NOTHING and self._shows_enough(picture) and self._coasting.is_guess(frame.timestamp):
            # After a time without a view, one that fits nothing is of elsewhere.
            return None
        self._coasting.pass_over(frame.index, frame.timestamp, camera_from_keyframe, told)
        if self._unknown_since is None and self._shows_enough(picture):
            self._unknown_since = frame.timestamp
        reason = f"{_SAID[told]}: {self._quality.shown(picture)}"
        if where.state is not TrackingState.WEAK:
            where.tell(EventKind.WEAK, frame, reason)
        where.state = TrackingState.WEAK
        keyframe_from_camera = inverse_transform(camera_from_keyframe)
        world_from_keyframe = where.map.world_from_keyframe(last.reference)
        return TrackedFrame(
            frame.index,
            frame.timestamp,
            where.state,
            last.reference,
            keyframe_from_camera,
            world_from_keyframe @ keyframe_from_camera if where.map.is_home(last.reference) else None,
            0,
            False,
            reason,
            is_coasted=True,
        )

    def _mended(self, last: LastFrame, picture: Picture, camera_from_keyframe: _Matrix) -> _Matrix:
        """The pose (4×4) of a frame that was carried along, with what it shows laid on the map: else it drifts."""
        slam_map = self._where.map
        camera_from_world = camera_from_keyframe @ slam_map.camera_from_world(last.reference)
        laid = self._refinding.mended(picture.frame, camera_from_world)
        if laid is None:
            return camera_from_keyframe
        mended = laid @ slam_map.world_from_keyframe(last.reference)
        self._carrying_on.mend(mended)
        return mended

    def lose(self, picture: Picture) -> TrackedFrame | None:
        """Say why a frame is lost; None if usable views were unknown for so long that a sub-map begins with it."""
        where, frame = self._where, picture.frame
        reason = f"no place in the map matched, {self._quality.shown(picture)}"
        if self._coasting.since is not None:
            # Poses that something told stay.
            guessed_since = self._coasting.guessed_since
            self.disown(frame.timestamp if guessed_since is None else guessed_since)
        if where.state is not TrackingState.LOST:
            where.tell(EventKind.LOST, frame, reason)
        where.state = TrackingState.LOST
        where.forget()
        if not self._shows_enough(picture) or not self._grows:
            self._unknown_since = None
        elif self._unknown_since is None:
            self._unknown_since = frame.timestamp
        elif self._may_begin(picture, self._unknown_since):
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
            keyframe_from_world = slam_map.world_from_keyframe(before.reference)
            found = now.camera_from_world(slam_map) @ keyframe_from_world
            expected = self._carrying_on.ahead(before, now.timestamp)
            is_told = expected is not None and self._coasting.guessed_since is None
            if expected is not None and self._anchoring.may_be_one_way(
                expected if is_told else before.camera_from_reference, found
            ):
                self.hindsight.disowned_since = None
                self.hindsight.bridged = self._coasting.bridged(before.timestamp, now.timestamp, expected, found)
        self._coasting.end()
        return self.hindsight.disowned_since is None

    def continued(self, picture: Picture) -> _Matrix | None:
        """Camera from world (4×4) of a frame with which the map goes on, though it shares no point with it; or None.

        It does where surfaces tell the way, all but a little, and what is in view has been unknown for long.
        """
        last, since = self._where.last, self._unknown_since
        if last is None or since is None or not self._grows or not self._carrying_on.is_told(self._untold):
            return None
        if not self._may_begin(picture, since):
            return None
        self._coasting.end()
        return self.expected(picture.timestamp)

    def parts(self, picture: Picture) -> bool:
        """Whether a frame that is coasted over begins a sub-map: it shows enough, and not even its turn is told."""
        since = self._unknown_since
        if since is None or not self._grows or picture.depths < self._beginnings.min_start_depths:
            return False
        return not self._carrying_on.is_turn_told(self._untold) and self._may_begin(picture, since)

    def _shows_enough(self, picture: Picture) -> bool:
        """Whether a frame shows as much as a patient camera begins a map with."""
        return picture.depths >= self._beginnings.patient_start_depths

    def _may_begin(self, picture: Picture, since: float) -> bool:
        """Whether views have been unknown for long enough, since a time in seconds, and this one shows enough."""
        waited = picture.timestamp - since
        return waited >= self._submap_after and picture.depths >= start_depths(self._beginnings, waited)

    def disown(self, since: float) -> None:
        """The poses from a time on, in seconds, are not where the camera was."""
        self.hindsight.disowned_since = since
        self._coasting.end()

    def finish(self) -> None:
        """The last frame has come: what was only predicted is not confirmed any more."""
        self.hindsight.disowned_since = self._coasting.guessed_since
        self._coasting.end()


_SAID = {Told.NOTHING: "coasting", Told.TURN: "only its turn is known", Told.WAY: "carried without the map"}
"""How a frame without a place of its own has got its pose."""
