"""Faint patterns under noise, light that stays with the camera, and the shift that tells how a picture moved."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lpslam.slam.tracking.relief import likeness, relief, shift_between, shift_of

SIZE = (120, 160)
INTRINSICS = np.array([131.0, 131.0, 79.5, 59.5])
AROUND = 4.0


def wall(seed: int) -> np.ndarray:
    """Grain of a grey value or so, larger than any picture of it."""
    grain = np.random.default_rng(seed).standard_normal((SIZE[0] + 100, SIZE[1] + 100)).astype(np.float32)
    smooth = cv2.GaussianBlur(grain, (0, 0), 1.5)
    return np.asarray(smooth / smooth.std(), np.float32)


def seen(seed: int, across: int, down: int, noise: float, look: int, darker: float = 40.0) -> np.ndarray:
    """The relief of a picture of the wall, with new noise, and darker towards its border as lenses make it."""
    v, u = np.mgrid[: SIZE[0], : SIZE[1]]
    vignette = 120.0 - darker * (((u - 79.5) / 80) ** 2 + ((v - 59.5) / 60) ** 2) / 2
    cut = wall(seed)[50 - down : 50 - down + SIZE[0], 50 - across : 50 - across + SIZE[1]]
    noisy = vignette + cut + noise * np.random.default_rng([seed, look]).standard_normal(SIZE)
    return relief(noisy.astype(np.float32), AROUND)


@settings(max_examples=15)
@given(st.integers(0, 99), st.integers(-30, 30), st.integers(-20, 20))
def test_a_shift_is_found_under_noise_as_strong_as_the_grain(seed: int, across: int, down: int) -> None:
    shift = shift_of(seen(seed, 0, 0, 1.0, 1), seen(seed, across, down, 1.0, 2))
    assert (abs(shift.across - across) <= 1, abs(shift.down - down) <= 1) == (True, True)
    assert shift.lead > 1.3


@settings(max_examples=15)
@given(st.integers(0, 99))
def test_noise_alone_leads_nowhere_and_light_that_stays_is_no_pattern(seed: int) -> None:
    one, other = (
        relief((seen(seed, 0, 0, 0.0, look) * 0 + noise).astype(np.float32), AROUND)
        for look in (1, 2)
        for noise in [np.random.default_rng([seed, look]).standard_normal(SIZE)]
    )
    assert shift_of(one, other).lead < 1.3
    assert likeness(one.ravel().astype(float), other.ravel().astype(float)) < 5.0


def test_what_a_lens_makes_of_a_picture_is_hardly_in_its_relief() -> None:
    v, u = np.mgrid[: SIZE[0], : SIZE[1]]
    vignette = (120.0 - 20.0 * (((u - 79.5) / 80) ** 2 + ((v - 59.5) / 60) ** 2)).astype(np.float32)
    assert np.abs(relief(vignette, AROUND)).max() < np.ptp(vignette) / 50


@pytest.mark.parametrize("turn", [0.0, 0.1, -0.2])
def test_a_shift_is_counted_from_the_turn_that_was_expected(turn: float) -> None:
    rotation, _ = cv2.Rodrigues(np.array([0.0, turn, 0.0]))
    before = seen(3, 0, 0, 0.3, 1)
    across = round(131.0 * np.tan(turn))
    now = seen(3, across + 5, -4, 0.3, 2)
    shift = shift_between(before, now, rotation, INTRINSICS)
    assert abs(shift.across - 5) <= 2
    assert abs(shift.down + 4) <= 2
    assert shift.turn(INTRINSICS)[1] == pytest.approx(np.arctan(shift.across / 131.0))


def test_a_picture_without_anything_has_no_leading_shift() -> None:
    blank = np.zeros(SIZE, np.float32)
    assert shift_of(blank, blank).lead < 1.3
    assert likeness(np.zeros(9), np.zeros(9)) == 0.0
