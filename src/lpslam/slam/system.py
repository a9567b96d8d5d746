"""RGB-D visual SLAM: frame in, pose out."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import SlamConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.features import FeatureExtractor
from lpslam.slam.levelling import floor_normal, level_rotation
from lpslam.slam.local_mapping import LocalMapper
from lpslam.slam.map import SlamMap
from lpslam.slam.sensor import SensorModel
from lpslam.slam.state import TrackedFrame
from lpslam.slam.tracking import Tracker
from lpslam.slam.trajectory import Trajectory


class RgbdSlam:
    """Tracks a camera and maps what it sees.

    Frames are processed in the caller's thread, in order: the same frames give the same map, to the bit.
    """

    def __init__(self, camera: PinholeCamera, config: SlamConfig | None = None) -> None:
        config = config or SlamConfig()
        self.camera = camera
        self.sensor = SensorModel.of(camera, config)
        extractor = FeatureExtractor(camera, config.features)
        self.map = SlamMap(extractor.capacity, self.sensor.scales)
        self.trajectory = Trajectory()
        self._tracker = Tracker(extractor, self.sensor, self.map, config)
        self._local_mapper = LocalMapper(self.map, self.sensor, config)
        self._levelling = config.levelling
        self._floor_views: list[tuple[int, NDArray[np.float64]]] = []

    def process(self, frame: RgbdFrame) -> TrackedFrame:
        """Track one frame and let the map grow with it."""
        tracked = self._tracker.track(frame)
        if tracked.is_keyframe:
            self._local_mapper.process(tracked.keyframe)
            self._tracker.after_map_change()
            self._look_for_floor(frame, tracked.keyframe)
            world_from_camera = self.map.world_from_keyframe(tracked.keyframe)
            tracked = replace(tracked, world_from_camera=world_from_camera)
        self.trajectory.append(tracked)
        return tracked

    def finish(self) -> None:
        """Level the map by all views of the floor together; call when the last frame has been processed."""
        if self._floor_views:
            self._level(np.median([self.map.world_from_keyframe(k)[:3, :3] @ n for k, n in self._floor_views], axis=0))

    def _look_for_floor(self, frame: RgbdFrame, keyframe: int) -> None:
        """Turn the map so that z is up when the floor is first seen; later views serve `finish`."""
        if len(self._floor_views) >= self._levelling.max_views:
            return
        camera_from_world = self.map.camera_from_world(keyframe)
        normal = floor_normal(frame.depth, self.camera, camera_from_world[:3, 2], self._levelling)
        if normal is None:
            return
        self._floor_views.append((keyframe, normal))
        if len(self._floor_views) == 1:
            self._level(camera_from_world[:3, :3].T @ normal)

    def _level(self, up_in_world: NDArray[np.float64]) -> None:
        level_from_world = level_rotation(up_in_world)
        self.map.transform(level_from_world)
        self._tracker.change_world(level_from_world)

    @property
    def is_levelled(self) -> bool:
        """Whether the floor has been seen, so that z is up."""
        return bool(self._floor_views)
