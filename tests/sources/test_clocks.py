"""Units of time: what is converted, and what stays."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpslam.sources.clocks import in_seconds

UNITS = {"seconds": 1.0, "milliseconds": 1e3, "microseconds": 1e6, "nanoseconds": 1e9}


@given(
    rate=st.floats(0.5, 200.0),
    begin=st.sampled_from([0.0, 3600.0, 86_400.0, 1_305_031_102.175]),
    frames=st.integers(2, 300),
    unit=st.sampled_from(list(UNITS)),
    jitter=st.floats(0.0, 0.3),
)
def test_stamps_of_any_unit_become_seconds(rate: float, begin: float, frames: int, unit: str, jitter: float) -> None:
    strayed = np.random.default_rng(frames).uniform(-jitter, jitter, frames)
    seconds = begin + (np.arange(frames) + strayed) / rate
    found, note = in_seconds(seconds * UNITS[unit])
    np.testing.assert_allclose(found, seconds, atol=1e-6)
    assert (unit in note) == (unit != "seconds")


@given(frames=st.integers(60, 300), factor=st.sampled_from([1.0, 1e3]))
def test_durations_are_added_up(frames: int, factor: float) -> None:
    steps = np.random.default_rng(frames).normal(1 / 30, 0.002, frames).clip(0.02, 0.05)
    found, note = in_seconds(steps * factor)
    np.testing.assert_allclose(found, np.concatenate([[0.0], np.cumsum(steps[1:])]), atol=1e-6)
    assert "durations" in note


@pytest.mark.parametrize("begin", [0.0, 100.0, 1_305_031_102.175])
def test_stamps_that_repeat_or_that_are_listed_out_of_order_stay(begin: float) -> None:
    seconds = begin + np.arange(200) / 30
    for times in (np.repeat(seconds, 2), np.concatenate([seconds[100:], seconds[:100]]), seconds[::-1]):
        found, note = in_seconds(times)
        np.testing.assert_array_equal(found, times)
        assert not note


def test_a_frame_alone_says_nothing() -> None:
    assert in_seconds(np.array([1e18])) == (np.array([1e18]), "")
