"""A hurried camera in the dark before a wall whose pattern repeats, and a machine too busy to take every frame."""

import numpy as np
import pytest
from slam_scenes import pose_error

from lpslam.config import SimulationConfig
from lpslam.frames import RgbdFrame
from lpslam.simulation.source import MallSource
from lpslam.slam.system import RgbdSlam

pytestmark = pytest.mark.slow

FRAMES = range(299, 341)


@pytest.fixture(scope="module")
def mall() -> MallSource:
    """After closing time; the camera turns by up to 134 degrees a second."""
    return MallSource(302, options=SimulationConfig(light=0.3, max_turn_rate=134.0))


@pytest.fixture(scope="module")
def frames(mall: MallSource) -> list[RgbdFrame]:
    return [mall.frame(index) for index in FRAMES]


@pytest.mark.parametrize("missing", [range(319, 325), range(322, 328), range(325, 329), range(325, 331)], ids=str)
def test_a_pose_after_a_gap_is_not_taken_from_a_pattern_that_repeats(
    mall: MallSource, frames: list[RgbdFrame], missing: range
) -> None:
    """Windows around a prediction that is some degrees off find the next bunch of leaves, and enough of them agree."""
    slam = RgbdSlam(mall.camera)
    kept = [frame for frame in frames if frame.index not in missing]
    tracked = [slam.process(frame) for frame in kept]
    slam.finish()
    assert all(frame.is_tracked for frame in tracked)
    _, estimated = slam.trajectory.world_from_camera(slam.map)
    true = mall.ground_truth.world_from_camera[[frame.index for frame in kept]]
    for before in range(len(kept) - 1):
        step = np.linalg.inv(estimated[before]) @ estimated[before + 1]
        metres, _ = pose_error(step, np.linalg.inv(true[before]) @ true[before + 1])
        assert metres < 0.06, f"from frame {kept[before].index} to {kept[before + 1].index}"
