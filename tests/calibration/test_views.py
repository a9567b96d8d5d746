import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpslam.calibration.views import Travel, chosen
from lpslam.config import CalibratingConfig

CONFIG = CalibratingConfig()


def travel(steps: np.ndarray) -> Travel:
    return Travel(np.arange(len(steps)), np.cumsum(steps), np.abs(steps))


@given(seed=st.integers(0, 1000), pace=st.floats(0.0, 200.0), frames=st.integers(0, 900))
def test_never_too_many_never_twice_and_in_order(seed: int, pace: float, frames: int) -> None:
    steps = np.random.default_rng(seed).uniform(0, 2 * pace + 1e-9, frames)
    found = chosen(travel(steps), CONFIG)
    assert len(found) <= CONFIG.views + 1
    assert (np.diff(found) > 0).all()
    assert (len(found) > 0) == (frames > 0)


def test_a_still_camera_gives_one_view() -> None:
    assert len(chosen(travel(np.zeros(100)), CONFIG)) == 1


def test_of_each_step_the_calmest_frame_is_taken() -> None:
    steps = np.tile([8.0, 1.0, 8.0, 8.0], 30)
    found = chosen(travel(steps), CONFIG)
    assert np.mean(steps[found] == 1.0) > 0.7


def test_a_long_way_is_seen_in_runs_whose_views_overlap() -> None:
    far = travel(np.full(3000, 20.0))
    found = chosen(far, CONFIG)
    apart = np.diff(far.travelled[found])
    assert np.median(apart) <= 1.2 * CONFIG.far_apart
    assert apart.max() > 2 * CONFIG.far_apart
    assert far.travelled[found[-1]] > 0.9 * far.travelled[-1]
    assert len(found) == pytest.approx(CONFIG.views, abs=5)
