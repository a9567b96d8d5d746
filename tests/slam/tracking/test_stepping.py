"""Steps told by whole pictures: how far they are believed, and when they are not."""

import cv2
import numpy as np
import pytest
from corner_room import CAMERA, CORNER, shot
from slam_scenes import descriptors_of, features_at, pose_error, rigid

from lpslam.config import PictureConfig, SlamConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.kernels.geometry import exponential, logarithm
from lpslam.slam.map import SlamMap
from lpslam.slam.mapping.relative_poses import RelativePoses
from lpslam.slam.sensor import SensorModel
from lpslam.slam.tracking.guesses import LastFrame
from lpslam.slam.tracking.stepping import Step, Stepping
from lpslam.slam.tracking.surfaces import Surfaces

CONFIG = SlamConfig()
SENSOR = SensorModel.of(CAMERA, CONFIG)
TURN = rigid([0.02, -0.01, 0.01], [0.004, 0.06, 0.0])
BLUR = 12
"""Poses over which a frame is exposed."""

Shot = tuple[np.ndarray, np.ndarray]


def blurred(camera_from_world: np.ndarray) -> Shot:
    """A picture that is exposed while the camera turns by half of `TURN` around a pose, and the depth at that pose."""
    twist = logarithm(TURN)
    shots = [
        shot(CORNER, exponential(twist * share) @ camera_from_world, 12.0)[0].astype(float)
        for share in np.linspace(-0.25, 0.25, BLUR)
    ]
    return np.mean(shots, axis=0).round().astype(np.uint8), shot(CORNER, camera_from_world, 12.0)[1]


def told_from_to(stepping: Stepping, before: Shot, now: Shot, expected: np.ndarray, at: float = 0.0) -> Step | None:
    nothing = features_at(np.zeros((0, 2)), np.zeros(0, np.float32), descriptors_of(np.random.default_rng(1), 0))
    last = LastFrame(at, *before, nothing, nothing, np.empty(0, np.int32), 0, np.eye(4))
    frame = RgbdFrame(1, at + 1 / 30, cv2.cvtColor(now[0], cv2.COLOR_GRAY2RGB), now[1])
    return stepping.told(last, frame, now[0], expected)


def stepping_in(slam_map: SlamMap, **config: float | bool) -> Stepping:
    surfaces = Surfaces(CAMERA, SENSOR, CONFIG.surfaces)
    return Stepping(slam_map, surfaces, PictureConfig.model_validate(config))


def test_a_step_between_two_blurred_frames_is_told() -> None:
    expected = rigid([0.01, 0.0, -0.01], [0.0, -0.02, 0.01]) @ TURN
    step = told_from_to(stepping_in(SlamMap(4, SENSOR.scales)), blurred(np.eye(4)), blurred(TURN), expected)
    assert step is not None
    metres, radians = pose_error(step.image_from_last, TURN)
    assert metres < 0.003
    assert np.degrees(radians) < 0.1
    assert step.leads(0.0, 1 / 30)
    assert not step.leads(0.0, 2 / 30)


def test_a_step_that_no_camera_takes_so_suddenly_is_not_believed() -> None:
    views = blurred(np.eye(4)), blurred(TURN)
    expected = rigid([0.05, 0.0, 0.0], [0.0, 0.0, 0.0]) @ TURN  # a change of pace by 1.5 m/s within a frame
    assert told_from_to(stepping_in(SlamMap(4, SENSOR.scales)), *views, expected) is None


def test_it_is_believed_as_far_as_keyframes_say() -> None:
    slam_map = SlamMap(4, SENSOR.scales)
    views = blurred(np.eye(4)), blurred(TURN)
    before = told_from_to(stepping_in(slam_map), *views, TURN)
    for _ in range(20):
        slam_map.relative_poses.judge(60.0)
    after = told_from_to(stepping_in(slam_map), *views, TURN)
    assert before is not None
    assert after is not None
    ratio = RelativePoses(PictureConfig()).excess / slam_map.relative_poses.excess
    np.testing.assert_allclose(after.information, before.information * ratio, rtol=1e-9, atol=1e-6)


@pytest.mark.parametrize("config", [{"enabled": False}, {"largest_excess": 1.0}])
def test_who_is_not_believed_is_not_asked(config: dict[str, float | bool]) -> None:
    stepping = stepping_in(SlamMap(4, SENSOR.scales), **config)
    assert told_from_to(stepping, blurred(np.eye(4)), blurred(TURN), TURN) is None


def test_a_coat_of_strong_contrasts_does_not_take_the_camera_along() -> None:
    """It goes with the camera and hides the middle: what moves with it agrees that the camera stands."""
    checks = np.random.default_rng(5).integers(0, 2, (40, 40)) * 200

    def with_coat(view: Shot) -> Shot:
        (gray, depth), (height, width) = (view[0].copy(), view[1].copy()), view[0].shape
        rows, columns = slice(height // 6, height), slice(width // 3, width * 2 // 3)
        gray[rows, columns] = np.kron(checks, np.ones((16, 16)))[: height - height // 6, : width * 2 // 3 - width // 3]
        depth[rows, columns] = 0.6
        return gray, depth

    stepping = stepping_in(SlamMap(4, SENSOR.scales))
    poses = [np.eye(4)]
    for _ in range(6):
        poses.append(TURN @ poses[-1])
    views = [blurred(pose) for pose in poses]
    for k in range(4):
        assert told_from_to(stepping, views[k], views[k + 1], TURN, k / 30) is not None
    step = told_from_to(stepping, with_coat(views[4]), with_coat(views[5]), TURN, 4 / 30)
    assert step is None or pose_error(step.image_from_last, TURN)[0] < 0.01
