"""Depth that was taken before or after its colour image: the delay is found where it can be, and not invented."""

from collections.abc import Iterator

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import DepthDelayConfig, FeatureConfig, SlamConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.delay import DepthDelay, PointsInView
from lpslam.slam.kernels.geometry import exponential
from lpslam.slam.sensor import SensorModel
from lpslam.slam.state import EventKind
from lpslam.slam.system import RgbdSlam

Array = NDArray[np.float64]

CAMERA = PinholeCamera(320, 240, 260.0, 262.0, 160.0, 120.0)
SENSOR = SensorModel.of(CAMERA, SlamConfig())
CORNER = [((0.8, 0.0, 0.6), 1.6), ((-0.7, 0.0, 0.7), 1.7), ((0.0, 0.8, 0.6), 1.4)]
"""Two walls and a floor: each a normal and its distance from the camera, metres."""

LEFT = np.array([0.05, 0.0, 0.1, 0.1, 0.9, 0.1])
RIGHT = np.array([0.02, 0.05, -0.1, -0.2, -0.8, 0.1])


def depths(pixels: Array, twist: Array, seconds: float) -> Array:
    """(n,) metres of the corner at undistorted pixels (n, 2), after so long in motion."""
    moved = exponential(seconds * twist)
    rays = np.column_stack([(pixels - [CAMERA.cx, CAMERA.cy]) / [CAMERA.fx, CAMERA.fy], np.ones(len(pixels))])
    every = []
    for normal, distance in CORNER:
        turned = moved[:3, :3] @ np.array(normal)
        along = (distance + turned @ moved[:3, 3]) / np.maximum(rays @ turned, 1e-6)
        every.append(np.where(rays @ turned > 1e-3, along, np.inf))
    nearest: Array = np.min(every, axis=0)
    return nearest


def view(rng: np.random.Generator, twist: Array, delay: float, beside: float = 0.0) -> PointsInView:
    """The corner in motion; depth is taken `delay` seconds late, and lies `beside` its colour by some pixels."""
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width].reshape(2, -1).astype(float)
    z = depths(np.column_stack([u - beside, v]), twist, delay)
    noise = rng.normal(0.0, 1.0, len(z)) * (0.001 + 0.001 * z**2)
    image = (z + noise).reshape(CAMERA.height, CAMERA.width).astype(np.float32)
    pixels = rng.uniform((30, 30), (290, 210), (150, 2))
    return PointsInView(pixels.astype(np.float32), depths(pixels, twist, 0.0), image, twist)


def estimated(delay: float, twists: list[Array], beside: float = 0.0) -> float:
    """What is found from views in different motion."""
    rng = np.random.default_rng(5)
    found = DepthDelay(CAMERA, SENSOR, FeatureConfig(), DepthDelayConfig())
    for k in range(24):
        found.note(0.2 * k, view(rng, twists[k % len(twists)] * rng.uniform(0.7, 1.3), delay, beside))
    return found.seconds


@pytest.mark.parametrize("delay", [0.02, -0.017, 0.035])
def test_a_delay_is_found_from_views_that_move_both_ways(delay: float) -> None:
    assert estimated(delay, [LEFT, RIGHT]) == pytest.approx(delay, abs=0.002)


def test_no_delay_is_none() -> None:
    assert estimated(0.0, [LEFT, RIGHT]) == 0.0


def test_one_way_alone_tells_nothing() -> None:
    assert estimated(0.02, [LEFT]) == 0.0


def test_depth_beside_the_colour_is_no_delay() -> None:
    assert estimated(0.0, [LEFT, RIGHT], beside=3.0) == 0.0
    assert estimated(0.02, [LEFT, RIGHT], beside=3.0) == pytest.approx(0.02, abs=0.004)


def test_what_is_said_names_the_order() -> None:
    found = DepthDelay(CAMERA, SENSOR, FeatureConfig(), DepthDelayConfig())
    found.seconds = -0.0192
    assert found.reason == "depth is taken 19 ms before colour"


def test_a_camera_that_stands_is_not_asked() -> None:
    found = DepthDelay(CAMERA, SENSOR, FeatureConfig(), DepthDelayConfig())
    assert not found.is_due(1.0, np.full(6, 0.01))
    assert found.is_due(1.0, LEFT)
    found.note(1.0, view(np.random.default_rng(1), LEFT, 0.0))
    assert not found.is_due(1.1, LEFT)


def swaying(seconds: float) -> Array:
    """4×4 camera from world of a camera that turns and shifts from one side to the other."""
    phase = 2.0 * np.pi * seconds / 1.7
    return exponential(np.array([0.15 * np.cos(phase), 0.0, 0.1 * np.sin(phase), 0.05, 0.3 * np.sin(phase), 0.0]))


def walls(camera_from_world: Array) -> tuple[Array, Array]:
    """Where every pixel's ray meets the corner: metres along the axis (h · w,), and points of the world (h · w, 3)."""
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width].reshape(2, -1).astype(float)
    rays = np.column_stack([(u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy, np.ones(u.size)])
    away = rays @ camera_from_world[:3, :3]
    centre = -camera_from_world[:3, :3].T @ camera_from_world[:3, 3]
    along = np.full(u.size, np.inf)
    for normal, distance in CORNER:
        slope = away @ np.array(normal)
        along = np.minimum(
            along, np.where(slope > 1e-3, (distance - centre @ normal) / np.maximum(slope, 1e-3), np.inf)
        )
    return along, centre + along[:, None] * away


def recorded(delay: float, frames: int = 60, fps: float = 15.0) -> Iterator[RgbdFrame]:
    """The corner covered with a pattern; depth is taken `delay` seconds after the colour."""
    rng = np.random.default_rng(7)
    pattern = cv2.GaussianBlur(rng.uniform(0, 255, (512, 512)).astype(np.float32), (0, 0), 1.5)
    pattern = np.clip(127 + 5 * (pattern - pattern.mean()), 0, 255).astype(np.float32)
    for k in range(frames):
        _, hits = walls(swaying(k / fps))
        # Each plane is looked at from aside, so that none is drawn along itself.
        at = (hits @ np.array([[90.0, 40.0], [-40.0, 90.0], [80.0, -70.0]])) % 511
        at = at.reshape(CAMERA.height, CAMERA.width, 2).astype(np.float32)
        gray = cv2.remap(pattern, at, None, cv2.INTER_LINEAR)
        image = np.repeat(gray[..., None].astype(np.uint8), 3, axis=2)
        z, _ = walls(swaying(k / fps + delay))
        depth = (z + rng.normal(0, 1, z.size) * 0.002 * z).reshape(image.shape[:2]).astype(np.float32)
        yield RgbdFrame(k, k / fps, image, depth)


@pytest.mark.parametrize("delay", [0.025, 0.0])
def test_slam_says_that_depth_comes_late(delay: float) -> None:
    slam = RgbdSlam(CAMERA, SlamConfig(delay=DepthDelayConfig(interval=0.07)))
    tracked = [slam.process(frame).is_tracked for frame in recorded(delay)]
    slam.finish()
    assert all(tracked)
    said = [event.reason for event in slam.events if event.kind is EventKind.DEPTH_DELAY]
    assert bool(said) == (delay > 0)
    if said:
        assert said[-1].endswith("ms after colour")
        assert float(said[-1].split()[3]) == pytest.approx(1000 * delay, abs=8)
