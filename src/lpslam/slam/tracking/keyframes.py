"""When a frame becomes a keyframe, and what it brings to the map (ORB-SLAM2, III-E)."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.config import KeyframeConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.association import Estimate
from lpslam.slam.features import Features
from lpslam.slam.kernels import graph
from lpslam.slam.map import SlamMap
from lpslam.slam.mapping.far_points import FarPoints
from lpslam.slam.sensor import SensorModel


class Keyframes:
    """Asks for keyframes where the view has moved on or close points are missing, and adds them to the map.

    How far the view has moved is the share of matches left of the most since the last keyframe: unlike the points of
    the reference keyframe, that does not depend on how many keyframes have confirmed them.
    """

    def __init__(self, slam_map: SlamMap, sensor: SensorModel, far_points: FarPoints, config: KeyframeConfig) -> None:
        self._map = slam_map
        self._far_points = far_points
        self._sensor = sensor
        self._config = config
        self._last_time = -np.inf
        self._most_matches = 0
        self._most_at = -np.inf

    def wants(
        self,
        timestamp: float,
        features: Features,
        is_matched: NDArray[np.bool_],
        is_mapping_idle: bool = True,
        frame_interval: float = 0.0,
    ) -> bool:
        """Judge a tracked frame.

        Args:
            timestamp: seconds.
            features: its keypoints, n rows.
            is_matched: (n,) which of them see a map point.
            is_mapping_idle: whether the keyframes before are worked into the map; what is not urgent waits for that.
            frame_interval: seconds since the frame before.
        """
        config = self._config
        matches = int(is_matched.sum())
        if matches >= self._most_matches:
            self._most_matches, self._most_at = matches, timestamp
        elapsed = timestamp - self._last_time
        # The frame that comes nearest to it: at 15 frames a second the next but one would be a third late.
        grace = 0.5 * frame_interval + _ROUNDING
        if elapsed < config.min_interval - grace and matches >= config.urgent_share * self._most_matches:
            return False
        close = features.has_depth & (features.depth < config.close_depth)
        tracked, untracked = int((close & is_matched).sum()), int((close & ~is_matched).sum())
        needs_close = tracked < config.close_tracked and untracked > config.close_untracked
        # A view that leaves the map gets a keyframe before it has left: the fall of the matches is drawn on.
        fall = (self._most_matches - matches) / max(timestamp - self._most_at, config.foresight)
        thinned = matches - fall * config.foresight < config.tracked_share * self._most_matches
        due = elapsed >= config.max_interval and matches < config.due_share * self._most_matches
        return thinned or needs_close or (due and is_mapping_idle)

    def is_known_view(self, estimate: Estimate, reference: int) -> bool:
        """Whether a keyframe was taken from here already and the map explains the view: one more would tell nothing.

        Without this a robot on its daily round would map the same place for ever.

        Args:
            estimate: of the frame.
            reference: a keyframe of its sub-map.
        """
        slam_map, config = self._map, self._config
        if estimate.matches < config.known_matches:
            return False
        living, submaps = slam_map.living_keyframes(), slam_map.submaps()
        poses = slam_map.columns.camera_from_world[living[submaps[living] == submaps[reference]]]
        centres = -np.einsum("nji,nj->ni", poses[:, :3, :3], poses[:, :3, 3])
        apart = np.linalg.norm(centres - inverse_transform(estimate.camera_from_world)[:3, 3], axis=1)
        cosine = poses[:, 2, :3] @ estimate.camera_from_world[2, :3]
        return bool(((apart < config.known_distance) & (cosine > np.cos(config.known_turn))).any())

    def add(self, frame: RgbdFrame, features: Features, estimate: Estimate, reference: int) -> tuple[int, Estimate]:
        """Put a frame into the map and make points of its keypoints: with depth, and where depth does not reach.

        Args:
            frame: to be added.
            features, estimate: its keypoints and its pose.
            reference: the parent; -1 founds a map or sub-map, and every keypoint with depth becomes a point.

        Returns:
            The keyframe's id, and the estimate with the new points.
        """
        slam_map, config = self._map, self._config
        keyframe = slam_map.add_keyframe(
            estimate.camera_from_world,
            features,
            self._sensor.disparity_information(features.depth),
            frame.timestamp,
            frame.index,
            reference,
        )
        graph.link_all(slam_map.columns, estimate.points, int(slam_map.columns.keyframe_slot[keyframe]))
        free = np.flatnonzero(features.has_depth & (estimate.points < 0))
        nearest = free[np.argsort(features.depth[free], kind="stable")]
        near = len(nearest) if reference < 0 else int((features.depth[nearest] < config.point_depth).sum())
        chosen = nearest[: max(near, config.points_in_view - estimate.matches)].astype(np.int32)
        in_camera = self._sensor.back_project(features.pixels[chosen], features.depth[chosen])
        world_from_camera = inverse_transform(estimate.camera_from_world)
        first = slam_map.add_points(
            keyframe, chosen, in_camera @ world_from_camera[:3, :3].T + world_from_camera[:3, 3]
        )
        points = estimate.points.copy()
        points[chosen] = np.arange(first, first + len(chosen))
        far = self._far_points.add(keyframe, frame.depth, features, points < 0)
        points = np.where(far >= 0, far, points)
        self._last_time, self._most_matches, self._most_at = frame.timestamp, 0, frame.timestamp
        return keyframe, replace(estimate, points=points)


_ROUNDING = 5e-4
"""Seconds to which timestamps are rounded at worst."""
