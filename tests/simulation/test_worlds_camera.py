"""The colour camera: rows read one after another, the lens, blur, automatic exposure."""

import numpy as np
import pytest

from lpslam.camera import PinholeCamera
from lpslam.simulation.worlds.sensing.exposure import MAX_GAIN, Sensor, exposure_gains
from lpslam.simulation.worlds.sensing.lens import Lens, row_times


def still(height: int) -> np.ndarray:
    return np.tile(np.eye(4)[:3], (height, 1, 1))


def turned(angles: np.ndarray) -> np.ndarray:
    """(n, 3, 4) turns to the right by (n,) radians."""
    moves = still(len(angles))
    moves[:, 0, 0] = moves[:, 2, 2] = np.cos(angles)
    moves[:, 0, 2], moves[:, 2, 0] = np.sin(angles), -np.sin(angles)
    return moves


def bar(lens: Lens) -> tuple[np.ndarray, np.ndarray]:
    """A bright upright bar straight ahead, endlessly far."""
    canvas = lens.canvas
    colour = np.zeros((canvas.height, canvas.width, 3), np.float32)
    middle = round(canvas.cx)
    colour[:, middle - 2 : middle + 3] = 200.0
    return colour, np.zeros((canvas.height, canvas.width), np.float32)


def place_of_bar(row: np.ndarray) -> float:
    return float((np.arange(len(row)) * row[:, 0]).sum() / row[:, 0].sum())


def test_rows_are_exposed_one_after_another() -> None:
    times = row_times(1.0, 481, 0.024)
    assert times[240] == pytest.approx(1.0)
    assert times[0] == pytest.approx(0.988)
    assert np.diff(times) == pytest.approx(0.024 / 480)
    assert np.ptp(row_times(1.0, 480, 0.0)) == 0.0


def test_an_upright_bar_leans_in_a_turn_by_what_the_readout_lasts() -> None:
    camera = PinholeCamera(320, 241, 300.0, 300.0, 159.5, 120.0)
    lens = Lens.of(camera)
    times = row_times(0.0, 241, 0.02)
    rate = 1.5  # radians a second
    moves = turned(rate * times)
    image = lens.shoot(*bar(lens), moves, moves)
    places = [place_of_bar(image[row]) for row in (0, 120, 240)]
    middle = 159.5 + (round(lens.canvas.cx) - lens.canvas.cx)
    expected = [middle - 300.0 * np.tan(rate * times[row]) for row in (0, 120, 240)]
    assert places == pytest.approx(expected, abs=0.1)


def test_blur_is_as_long_as_the_camera_turns_while_exposed() -> None:
    camera = PinholeCamera(320, 240, 300.0, 300.0, 159.5, 119.5)
    lens = Lens.of(camera)
    half = np.full(240, 0.03)
    image = lens.shoot(*bar(lens), turned(-half), turned(half))
    lit = (image[120, :, 0] > 2.0).sum()
    assert lit == pytest.approx(2 * 300.0 * 0.03 + 5, abs=3)
    sharp = lens.shoot(*bar(lens), still(240), still(240))
    assert (sharp[120, :, 0] > 2.0).sum() <= 7


def test_near_things_move_more_than_far_ones_when_the_camera_slides() -> None:
    camera = PinholeCamera(320, 240, 300.0, 300.0, 159.5, 119.5)
    lens = Lens.of(camera)
    colour, depth = bar(lens)
    moves = still(240)
    moves[:, 0, 3] = 0.02
    for z in (1.0, 4.0):
        depth[:] = z
        image = lens.shoot(colour, depth, moves, moves)
        unmoved = lens.shoot(colour, depth, still(240), still(240))
        assert place_of_bar(unmoved[120]) - place_of_bar(image[120]) == pytest.approx(300 * 0.02 / z, abs=0.1)


def test_pixels_see_along_the_rays_of_the_stated_distortion() -> None:
    camera = PinholeCamera(640, 480, 500.0, 501.0, 322.0, 236.0, (-0.2, 0.05, 0.001, -0.002, 0.0))
    lens = Lens.of(camera)
    pixels = np.array([[20.0, 30.0], [600.0, 440.0], [322.0, 236.0]])
    rays = np.array([lens.rays[int(v), int(u)] for u, v in pixels])
    straight = rays * [camera.fx, camera.fy] + [camera.cx, camera.cy]
    assert camera.distort(straight) == pytest.approx(pixels, abs=0.01)
    corners = lens.rays[[0, 0, -1, -1], [0, -1, 0, -1]] * [camera.fx, camera.fy] + [lens.canvas.cx, lens.canvas.cy]
    assert (corners > 0).all()
    assert (corners < [lens.canvas.width, lens.canvas.height]).all()


def test_exposure_reaches_its_aim_and_a_hunting_one_overshoots() -> None:
    brightness = np.concatenate([np.full(60, 150.0), np.full(120, 60.0)])
    steady = exposure_gains(brightness, np.random.default_rng(1), 30.0, False)[:, 1]
    hunting = exposure_gains(brightness, np.random.default_rng(1), 30.0, True)[:, 1]
    assert steady[-1] == pytest.approx(112 / 60, rel=0.1)
    assert steady.max() < 1.02 * 112 / 60
    assert hunting.max() > 1.1 * 112 / 60
    assert exposure_gains(np.full(90, 1.0), np.random.default_rng(1), 30.0, False).max() <= 1.2 * MAX_GAIN


def test_a_short_shutter_in_the_dark_is_noisy_and_a_cover_is_black() -> None:
    light = np.full((240, 320, 3), 100.0, np.float32)
    even = np.ones((240, 320), np.float32)
    noises = []
    for shutter, gain in ((0.03, 1.0), (0.003, 1.0), (0.003, 2.2)):
        rng = np.random.default_rng(2)
        rgb = Sensor(even, 1.0, shutter).develop(rng, light / gain, 1.0, np.full(3, gain), 0.0)
        noises.append(float(rgb[..., 1].std()))
    assert noises[0] < noises[1] < noises[2]
    rng = np.random.default_rng(2)
    sensor = Sensor(even, 1.0, 0.01)
    assert sensor.develop(rng, light, 1.0, np.ones(3), 1.0).mean() < 5
    half = sensor.develop(rng, light, 1.0, np.ones(3), 0.5)
    assert half[:60].mean() > 80
    assert half[-60:].mean() < 5
