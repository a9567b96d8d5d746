"""Reading and remembering apart from SLAM: every text hangs on the camera's true poses."""

from dataclasses import asdict

import numpy as np

from lpslam import pipeline
from lpslam.camera import inverse_transform
from lpslam.config import Config
from lpslam.frames import FrameSource
from lpslam.language.offline import OfflineModel
from lpslam.mapfile.language_map import LanguageMap
from lpslam.poses import StampedPoses
from lpslam.slam.features import Features
from lpslam.slam.map import SlamMap
from lpslam.slam.state import TrackedFrame, TrackingState
from lpslam.slam.trajectory import Trajectory
from lpslam.text.mapper import TextMapper
from lpslam.text.reading.spotting import TextSpotter

FRAMES_A_KEYFRAME = 30


def map_with_true_poses(source: FrameSource, truth: StampedPoses, config: Config, spotter: TextSpotter) -> LanguageMap:
    """Map the texts of a recording in step, with a keyframe every second and nothing but its pose in it."""
    slam_map, trajectory, none = SlamMap(1, np.ones(1)), Trajectory(), np.zeros(0, np.float32)
    octave, descriptor = np.zeros(0, np.uint8), np.zeros((0, 4), np.uint64)
    features = Features(np.zeros((0, 2), np.float32), none, none, none > 0, octave, none, descriptor)
    mapper = TextMapper(source.camera, spotter, config.text, OfflineModel())
    for count, frame in enumerate(source):
        world_from_camera = truth.world_from_camera[np.abs(truth.timestamps - frame.timestamp).argmin()]
        is_keyframe = count % FRAMES_A_KEYFRAME == 0
        if is_keyframe:
            pose = inverse_transform(world_from_camera)
            parent = slam_map.keyframe_count - 1
            keyframe = slam_map.add_keyframe(pose, features, none, frame.timestamp, frame.index, parent)
        tracked = TrackedFrame(
            index=frame.index,
            timestamp=frame.timestamp,
            state=TrackingState.TRACKING,
            keyframe=keyframe,
            keyframe_from_camera=slam_map.camera_from_world(keyframe) @ world_from_camera,
            world_from_camera=world_from_camera,
            matches=0,
            is_keyframe=is_keyframe,
        )
        trajectory.append(tracked)
        mapper.observe(frame, tracked)
    statistics = {"run": {"frames_dropped": 0.0}, "reading": asdict(mapper.statistics)}
    world = LanguageMap(source.camera, slam_map, trajectory, mapper.text_map, source.name, statistics)
    pipeline.distill(world)
    return world
