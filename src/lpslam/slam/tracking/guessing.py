"""First guesses of a frame's pose: by optical flow, by constant velocity, by the reference keyframe (ORB-SLAM, V-B)."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import centre_distance, inverse_transform
from lpslam.config import SlamConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.association import Associator, View
from lpslam.slam.features import FeatureExtractor
from lpslam.slam.kernels.pose import PosePrior
from lpslam.slam.map import SlamMap
from lpslam.slam.sensor import Reach, SensorModel
from lpslam.slam.shutter.straightening import RollingShutter
from lpslam.slam.tracking.following import choose_followed, follow_flow
from lpslam.slam.tracking.guesses import FirstGuess, Followed, LastFrame, Sighted
from lpslam.slam.tracking.motion import ConstantVelocity, velocity
from lpslam.slam.tracking.stepping import Step, Stepping

_Matrix = NDArray[np.float64]
_Rows = NDArray[np.int32]


class Guesser:
    """Guesses where a frame was taken from the last one that has a pose.

    Args:
        extractor, sensor: of the camera.
        slam_map: in which the poses are.
        associator: matches views with it.
        motion: how the camera has moved; kept by the caller.
        shutter: straightens what is followed.
        config: thresholds.

    Attributes:
        step: what whole pictures tell of the step to the newest frame; None where they were not asked or do not tell.
    """

    def __init__(
        self,
        extractor: FeatureExtractor,
        sensor: SensorModel,
        slam_map: SlamMap,
        associator: Associator,
        motion: ConstantVelocity,
        shutter: RollingShutter,
        config: SlamConfig,
    ) -> None:
        self._extractor = extractor
        self._sensor = sensor
        self._map = slam_map
        self._associator = associator
        self._motion = motion
        self._shutter = shutter
        self._config = config.tracking
        self._longest_gap = config.shutter.longest_gap
        self.step: Step | None = None
        self._reach = Reach(self._config.min_followed, _REACHED)

    def can_predict(self, last: LastFrame, frame: RgbdFrame) -> bool:
        """Whether constant velocity says well where a frame is: after a gap in a turn it is off by degrees."""
        return self._motion.is_known and frame.timestamp - last.timestamp <= self._config.predictable_gap

    def look_at_step(
        self, last: LastFrame, frame: RgbdFrame, gray: NDArray[np.uint8], stepping: Stepping | None
    ) -> None:
        """Ask whole pictures for the step to a frame, if they are to be asked and can be told what to expect."""
        self.step = None
        if stepping is not None and self.can_predict(last, frame):
            with self._map.lock:
                before = self.pose(last)
                ahead = self._motion.ahead(before, frame.timestamp - last.timestamp)
            self.step = stepping.told(last, frame, gray, ahead @ inverse_transform(before))

    def follow(self, last: LastFrame, frame: RgbdFrame, gray: NDArray[np.uint8]) -> Followed | None:
        """Follow the last frame's keypoints, and optimise the pose on the points that they see."""
        config = self._config
        if last.gray.shape != gray.shape or config.followed_points == 0:
            return None
        with self._map.lock:
            version = self._map.version
            predicted, prior = self.predicted(last, frame.timestamp), self.prior(last, frame.timestamp)
            sighted = self._sighted(last, predicted)
        rows = sighted.rows
        chosen = choose_followed(
            last.features.pixels[rows], last.features.octave[rows], sighted.points >= 0, config.followed_points
        )
        sighted = sighted.kept(chosen)
        rows = sighted.rows
        if len(rows) < config.min_followed:
            return None
        in_camera = sighted.positions @ predicted[:3, :3].T + predicted[:3, 3]
        in_camera[:, 2] = np.maximum(in_camera[:, 2], 0.05)
        expected = self._extractor.camera.project(in_camera).astype(np.float32)
        levels = config.flow_levels + (0 if self.can_predict(last, frame) else _LEVELS_FOR_UNKNOWN_MOTION)
        flow = follow_flow(last.gray, gray, last.seen.pixels[rows], expected, levels, self._extractor.camera, config)
        if len(flow.rows) < config.min_followed:
            return None
        seen = self._extractor.moved(last.seen, rows[flow.rows], flow.raw, frame.depth)
        straight = self._shutter.straighten(seen, self._motion.twist)
        match, found = np.arange(len(flow.rows), dtype=np.int32), sighted.kept(flow.rows)
        known = (match, found.positions, found.points, found.spread)
        estimate = self._associator.optimise(straight, predicted, *known, prior)
        if estimate is None:
            return None
        twist = self.twist(last, frame, estimate.camera_from_world)
        if twist is not None and (self._motion.twist is None or self._shutter.bends(twist, self._motion.twist)):
            straight = self._shutter.straighten(seen, twist)
            estimate = self._associator.optimise(straight, estimate.camera_from_world, *known, prior)
        return None if estimate is None else Followed(straight, seen, estimate, version, len(rows))

    def twist(self, last: LastFrame, frame: RgbdFrame, camera_from_world: _Matrix) -> _Matrix | None:
        """(6,) velocity a second, if that can be said from the last frame to a pose of this one (4×4)."""
        if not self.tells_velocity(last, frame):
            return None
        return velocity(self.pose(last), camera_from_world, frame.timestamp - last.timestamp)

    def tells_velocity(self, last: LastFrame, frame: RgbdFrame) -> bool:
        """Whether the last frame is so near in time that the camera has kept its velocity."""
        return 0.0 < frame.timestamp - last.timestamp <= self._longest_gap

    def from_motion(self, last: LastFrame, timestamp: float, view: View) -> Iterator[FirstGuess]:
        """The last frame's points in windows around where they should appear, then in wider ones."""
        config, predicted = self._config, self.predicted(last, timestamp)
        prior = self.prior(last, timestamp)
        sighted = self._sighted(last, predicted)
        fx, fy, cx, cy, bf = self._sensor.intrinsics
        x, y, z = (sighted.positions @ predicted[:3, :3].T + predicted[:3, 3]).T
        width, height = self._sensor.image_size
        with np.errstate(divide="ignore", invalid="ignore"):
            u, v = fx * x / z + cx, fy * y / z + cy
            kept = np.flatnonzero((z > 0.05) & (u >= 0) & (u < width) & (v >= 0) & (v < height))
            projections = np.column_stack([u, v, u - bf / z])[kept].astype(np.float32)
        sighted = sighted.kept(kept)
        before = sighted.rows
        octaves = last.features.octave[before].astype(np.int32)
        for radius in (config.motion_radius, 2 * config.motion_radius):
            match = self._associator.match_windows(
                view, projections, octaves, last.features.descriptor[before], last.features.angle[before], radius
            )
            if np.count_nonzero(match >= 0) < config.min_motion_matches:
                continue
            estimate = self._associator.optimise(
                view.features, predicted, match, sighted.positions, sighted.points, sighted.spread, prior
            )
            if estimate is not None:
                yield FirstGuess.of(estimate)

    def from_reference(self, last: LastFrame | None, view: View, reference: int) -> Iterator[FirstGuess]:
        """Match descriptors against the reference keyframe, wherever they are in the image."""
        points = self._associator.match_descriptors(view, reference)
        if np.count_nonzero(points >= 0) < self._config.min_motion_matches:
            return
        guess = self._map.camera_from_world(reference) if last is None else self.pose(last)
        estimate = self._associator.optimise_on_map(view.features, guess, points)
        if estimate is not None:
            yield FirstGuess.of(estimate)

    def from_appearance(self, last: LastFrame, view: View) -> Iterator[FirstGuess]:
        """Match descriptors against the last frame, wherever they are in the image: the camera may have swung round."""
        config, pose = self._config, self.pose(last)
        sighted = self._sighted(last, pose)
        match = self._associator.match_anywhere(
            view, last.features.descriptor[sighted.rows], last.features.angle[sighted.rows]
        )
        if np.count_nonzero(match >= 0) < config.min_motion_matches:
            return
        estimate = self._associator.optimise(
            view.features, pose, match, sighted.positions, sighted.points, sighted.spread
        )
        if estimate is not None:
            yield FirstGuess.of(estimate)

    def pose(self, last: LastFrame) -> _Matrix:
        """Camera from world of the last frame as the map has it now."""
        return last.camera_from_world(self._map)

    def predicted(self, last: LastFrame, timestamp: float) -> _Matrix:
        """Camera from world at a time in seconds: where pictures say, or if the camera goes on as it did."""
        if self.step is not None and self.step.leads(last.timestamp, timestamp):
            told: _Matrix = self.step.image_from_last @ self.pose(last)
            return told
        return self._motion.ahead(self.pose(last), timestamp - last.timestamp)

    def can_have_come(
        self,
        last: LastFrame | None,
        camera_from_world: _Matrix,
        timestamp: float,
        carried: _Matrix | None,
        is_told: bool = False,
    ) -> bool:
        """Whether a camera can have moved to a pose (4×4) since the last frame; else it must be told as a place is.

        Before fronts all alike, a few points that look the same pull the pose of a quick pan to the next one.

        Args:
            last: the last frame with a pose, if there is one.
            camera_from_world: that a search has found.
            timestamp: of the frame, in seconds.
            carried: camera from world (4×4) where frames since the last were coasted over.
            is_told: all the way there was told, and so is wrong by its drift alone.

        Returns:
            True as well where nothing foretells the pose: of a camera on a car two frames must say how fast it is.
        """
        if last is None or (carried is None and not self._motion.is_known):
            return True
        expected = self.predicted(last, timestamp) if carried is None else carried
        speed = self._config.told_drift if is_told and carried is not None else self._config.carried_speed
        reach = self._config.swerve_distance + speed * (timestamp - last.timestamp)
        return centre_distance(camera_from_world, expected) <= reach

    def prior(self, last: LastFrame | None, timestamp: float) -> PosePrior | None:
        """What pictures tell of the pose of the frame at a time in seconds, as the map has the last one now."""
        if last is None or self.step is None or not self.step.leads(last.timestamp, timestamp):
            return None
        return PosePrior(inverse_transform(self.predicted(last, timestamp)), self.step.information)

    def _sighted(self, last: LastFrame, predicted: _Matrix) -> Sighted:
        """Keypoints of the last frame whose place is known; `predicted` is the next frame's camera from world.

        Keypoints without a map point stand where their depth puts them. Where those are few, keypoints without depth
        say how the camera turns and nothing of how it moves: they lie far away in the direction in which the predicted
        camera sees what stands between the sensor's reach and infinity.
        """
        alive = self._map.columns.point_alive
        points = np.where((last.points >= 0) & alive[last.points], last.points, -1).astype(np.int32)
        mapped = points >= 0
        is_placed = mapped | last.features.has_depth
        far = self._reach.see(last.features.depth[last.features.has_depth]) / _REACH_TO_MIDDLE
        needs_bearings = np.isfinite(far) and np.count_nonzero(mapped) < self._config.bearings_below
        rows = np.arange(last.features.rows) if needs_bearings else np.flatnonzero(is_placed)
        pose = self.pose(last)
        depth = np.where(is_placed[rows], last.features.depth[rows], far).astype(np.float32)
        in_camera = self._sensor.back_project(last.features.pixels[rows], depth)
        world_from_camera = inverse_transform(pose)
        positions = in_camera @ world_from_camera[:3, :3].T + world_from_camera[:3, 3]
        known = mapped[rows]
        positions[known] = self._map.columns.position[points[rows][known]]
        centre = inverse_transform(predicted)[:3, 3]
        positions[~is_placed[rows]] = centre + _BEYOND * (positions[~is_placed[rows]] - centre)
        shift = self._sensor.intrinsics[0] * np.linalg.norm((predicted @ world_from_camera)[:3, 3])
        spread = np.where(is_placed[rows], 0.0, (shift / far) ** 2)
        return Sighted(rows, points[rows], positions, spread)


_REACHED = 0.95
"""Share of the depth readings within the reach: the last few may be false."""

_REACH_TO_MIDDLE = 0.5
"""The middle, by inverse depth, between the sensor's reach and infinity, in parts of the reach's inverse."""

_BEYOND = 100.0
"""Times as far as that middle: from there a camera's step changes no direction."""

_LEVELS_FOR_UNKNOWN_MOTION = 2
"""Pyramid levels more for flow where the motion cannot be predicted: four times the reach."""
