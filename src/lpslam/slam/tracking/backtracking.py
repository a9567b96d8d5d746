"""Frames that had no place when they came: the camera is followed back in time from where it is found."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.config import SlamConfig
from lpslam.slam.association import Associator, View
from lpslam.slam.features import FeatureExtractor, Features
from lpslam.slam.map import SlamMap
from lpslam.slam.sensor import SensorModel
from lpslam.slam.shutter.straightening import RollingShutter
from lpslam.slam.tracking.guesses import FirstGuess, LastFrame, Search
from lpslam.slam.tracking.guessing import Guesser
from lpslam.slam.tracking.local_search import LocalSearch
from lpslam.slam.tracking.motion import ConstantVelocity
from lpslam.slam.tracking.picture import Picture

_Matrix = NDArray[np.float64]
Placed = dict[int, tuple[int, _Matrix]]


@dataclass(frozen=True, slots=True, eq=False)
class _Kept:
    """A frame without a place: its number, its time in seconds, and its keypoints as they are in the image."""

    index: int
    timestamp: float
    seen: Features


class Backtracking:
    """Keeps the latest frames without a place, and follows the camera back through them once it is found.

    Time runs backwards here: seconds are counted from the frame in which the camera was found into the past.

    Args:
        extractor, sensor, shutter: of the camera.
        slam_map, associator, search: where it is looked for.
        config: thresholds.

    Attributes:
        since: time in seconds of the first of the frames that were placed last.
    """

    def __init__(
        self,
        extractor: FeatureExtractor,
        sensor: SensorModel,
        slam_map: SlamMap,
        associator: Associator,
        search: LocalSearch,
        shutter: RollingShutter,
        config: SlamConfig,
    ) -> None:
        self._map = slam_map
        self._motion = ConstantVelocity()
        self._guesser = Guesser(extractor, sensor, slam_map, associator, self._motion, shutter, config)
        self._search = search
        self._sensor = sensor
        self._shutter = shutter
        self._seconds = config.tracking.backtracked_seconds
        self._longest_gap = config.tracking.long_gap
        self._kept: deque[_Kept] = deque()
        self.since = np.inf

    def keep(self, picture: Picture) -> None:
        """Take a frame without a place."""
        self._kept.append(_Kept(picture.frame.index, picture.timestamp, picture.seen))
        while self._kept and picture.timestamp - self._kept[0].timestamp > self._seconds:
            self._kept.popleft()

    def forget(self) -> None:
        """The frames that are kept have a place now, or will have none."""
        self._kept.clear()

    def back_from(self, found: LastFrame) -> Placed:
        """Follow the camera back from a frame with a place.

        Returns:
            For frames by index their reference keyframe and the pose (4×4) in its frame.
        """
        placed: Placed = {}
        self.since = np.inf
        self._motion.forget()
        after, origin, passed = found, found.timestamp, 0.0
        for kept in reversed(self._kept):
            seconds = origin - kept.timestamp
            if seconds <= 0.0:  # the frame itself
                continue
            if seconds > self._seconds or seconds - passed > self._longest_gap:
                break
            before = self._placed(kept, after, passed, seconds)
            if before is not None:
                self._motion.note(self._guesser.pose(after), self._guesser.pose(before), seconds - passed)
                placed[kept.index] = (before.reference, inverse_transform(before.camera_from_reference))
                after, passed, self.since = before, seconds, kept.timestamp
        self.forget()
        return placed

    def _placed(self, kept: _Kept, after: LastFrame, passed: float, seconds: float) -> LastFrame | None:
        """A frame with its place, found from the one after it; both times in seconds before the camera was found."""
        twist = self._motion.twist
        features = self._shutter.straighten(kept.seen, None if twist is None else -twist)
        view = View.of(features, self._sensor)
        found = self._search.best(view, self._starts(after, view, seconds - passed), 0.0, is_strict=False)
        if found is None or not found.is_sure:
            return None
        return self._last_frame(kept, features, found)

    def _starts(self, after: LastFrame, view: View, elapsed: float) -> Iterator[FirstGuess]:
        yield from self._guesser.from_motion(after, after.timestamp + elapsed, view)
        yield from self._guesser.from_appearance(after, view)
        yield from self._guesser.from_reference(after, view, after.reference)

    def _last_frame(self, kept: _Kept, features: Features, found: Search) -> LastFrame:
        reference_from_world = self._map.camera_from_world(found.reference)
        return LastFrame(
            kept.timestamp,
            np.empty((0, 0), np.uint8),
            np.empty((0, 0), np.float32),
            features,
            kept.seen,
            found.estimate.points,
            found.reference,
            found.estimate.camera_from_world @ inverse_transform(reference_from_world),
        )
