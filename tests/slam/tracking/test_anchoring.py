"""When flow yields to matching: by what the picture does, not by a count of frames."""

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import SlamConfig
from lpslam.slam.kernels.geometry import exponential
from lpslam.slam.sensor import SensorModel
from lpslam.slam.tracking.anchoring import Anchoring

CAMERA = PinholeCamera(640, 480, 520.0, 520.0, 320.0, 240.0)
CONFIG = SlamConfig()


def turned(radians: float) -> NDArray[np.float64]:
    return exponential(np.array([0.0, 0, 0, 0, radians, 0]))


def frames_until_due(step: float) -> int:
    """How many frames of 1/30 s a camera that turns by so many radians a frame goes without being matched."""
    anchoring = Anchoring(SensorModel.of(CAMERA, CONFIG), CONFIG.tracking)
    anchoring.matched(0.0)
    for k in range(1, 100):
        if anchoring.is_due(k / 30):
            return k
        anchoring.moved(turned((k - 1) * step), turned(k * step), turned(k * step), 1 / 30)
    return 100


def test_the_faster_the_picture_moves_the_sooner_it_is_matched() -> None:
    waits = [frames_until_due(step) for step in (0.0, 0.01, 0.03, 0.06, 0.12)]
    assert waits == sorted(waits, reverse=True)
    assert waits[0] == round(CONFIG.tracking.anchor_interval * 30)
    assert waits[-1] <= 2


def test_a_prediction_that_fails_is_remembered_for_some_frames() -> None:
    anchoring = Anchoring(SensorModel.of(CAMERA, CONFIG), CONFIG.tracking)
    assert anchoring.is_steady
    anchoring.moved(turned(0.0), turned(0.05), turned(0.0), 1 / 30)
    assert not anchoring.is_steady
    for k in range(30):
        pose = turned(0.05 + 0.01 * (k + 1))
        anchoring.moved(turned(0.05 + 0.01 * k), pose, pose, 1 / 30)
    assert anchoring.is_steady


def test_a_way_of_a_moment_is_no_carrying() -> None:
    anchoring = Anchoring(SensorModel.of(CAMERA, CONFIG), CONFIG.tracking)
    assert anchoring.may_be_one_way(turned(0.0), turned(1.0))
    elsewhere = exponential(np.array([5.0, 0, 0, 0, 0, 0]))
    assert not anchoring.may_be_one_way(turned(0.0), elsewhere)


def test_what_moves_far_while_a_frame_is_exposed_may_be_blurred() -> None:
    """Exposing takes no longer than a frame, and no longer than a thirtieth of a second where frames are rare."""
    anchoring = Anchoring(SensorModel.of(CAMERA, CONFIG), CONFIG.tracking)
    assert not anchoring.may_be_blurred
    for step, seconds, may_be in (
        (0.02, 1 / 30, False),
        (0.06, 1 / 30, True),
        (0.06, 1 / 10, False),
        (0.06, 1 / 60, True),
    ):
        anchoring.moved(turned(0.0), turned(step), turned(step), seconds)
        assert anchoring.may_be_blurred is may_be
