"""What of the map a view should show and shows, in every part of the image."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lpslam.slam.places.parts import Parts

SIZE = (640, 480)


def view(random: np.random.Generator, share: float, points: int = 800, hidden: tuple[int, int] | None = None) -> Parts:
    """Points all over the image of which a share is seen, but none between two columns."""
    pixels = (random.random((points, 2)) * SIZE).astype(np.float32)
    is_seen = random.random(points) < share
    if hidden is not None:
        is_seen &= (pixels[:, 0] < hidden[0]) | (pixels[:, 0] > hidden[1])
    return Parts.of(pixels, is_seen, SIZE)


def test_points_are_counted_where_they_are() -> None:
    pixels = np.array([[0, 0], [639, 479], [-3, 0], [700, 500], [79, 79], [81, 0]], np.float32)
    parts = Parts.of(pixels, np.array([True, False, False, True, True, True]), SIZE)
    assert parts.expected[0] == 3
    assert parts.seen[0] == 2
    assert parts.expected[-1] == 2
    assert parts.seen[-1] == 1
    assert parts.expected.sum() == len(pixels)


def test_nothing_expected_says_nothing() -> None:
    nothing = Parts.of(np.zeros((0, 2), np.float32), np.zeros(0, np.bool_), SIZE)
    assert nothing.missing_share == 0.0
    full = view(np.random.default_rng(0), 0.5)
    assert nothing.speak_for(full) == full.speak_for(nothing) == nothing.speak_for(nothing) == 0.0


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.1, 0.9))
def test_what_one_place_gains_the_other_loses(seed: int, share: float) -> None:
    random = np.random.default_rng(seed)
    one, other = view(random, share), view(random, 0.5)
    assert one.speak_for(other) == pytest.approx(-other.speak_for(one))
    assert one.speak_for(one) == 0.0


def test_places_that_are_equally_right_are_seldom_told_apart() -> None:
    random = np.random.default_rng(1)
    told = [abs(view(random, 0.45).speak_for(view(random, 0.45))) >= 3.0 for _ in range(400)]
    assert np.mean(told) < 0.06


def test_a_sign_that_is_another_one_tells_two_fronts_apart() -> None:
    random = np.random.default_rng(2)
    told = [view(random, 0.45).speak_for(view(random, 0.45, hidden=(160, 260))) for _ in range(100)]
    assert np.mean(np.array(told) >= 3.0) > 0.95


def test_a_poor_map_of_either_place_is_no_difference() -> None:
    """Twice as many points are expected at a place that was mapped twice."""
    random = np.random.default_rng(3)
    told = [view(random, 0.45, 400).speak_for(view(random, 0.45, 1600)) for _ in range(200)]
    assert np.mean(np.abs(told) >= 3.0) < 0.06
    assert abs(np.mean(told)) < 0.3
