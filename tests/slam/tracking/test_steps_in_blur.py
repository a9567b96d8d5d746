"""A fast turn in the dark: whole pictures beside keypoints that blur has made streaks of."""

import numpy as np
import pytest
from slam_scenes import pose_error

from lpslam.config import SimulationConfig, SlamConfig
from lpslam.frames import RgbdFrame
from lpslam.simulation.source import MallSource
from lpslam.slam.system import RgbdSlam

pytestmark = pytest.mark.slow

FRAMES = range(345, 377)
FAST = np.radians(2.2)
"""Turn from frame to frame from which on a step counts: 20 pixels, of which exposing takes four fifths."""


def fast_steps(mall: MallSource, frames: list[RgbdFrame], travel: float) -> np.ndarray:
    """(n,) metres by which each fast step is off; pictures are asked where they move by a share of their width."""
    config = SlamConfig()
    tracking = config.tracking.model_copy(update={"pictured_travel": travel})
    slam = RgbdSlam(mall.camera, config.model_copy(update={"tracking": tracking}))
    assert all(slam.process(frame).is_tracked for frame in frames)
    slam.finish()
    _, estimated = slam.trajectory.world_from_camera(slam.map)
    true = mall.ground_truth.world_from_camera[FRAMES.start : FRAMES.stop]
    steps = [[np.linalg.inv(poses[k]) @ poses[k + 1] for k in range(len(frames) - 1)] for poses in (true, estimated)]
    return np.array([
        pose_error(found, step)[0]
        for step, found in zip(*steps, strict=True)
        if pose_error(step, np.eye(4))[1] > FAST
    ])  # fmt: skip


def test_steps_of_a_fast_turn_are_nearer_with_whole_pictures() -> None:
    mall = MallSource(302, options=SimulationConfig(light=0.3, max_turn_rate=134.0))
    frames = [mall.frame(index) for index in FRAMES]
    beside, alone = (fast_steps(mall, frames, travel) for travel in (SlamConfig().tracking.pictured_travel, np.inf))
    assert len(beside) >= 15
    assert np.median(beside) < 0.8 * np.median(alone)
