"""RGB-D visual SLAM: frame in, pose out."""

import numpy as np

from lpslam.camera import PinholeCamera
from lpslam.config import SlamConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.features import FeatureExtractor
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

    def process(self, frame: RgbdFrame) -> TrackedFrame:
        """Track one frame and let the map grow with it."""
        tracked = self._tracker.track(frame)
        self.trajectory.append(tracked)
        if tracked.is_keyframe:
            self._local_mapper.process(tracked.keyframe)
            self._tracker.after_map_change()
        return tracked
