"""Rolling shutter: keypoints as they would be had all rows been exposed at once, and how long the rows take.

Most colour cameras expose one row after the other. At 100 degrees a second and 30 ms from the first row to the last the
picture is sheared by 3 degrees, dozens of pixels. How long the rows take is seldom written anywhere. It is estimated
from pairs of views taken in different motion: one rigid motion explains both pictures only with the right readout.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.config import ShutterConfig, TrackingConfig
from lpslam.slam.features import Features
from lpslam.slam.kernels import matching
from lpslam.slam.kernels import shutter as kernels
from lpslam.slam.kernels.graph import MapColumns
from lpslam.slam.map import SlamMap
from lpslam.slam.medians import weighted_median
from lpslam.slam.ranges.curve import DepthChange
from lpslam.slam.sensor import SensorModel
from lpslam.slam.shutter.readout import Correspondences, readout_between
from lpslam.slam.tracking.guesses import LastFrame

_Matrix = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class _MovingView:
    """A view whose velocity is known: (6,) twist of the world in its camera frame, a second."""

    frame: LastFrame
    twist: _Matrix


@dataclass(frozen=True, slots=True, eq=False)
class _Waiting:
    """A frame of which only the velocity before it is known."""

    frame: LastFrame
    before: _Matrix | None
    is_matched: bool
    is_keyframe: bool


class RollingShutter:
    """Straightens keypoints by the camera's velocity, and learns the readout while running.

    Args:
        sensor: of the camera.
        slam_map: its keyframes are straightened again when the readout becomes known.
        tracking: for descriptors.
        config: thresholds.

    Attributes:
        readout: seconds from the first row to the last that are corrected for; negative for a camera held upside
            down, 0 while nothing else is certain.
    """

    def __init__(self, sensor: SensorModel, slam_map: SlamMap, tracking: TrackingConfig, config: ShutterConfig) -> None:
        self.sensor = sensor
        self._map = slam_map
        self._hamming, self._ratio = tracking.hamming_strict, tracking.ratio_brute_force
        self._config = config
        self.readout = config.readout or 0.0
        self._views: deque[_MovingView] = deque(maxlen=config.views)
        self._pairs: deque[tuple[float, float]] = deque(maxlen=config.pairs)
        self._noted_at = -np.inf
        self._waiting: _Waiting | None = None
        self._gaps: deque[float] = deque(maxlen=_GAPS)
        self._better: float | None = None
        self._doubt = np.inf
        self._keyframes: dict[int, tuple[Features, _Matrix | None]] = {}

    def straighten(self, seen: Features, twist: _Matrix | None) -> Features:
        """Keypoints as at the time of the middle row.

        Args:
            seen: keypoints as they are in the image.
            twist: (6,) of the world in the camera frame, a second; None where the motion is not known.
        """
        if twist is None or self.readout == 0.0 or not seen.rows:
            return seen
        pixels, depth = kernels.straighten(
            seen.pixels, seen.depth, twist, self.readout, self.sensor.image_size[1], self.sensor.intrinsics
        )
        return seen._replace(pixels=pixels, depth=depth, u_right=pixels[:, 0] - self.sensor.disparity(depth))

    def bends(self, twist: _Matrix, other: _Matrix) -> bool:
        """Whether two velocities bend the image noticeably differently."""
        pixels = 0.5 * abs(self.readout) * self.sensor.intrinsics[0] * float(np.linalg.norm((twist - other)[3:]))
        return bool(pixels > self._config.noticed_pixels)

    def note(self, frame: LastFrame, twist: _Matrix | None, is_matched: bool, is_keyframe: bool) -> None:
        """Take a tracked frame with its velocity (6,) since the frame before, if that is known.

        A frame lies in the middle of what the camera did before and after it: it is judged when the next one is there.
        The caller holds the map's lock.
        """
        if self._waiting is not None and twist is not None:
            self._gaps.append(frame.timestamp - self._waiting.frame.timestamp)
            self._complete(self._waiting, twist)
        self._waiting = _Waiting(frame, twist, is_matched, is_keyframe)
        if is_keyframe:
            self._remember(frame.reference, frame.seen, twist)

    def _complete(self, waiting: "_Waiting", after: _Matrix) -> None:
        twist = after if waiting.before is None else 0.5 * (waiting.before + after)
        if waiting.is_keyframe:
            self._refine(waiting.frame.reference, twist)
        if waiting.before is not None and waiting.is_matched and self._config.readout is None:
            self._learn(_MovingView(waiting.frame, twist), waiting.is_keyframe)

    def _remember(self, keyframe: int, seen: Features, twist: _Matrix | None) -> None:
        """Keep what a keyframe saw, to straighten it again."""
        self._keyframes[keyframe] = (seen, twist)
        while len(self._keyframes) > self._config.keyframes:
            del self._keyframes[next(iter(self._keyframes))]

    def _refine(self, keyframe: int, twist: _Matrix) -> None:
        """Straighten a keyframe by a better velocity."""
        seen, before = self._keyframes[keyframe]
        self._keyframes[keyframe] = (seen, twist)
        if self._map.is_alive(keyframe) and (before is None or self.bends(twist, before)):
            _observe_again(self._map.columns, keyframe, self.straighten(seen, twist), self.sensor)

    def _learn(self, now: _MovingView, is_keyframe: bool) -> None:
        """Compare a view that was matched with the map with views in other motion."""
        config, timestamp = self._config, now.frame.timestamp
        if timestamp - self._noted_at < (config.settled_interval if self.is_settled else config.interval):
            return
        self._noted_at = timestamp
        others = [(float(np.linalg.norm((view.twist - now.twist)[3:])), view) for view in self._views]
        others.sort(key=lambda each: -each[0])
        for difference, view in others[: config.compared]:
            if difference > config.least_difference:
                self._compare(view, now)
        self._views.append(now)
        if is_keyframe:
            self._reconsider()

    @property
    def is_settled(self) -> bool:
        """Whether so much has been compared that the readout hardly changes any more."""
        config = self._config
        return (
            config.readout is not None
            or len(self._pairs) >= config.pairs
            or (len(self._pairs) >= config.settled_pairs and self._doubt < config.least_change)
        )

    def _compare(self, one: _MovingView, other: _MovingView) -> None:
        a, b = one.frame, other.frame
        rows = np.flatnonzero(a.seen.has_depth)
        match = matching.match_brute_force(a.seen.descriptor[rows], b.seen.descriptor, self._hamming, self._ratio)
        matching.keep_consistent_rotations(match, a.seen.angle[rows], b.seen.angle)
        in_b = np.flatnonzero(match >= 0)
        if len(in_b) < self._config.min_matches:
            return
        in_a = rows[match[in_b]]
        found = readout_between(
            Correspondences(
                a.seen.pixels[in_a],
                a.seen.depth[in_a],
                one.twist,
                b.seen.pixels[in_b],
                other.twist,
                self.sensor.pixel_information[b.seen.octave[in_b]],
            ),
            b.camera_from_world(self._map) @ np.linalg.inv(a.camera_from_world(self._map)),
            self.readout,
            self.sensor,
        )
        if found is None or abs(found.readout) > self._config.longest or found.sigma > self._config.largest_sigma:
            return
        if found.agreeing >= self._config.min_matches:
            self._pairs.append((found.readout, found.sigma**-2))

    def _reconsider(self) -> None:
        """Correct for another readout where the pairs are sure of it."""
        if len(self._pairs) < self._config.min_pairs:
            return
        values, weights = np.array(self._pairs).T
        # No camera reads longer than from one frame to the next.
        longest = float(np.median(self._gaps))
        middle = min(max(weighted_median(values, weights), -longest), longest)
        # The formal sigma knows nothing of errors of the velocities: the spread of the pairs does.
        share = weights / weights.sum()
        sigma = 1.5 * weighted_median(np.abs(values - middle), weights) * float(np.sqrt(np.square(share).sum()))
        difference = abs(middle - self.readout)
        self._doubt = difference + self._config.certain_sigmas * sigma
        if difference > max(self._config.least_change, self._config.certain_sigmas * sigma):
            self._better = middle

    def apply(self) -> bool:
        """Correct for a readout that has become known: straighten the map's keyframes anew, which then want adjusting.

        For whoever adjusts the map; its lock is taken here. Returns whether anything has changed.
        """
        with self._map.lock:
            if self._better is None:
                return False
            self.readout, self._better = self._better, None
            self._straighten_keyframes()
        return True

    def read_again(self, change: DepthChange) -> None:
        """Take other depths for what keyframes saw; the map's lock is taken here."""
        with self._map.lock:
            for keyframe, (seen, twist) in self._keyframes.items():
                self._keyframes[keyframe] = (change.of(seen, self.sensor), twist)

    def _straighten_keyframes(self) -> None:
        for keyframe, (seen, twist) in list(self._keyframes.items()):
            if self._map.is_alive(keyframe):
                _observe_again(self._map.columns, keyframe, self.straighten(seen, twist), self.sensor)
            else:
                del self._keyframes[keyframe]


_GAPS = 31
"""Latest times between frames whose median is the camera's interval: a frame that is missing does not change it."""


def _observe_again(m: MapColumns, keyframe: int, features: Features, sensor: SensorModel) -> None:
    """Put other places of the same keypoints into a keyframe; points that it brought to the map move as they do."""
    slot = int(m.keyframe_slot[keyframe])
    points = m.point[slot, : features.rows]
    rows = np.flatnonzero((points >= 0) & (m.first_keyframe[points] == keyframe) & features.has_depth)
    before = sensor.back_project(m.pixels[slot, rows], m.depth[slot, rows])
    after = sensor.back_project(features.pixels[rows], features.depth[rows])
    m.position[points[rows]] += (after - before) @ m.camera_from_world[keyframe, :3, :3]
    for name in ("pixels", "u_right", "depth"):
        getattr(m, name)[slot, : features.rows] = getattr(features, name)
