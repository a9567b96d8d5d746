"""Constant velocity."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpslam.camera import inverse_transform
from lpslam.slam.kernels.geometry import exponential
from lpslam.slam.tracking.motion import ConstantVelocity

TWIST = np.array([0.4, -0.1, 0.9, 0.2, 1.9, -0.3])
"""Metres and radians a second: a walk with a quick turn."""


def camera_at(seconds: float) -> np.ndarray:
    return exponential(TWIST * seconds)


@given(st.floats(0.02, 0.1), st.floats(0.0, 0.29))
def test_the_camera_goes_on_at_its_pace_whatever_the_frames_are(before: float, ahead: float) -> None:
    """After a missing frame the last step is two frames long and the next one is not."""
    motion = ConstantVelocity()
    motion.note(camera_at(0.0), camera_at(before), before)
    predicted = motion.ahead(camera_at(before), ahead)
    error = predicted @ inverse_transform(camera_at(before + ahead))
    assert error == pytest.approx(np.eye(4), abs=1e-6)


def test_it_is_not_believed_for_long() -> None:
    motion = ConstantVelocity()
    motion.note(camera_at(0.0), camera_at(0.1), 0.1)
    late = motion.ahead(camera_at(0.1), 5.0)
    assert late == pytest.approx(motion.ahead(camera_at(0.1), 0.3))
    assert motion.ahead(camera_at(0.1), -1.0) == pytest.approx(camera_at(0.1)), "time does not run backwards"


def test_before_two_frames_and_after_losing_it_stands_still() -> None:
    motion = ConstantVelocity()
    assert motion.ahead(camera_at(0.2), 0.1) == pytest.approx(camera_at(0.2))
    motion.note(camera_at(0.0), camera_at(0.1), 0.1)
    motion.forget()
    assert not motion.is_known
    assert motion.ahead(camera_at(0.2), 0.1) == pytest.approx(camera_at(0.2))
