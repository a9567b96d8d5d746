"""Colour and depth paired as they come."""

import numpy as np
import pytest

from lpslam.config import PairingConfig
from lpslam.sources.pairing import Paired, Stamped, paired
from lpslam.timestamps import usual_tolerance


def pairs_at(rate: float, late: float, count: int = 40) -> list[Paired[int]]:
    """Of a stream whose depth comes some seconds after its colour."""
    colours = [Stamped(i / rate, False, i) for i in range(count)]
    depths = [Stamped(i / rate + late, True, i) for i in range(count)]
    return list(paired(sorted(colours + depths, key=lambda each: each.timestamp), PairingConfig()))


@pytest.mark.parametrize(("rate", "late"), [(30, 0.016), (15, 0.03), (15, -0.03), (6, 0.045)])
def test_depth_is_paired_within_half_of_what_lies_between_frames(rate: float, late: float) -> None:
    frames = pairs_at(rate, late)
    assert [frame.colour for frame in frames] == list(range(40))
    assert all(frame.depth == frame.colour for frame in frames[1:])


def test_what_is_half_a_picture_away_is_none_of_it() -> None:
    assert all(frame.depth is None for frame in pairs_at(5, 0.07))


def test_a_gap_of_one_stream_makes_no_wider_pairs() -> None:
    times = np.arange(40) / 30
    assert usual_tolerance(times, np.delete(times, slice(10, 30)), 0.02, 0.05) == 0.02
    assert usual_tolerance(times, times[:1], 0.02, 0.05) == 0.02
    assert usual_tolerance(times[::6], times[::6], 0.02, 0.05) == pytest.approx(0.05)
    assert usual_tolerance(times, times, 0.1, 0.05) == 0.1
