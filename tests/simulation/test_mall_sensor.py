"""The simulated sensor: depth noise, holes, blur, exposure."""

import numpy as np
import pytest
from scipy.ndimage import maximum_filter, minimum_filter

from lpslam.camera import PinholeCamera
from lpslam.simulation import sensor
from lpslam.simulation.source import MallSource


def flat_measurement(z: float, *, gloss: float = 0.0, brightness: float = 120.0, seed: int = 0) -> np.ndarray:
    """What the sensor says of a wall at z metres that faces it."""
    camera = PinholeCamera(640, 480, 570.0, 570.0, 319.5, 239.5)
    rng = np.random.default_rng(seed)
    noise = sensor.draw_noise(rng, 640, 480)
    return sensor.measure_depth(
        rng, np.full((480, 640), z, np.float32), np.zeros((480, 640), np.int32),
        np.full((480, 640, 3), brightness, np.float32), np.array([[0.0, 0.0, -1.0]]), np.array([gloss], np.float32),
        camera, noise,
    )  # fmt: skip


@pytest.mark.parametrize("z", [0.5, 1.0, 2.5, 5.0, 7.5])
def test_noise_grows_with_the_square_of_the_range(z: float) -> None:
    depth = flat_measurement(z)
    error = depth[depth > 0] - z
    sigma = 0.0007 + 0.0022 * z**2
    assert error.std() == pytest.approx(sigma, rel=0.08)
    assert abs(error.mean()) < 0.05 * sigma


def test_noise_is_correlated_a_little_as_real_sensors_are() -> None:
    depth = flat_measurement(3.0)
    error = np.where(depth > 0, depth - 3.0, 0.0)
    neighbours = np.corrcoef(error[:, :-1].ravel(), error[:, 1:].ravel())[0, 1]
    distant = np.corrcoef(error[:, :-12].ravel(), error[:, 12:].ravel())[0, 1]
    assert 0.2 < neighbours < 0.9
    assert abs(distant) < 0.05


def test_range_is_limited_and_dark_or_shiny_faces_have_holes() -> None:
    assert not flat_measurement(0.25).any()
    assert not flat_measurement(8.5).any()
    plain = np.mean(flat_measurement(2.0) == 0)
    shiny = np.mean(flat_measurement(2.0, gloss=1.0) == 0)
    dark = np.mean(flat_measurement(2.0, brightness=10.0) == 0)
    assert plain < 0.02
    assert shiny > 5 * plain + 0.05
    assert dark > 2 * plain


@pytest.mark.slow
def test_measured_depth_of_a_walk(mall: MallSource, ideal_mall: MallSource) -> None:
    holes, inner = [], []
    for index in (20, 100):
        measured, exact = mall.frame(index).depth, ideal_mall.frame(index).depth
        in_range = (exact > 0.3) & (exact < 7.8)
        holes.append(np.mean(measured[in_range] == 0))
        edge = maximum_filter(exact, 7) > 1.04 * minimum_filter(exact, 7)
        smooth = in_range & ~edge & (measured > 0)
        z = exact[smooth]
        inner.append((measured[smooth] - z) / (0.0007 + 0.0022 * z**2))
        # Edges are ragged: there the measured depth is often missing or the neighbour's.
        assert np.mean(measured[edge & in_range] == 0) > 3 * np.mean(measured[~edge & in_range] == 0)
    assert 0.003 < np.mean(holes) < 0.25
    assert np.concatenate(inner).std() == pytest.approx(1.0, rel=0.08)


def test_blur_follows_the_motion() -> None:
    camera = PinholeCamera(160, 120, 140.0, 140.0, 79.5, 59.5)
    picture = np.zeros((120, 160, 3), np.float32)
    picture[:, 80:] = 200.0
    depth = np.full((120, 160), 2.0, np.float32)
    still = np.eye(4)
    assert np.array_equal(sensor.blur_by_motion(picture, depth, camera, still, still, still), picture)
    start, end = np.eye(4), np.eye(4)
    start[0, 3], end[0, 3] = -0.05, 0.05  # 0.1 m at 2 m: 7 pixels
    blurred = sensor.blur_by_motion(picture, depth, camera, start, still, end)
    ramp = np.mean((blurred[60, :, 0] > 5) & (blurred[60, :, 0] < 195)) * 160
    assert 5 <= ramp <= 9
    upward = start.copy()
    upward[:3, 3] = 0.0, -0.05, 0.0
    downward = np.eye(4)
    downward[1, 3] = 0.05
    assert np.allclose(sensor.blur_by_motion(picture, depth, camera, upward, still, downward), picture, atol=0.01)


def test_exposure_never_leaves_eight_bits_and_keeps_order() -> None:
    rng = np.random.default_rng(0)
    noise = sensor.draw_noise(rng, 64, 48)
    camera = PinholeCamera(64, 48, 60.0, 60.0, 31.5, 23.5)
    vignette = sensor.vignette_of(camera, 0.2)
    means = [
        sensor.expose(rng, np.full((48, 64, 3), value, np.float32), 1.0, noise, vignette).mean()
        for value in (0.0, 60.0, 120.0, 240.0, 600.0)
    ]
    assert np.all(np.diff(means) > 3)
    assert means[-1] <= 255
    assert vignette.max() == pytest.approx(1.0, abs=0.01)
    assert vignette.min() == pytest.approx(0.8, abs=0.01)
