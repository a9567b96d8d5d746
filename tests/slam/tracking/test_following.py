"""Optical flow between frames, and the choice of what is followed."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from lpslam.camera import PinholeCamera
from lpslam.config import TrackingConfig
from lpslam.slam.tracking.following import Flow, choose_followed, follow_flow

WIDTH, HEIGHT = 320, 240
CAMERA = PinholeCamera(WIDTH, HEIGHT, 260.0, 260.0, 159.3, 121.8)
# The lens of the TUM benchmark's first camera, at half the resolution.
LENS = replace(CAMERA, distortion=(0.262383, -0.953104, -0.005358, 0.002628, 1.163314))
CONFIG = TrackingConfig()


def texture(shift: tuple[float, float] = (0.0, 0.0), seed: int = 4) -> np.ndarray:
    """A wall of soft spots, (h, w) grey; what is at a pixel appears `shift` (x, y) pixels further."""
    margin = 80
    noise = np.random.default_rng(seed).normal(0, 1, (HEIGHT + 2 * margin, WIDTH + 2 * margin)).astype(np.float32)
    wall = cv2.GaussianBlur(noise, (0, 0), 2.0)
    wall = 128 + 40 * wall / wall.std()
    to_image = np.array([[1.0, 0.0, shift[0] - margin], [0.0, 1.0, shift[1] - margin]])
    return np.asarray(cv2.warpAffine(wall, to_image, (WIDTH, HEIGHT), flags=cv2.INTER_CUBIC).clip(0, 255), np.uint8)


def grid(margin: float = 40.0, step: float = 16.0) -> np.ndarray:
    """(n, 2) pixels all over the image."""
    u, v = np.meshgrid(np.arange(margin, WIDTH - margin, step), np.arange(margin, HEIGHT - margin, step))
    return np.column_stack([u.ravel(), v.ravel()]).astype(np.float32)


def follow(
    shift: tuple[float, float], predicted: np.ndarray, levels: int, pixels: np.ndarray | None = None
) -> tuple[Flow, np.ndarray]:
    """Flow of the grid over a shifted wall; also how far each found pixel is off."""
    pixels = grid() if pixels is None else pixels
    flow = follow_flow(texture(), texture(shift), pixels, predicted.astype(np.float32), levels, CAMERA, CONFIG)
    return flow, np.linalg.norm(flow.raw - pixels[flow.rows] - np.array(shift), axis=1)


@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.37, -0.61), (3.4, 2.25), (-9.3, 6.8)])
def test_a_shift_is_found_to_a_tenth_of_a_pixel(shift: tuple[float, float]) -> None:
    flow, error = follow(shift, grid(), levels=2)
    assert len(flow.rows) == len(grid())
    assert np.quantile(error, 0.98) < 0.1


def test_a_shift_that_flow_alone_cannot_reach_is_found_from_its_prediction() -> None:
    shift = (34.6, -27.3)
    unpredicted, error = follow(shift, grid(), levels=0)
    assert not len(unpredicted.rows) or np.median(error) > 5
    flow, error = follow(shift, grid() + np.array(shift) + [1.5, -1.0], levels=0)
    assert len(flow.rows) == len(grid())
    assert np.quantile(error, 0.98) < 0.1


def test_what_is_expected_outside_the_image_is_not_looked_for_and_rows_stay_those_asked_for() -> None:
    pixels, shift = grid(), (5.0, 0.0)
    predicted = pixels + np.array(shift, np.float32)
    outside = np.arange(0, len(pixels), 3)
    predicted[outside] = np.resize([[-1, 50], [WIDTH, 50], [50, -0.5], [50, HEIGHT], [np.nan, 9]], (len(outside), 2))
    flow, error = follow(shift, predicted, levels=2)
    assert set(flow.rows.tolist()) == set(range(len(pixels))) - set(outside.tolist())
    assert error.max() < 0.2


def test_what_leaves_the_image_is_dropped() -> None:
    at_the_rim = np.column_stack([np.full(12, WIDTH - 12.0), np.arange(20.0, 200.0, 15.0)]).astype(np.float32)
    flow, _ = follow((20.0, 0.0), at_the_rim, levels=2, pixels=at_the_rim)
    assert ((flow.raw >= 0) & (flow.raw < [WIDTH - 1, HEIGHT - 1])).all()
    inside = np.concatenate([grid(), at_the_rim])
    both, error = follow((20.0, 0.0), inside + np.float32([17, 0]).astype(np.float32), levels=2, pixels=inside)
    assert set(range(len(grid()))) <= set(both.rows.tolist())
    assert error[both.rows < len(grid())].max() < 0.2


def test_nothing_asked_or_nothing_in_the_image_is_no_flow() -> None:
    for pixels in (np.empty((0, 2), np.float32), np.full((3, 2), -5.0, np.float32)):
        flow = follow_flow(texture(), texture(), pixels, pixels, 2, CAMERA, CONFIG)
        assert flow.rows.shape == (0,)
        assert flow.raw.shape == (0, 2)


def test_through_a_lens_pixels_are_undistorted_ones_and_what_is_found_is_raw() -> None:
    shift = np.array([26.3, -8.7])
    u, v = np.meshgrid(np.arange(12.0, WIDTH - 40, 14), np.arange(24.0, HEIGHT - 12, 14))
    raw = np.column_stack([u.ravel(), v.ravel()])
    pixels, predicted = LENS.undistort(raw), LENS.undistort(raw + shift)
    assert np.abs(raw - pixels).max() > 3  # the lens does move pixels
    flow = follow_flow(
        texture(), texture((26.3, -8.7)), pixels.astype(np.float32), predicted.astype(np.float32), 0, LENS, CONFIG
    )
    assert len(flow.rows) > 0.95 * len(raw)
    error = np.linalg.norm(flow.raw - raw[flow.rows] - shift, axis=1)
    assert np.quantile(error, 0.97) < 0.15


# Choice ------------------------------------------------------------------------------------------------------------


def crowd(random: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Pixels of which nine in ten are in one corner of a large image, and their octaves."""
    pixels = random.uniform(0, [640, 480], (count, 2))
    pixels[: 9 * count // 10] /= 6
    return pixels.astype(np.float32), random.integers(0, 8, count).astype(np.uint8)


def test_few_keypoints_are_all_followed() -> None:
    pixels, octave = crowd(np.random.default_rng(0), 50)
    np.testing.assert_array_equal(choose_followed(pixels, octave, np.zeros(50, np.bool_), 50), np.arange(50))


def test_those_in_the_map_go_first_whatever_their_level() -> None:
    random = np.random.default_rng(1)
    pixels, octave = crowd(random, 800)
    is_mapped = random.random(800) < 0.15
    octave[is_mapped] = 7
    chosen = choose_followed(pixels, octave, is_mapped, 200)
    assert len(set(chosen.tolist())) == 200
    assert (np.diff(chosen) > 0).all()
    assert is_mapped[chosen].sum() == is_mapped.sum()
    only_mapped = choose_followed(pixels, octave, is_mapped, 60)
    assert is_mapped[only_mapped].all()


def test_the_choice_is_spread_over_the_image_and_takes_fine_levels() -> None:
    random = np.random.default_rng(2)
    pixels, octave = crowd(random, 1000)
    is_mapped = np.ones(1000, np.bool_)
    chosen = choose_followed(pixels, octave, is_mapped, 250)
    cells = np.floor(pixels / 32).astype(int) @ [1, 1000]
    # No cell is left without a follower while another gets a second one.
    assert set(cells[chosen].tolist()) == set(cells.tolist())
    counts = {cell: int((cells[chosen] == cell).sum()) for cell in set(cells.tolist())}
    for cell, count in counts.items():
        available = np.sort(octave[cells == cell])
        taken = np.sort(octave[chosen][cells[chosen] == cell])
        assert count == len(available) or count >= max(counts.values()) - 1
        np.testing.assert_array_equal(taken, available[:count])


def test_the_choice_does_not_depend_on_chance() -> None:
    pixels, octave = crowd(np.random.default_rng(3), 600)
    is_mapped = np.arange(600) % 3 == 0
    first = choose_followed(pixels, octave, is_mapped, 100)
    np.testing.assert_array_equal(first, choose_followed(pixels.copy(), octave.copy(), is_mapped.copy(), 100))
