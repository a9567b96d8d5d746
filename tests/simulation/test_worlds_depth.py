"""The four depth sensors keep to what is published of them."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter, minimum_filter

from lpslam.camera import PinholeCamera
from lpslam.simulation.worlds.sensing.flight import TimeOfFlight
from lpslam.simulation.worlds.sensing.lidar import PhoneLidar
from lpslam.simulation.worlds.sensing.registration import register
from lpslam.simulation.worlds.sensing.stereo import ActiveStereo
from lpslam.simulation.worlds.sensing.structured import BASELINE, FOCAL, STEPS, StructuredLight, sigma_of
from lpslam.simulation.worlds.sensing.surfaces import Surfaces

Picture = NDArray[np.float32]


def surfaces(
    depth: Picture, focal: float, *, brightness: float = 130.0, gloss: float = 0.0, texture: float = 40.0
) -> Surfaces:
    """Walls that face the sensor."""
    height, width = depth.shape
    camera = PinholeCamera(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2)
    even = np.ones_like(depth)
    marks = np.zeros(depth.shape, np.uint8)
    return Surfaces(camera, depth, even, brightness * even, texture * even, gloss * even, marks)


def flat(z: float, size: tuple[int, int] = (640, 480)) -> Picture:
    return np.full(size[::-1], z, np.float32)


def step(near: float, far: float, size: tuple[int, int] = (640, 480)) -> Picture:
    """Near on the right half, far on the left."""
    depth = flat(far, size)
    depth[:, size[0] // 2 :] = near
    return depth


@pytest.mark.parametrize("z", [2.0, 4.0])
@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_structured_light_has_the_published_noise_and_steps(z: float, noise: float) -> None:
    rng = np.random.default_rng(3)
    depth = StructuredLight(640, 480, noise, 8.0).measure(rng, surfaces(flat(z), FOCAL))
    seen = depth[depth > 0]
    assert (seen - z).std() == pytest.approx(sigma_of(noise) * z * z, rel=0.15)
    levels = np.unique(seen)
    assert np.diff(levels).min() == pytest.approx(z * z / (STEPS * FOCAL * BASELINE), rel=0.12)
    assert len(levels) < 30


def test_the_projector_throws_a_shadow_left_of_near_things_only() -> None:
    rng = np.random.default_rng(4)
    depth = StructuredLight(640, 480, 0.0, 8.0).measure(rng, surfaces(step(1.0, 3.0), FOCAL))
    wide = FOCAL * BASELINE * (1 / 1.0 - 1 / 3.0)
    dark = (depth == 0).mean(axis=0)
    assert (dark[320 - round(0.9 * wide) : 318] > 0.9).all()
    assert dark[:280].max() < 0.2
    assert dark[330:].max() < 0.2


def test_structured_light_has_a_range_and_holes_in_the_dark() -> None:
    rng = np.random.default_rng(5)
    sensor = StructuredLight(640, 480, 0.5, 4.0)
    assert not sensor.measure(rng, surfaces(flat(0.4), FOCAL)).any()
    assert not sensor.measure(rng, surfaces(flat(4.2), FOCAL)).any()
    plain = np.mean(sensor.measure(rng, surfaces(flat(3.0), FOCAL)) == 0)
    assert np.mean(sensor.measure(rng, surfaces(flat(3.0), FOCAL, brightness=5.0)) == 0) > 3 * plain + 0.02
    assert np.mean(sensor.measure(rng, surfaces(flat(3.0), FOCAL, gloss=1.0)) == 0) > 3 * plain + 0.02


@pytest.mark.parametrize("z", [1.0, 2.0, 3.0])
def test_the_noise_of_stereo_is_that_of_its_disparity(z: float) -> None:
    rng = np.random.default_rng(6)
    sensor = ActiveStereo(640, 480, 0.5, 0.05, 10.0)
    depth = sensor.measure(rng, surfaces(flat(z), 385.0))
    published = 0.1 * z * z / (385.0 * 0.05)
    assert published <= (depth[depth > 0] - z).std() <= 1.5 * published


def test_stereo_makes_near_things_fat_and_loses_what_has_no_texture() -> None:
    rng = np.random.default_rng(7)
    sensor = ActiveStereo(640, 480, 0.5, 0.05, 10.0)
    depth = sensor.measure(rng, surfaces(step(1.0, 3.0), 385.0))
    beside = depth[:, 317:320]
    assert np.mean((beside > 0.9) & (beside < 1.1)) > 0.3
    far = np.mean(sensor.measure(rng, surfaces(flat(6.0), 385.0, texture=0.0)) == 0)
    assert far > 5 * np.mean(sensor.measure(rng, surfaces(flat(6.0), 385.0)) == 0)


def test_pixels_fly_only_at_edges() -> None:
    rng = np.random.default_rng(8)
    sensor = TimeOfFlight(rng, 512, 424, 0.5, 5.5)
    exact = step(1.0, 3.0, (512, 424))
    depth = sensor.measure(rng, surfaces(exact, 365.0))
    flies = (depth > 1.15) & (depth < 2.8)
    edge = maximum_filter(exact, 3) > 1.04 * minimum_filter(exact, 3)
    assert flies[edge].mean() > 0.3
    assert not flies[~edge].any()


def test_the_noise_of_flight_is_small_near_by_and_grows_as_less_light_returns() -> None:
    rng = np.random.default_rng(9)
    sensor = TimeOfFlight(rng, 512, 424, 0.5, 5.5)

    def sigma(z: float, brightness: float) -> float:
        depth = sensor.measure(rng, surfaces(flat(z, (512, 424)), 365.0, brightness=brightness))
        return float(depth[depth > 0].std())

    assert sigma(1.0, 130.0) < 0.003
    assert sigma(4.0, 130.0) < 0.010
    assert sigma(1.0, 130.0) < sigma(4.0, 130.0)
    assert sigma(2.0, 130.0) < sigma(2.0, 10.0)
    # The wave along the range.
    means = [sensor.measure(rng, surfaces(flat(z, (512, 424)), 365.0)).mean() - z for z in np.arange(1.0, 1.5, 0.04)]
    assert np.ptp(means) == pytest.approx(2 * sensor.wiggle, rel=0.25)


def test_corners_bulge_away() -> None:
    rng = np.random.default_rng(10)
    sensor = TimeOfFlight(rng, 512, 424, 0.0, 5.5)
    x = (np.arange(512) - 255.5) / 365.0
    corner = np.broadcast_to(2.5 / (1 + np.abs(x)), (424, 512)).astype(np.float32)
    error = sensor.measure(rng, surfaces(corner, 365.0)) - corner
    assert error[:, 250:262].mean() > error[:, 150:170].mean() + 0.001


def test_a_telephone_is_smooth_without_holes_and_wrong_at_edges() -> None:
    rng = np.random.default_rng(11)
    sensor = PhoneLidar(256, 192, 0.5)
    exact = step(1.0, 2.5, (256, 192))
    depth = sensor.measure(rng, surfaces(exact, 200.0))
    assert (depth > 0).all()
    between = (depth > 1.2) & (depth < 2.2)
    columns = np.flatnonzero(between.mean(axis=0) > 0.5)
    assert 1 <= len(columns) <= 6
    assert np.abs(columns - 127.5).max() < 5
    inner = depth[:, 20:110] / 2.5 - 1
    assert 0.3 * sensor.patchy < inner.std() < 2 * sensor.patchy
    assert np.corrcoef(inner[:, :-2].ravel(), inner[:, 2:].ravel())[0, 1] > 0.8


def test_registered_depth_is_where_the_colour_camera_sees_it() -> None:
    sensor = PinholeCamera(512, 424, 365.0, 365.0, 255.5, 211.5)
    colour = PinholeCamera(640, 480, 520.0, 520.0, 318.0, 241.0, (-0.1, 0.03, 0.001, -0.001, 0.0))
    colour_from_sensor = np.eye(4)
    colour_from_sensor[:3, 3] = [0.05, 0.0, 0.01]
    depth = step(1.0, 3.0, (512, 424))
    out = register(depth, sensor, colour, colour_from_sensor, (0.0, 0.0))
    inner = out[60:420, 60:580]
    assert (np.abs(inner[..., None] - [0.0, 1.01, 3.01]).min(axis=-1) < 1e-4).all()
    edge = colour.distort(colour.project(np.array([[0.0 + 0.05 + 0.5 / 365.0, 0.0, 1.01]])))[0]
    row = out[round(edge[1])]
    assert abs(np.flatnonzero(np.isclose(row, 1.01, atol=1e-3))[0] - edge[0]) <= 2.0
    # A camera that looks at a plain wall sees no cracks in it.
    wall = register(flat(2.0, (512, 424)), sensor, colour, colour_from_sensor, (0.0, 0.0))
    assert (wall[80:400, 80:560] > 0).all()


def test_misregistered_depth_lies_beside_the_colour() -> None:
    camera = PinholeCamera(320, 240, 300.0, 300.0, 159.5, 119.5)
    depth = step(1.0, 3.0, (320, 240))
    still, moved = (register(depth, camera, camera, np.eye(4), beside) for beside in ((0.0, 0.0), (2.0, 0.0)))
    assert np.array_equal(moved[:, 4:-4], np.roll(still, 2, axis=1)[:, 4:-4])
