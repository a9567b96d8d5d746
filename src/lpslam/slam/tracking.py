"""Tracking: the pose of each frame against the map (ORB-SLAM, V; ORB-SLAM2, III).

Motion model, else reference keyframe, then the local map; a frame that fits neither is lost, says why, and every
further frame is tried against remembered keyframes until one fits.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.config import SlamConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.features import FeatureExtractor, Features
from lpslam.slam.kernels import graph, matching, pose
from lpslam.slam.kernels.geometry import orthonormalise
from lpslam.slam.keyframes import KeyframePolicy
from lpslam.slam.map import SlamMap
from lpslam.slam.sensor import SensorModel
from lpslam.slam.state import TrackedFrame, TrackingState

_Matrix = NDArray[np.float64]
_Rows = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class _Estimate:
    """A frame's pose with the map points that hold it.

    Attributes:
        camera_from_world: 4×4.
        points: (n,) the map point of each keypoint, or -1; inliers only.
        inliers: how many keypoints agree with the pose, counting points that are not in the map.
    """

    camera_from_world: _Matrix
    points: _Rows
    inliers: int


class Tracker:
    """Follows the camera through frames that come in order of time."""

    def __init__(self, extractor: FeatureExtractor, sensor: SensorModel, slam_map: SlamMap, config: SlamConfig) -> None:
        self._map = slam_map
        self._sensor = sensor
        self._config = config.tracking
        self._keyframe_config = config.keyframes
        self._extractor = extractor
        self.state = TrackingState.INITIALISING
        self._reference = -1
        self._features: Features | None = None
        self._last: _Estimate | None = None
        self._last_from_reference: _Matrix | None = None
        self._current_from_last: _Matrix | None = None
        self._policy = KeyframePolicy(config.keyframes)
        self._usual_sharpness = 0.0

    def track(self, frame: RgbdFrame) -> TrackedFrame:
        """Find the pose of a frame; a frame that should become a keyframe is added to the map."""
        features = self._extractor.extract(frame)
        if self._map.keyframe_count == 0:
            return self._initialise(frame, features)
        if self.state is TrackingState.LOST:
            estimate = self._recover(features)
            needed = self._config.min_recovery_inliers
        else:
            estimate = self._follow_motion(features) or self._follow_reference(features, self._reference)
            needed = self._config.min_inliers
        if estimate is not None:
            estimate = self._follow_local_map(features, estimate)
        if estimate is None or int((estimate.points >= 0).sum()) < needed:
            return self._lose(frame, features, estimate)
        return self._accept(frame, features, estimate)

    # Beginning and end of tracking -------------------------------------------------------------------------------

    def _initialise(self, frame: RgbdFrame, features: Features) -> TrackedFrame:
        """The first frame with enough depth founds the map: every keypoint with depth is a point."""
        depths = int(features.has_depth.sum())
        if depths < self._keyframe_config.min_start_depths:
            reason = f"waiting for a first view: {depths} of {features.rows} keypoints have depth, "
            return self._without_pose(
                frame, TrackingState.INITIALISING, reason + f"{self._keyframe_config.min_start_depths} needed"
            )
        self._remember_sharpness(frame)
        start = _Estimate(inverse_transform(_FIRST_WORLD_FROM_CAMERA), np.full(features.rows, -1, np.int32), depths)
        self.state = TrackingState.TRACKING
        return self._commit(frame, features, self._add_keyframe(frame, features, start, everything=True), True, "")

    def _lose(self, frame: RgbdFrame, features: Features, estimate: _Estimate | None) -> TrackedFrame:
        matches = 0 if estimate is None else int((estimate.points >= 0).sum())
        parts = [f"{matches} map points matched", f"{features.rows} keypoints"]
        if features.rows:
            parts.append(f"{features.has_depth.mean():.0%} of them with depth")
        sharpness = _sharpness(frame)
        if self._usual_sharpness > 0 and sharpness < self._config.blur_ratio * self._usual_sharpness:
            parts.append(f"blurred (sharpness {sharpness / self._usual_sharpness:.0%} of the usual)")
        self.state = TrackingState.LOST
        self._last, self._features, self._current_from_last = None, None, None
        return self._without_pose(frame, TrackingState.LOST, ", ".join(parts))

    def _without_pose(self, frame: RgbdFrame, state: TrackingState, reason: str) -> TrackedFrame:
        return TrackedFrame(frame.index, frame.timestamp, state, self._reference, None, None, 0, False, reason)

    def _accept(self, frame: RgbdFrame, features: Features, estimate: _Estimate) -> TrackedFrame:
        matches = int((estimate.points >= 0).sum())
        weak = matches < self._config.weak_inliers
        self.state = TrackingState.WEAK if weak else TrackingState.TRACKING
        reason = f"{matches} map points matched" if weak else ""
        if not weak:
            self._remember_sharpness(frame)
        wanted = self._policy.wants(frame.timestamp, features, estimate.points >= 0)
        if wanted:
            estimate = self._add_keyframe(frame, features, estimate, everything=False)
        return self._commit(frame, features, estimate, wanted, reason)

    def _commit(
        self, frame: RgbdFrame, features: Features, estimate: _Estimate, is_keyframe: bool, reason: str
    ) -> TrackedFrame:
        """Keep the frame as the one that the next is predicted from."""
        world_from_camera = inverse_transform(estimate.camera_from_world)
        if self._last is not None:
            self._current_from_last = estimate.camera_from_world @ inverse_transform(self._last.camera_from_world)
        reference_from_world = self._map.camera_from_world(self._reference)
        self._features, self._last = features, estimate
        self._last_from_reference = estimate.camera_from_world @ inverse_transform(reference_from_world)
        return TrackedFrame(
            frame.index,
            frame.timestamp,
            self.state,
            self._reference,
            reference_from_world @ world_from_camera,
            world_from_camera,
            int((estimate.points >= 0).sum()),
            is_keyframe,
            reason,
        )

    def after_map_change(self) -> None:
        """Move the last frame with its reference keyframe after mapping has adjusted the map."""
        if self._last is None or self._last_from_reference is None:
            return
        moved = self._last_from_reference @ self._map.camera_from_world(self._reference)
        alive = self._map.columns.point_alive
        points = np.where((self._last.points >= 0) & alive[self._last.points], self._last.points, -1)
        self._last = replace(self._last, camera_from_world=moved, points=points.astype(np.int32))

    def change_world(self, new_from_old_world: _Matrix) -> None:
        """Follow a change of the map's world frame (4×4)."""
        if self._last is not None:
            pose = self._last.camera_from_world @ inverse_transform(new_from_old_world)
            self._last = replace(self._last, camera_from_world=pose)

    # Finding the pose --------------------------------------------------------------------------------------------

    def _follow_motion(self, features: Features) -> _Estimate | None:
        """Constant velocity, then the last frame's points in windows around where they should appear."""
        if self._last is None or self._features is None or self._current_from_last is None:
            return None
        last, config = self._features, self._config
        predicted = self._current_from_last @ self._last.camera_from_world
        orthonormalise(predicted)
        mapped = self._last.points >= 0
        rows = np.flatnonzero(mapped | last.has_depth).astype(np.int32)
        if len(rows) < config.min_pose_inliers:
            return None
        points = self._last.points[rows]
        in_camera = self._sensor.back_project(last.pixels[rows], last.depth[rows])
        world_from_last = inverse_transform(self._last.camera_from_world)
        positions = in_camera @ world_from_last[:3, :3].T + world_from_last[:3, 3]
        is_mapped = points >= 0
        positions[is_mapped] = self._map.columns.position[points[is_mapped]]
        for radius in (config.motion_radius, 2 * config.motion_radius):
            match = self._search_last_frame(features, last, rows, positions, predicted, radius)
            if np.count_nonzero(match >= 0) >= config.min_motion_matches:
                return self._optimise(features, predicted, match, positions, points)
        return None

    def _search_last_frame(
        self,
        features: Features,
        last: Features,
        rows: _Rows,
        positions: _Matrix,
        camera_from_world: _Matrix,
        radius: float,
    ) -> _Rows:
        """(n,) for each keypoint the row of `positions` that it sees, or -1."""
        fx, fy, cx, cy, bf = self._sensor.intrinsics
        x, y, z = (positions @ camera_from_world[:3, :3].T + camera_from_world[:3, 3]).T
        width, height = self._sensor.image_size
        with np.errstate(divide="ignore", invalid="ignore"):
            u, v = fx * x / z + cx, fy * y / z + cy
            ok = (z > 0.05) & (u >= 0) & (u < width) & (v >= 0) & (v < height)
            projections = np.column_stack([u, v, u - bf / z])[ok].astype(np.float32)
        kept = np.flatnonzero(ok)
        octave = last.octave[rows[kept]].astype(np.int32)
        radii = (radius * self._sensor.scales[octave]).astype(np.float32)
        match = matching.search_windows(
            projections,
            radii,
            octave - 1,
            octave + 1,
            last.descriptor[rows[kept]],
            self._keypoints(features),
            np.zeros(features.rows, np.bool_),
            self._config.hamming_loose,
            1.0,
        )
        matching.keep_consistent_rotations(match, last.angle[rows[kept]], features.angle)
        return np.where(match >= 0, kept[match], -1).astype(np.int32)

    def _keypoints(self, features: Features) -> matching.Keypoints:
        starts, order, size = matching.build_grid(features.pixels, *self._sensor.image_size)
        return matching.Keypoints(
            features.pixels, features.u_right, features.has_depth, features.octave, features.descriptor,
            starts, order, size,
        )  # fmt: skip

    def _optimise(
        self, features: Features, guess: _Matrix, match: _Rows, positions: _Matrix, points: _Rows
    ) -> _Estimate | None:
        """Pose from matches; `match` (n,) gives the row of `positions` and of `points` for each keypoint."""
        keypoints = np.flatnonzero(match >= 0)
        rows = match[keypoints]
        depth = features.depth[keypoints]
        camera_from_world, inlier, _, _ = pose.optimise_pose(
            guess,
            positions[rows],
            features.pixels[keypoints],
            features.pixels[keypoints, 0] - features.u_right[keypoints],
            features.has_depth[keypoints],
            self._sensor.pixel_information[features.octave[keypoints]],
            self._sensor.disparity_information(depth),
            self._sensor.intrinsics,
            self._config.pose_rounds,
            self._config.pose_iterations,
        )
        inliers = int(inlier.sum())
        if inliers < self._config.min_pose_inliers:
            return None
        held = np.full(features.rows, -1, np.int32)
        held[keypoints[inlier]] = points[rows[inlier]]
        return _Estimate(camera_from_world, held, inliers)

    def _follow_reference(self, features: Features, keyframe: int) -> _Estimate | None:
        """Match descriptors against a keyframe's points, wherever they are in the image."""
        m = self._map.columns
        slot = int(m.keyframe_slot[keyframe])
        if slot < 0:
            return None
        rows = np.flatnonzero(m.point[slot, : m.feature_count[slot]] >= 0).astype(np.int32)
        match = matching.match_brute_force(
            m.descriptor[slot, rows], features.descriptor, self._config.hamming_strict, self._config.ratio_brute_force
        )
        matching.keep_consistent_rotations(match, m.angle[slot, rows], features.angle)
        if np.count_nonzero(match >= 0) < self._config.min_motion_matches:
            return None
        points = m.point[slot, rows]
        guess = self._last.camera_from_world if self._last is not None else m.camera_from_world[keyframe].copy()
        return self._optimise(features, guess, match, m.position[points], points)

    def _recover(self, features: Features) -> _Estimate | None:
        """Try the newest keyframes and those around the place where tracking was lost."""
        m = self._map.columns
        living = self._map.living_keyframes()
        near = self._map.covisible(self._reference, 1) if self._map.is_alive(self._reference) else living[:0]
        half = self._config.recovery_keyframes // 2
        tried = dict.fromkeys([self._reference, *living[::-1][:half].tolist(), *near[:half].tolist()])
        best: _Estimate | None = None
        for keyframe in tried:
            estimate = self._follow_reference(features, keyframe) if m.keyframe_slot[keyframe] >= 0 else None
            if estimate is not None and (best is None or estimate.inliers > best.inliers):
                best = estimate
        return best

    def _follow_local_map(self, features: Features, estimate: _Estimate) -> _Estimate | None:
        """Search the points of covisible keyframes near their projections, and optimise with all matches."""
        slam_map, sensor, config = self._map, self._sensor, self._config
        m = slam_map.columns
        local = self._local_keyframes(estimate.points)
        if not len(local):
            return estimate
        self._reference = int(local[0])
        candidates = graph.points_of(m, local, slam_map.point_count)
        held = estimate.points[estimate.points >= 0]
        is_held = np.zeros(slam_map.point_count, np.bool_)
        is_held[held] = True
        kept, projections, levels, cosines = matching.project_candidates(
            candidates[~is_held[candidates]],
            m.position,
            m.normal,
            m.distance_range,
            estimate.camera_from_world,
            sensor.intrinsics,
            sensor.image_size,
            len(sensor.scales),
            sensor.log_scale,
            config.min_view_cosine,
        )
        frontal = cosines > config.frontal_cosine
        radius = np.where(frontal, config.local_map_radius_frontal, config.local_map_radius)
        match = matching.search_windows(
            projections,
            (radius * sensor.scales[levels]).astype(np.float32),
            levels - 1,
            levels,
            m.point_descriptor[kept],
            self._keypoints(features),
            estimate.points >= 0,
            config.hamming_loose,
            config.ratio_local_map,
        )
        points = np.where(match >= 0, kept[match] if len(kept) else -1, estimate.points).astype(np.int32)
        rows = np.flatnonzero(points >= 0)
        numbering = np.full(features.rows, -1, np.int32)
        numbering[rows] = np.arange(len(rows))
        refined = self._optimise(
            features, estimate.camera_from_world, numbering, m.position[points[rows]], points[rows]
        )
        m.visible[kept] += 1
        m.visible[held] += 1
        if refined is not None:
            m.found[refined.points[refined.points >= 0]] += 1
        return refined

    def _local_keyframes(self, points: _Rows) -> _Rows:
        """Keyframes that share points with the frame, most first, then those that share points with them."""
        slam_map, limit = self._map, self._config.local_keyframes
        counts = graph.count_shared_points(slam_map.columns, points, slam_map.keyframe_count)
        order = np.argsort(-counts, kind="stable").astype(np.int32)
        first = order[: min(int(np.count_nonzero(counts)), limit)]
        if len(first) in (0, limit):
            return first
        around = graph.points_of(slam_map.columns, first, slam_map.point_count)
        counts = graph.count_shared_points(slam_map.columns, around, slam_map.keyframe_count)
        counts[first] = 0
        order = np.argsort(-counts, kind="stable").astype(np.int32)
        second = order[: min(int(np.count_nonzero(counts)), limit - len(first))]
        return np.concatenate([first, second])

    # Keyframes ---------------------------------------------------------------------------------------------------

    def _add_keyframe(self, frame: RgbdFrame, features: Features, estimate: _Estimate, everything: bool) -> _Estimate:
        """Put the frame into the map and make points of its keypoints with depth."""
        slam_map, config = self._map, self._keyframe_config
        keyframe = slam_map.add_keyframe(
            estimate.camera_from_world,
            features,
            self._sensor.disparity_information(features.depth),
            frame.timestamp,
            frame.index,
            self._reference,
        )
        slot = int(slam_map.columns.keyframe_slot[keyframe])
        graph.link_all(slam_map.columns, estimate.points, slot)
        free = np.flatnonzero(features.has_depth & (estimate.points < 0))
        nearest = free[np.argsort(features.depth[free], kind="stable")]
        wanted = len(nearest) if everything else int((features.depth[nearest] < config.point_depth).sum())
        held = int((estimate.points >= 0).sum())
        chosen = nearest[: max(wanted, config.points_in_view - held)].astype(np.int32)
        in_camera = self._sensor.back_project(features.pixels[chosen], features.depth[chosen])
        world_from_camera = inverse_transform(estimate.camera_from_world)
        first = slam_map.add_points(
            keyframe, chosen, in_camera @ world_from_camera[:3, :3].T + world_from_camera[:3, 3]
        )
        points = estimate.points.copy()
        points[chosen] = np.arange(first, first + len(chosen))
        self._reference = keyframe
        self._policy.made(frame.timestamp)
        return replace(estimate, points=points)

    def _remember_sharpness(self, frame: RgbdFrame) -> None:
        sharpness = _sharpness(frame)
        self._usual_sharpness += (sharpness - self._usual_sharpness) * (0.1 if self._usual_sharpness else 1.0)


_FIRST_WORLD_FROM_CAMERA = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
"""The map frame starts at the first camera with REP-103 axes: x forward, y left, z up."""


def _sharpness(frame: RgbdFrame) -> float:
    """Mean squared difference of neighbouring grey values at half resolution; falls with blur."""
    green = frame.rgb[::2, ::2, 1]
    return float(np.square(cv2.subtract(green[:, 1:], green[:, :-1]), dtype=np.float32).mean())
