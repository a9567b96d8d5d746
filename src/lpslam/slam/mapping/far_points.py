"""Points beyond the sensor's reach: of them the direction is known at once, the distance when the camera has moved.

Where no depth was read, a keypoint lies somewhere between the reach and infinity. It becomes a point of the map with
the mean and the sigma of its inverse depth in the keyframe that saw it first (Civera et al. 2008); each keyframe that
sees it again, or reads its depth, makes the sigma less. Until it is small the point holds poses by its direction, and
takes no part in bundle adjustment.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.config import FarPointConfig
from lpslam.slam.carrying import inverses
from lpslam.slam.features import Features
from lpslam.slam.kernels import graph
from lpslam.slam.kernels.rays import measure_inverse
from lpslam.slam.kernels.reprojection import CHI2_PIXEL
from lpslam.slam.map import SlamMap
from lpslam.slam.rays import is_unsure, rays_of
from lpslam.slam.sensor import Reach, SensorModel
from lpslam.slam.tracking.following import choose_followed

_Matrix = NDArray[np.float64]
_Rows = NDArray[np.int32]


class FarPoints:
    """Makes points of keypoints without depth, and measures how far they are. The caller holds the map's lock."""

    def __init__(self, slam_map: SlamMap, sensor: SensorModel, config: FarPointConfig) -> None:
        self._map = slam_map
        self._sensor = sensor
        self._config = config
        self._reach = Reach(config.least_depths, config.reach_share)

    def add(self, keyframe: int, depth: NDArray[np.float32], features: Features, is_free: NDArray[np.bool_]) -> _Rows:
        """Make points of a new keyframe's keypoints (n) that are free and lie where no depth was read.

        Args:
            keyframe: the newest.
            depth: (h, w) metres, its depth image.
            features: its keypoints.
            is_free: (n,) which of them see no point.

        Returns:
            (n,) ids of the new points, -1 elsewhere.
        """
        config, slam_map = self._config, self._map
        made = np.full(features.rows, -1, np.int32)
        reach = self._reach.see(features.depth[features.has_depth])
        room = min(config.in_view - int(np.count_nonzero(~is_free)), config.most)
        if np.isinf(reach) or room <= 0:
            return made
        free = np.flatnonzero(is_free & ~features.has_depth)
        free = free[_is_in_hole(depth, features.pixels[free], config.hole_width, config.hole_share)]
        if not len(free):
            return made
        nothing = np.zeros(len(free), np.bool_)
        chosen = free[choose_followed(features.pixels[free], features.octave[free], nothing, room)]
        mean, sigma = 0.5 / reach, _UNIFORM / reach
        in_camera = self._sensor.back_project(features.pixels[chosen], np.full(len(chosen), 1.0 / mean, np.float32))
        world_from_camera = slam_map.world_from_keyframe(keyframe)
        positions = in_camera @ world_from_camera[:3, :3].T + world_from_camera[:3, 3]
        first = slam_map.add_points(keyframe, chosen.astype(np.int32), positions)
        slam_map.columns.inverse_sigma[first : slam_map.point_count] = sigma
        made[chosen] = np.arange(first, slam_map.point_count)
        return made

    def measure(self, keyframe: int) -> None:
        """Take what a keyframe tells of the points that are not sure yet; drop those that contradict themselves."""
        slam_map, m = self._map, self._map.columns
        unsure = np.flatnonzero(
            slam_map.columns.inverse_sigma[: slam_map.point_count] * m.point_alive[: slam_map.point_count]
        )
        # The keyframe that saw a point first holds its direction.
        gone = m.keyframe_slot[m.first_keyframe[unsure]] < 0
        graph.remove_points(m, unsure[gone].astype(np.int32))
        slot = int(m.keyframe_slot[keyframe])
        if slot < 0:
            return
        points = m.point[slot, : m.feature_count[slot]]
        rows = np.flatnonzero(is_unsure(slam_map, points))
        rows = rows[m.first_keyframe[points[rows]] != keyframe]
        if len(rows):
            self._measure(keyframe, points[rows].copy(), slot, rows)

    def _measure(self, keyframe: int, points: _Rows, slot: int, rows: NDArray[np.int64]) -> None:
        """Measure points (k ids) anew by the keypoints (k rows) of a keyframe."""
        config, slam_map, m = self._config, self._map, self._map.columns
        anchors = m.camera_from_world[m.first_keyframe[points]]
        origin, direction, inverse = rays_of(slam_map, points)
        bearing = np.einsum("nij,nj->ni", anchors[:, :3, :3], direction)
        camera_from_anchor = np.ascontiguousarray(m.camera_from_world[keyframe] @ inverses(anchors))
        information = self._sensor.pixel_information[m.octave[slot, rows]] / 2.0  # both sights have their noise
        mean, sigma, left = measure_inverse(
            camera_from_anchor,
            bearing,
            m.pixels[slot, rows],
            information.astype(np.float32),
            inverse,
            slam_map.columns.inverse_sigma[points].astype(np.float64),
            self._sensor.intrinsics,
        )
        contradicts = (left > CHI2_PIXEL) | (mean + config.behind_sigmas * sigma < 0.0)
        graph.remove_points(m, points[contradicts])
        held = np.flatnonzero(~contradicts)
        points, mean, sigma = points[held], np.maximum(mean[held], 1.0 / config.farthest), sigma[held]
        m.position[points] = origin[held] + direction[held] / mean[:, None]
        slam_map.columns.inverse_sigma[points] = np.where(sigma < config.sure_share * mean, 0.0, sigma)
        self._take_depths(keyframe, points, slot, rows[held])
        graph.refresh_points(m, points, slam_map.scales)

    def _take_depths(self, keyframe: int, points: _Rows, slot: int, rows: NDArray[np.int64]) -> None:
        """Points whose depth a keyframe has read stand there."""
        m = self._map.columns
        read = np.flatnonzero(m.has_depth[slot, rows] & (self._map.columns.inverse_sigma[points] > 0))
        in_camera = self._sensor.back_project(m.pixels[slot, rows[read]], m.depth[slot, rows[read]])
        world_from_camera = inverse_transform(m.camera_from_world[keyframe])
        m.position[points[read]] = in_camera @ world_from_camera[:3, :3].T + world_from_camera[:3, 3]
        self._map.columns.inverse_sigma[points[read]] = 0.0

    def forget_unsure(self) -> None:
        """The last keyframe has come: what stands nowhere yet is dropped."""
        living = self._map.living_points()
        graph.remove_points(self._map.columns, living[self._map.columns.inverse_sigma[living] > 0])


def _is_in_hole(
    depth: NDArray[np.float32], pixels: NDArray[np.float32], width: float, share: float
) -> NDArray[np.bool_]:
    """(n,) whether next to nothing was read around pixels (n, 2): at an edge or in a shadow, much was."""
    height, across = depth.shape
    side = max(round(width * across), 3)
    read = cv2.blur((depth > 0).astype(np.float32), (side, side))
    column = np.clip(np.rint(pixels[:, 0]).astype(int), 0, across - 1)
    row = np.clip(np.rint(pixels[:, 1]).astype(int), 0, height - 1)
    is_empty: NDArray[np.bool_] = read[row, column] < share
    return is_empty


_UNIFORM = 1.0 / np.sqrt(12.0)
"""Sigma of what lies anywhere between the reach and infinity, by inverse depth, in parts of the reach's inverse."""
