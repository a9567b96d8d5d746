"""Places of a recorded room: of what its map holds, a hand-held camera sees far less again than in rendered ones."""

from pathlib import Path

import numpy as np
import pytest
from slam_scenes import UNCHECKED, pose_error

from lpslam.camera import inverse_transform
from lpslam.config import SlamConfig
from lpslam.slam.features import FeatureExtractor, gray_of
from lpslam.slam.places.locating import Locator
from lpslam.slam.system import RgbdSlam
from lpslam.sources.ground_truth import read_ground_truth
from lpslam.sources.open import open_source

KITCHEN = Path(__file__).parents[4] / "shared" / "data" / "redkitchen"
HALF, EVERY = 250, 10
CONFIG = SlamConfig()


@pytest.mark.skipif(not KITCHEN.is_dir(), reason="needs the red kitchen recording")
def test_views_of_the_other_half_of_a_kitchen_are_located_and_none_is_wrong() -> None:
    source = open_source(KITCHEN, checks=UNCHECKED)
    slam = RgbdSlam(source.camera, CONFIG)
    for frame in map(source.frame, range(HALF, len(source))):
        assert frame is not None
        slam.process(frame)
    slam.finish()
    times, poses = slam.trajectory.world_from_camera(slam.map)
    truth = read_ground_truth(KITCHEN)
    assert truth is not None
    true = {round(float(t), 3): pose for t, pose in zip(truth.timestamps, truth.world_from_camera, strict=True)}
    middle = len(times) // 2
    truth_from_map = true[round(float(times[middle]), 3)] @ inverse_transform(poses[middle])
    locator = Locator(slam.map, slam.sensor, CONFIG.tracking, CONFIG.locating)
    extractor = FeatureExtractor(source.camera, CONFIG.features)
    views = range(0, HALF, EVERY)
    errors = []
    for frame in map(source.frame, views):
        assert frame is not None
        features = extractor.extract(frame, gray_of(frame.rgb))
        found = [locator.locate(features, int(keyframe)) for keyframe in slam.map.living_keyframes()]
        best = max((place for place in found if place), key=lambda place: place.inliers, default=None)
        if best is not None:
            world_from_camera = truth_from_map @ inverse_transform(best.camera_from_world)
            errors.append(pose_error(world_from_camera, true[round(frame.timestamp, 3)])[0])
    # 40 to 52 %, as the map begins one frame earlier or later.
    assert len(errors) >= 0.4 * len(views)
    assert np.max(errors) < 0.3
