"""Corners settle where a spot is, in every view of it."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lpslam.slam.features import smoothed
from lpslam.slam.kernels.image import BORDER
from lpslam.slam.kernels.settling import MOVES, settle

SIDE = 80


def spot(x: float, y: float, sigma: float, contrast: float = 90.0, noise: float = 0.0) -> np.ndarray:
    """A soft bright or dark spot at a fraction of a pixel."""
    v, u = np.mgrid[0:SIDE, 0:SIDE]
    picture = 120 + contrast * np.exp(-((u - x) ** 2 + (v - y) ** 2) / (2 * sigma**2))
    picture = picture + np.random.default_rng(0).normal(0, noise, picture.shape) if noise else picture
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def settled(picture: np.ndarray, *corners: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    return settle(smoothed(picture), np.array(corners, np.int32).reshape(-1, 2), BORDER)


@given(
    st.floats(35, 45),
    st.floats(35, 45),
    st.floats(1.2, 2.5),
    st.sampled_from([-90.0, -30.0, 30.0, 90.0]),
    st.tuples(st.integers(-1, 1), st.integers(-1, 1)),
)
@settings(max_examples=60, deadline=None)
def test_a_spot_is_found_at_its_place_from_any_pixel_beside_it(
    x: float, y: float, sigma: float, contrast: float, aside: tuple[int, int]
) -> None:
    start = (round(x) + aside[0], round(y) + aside[1])
    whole, exact = settled(spot(x, y, sigma, contrast), start)
    np.testing.assert_allclose(exact[0], (x, y), atol=0.15)
    assert np.abs(whole[0] - (x, y)).max() <= 0.65


def test_corners_of_one_spot_are_one_and_the_first_names_it() -> None:
    picture = np.minimum(spot(30.3, 40.2, 1.5), 255)
    picture = np.maximum(picture, spot(50.6, 39.7, 1.5))
    whole, exact = settled(picture, (51, 40), (30, 40), (31, 41), (50, 39))
    assert whole.tolist() == [[51, 40], [30, 40]]
    np.testing.assert_allclose(exact, [(50.6, 39.7), (30.3, 40.2)], atol=0.15)


def test_a_corner_moves_no_farther_than_it_may() -> None:
    whole, _ = settled(spot(44.0, 40.0, 3.0), (38, 40))
    assert np.abs(whole[0] - (38, 40)).max() <= MOVES


def test_corners_stay_clear_of_the_border() -> None:
    random = np.random.default_rng(3)
    picture = cv2.GaussianBlur(random.uniform(0, 255, (SIDE, SIDE)), (0, 0), 1.5)
    picture = np.clip(3 * (picture - 128) + 128, 0, 255).astype(np.uint8)
    low, high = BORDER, SIDE - 1 - BORDER
    edge = [(low, v) for v in range(low, high + 1)] + [(u, high) for u in range(low, high + 1)]
    whole, exact = settled(picture, *edge)
    assert whole.min() >= low
    assert whole.max() <= high
    assert np.abs(exact - whole).max() <= 0.5


def test_nothing_settles_where_nothing_was_found() -> None:
    whole, exact = settled(spot(40, 40, 2.0))
    assert whole.shape == exact.shape == (0, 2)


@pytest.mark.parametrize("noise", [2.0, 6.0])
def test_in_noise_two_views_of_a_spot_differ_by_less_than_whole_pixels_would(noise: float) -> None:
    random = np.random.default_rng(1)
    errors, rounded = [], []
    for _ in range(40):
        x, y = random.uniform(38, 42, 2)
        clean = spot(x, y, 1.6).astype(float)
        picture = np.clip(clean + random.normal(0, noise, clean.shape), 0, 255).astype(np.uint8)
        start = (round(x) + int(random.integers(-1, 2)), round(y) + int(random.integers(-1, 2)))
        errors.append(np.linalg.norm(settled(picture, start)[1][0] - (x, y)))
        rounded.append(np.linalg.norm(np.rint((x, y)) - (x, y)))
    assert np.median(errors) < 0.5 * np.median(rounded)
